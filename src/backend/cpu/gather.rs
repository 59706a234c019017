//! Gather: the radiance that leaves a gather point, from the jotons around it. L = throughput Σ f Φ w, w = 1/(π r²) or
//! corrected at edges and walls [E7, E15, E31].

use super::Pass;
use super::disc::Disc;
use super::eye::GatherPoint;
use super::kd_tree::{EMPTY, LANES};
use super::kernel_correction::Weights;
use super::maps::JotonMap;
use super::window::Window;
use crate::packed::PackedScene;
use crate::plan::{CAUSTIC_FOOTPRINTS, Plan};
use crate::spectrum::{BANDS, BLACK, Bands, add, mul, scale};
use glam::Vec4;

/// Smallest and largest caustic radius of the first pass at a gather point.
pub(super) fn caustic_limits(scene: &PackedScene, plan: &Plan, g: &GatherPoint) -> [f32; 2] {
    let footprint = g.length * scene.pixel_angle();
    let largest = (CAUSTIC_FOOTPRINTS[1] * footprint).min(plan.caustic.base as f32);
    [(CAUSTIC_FOOTPRINTS[0] * footprint).min(largest), largest]
}

/// Number of jotons that count.
pub(super) fn count(map: &JotonMap, w: &Window) -> u32 {
    let mut found = 0;
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for four in &map.fours[quads] {
            found += w.accept(four).0.bitmask().count_ones();
        }
    });
    found
}

/// Radiance of the caustic map toward the eye, times the throughput, from the jotons within a radius [E7, E31]. `is_whole`: the disc is
/// known to lie in flat surface.
pub(super) fn caustic(
    pass: &Pass,
    g: &GatherPoint,
    radius: f32,
    is_whole: bool,
    accepted: Option<u32>,
) -> Bands {
    let map = &pass.caustic;
    let w = Window::new(g, radius * radius).by_own_plane();
    let plain = Weights::plain(w.radius_squared);
    let whole = radiance(map, g, &w, plain, accepted);
    // most discs hold nothing that is worth a measured area
    if is_whole || whole == BLACK {
        return whole;
    }
    let disc = Disc::about(pass.scene, g, radius);
    let weights = Weights::of_area(disc.area);
    if disc.walls().is_none() && disc.radius == radius {
        return scale(&whole, weights.constant / plain.constant);
    }
    let w = Window::new(g, disc.radius * disc.radius).by_own_plane().before(disc.walls());
    radiance(map, g, &w, weights, accepted)
}

/// Radiance toward the eye, times the throughput. `accepted` masks the automaton's states, None where every path is
/// wanted.
pub(super) fn radiance(
    map: &JotonMap,
    g: &GatherPoint,
    w: &Window,
    weights: Weights,
    accepted: Option<u32>,
) -> Bands {
    let sum = if g.bsdf.scatter.varies() || g.bsdf.scatter.crosses() || accepted.is_some() {
        one_by_one(map, g, w, weights, accepted.unwrap_or(u32::MAX))
    } else {
        mul(&irradiance(map, w, weights), &g.bsdf.eval_scatter(g.ns))
    };
    mul(&sum, &g.throughput)
}

/// Σ Φ w: f is the same for every joton.
fn irradiance(map: &JotonMap, w: &Window, weights: Weights) -> Bands {
    let mut sums = [Vec4::ZERO; BANDS];
    let constant = Vec4::splat(weights.constant);
    let sloped = weights.slope != [0.0; 2];
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for (four, flux) in map.fours[quads.clone()].iter().zip(&map.flux[quads]) {
            let (inside, d) = w.accept(four);
            if !inside.any() {
                continue;
            }
            let weight = if sloped {
                let (x, y) = w.tangent(&d);
                constant + x * weights.slope[0] + y * weights.slope[1]
            } else {
                constant
            };
            let weight = Vec4::select(inside, weight, Vec4::ZERO);
            for b in 0..BANDS {
                sums[b] += flux[b] * weight;
            }
        }
    });
    sums.map(|s| s.element_sum())
}

/// Σ f Φ w with f and the path's state of each joton.
fn one_by_one(map: &JotonMap, g: &GatherPoint, w: &Window, weights: Weights, accepted: u32) -> Bands {
    let mut sum = [0.0; BANDS];
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for quad in quads {
            let (inside, d) = w.accept(&map.fours[quad]);
            let inside = inside.bitmask();
            if inside == 0 {
                continue;
            }
            let (x, y) = w.tangent(&d);
            for lane in (0..LANES).filter(|l| inside >> l & 1 == 1) {
                let slot = map.slots[quad * LANES + lane];
                debug_assert!(slot != EMPTY, "empty slots are far away");
                let joton = &map.jotons[slot as usize];
                if accepted >> joton.state & 1 == 0 {
                    continue;
                }
                let weight = weights.constant + weights.slope[0] * x[lane] + weights.slope[1] * y[lane];
                let f = g.bsdf.eval_scatter_from(joton.normal.dot(g.ng) < 0.0, joton.wi);
                sum = add(&sum, &scale(&mul(&f, &joton.flux), weight));
            }
        }
    });
    sum
}
