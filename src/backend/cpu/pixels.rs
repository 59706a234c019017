//! Pixels: one pass's eye path, direct light and gather of every pixel, in small tiles so that neighbours share caches.

use super::clip_planes::{self, Clip, Walls};
use super::gather::{caustic, caustic_limits, count, radiance};
use super::interior::Interior;
use super::kernel_correction::{self, Weights, weights};
use super::maps::{AreaMap, JotonMap};
use super::window::Window;
use super::{Pass, direct, disc, eye, glint, indirect};
use crate::backend::{Cause, Tally};
use crate::estimators::maps::MapKind;
use crate::film::neighbours::around;
use crate::film::paths::{Event, LightPaths};
use crate::film::tile_schedule::TILE;
use crate::film::{LAYERS, Layer};
use crate::packed::PackedScene;
use crate::plan::Plan;
use crate::spectrum::{Bands, add};
use rayon::prelude::*;

/// The tiles of a strip: number in the image, and the pixels that lie in it.
fn tiles([width, height]: [u32; 2], strip: u32) -> impl Iterator<Item = (u32, impl Iterator<Item = u32>)> {
    let across = width.div_ceil(TILE);
    let rows = strip * TILE..((strip + 1) * TILE).min(height);
    (0..across).map(move |tile| {
        let columns = tile * TILE..((tile + 1) * TILE).min(width);
        let pixels = rows.clone().flat_map(move |y| columns.clone().map(move |x| y * width + x));
        (strip * across + tile, pixels)
    })
}

/// Add one pass to the layers.
pub(super) fn render(pass: &Pass, layers: &mut [Vec<Bands>; LAYERS]) -> Tally {
    let size = pass.scene.size;
    let per_strip = (size[0] * TILE) as usize;
    let [emission, direct, caustic, diffuse] = layers;
    let strips: Vec<[&mut [Bands]; LAYERS]> = emission
        .chunks_mut(per_strip)
        .zip(direct.chunks_mut(per_strip))
        .zip(caustic.chunks_mut(per_strip))
        .zip(diffuse.chunks_mut(per_strip))
        .map(|(((e, d), c), f)| [e, d, c, f])
        .collect();
    let tallies: Vec<Tally> = strips
        .into_par_iter()
        .enumerate()
        .map(|(i, mut out)| {
            let mut tally = Tally::default();
            let live = |tile: &u32| pass.schedule.is_live(*tile as usize, u64::from(pass.index));
            for (tile, pixels) in tiles(size, i as u32).filter(|(tile, _)| live(tile)) {
                let index = pass.schedule.sequence_index(tile as usize, pass.index);
                for pixel in pixels {
                    let local = pixel as usize - i * per_strip;
                    for (layer, seen) in out.iter_mut().zip(one(pass, pixel, index, &mut tally)) {
                        let radiance = pass.bands.map_or(seen, |bands| bands.rgb(&seen));
                        if radiance.iter().all(|x| is_finite(*x)) {
                            layer[local] = add(&layer[local], &radiance);
                        } else {
                            tally.non_finite.count(Cause::Pixel);
                        }
                    }
                }
            }
            tally
        })
        .collect();
    let mut all = Tally::default();
    tallies.into_iter().for_each(|t| all += t);
    all
}

/// Finite, by its bits: no compiler may assume the answer.
fn is_finite(x: f32) -> bool {
    x.to_bits() & 0x7f80_0000 != 0x7f80_0000
}

/// The radiance of one pixel in one pass, by layer, by the random numbers of `index`.
fn one(pass: &Pass, pixel: u32, index: u32, tally: &mut Tally) -> [Bands; LAYERS] {
    let (scene, plan) = (pass.scene, pass.plan);
    let mut out = [[0.0; crate::spectrum::BANDS]; LAYERS];
    let trees = pass.glints.map_or(0.0, |g| g.trees_a_pass(pixel as usize));
    let path = eye::follow(scene, plan, pixel, index, trees, tally);
    if plan.traces(Layer::Emission) {
        let seen = pass.glints.map(|g| glint::emission(scene, plan, g, pixel, index, tally));
        out[Layer::Emission as usize] = seen.map_or(path.emission, |seen| add(&path.emission, &seen));
    }
    let Some(g) = path.gather_point else { return out };
    let paths = &plan.settings.paths;
    let accepted = plan.features.path_filter.then(|| paths.accept_mask_after_specular(g.chain));
    let after_d = paths.step(LightPaths::START, Event::D);
    if plan.traces(Layer::Direct) && accepted.is_none_or(|mask| mask >> after_d & 1 == 1) {
        out[Layer::Direct as usize] = direct::light(scene, plan, &g, pixel, index, tally);
    }
    if plan.traces(Layer::Caustic) {
        let [smallest, largest] = caustic_limits(scene, plan, &g);
        let base = pass.caustic_base[pixel as usize].clamp(smallest, largest);
        let radius = base * pass.caustic_shrink.sqrt();
        let is_whole = pass.caustic_interiors[pixel as usize].holds(&g, radius);
        out[Layer::Caustic as usize] = caustic(pass, &g, radius, is_whole, accepted);
    }
    if plan.has_indirect_paths() {
        out[Layer::Diffuse as usize] = indirect::light(pass, &g, pixel, index, accepted, tally);
    }
    if let (true, Some(area)) = (plan.has_map(MapKind::Diffuse), pass.area) {
        let radius = pass.diffuse_radius;
        let walls = Walls::about(pass.clips, scene.size, pixel, &g, radius);
        let w = Window::new(&g, radius * radius).before(walls.from(g.position));
        let whole = w.is_open()
            && pass.interiors.get(pixel as usize).is_some_and(|i| i.holds(&g, pass.diffuse_radius));
        let weights = if whole { Weights::plain(w.radius_squared) } else { weights(area, &w) };
        out[Layer::Diffuse as usize] = radiance(&pass.diffuse, &g, &w, weights, accepted);
    }
    out
}

