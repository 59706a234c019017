//! Tests of sharing: on planes whose light is known.

use super::apart::Told;
use super::*;
use crate::sampling::rng::random4;
use glam::Vec3;
use patch::{Patch, Place};
use pyramid::Level;
use regression::Kernel;

const SIZE: [u32; 2] = [96, 96];
const SEEDS: u32 = 8;

/// A pixel's patch on the plane z = `height`.
fn flat(pixel: u32, height: f32, weight: f32, share: f32) -> Patch {
    let position = Vec3::new((pixel % SIZE[0]) as f32, (pixel / SIZE[0]) as f32, height);
    let place = Place { position, normal: Vec3::Z, footprint: 1.0, kind: 0, clearance: 5.0 };
    Patch { place, weight: [weight * share; BANDS], share, is_through: false, is_textured: false }
}

/// What two halves of a pass each find of a truth, with white noise of this standard deviation, and what sharing makes of it.
fn shared(surfaces: &Surfaces, truth: impl Fn(u32) -> f32, noise: f32, seed: u32) -> Resolved {
    shared_as(Layer::Diffuse, surfaces, truth, noise, seed)
}

/// The same of a layer.
fn shared_as(
    layer: Layer,
    surfaces: &Surfaces,
    truth: impl Fn(u32) -> f32,
    noise: f32,
    seed: u32,
) -> Resolved {
    let (layers, strip) = ([layer], SIZE[1]);
    shared_in_strips(&layers, surfaces, truth, noise, seed, strip).remove(0)
}

/// The same of some layers, so many rows at a time.
fn shared_in_strips(
    layers: &[Layer],
    surfaces: &Surfaces,
    truth: impl Fn(u32) -> f32,
    noise: f32,
    seed: u32,
    strip: u32,
) -> Vec<Resolved> {
    let half = |h: u32| -> Vec<Bands> {
        let of = |pixel: u32| {
            let u = random4(seed, h, pixel, 0);
            // the sum of four uniform numbers, of variance one
            let normal = (u.iter().sum::<f32>() - 2.0) * 3.0f32.sqrt();
            [truth(pixel) + noise * std::f32::consts::SQRT_2 * normal; BANDS]
        };
        (0..surfaces.size()[0] * surfaces.size()[1]).map(of).collect()
    };
    let halves = [half(0), half(1)];
    let means = |pixel: usize| [halves[0][pixel], halves[1][pixel]];
    let lit: Vec<Lit<'_>> = layers.iter().map(|layer| Lit { layer: *layer, means: &means }).collect();
    let size = surfaces.size();
    let weights = |rows: Range<u32>| vec![1.0; (rows.len() as u32 * size[0]) as usize];
    let found = Found { size, layers: &lit, parts: [0.5; 2], step: 1, weights: &weights };
    share(&found, Shown::Kept(surfaces), strip)
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

/// On a plane, irradiance that changes evenly loses all but a hundredth of its noise, to the edges of the image; and the variance that is told is that
/// within a factor of three, with no more bias than chance makes.
#[test]
fn smooth_light_loses_its_noise() {
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 0.5, 1.0)]));
    let truth = |pixel: u32| 1.0 + 0.01 * (pixel % SIZE[0]) as f32 - 0.003 * (pixel / SIZE[0]) as f32;
    let noise = 0.3;
    let (mut found, mut variance, mut bias) = (0.0, 0.0, 0.0);
    for seed in 0..SEEDS {
        let resolved = shared(&surfaces, truth, noise, seed);
        let squared = error(&resolved, truth, all);
        assert!(squared < 0.01 * noise * noise, "{squared}");
        found += squared;
        variance += mean_of(&resolved, |e| e.variance);
        bias += mean_of(&resolved, |e| e.bias);
    }
    assert!(variance > found / 3.0 && variance < found * 3.0, "{variance} told, {found} found");
    // a product of two halves, each with twice the variance of both
    let by_chance = 2.0 * noise * noise * (SEEDS as f32 / (SIZE[0] * SIZE[1]) as f32).sqrt();
    assert!(bias.abs() < 4.0 * by_chance, "{bias} of bias, {by_chance} by chance");
}

