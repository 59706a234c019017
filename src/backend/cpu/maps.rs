//! Maps: jotons and area points in kd-tree order, four to a group, ready to be tested together.

use super::kd_tree::{EMPTY, KdTree, LANES};
use crate::packed::AreaPoint;
use crate::spectrum::{BANDS, Bands};
use glam::{Vec3, Vec4};

/// A stored joton.
#[derive(Debug, Clone, Copy)]
pub(super) struct Joton {
    pub(super) position: Vec3,
    /// Unit vector toward where it came from.
    pub(super) wi: Vec3,
    /// Flux as it arrived, internal W per band, times |wi·Ns|/|wi·Ng|; already divided by the number emitted.
    pub(super) flux: Bands,
    /// Unit geometric normal, on the side it arrived on.
    pub(super) normal: Vec3,
    /// State of the light path automaton after the D event of this surface.
    pub(super) state: u32,
}

/// Four positions and normals, one array for each coordinate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Four {
    pub(super) position: [Vec4; 3],
    pub(super) normal: [Vec4; 3],
}

/// Where empty slots lie: farther than any radius reaches, and finite.
const NOWHERE: Vec3 = Vec3::splat(1e12);

fn lanes(f: impl Fn(usize) -> f32) -> Vec4 {
    Vec4::from_array(std::array::from_fn(f))
}

impl Four {
    fn new(slots: &[u32], at: impl Fn(u32) -> (Vec3, Vec3)) -> Self {
        let items: [(Vec3, Vec3); LANES] =
            std::array::from_fn(|l| if slots[l] == EMPTY { (NOWHERE, Vec3::ZERO) } else { at(slots[l]) });
        Self {
            position: std::array::from_fn(|c| lanes(|l| items[l].0[c])),
            normal: std::array::from_fn(|c| lanes(|l| items[l].1[c])),
        }
    }
}

/// The jotons of one map and pass.
#[derive(Debug, Default)]
pub(super) struct JotonMap {
    pub(super) tree: KdTree,
    pub(super) fours: Vec<Four>,
    /// Flux of the same groups.
    pub(super) flux: Vec<[Vec4; BANDS]>,
    /// Which joton stands in each slot.
    pub(super) slots: Vec<u32>,
    pub(super) jotons: Vec<Joton>,
}

impl JotonMap {
    pub(super) fn new(jotons: Vec<Joton>) -> Self {
        let (tree, slots) = KdTree::build(jotons.iter().map(|j| j.position));
        let groups = || slots.chunks_exact(LANES);
        let fours = groups()
            .map(|s| Four::new(s, |i| (jotons[i as usize].position, jotons[i as usize].normal)))
            .collect();
        let flux = groups()
            .map(|s| {
                std::array::from_fn(|b| {
                    lanes(|l| if s[l] == EMPTY { 0.0 } else { jotons[s[l] as usize].flux[b] })
                })
            })
            .collect();
        Self { tree, fours, flux, slots, jotons }
    }
}

/// Area points of the diffuse surfaces.
#[derive(Debug, Default)]
pub(super) struct AreaMap {
    pub(super) tree: KdTree,
    pub(super) fours: Vec<Four>,
    /// Area that each point stands for, internal units².
    pub(super) area_each: f32,
}

impl AreaMap {
    pub(super) fn new(points: &[AreaPoint], area_each: f32) -> Self {
        let (tree, slots) = KdTree::build(points.iter().map(|p| p.position));
        let fours = slots
            .chunks_exact(LANES)
            .map(|s| Four::new(s, |i| (points[i as usize].position, points[i as usize].normal)))
            .collect();
        Self { tree, fours, area_each }
    }
}
