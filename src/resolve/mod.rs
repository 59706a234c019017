//! Resolve: from what passes summed up to the picture. What the paths of single pixels find of indirect light is white noise about
//! something smooth: it is shared with neighbours on the same surface \[E29\].
//!
//! The sums stay as they are: a picture is resolved when it is looked at, from the means of two halves of the passes.

mod bandwidth;
mod pyramid;
mod regression;
mod surfaces;

use crate::packed::PackedScene;
use crate::spectrum::{BANDS, BLACK, Bands, add, mul, scale};
use bandwidth::{Bandwidths, CHOICES, Errors, LEVELS, Sources, agreed, credible};
use pyramid::{Level, Told, middle};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};
use surfaces::{Patch, Surfaces};

/// Pixels around one of several surfaces that tell how good its neighbours' word is.
const MIXED_REACH: u32 = 4;
/// What these agree on is chance below the square root of this in standard errors.
const MIXED_DOUBT: f32 = 2.0;
/// What is taken after a single pass: a kernel of 10 pixels.
const FIRST_CHOICE: usize = 3;
/// How fast the weight of a choice falls with its squared error.
const SHARPNESS: i32 = 4;
/// Choices with less than this part of the weight are left out.
const LEAST_WEIGHT: f32 = 0.15;

/// Smooths the indirect light of a scene.
#[derive(Debug)]
pub struct Resolver {
    scene: Arc<PackedScene>,
    seed: u32,
    surfaces: OnceLock<Surfaces>,
}

/// An image of indirect light.
#[derive(Debug, Clone)]
pub struct Resolved {
    /// Radiance of each pixel, W/(m² sr).
    pub radiance: Vec<Bands>,
    /// Estimates of its variance and its squared bias, means over the bands.
    pub squared_error: Vec<[f32; 2]>,
}

impl Resolver {
    /// Of a scene as its camera sees it.
    pub fn new(scene: Arc<PackedScene>, seed: u32) -> Self {
        Self { scene, seed, surfaces: OnceLock::new() }
    }

    /// Share indirect light among neighbours. `halves`: its mean in each half of the passes; `parts`: what part of the passes each has.
    pub fn resolve(&self, halves: [&[Bands]; 2], parts: [f32; 2]) -> Resolved {
        let surfaces = self.surfaces.get_or_init(|| Surfaces::look(&self.scene, self.seed));
        share(self.scene.size, surfaces, halves, parts)
    }
}

/// Share what the halves of the passes found among pixels that show these surfaces.
fn share(size: [u32; 2], surfaces: &Surfaces, halves: [&[Bands]; 2], parts: [f32; 2]) -> Resolved {
    let mut levels = vec![Level::of_pixels(size, surfaces, halves)];
    while levels.len() < LEVELS {
        levels.push(levels[levels.len() - 1].coarser());
    }
    let sources = Sources { size, surfaces, levels: &levels, halves, parts };
    let bandwidths = Bandwidths::look(&sources);
    let pixels = 0..size[0] * size[1];
    let shared: Vec<Option<Estimate>> =
        pixels.clone().into_par_iter().map(|pixel| of_pixel(&sources, &bandwidths, pixel)).collect();
    let (radiance, squared_error) =
        pixels.into_par_iter().map(|pixel| weighed(&sources, &shared, pixel)).unzip();
    Resolved { radiance, squared_error }
}

/// Irradiance at a patch, or radiance of a pixel.
struct Estimate {
    /// As each half of the passes tells it.
    halves: [Bands; 2],
    /// Variance and squared bias.
    error: [f32; 2],
}

/// Radiance of a pixel by what is known of its surfaces; none where nothing is.
fn of_pixel(sources: &Sources<'_>, bandwidths: &Bandwidths, pixel: u32) -> Option<Estimate> {
    let told = sources.told(pixel);
    let mut all = Estimate { halves: [BLACK; 2], error: [0.0; 2] };
    for patch in sources.surfaces.at(pixel as usize) {
        let found = of_patch(sources, bandwidths, patch, pixel, &told)?;
        all.halves = [0, 1].map(|h| add(&all.halves[h], &mul(&patch.weight, &found.halves[h])));
        let weight = patch.weight.iter().sum::<f32>() / BANDS as f32;
        (0..2).for_each(|i| all.error[i] += found.error[i] * weight * weight);
    }
    Some(all)
}

