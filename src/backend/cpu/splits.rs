//! Splits: where a camera tree takes both ways, and how likely an eye path is to go where a tree goes anyway [E25].
//! Twin: shaders/paths/splits.wgsl.

use crate::optics::shading::bsdf::Shares;
use crate::packed::constants::SPLIT_MIN;

/// Along a path from the eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Splits {
    /// Flux kept so far of all that set out.
    share: f32,
    /// Chance that an eye path, which picks one way by its flux, took these where a tree takes both.
    chance: f32,
    /// pdf_solid_angle of an eye path's last direction, and lobe; none where no light sample may have found what it meets.
    pdf: Option<f32>,
}

impl Splits {
    /// At the eye.
    pub(super) fn start() -> Self {
        Self { share: 1.0, chance: 1.0, pdf: None }
    }

    /// Whether a tree takes both ways at an interface.
    pub(super) fn takes_both(&self, shares: &Shares) -> bool {
        shares.delta[0].min(shares.delta[1]) * self.share >= SPLIT_MIN
    }

    /// After a delta lobe that was taken where all have these shares, in a direction with this pdf_solid_angle of the lobe, if it has a
    /// width. Where a tree takes one way only, it picks among the delta lobes as an eye path does.
    pub(super) fn after(&self, shares: &Shares, lobe: usize, pdf: Option<f32>) -> Self {
        let taken = if self.takes_both(shares) { shares.delta[lobe] } else { shares.followed() };
        Self {
            share: self.share * taken,
            chance: self.chance * taken / shares.kept(),
            pdf: pdf.map(|pdf| pdf * shares.delta[lobe] / shares.kept()),
        }
    }

    /// Eye paths and the light samples of their last vertex, which have this pdf_solid_angle, in the measure of [`Splits::chance`].
    fn without_trees(&self, pdf_light: f32) -> f32 {
        self.pdf.map_or(self.chance, |pdf| self.chance * (1.0 + pdf_light / pdf))
    }

    /// Weight of the emission that an eye path meets, beside so many trees a pass, and light samples: the balance heuristic.
    pub(super) fn weight_of_eye(&self, trees: f32, pdf_light: f32) -> f32 {
        self.chance / (self.without_trees(pdf_light) + trees)
    }

    /// Weight of the emission that each of so many trees a pass meets.
    pub(super) fn weight_of_tree(&self, trees: f32, pdf_light: f32) -> f32 {
        1.0 / (self.without_trees(pdf_light) + trees)
    }

    /// Weight of what light samples find in the lobe that these splits are after.
    pub(super) fn weight_of_light(&self, trees: f32, pdf_light: f32) -> f32 {
        let followed = self.pdf.unwrap_or(0.0);
        let by_light = self.chance * pdf_light;
        by_light / (by_light + (self.chance + trees) * followed)
    }
}