/// Mean over the pixels of what is told of their errors.
fn mean_of(resolved: &Resolved, of: impl Fn(&SquaredError) -> f32) -> f32 {
    resolved.squared_error.iter().map(of).sum::<f32>() / resolved.radiance.len() as f32
}

/// Light that changes too finely to be seen through the noise is blurred, and most of the error that this makes is told, in the mean over some seeds:
/// were there none of it, less than half would be.
#[test]
fn blur_that_hides_in_the_noise_is_told() {
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 0.5, 1.0)]));
    let truth = |pixel: u32| 1.0 + 0.06 * ((pixel % SIZE[0]) as f32 * 0.9).sin();
    let (mut found, mut told, mut variance) = (0.0, 0.0, 0.0);
    for seed in 0..4 * SEEDS {
        let resolved = shared(&surfaces, truth, 0.3, seed);
        found += error(&resolved, truth, all);
        told += mean_of(&resolved, |e| e.variance + e.bias);
        variance += mean_of(&resolved, |e| e.variance);
    }
    assert!(found > 2.0 * variance, "{found} found, {variance} of it variance: nothing is hidden");
    assert!(told > 0.5 * found && told < 1.5 * found, "{told} told, {found} found");
}

/// All levels of what pixels tell of a layer.
fn told(surfaces: &Surfaces, means: &(dyn Fn(usize) -> [Bands; 2] + Sync)) -> Told {
    let mut told = Told::new(SIZE, 1);
    told.go_on(surfaces, &[Lit { layer: Layer::Diffuse, means }], SIZE[1]);
    told
}

/// The fits of all levels at some pixels: the first band of the first half.
fn fits(surfaces: &Surfaces, truth: impl Fn(u32) -> f32, pixels: &[u32]) -> Vec<f32> {
    let half: Vec<Bands> = (0..SIZE[0] * SIZE[1]).map(|pixel| [truth(pixel); BANDS]).collect();
    let means = |pixel: usize| [half[pixel]; 2];
    let levels = told(surfaces, &means).levels;
    let of = |level: &Level, pixel: u32| {
        let patch = surfaces.patch(surfaces.ids(pixel as usize).start);
        let kernel = Kernel::at(level, surfaces, patch, middle(pixel, SIZE)).expect("its own pixel is near");
        kernel.of(level.values(0))[0][0]
    };
    levels.iter().flat_map(|level| pixels.iter().map(|&pixel| of(level, pixel)).collect::<Vec<_>>()).collect()
}

/// Light that changes evenly comes out as it is at every level, in the corner of the image and next to its border, too: to 5 %, which the
/// ridge takes of a slope there.
#[test]
fn fits_are_exact_where_light_changes_evenly() {
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 1.0, 1.0)]));
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
        let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(of));
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
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(of));
    let truth = |pixel: u32| match pixel % SIZE[0] {
        0..40 => 1.0,
        40 => 0.25 + 0.75 * 3.0,
        _ => 3.0,
    };
    let noise = 0.3;
    let found = error(&shared(&surfaces, truth, noise, 11), truth, is_edge);
    assert!(found < 0.05 * noise * noise, "{found}");
}

/// Light of a checkerboard of two pixels' squares has no smooth part: with little noise it is left as it is, and with less and less
/// the error goes to zero.
#[test]
fn sharing_is_consistent() {
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 1.0, 1.0)]));
    let truth = |pixel: u32| 1.0 + (pixel % SIZE[0] / 2 + pixel / SIZE[0] / 2) as f32 % 2.0;
    let mut before = f32::INFINITY;
    for noise in [1.0, 0.3, 0.1, 0.03, 0.01] {
        let found = error(&shared(&surfaces, truth, noise, 11), truth, all);
        assert!(found < 2.0 * noise * noise && found < before, "noise {noise}: {found}");
        before = found;
    }
}