/// Radiance of a pixel, of what neighbours tell and of its own findings, and its squared error.
fn weighed(sources: &Sources<'_>, shared: &[Option<Estimate>], pixel: u32) -> (Bands, [f32; 2]) {
    let own = sources.own(pixel);
    let Some(all) = &shared[pixel as usize] else {
        return (sources.mean(&own), [sources.variance(&own), 0.0]);
    };
    // one pass has no second half that could say so
    let is_mixed = sources.parts[1] > 0.0 && sources.surfaces.is_mixed(pixel as usize);
    let (t, away, alone) = if is_mixed { mixed(sources, shared, pixel) } else { (0.0, 0.0, 0.0) };
    let mean = sources.mean(&all.halves).map(|x| x.max(0.0));
    let value = add(&scale(&mean, 1.0 - t), &scale(&sources.mean(&own), t));
    let kept = (1.0 - t) * (1.0 - t);
    (value, [kept * all.error[0] + t * t * alone, kept * (all.error[1] + away)])
}

/// The weight of a pixel's own findings where it shows several surfaces, the squared bias of what neighbours tell, and the variance of its
/// own: from all such pixels around it.
fn mixed(sources: &Sources<'_>, shared: &[Option<Estimate>], pixel: u32) -> (f32, f32, f32) {
    let [width, height] = sources.size;
    let [x, y] = [pixel % width, pixel / width];
    let near = |i: u32, n: u32| i.saturating_sub(MIXED_REACH)..(i + MIXED_REACH + 1).min(n);
    let (mut n, mut product, mut variance) = (0.0f32, 0.0f32, 0.0f32);
    for y in near(y, height) {
        for x in near(x, width) {
            let pixel = y * width + x;
            let Some(all) = &shared[pixel as usize] else { continue };
            if !sources.surfaces.is_mixed(pixel as usize) {
                continue;
            }
            let own = sources.own(pixel);
            for (band, (x, y)) in own[0].iter().zip(&own[1]).enumerate() {
                product += agreed(x - all.halves[0][band], y - all.halves[1][band]) / BANDS as f32;
            }
            variance += sources.variance(&own);
            n += 1.0;
        }
    }
    let (product, variance) = (product / n, variance / n);
    let by_chance = (2.0 * variance).powi(2) / n;
    let bias = credible(product, by_chance, MIXED_DOUBT);
    (bias / (bias + variance).max(f32::MIN_POSITIVE), bias, variance)
}

/// Irradiance at a patch; none where nothing is known.
fn of_patch(
    sources: &Sources<'_>,
    bandwidths: &Bandwidths,
    patch: &Patch,
    pixel: u32,
    told: &Told,
) -> Option<Estimate> {
    let errors = if sources.parts[1] > 0.0 {
        bandwidths.at(patch, middle(pixel, sources.size))?
    } else {
        // one pass tells nothing of its noise
        std::array::from_fn(|choice| [if choice == FIRST_CHOICE { 0.0 } else { 1.0 }, 0.0])
    };
    let mut all = Estimate { halves: [BLACK; 2], error: [0.0; 2] };
    let mut total = 0.0;
    for (choice, &weight) in weights(&errors).iter().enumerate().filter(|(_, w)| **w > 0.0) {
        let Some(halves) = sources.choose(choice, patch, pixel, told) else { continue };
        all.halves = [0, 1].map(|h| add(&all.halves[h], &scale(&halves[h], weight)));
        (0..2).for_each(|i| all.error[i] += weight * errors[choice][i]);
        total += weight;
    }
    (total > 0.0).then(|| Estimate {
        halves: all.halves.map(|half| scale(&half, 1.0 / total)),
        error: all.error.map(|e| e / total),
    })
}