/// What surrounds each pixel's gather point of a pass: whole surface or not.
pub(super) fn interiors(
    scene: &PackedScene,
    plan: &Plan,
    pass: u32,
    area: &AreaMap,
    radius: f32,
) -> Vec<Interior> {
    let strips: Vec<Vec<(u32, Interior)>> = (0..scene.size[1].div_ceil(TILE))
        .into_par_iter()
        .map(|i| {
            let surveyed = tiles(scene.size, i).flat_map(|(_, pixels)| pixels).filter_map(|pixel| {
                let g = eye::follow(scene, plan, pixel, pass, 0.0, &mut Tally::default()).gather_point?;
                Some((pixel, kernel_correction::survey(area, &g, radius)))
            });
            surveyed.collect()
        })
        .collect();
    let mut all = vec![Interior::default(); scene.pixels()];
    strips.into_iter().flatten().for_each(|(pixel, interior)| all[pixel as usize] = interior);
    all
}

/// The walls about each pixel's gather point of a pass, within the largest radius of the diffuse map.
pub(super) fn clips(scene: &PackedScene, plan: &Plan, pass: u32, area: Option<&AreaMap>) -> Vec<Clip> {
    let look = |pixel| {
        let g = eye::follow(scene, plan, pixel, pass, 0.0, &mut Tally::default()).gather_point;
        g.map_or(Clip::default(), |g| clip_planes::find(scene, area, &g, plan.diffuse.base as f32))
    };
    (0..scene.pixels() as u32).into_par_iter().map(look).collect()
}

/// The largest caustic disc of a pixel in the pilot.
pub(super) struct CausticDisc {
    /// Jotons in it.
    count: u32,
    /// Smallest and largest radius.
    limits: [f32; 2],
    /// How far the surface about it is whole.
    interior: Interior,
}

/// The largest caustic disc of each pixel's gather point of a pass; none without a gather point.
pub(super) fn caustic_discs(
    scene: &PackedScene,
    plan: &Plan,
    pass: u32,
    map: &JotonMap,
) -> Vec<Option<CausticDisc>> {
    let look = |pixel| {
        let g = eye::follow(scene, plan, pixel, pass, 0.0, &mut Tally::default()).gather_point?;
        let limits = caustic_limits(scene, plan, &g);
        let count = count(map, &Window::new(&g, limits[1] * limits[1]).by_own_plane());
        // the pixel's other gather points lie about this one
        let footprint = g.pixel_width(scene);
        let interior = disc::survey(scene, &g, limits[1] + footprint);
        Some(CausticDisc { count, limits, interior })
    };
    (0..scene.pixels() as u32).into_par_iter().map(look).collect()
}

/// Where each pixel's caustic disc is known to be whole.
pub(super) fn caustic_interiors(found: &[Option<CausticDisc>]) -> Vec<Interior> {
    found.iter().map(|disc| disc.as_ref().map_or_else(Interior::default, |disc| disc.interior)).collect()
}

/// The caustic radius of each pixel in the first pass, from the jotons counted in a pilot:
/// r = clamp(r_max √(K/k), r_min, r_max), k the mean count at r_max over 3×3 pixels [E14].
pub(super) fn caustic_base(scene: &PackedScene, plan: &Plan, found: &[Option<CausticDisc>]) -> Vec<f32> {
    let base = |pixel: usize| {
        let Some(CausticDisc { limits: [smallest, largest], .. }) = found[pixel] else {
            return plan.caustic.base as f32;
        };
        let counts =
            || around(pixel as u32, scene.size).filter_map(|i| found[i].as_ref()).map(|disc| disc.count);
        let sum: u32 = counts().sum();
        if sum == 0 {
            return largest;
        }
        let mean = sum as f32 / counts().count() as f32;
        (largest * (plan.caustic_wanted / mean).sqrt()).clamp(smallest, largest)
    };
    (0..found.len()).map(base).collect()
}