/// Where no pixel shows one surface alone, as in grass, each still comes out with its own irradiance: pixels that show more of one tell
/// more of it.
#[test]
fn surfaces_that_are_never_alone_are_told_apart() {
    let part = |pixel: u32| 0.2 + 0.6 * random4(3, 0, pixel, 0)[0];
    let of = |pixel: u32| vec![flat(pixel, 0.0, 1.0, part(pixel)), flat(pixel, 60.0, 1.0, 1.0 - part(pixel))];
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(of));
    let half: Vec<Bands> =
        (0..SIZE[0] * SIZE[1]).map(|pixel| [part(pixel) + 3.0 * (1.0 - part(pixel)); BANDS]).collect();
    let means = |pixel: usize| [half[pixel]; 2];
    let told = told(&surfaces, &means).levels.remove(0);
    let mean = |which: usize| {
        let of = |pixel: u32| told.of(0, surfaces.ids(pixel as usize).start + which)[0][0];
        (0..SIZE[0] * SIZE[1]).map(of).sum::<f32>() / (SIZE[0] * SIZE[1]) as f32
    };
    // alike they would tell 2 and 2
    assert!(mean(0) < 1.6 && mean(1) > 2.4, "{} and {}, not 1 and 3", mean(0), mean(1));
}

/// Small shadows stay where direct light has little noise: on them and next to them errors are no larger than the noise, and away from
/// them less than half of it is left.
#[test]
fn small_shadows_stay() {
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 1.0, 1.0)]));
    let at = |pixel: u32| [pixel % SIZE[0] % 24, pixel / SIZE[0] % 48];
    let truth = |pixel: u32| if at(pixel).iter().all(|i| (10..12).contains(i)) { 0.2 } else { 1.0 };
    let noise = 0.03;
    let resolved = shared_as(Layer::Direct, &surfaces, truth, noise, 11);
    let on = error(&resolved, truth, |pixel| at(pixel).iter().all(|i| (9..13).contains(i)));
    let away = error(&resolved, truth, |pixel| at(pixel)[1] >= 32);
    assert!(on < 1.5 * noise * noise, "{on}");
    assert!(away < 0.5 * noise * noise, "{away}");
}

/// Light whose square is no f32, or none, comes out as it was found.
#[test]
fn light_may_be_of_any_size() {
    let surfaces = Surfaces::of(SIZE, (0..SIZE[0] * SIZE[1]).map(|pixel| vec![flat(pixel, 0.0, 1.0, 1.0)]));
    for size in [1e-30f32, 1e25] {
        let resolved = shared(&surfaces, |_| size, 0.1 * size, 11);
        let is_near = |l: &Bands| l.iter().all(|x| (x / size - 1.0).abs() < 0.5);
        assert!(resolved.radiance.iter().all(is_near), "{size}");
    }
}

/// Swept in strips of any height a picture has the bits that it has where all of its rows are taken at once: pixels of one surface, of
/// several, and of none, on surfaces that rise over each other, with light that changes finely in places.
#[test]
fn strips_change_no_bit() {
    let size = [48, 5 * SIZE[1]];
    let of = |pixel: u32| {
        let at = |height: f32, share: f32| {
            let mut patch = flat(pixel, height, 0.5, share);
            patch.place.position = Vec3::new((pixel % size[0]) as f32, (pixel / size[0]) as f32, height);
            patch.place.clearance = 5.0 * random4(7, pixel / 300, 0, 0)[0];
            patch
        };
        let u = random4(5, 0, pixel, 0)[0];
        match pixel % size[0] {
            0..2 => vec![],
            2..20 => vec![at(0.0, 1.0)],
            20..30 => vec![at(0.0, 0.1 + 0.5 * u), at(60.0, 0.4 - 0.3 * u)],
            _ => vec![at(60.0, 1.0)],
        }
    };
    let surfaces = Surfaces::of(size, (0..size[0] * size[1]).map(of));
    let truth = |pixel: u32| 1.0 + 0.3 * ((pixel / size[0]) as f32 * 0.03).sin() + (pixel % 7 / 6) as f32;
    let shared = |strip: u32| shared_in_strips(&Layer::ON_SURFACES, &surfaces, truth, 0.2, 3, strip);
    let whole = shared(size[1]);
    for strip in [STRIP, 3 * STRIP, 5] {
        for (layer, (found, wanted)) in shared(strip).iter().zip(&whole).enumerate() {
            for pixel in 0..whole[0].radiance.len() {
                let bits = |of: &Resolved| of.radiance[pixel].map(f32::to_bits);
                assert_eq!(bits(found), bits(wanted), "strips of {strip}, layer {layer}, pixel {pixel}");
                assert_eq!(
                    found.squared_error[pixel], wanted.squared_error[pixel],
                    "{strip}, {layer}, {pixel}"
                );
            }
        }
    }
}