/// Weights of the choices: those whose squared errors differ from the least by little, compared with their variance, share it.
fn weights(errors: &Errors) -> [f32; CHOICES] {
    let squared = errors.map(|[variance, bias]| variance + bias);
    let best = (0..CHOICES).min_by(|a, b| squared[*a].total_cmp(&squared[*b])).unwrap_or(0);
    let mut weights: [f32; CHOICES] = std::array::from_fn(|choice| {
        let scale = errors[best][0] + errors[choice][0] + f32::MIN_POSITIVE;
        (1.0 + (squared[choice] - squared[best]) / scale).powi(-SHARPNESS)
    });
    let total: f32 = weights.iter().sum();
    weights.iter_mut().filter(|w| **w < LEAST_WEIGHT * total).for_each(|w| *w = 0.0);
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::random4;
    use glam::Vec3;
    use surfaces::Place;

    const SIZE: [u32; 2] = [96, 96];

    /// A pixel's patch on the plane z = `height`.
    fn flat(pixel: u32, height: f32, weight: f32, share: f32) -> Patch {
        let position = Vec3::new((pixel % SIZE[0]) as f32, (pixel / SIZE[0]) as f32, height);
        let place = Place { position, normal: Vec3::Z, footprint: 1.0, kind: 0, clearance: 5.0 };
        Patch { place, weight: [weight * share; BANDS], share }
    }

    /// What two halves of a pass each find of a truth, with white noise of this standard deviation, and what sharing makes of it.
    fn shared(surfaces: &Surfaces, truth: impl Fn(u32) -> f32, noise: f32) -> Resolved {
        let half = |h: u32| -> Vec<Bands> {
            let of = |pixel: u32| {
                let u = random4(11, h, pixel, 0);
                // the sum of four uniform numbers, of variance one
                let normal = (u.iter().sum::<f32>() - 2.0) * 3.0f32.sqrt();
                [truth(pixel) + noise * std::f32::consts::SQRT_2 * normal; BANDS]
            };
            (0..SIZE[0] * SIZE[1]).map(of).collect()
        };
        share(SIZE, surfaces, [&half(0), &half(1)], [0.5; 2])
    }

    /// Mean squared error.
    fn error(resolved: &Resolved, truth: impl Fn(u32) -> f32, of: impl Fn(u32) -> bool) -> f32 {
        let pixels: Vec<u32> = (0..SIZE[0] * SIZE[1]).filter(|pixel| of(*pixel)).collect();
        let square = |pixel: &u32| (resolved.radiance[*pixel as usize][0] - truth(*pixel)).powi(2);
        pixels.iter().map(square).sum::<f32>() / pixels.len() as f32
    }

    fn all(_: u32) -> bool {
        true
    }

    /// On a plane, irradiance that changes evenly keeps its mean and loses all but a hundredth of its noise, to the edges of the image;
    /// and the estimate says so within a factor of three.
    #[test]
    fn smooth_light_loses_its_noise() {
        let surfaces = Surfaces::of((0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 0.5, 1.0)]));
        let truth = |pixel: u32| 1.0 + 0.01 * (pixel % SIZE[0]) as f32 - 0.003 * (pixel / SIZE[0]) as f32;
        let noise = 0.3;
        let resolved = shared(&surfaces, truth, noise);
        let found = error(&resolved, truth, all);
        assert!(found < 0.01 * noise * noise, "{found}");
        let told = resolved.squared_error.iter().flatten().sum::<f32>() / resolved.radiance.len() as f32;
        assert!(told > found / 3.0 && told < found * 3.0, "{told} told, {found} found");
    }

    /// The fits of all levels at some pixels: the first band of the first half.
    fn fits(surfaces: &Surfaces, truth: impl Fn(u32) -> f32, pixels: &[u32]) -> Vec<f32> {
        let half: Vec<Bands> = (0..SIZE[0] * SIZE[1]).map(|pixel| [truth(pixel); BANDS]).collect();
        let mut levels = vec![Level::of_pixels(SIZE, surfaces, [&half, &half])];
        while levels.len() < LEVELS {
            levels.push(levels[levels.len() - 1].coarser());
        }
        let of = |level: &Level, pixel: u32| {
            let patch = &surfaces.at(pixel as usize)[0];
            regression::fit(level, patch, middle(pixel, SIZE)).expect("its own pixel is near")[0][0]
        };
        levels
            .iter()
            .flat_map(|level| pixels.iter().map(|&pixel| of(level, pixel)).collect::<Vec<_>>())
            .collect()
    }

    /// Light that changes evenly comes out as it is at every level, in the corner of the image and next to its border, too: to 5 %, which the
    /// ridge takes of a slope there.
    #[test]
    fn fits_are_exact_where_light_changes_evenly() {
        let surfaces = Surfaces::of((0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 1.0, 1.0)]));
        let truth = |pixel: u32| 1.0 + 0.02 * (pixel % SIZE[0]) as f32 + 0.01 * (pixel / SIZE[0]) as f32;
        let pixels = [0, 5, 40 * SIZE[0], 50 * SIZE[0] + 50];
        for (i, found) in fits(&surfaces, truth, &pixels).into_iter().enumerate() {
            let wanted = truth(pixels[i % pixels.len()]);
            assert!((found / wanted - 1.0).abs() < 0.05, "level {}: {found}, {wanted}", i / pixels.len());
        }
    }

    /// Nothing passes from one surface to another beside it: one that lies higher, one of another kind, one that looks elsewhere.
    #[test]
    fn surfaces_keep_their_own() {
        let is_left = |pixel: u32| pixel % SIZE[0] < 40;
        let truth = |pixel: u32| if is_left(pixel) { 0.0 } else { 2.0 };
        let changed = |pixel: u32, change: &dyn Fn(&mut Place)| {
            let mut patch = flat(pixel, 0.0, 1.0, 1.0);
            change(&mut patch.place);
            patch
        };
        let others: [&dyn Fn(&mut Place); 3] =
            [&|p| p.position.z = 60.0, &|p| p.kind = 7, &|p| p.normal = Vec3::X];
        for (i, other) in others.into_iter().enumerate() {
            let of =
                |pixel| vec![if is_left(pixel) { flat(pixel, 0.0, 1.0, 1.0) } else { changed(pixel, other) }];
            let surfaces = Surfaces::of((0..SIZE[0] * SIZE[1]).map(of));
            let at = |x: u32| 50 * SIZE[0] + x;
            let found = fits(&surfaces, truth, &[at(39), at(40)]);
            assert!(
                found.chunks(2).all(|two| two[0].abs() < 1e-5 && (two[1] - 2.0).abs() < 1e-4),
                "{i}: {found:?}"
            );
        }
    }

    /// A pixel that shows two surfaces takes of each as much as it shows, from pixels that show one.
    #[test]
    fn pixels_of_two_surfaces_take_from_both() {
        let is_edge = |pixel: u32| pixel % SIZE[0] == 40;
        let of = |pixel: u32| match pixel % SIZE[0] {
            0..40 => vec![flat(pixel, 0.0, 1.0, 1.0)],
            40 => vec![flat(pixel, 0.0, 1.0, 0.25), flat(pixel, 60.0, 1.0, 0.75)],
            _ => vec![flat(pixel, 60.0, 1.0, 1.0)],
        };
        let surfaces = Surfaces::of((0..SIZE[0] * SIZE[1]).map(of));
        let truth = |pixel: u32| match pixel % SIZE[0] {
            0..40 => 1.0,
            40 => 0.25 + 0.75 * 3.0,
            _ => 3.0,
        };
        let noise = 0.3;
        let found = error(&shared(&surfaces, truth, noise), truth, is_edge);
        assert!(found < 0.05 * noise * noise, "{found}");
    }

    /// Light of a checkerboard of two pixels' squares has no smooth part: with little noise it is left as it is, and with less and less
    /// the error goes to zero.
    #[test]
    fn sharing_is_consistent() {
        let surfaces = Surfaces::of((0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 1.0, 1.0)]));
        let truth = |pixel: u32| 1.0 + (pixel % SIZE[0] / 2 + pixel / SIZE[0] / 2) as f32 % 2.0;
        let mut before = f32::INFINITY;
        for noise in [1.0, 0.3, 0.1, 0.03, 0.01] {
            let found = error(&shared(&surfaces, truth, noise), truth, all);
            assert!(found < 2.0 * noise * noise && found < before, "noise {noise}: {found}");
            before = found;
        }
    }
}
