//! Splits: where a camera tree takes both ways, and how likely an eye path is to go where a tree goes anyway [E25].
//! Twin: shaders/shared/splits.wgsl.

use super::eye::Branch;
use crate::layout::SPLIT_MIN;

/// Along a path from the eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Splits {
    /// Flux kept so far of all that set out.
    share: f32,
    /// Chance that an eye path, which picks one way by its flux, took these where a tree takes both.
    chance: f32,
}

impl Splits {
    /// At the eye.
    pub(super) fn start() -> Self {
        Self { share: 1.0, chance: 1.0 }
    }

    /// Whether a tree takes both ways at a boundary; `carried` is the flux of what arrives.
    pub(super) fn takes_both(&self, ways: &[Branch; 2], carried: f32) -> bool {
        ways[0].kept.min(ways[1].kept) / carried * self.share >= SPLIT_MIN
    }

    /// After the way `taken` of these at a boundary.
    pub(super) fn after(&self, ways: &[Branch; 2], taken: usize, carried: f32) -> Self {
        let kept = ways[0].kept + ways[1].kept;
        if self.takes_both(ways, carried) {
            self.mirrored(ways[taken].kept / carried, ways[taken].kept / kept)
        } else {
            Self { share: self.share * kept / carried, ..*self }
        }
    }

    /// After a mirror that keeps this part of what arrives; an eye path is mirrored with probability `chance`.
    pub(super) fn mirrored(&self, kept: f32, chance: f32) -> Self {
        Self { share: self.share * kept, chance: self.chance * chance }
    }

    /// Weight of the emission that an eye path meets, beside so many trees a pass: the balance heuristic.
    pub(super) fn weight_of_eye(&self, trees: f32) -> f32 {
        self.chance / (self.chance + trees)
    }

    /// Weight of the emission that each of so many trees a pass meets.
    pub(super) fn weight_of_tree(&self, trees: f32) -> f32 {
        1.0 / (self.chance + trees)
    }
}
