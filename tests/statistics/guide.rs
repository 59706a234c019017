//! Guided emission [E20]: caustic jotons that are picked and steered by what was learned, or by anything else, carry the same
//! light, on both sides; and what is learned finds a tiny light among strong ones.

use crate::chi_square::{Claims, draws, p_value, seed};
use crate::common::scenes::{Builder, emitter, glass, three_glass_spheres};
use crate::common::{Row, dvec3, floats, row};
use crate::device::Device;
use crate::renders::{Planner, Side, file, layer, pictures, pictures_of, plan, plan_by_map};
use glam::DVec3;
use joton::backend::cpu::harness;
use joton::film::Layer;
use joton::film::stats::{Estimate, test_equal};
use joton::packed::{Guide, PackedScene, WARP_BINS, Warp};
use joton::plan::{Guides, Plan};
use joton::scene::Light;
use statrs::distribution::{ContinuousCDF, Normal};
use std::sync::Arc;

/// Paths of the caustic layer.
const CAUSTIC: &str = "LS+DS*E";
const BINS: usize = WARP_BINS * WARP_BINS;
/// Jotons of a sampler's test.
const COUNT: u32 = 1 << 18;
/// Jotons a pass, as far as their flux knows.
const EMITTED: u32 = 1000;

/// Weights of a warp that is right for nothing: over a factor of thirty, without any order.
fn haphazard(number: u32) -> Vec<f64> {
    (0..BINS as u32).map(|i| 30f64.powf(joton::sampling::rng::random4(7, number, i, 0)[0].into())).collect()
}

/// A guide that has learned nonsense: picks over a factor of a hundred, and every other emitter steered astray.
fn misled(scene: &PackedScene) -> Guide {
    let count = scene.emitters.len();
    let weights: Vec<f64> =
        (0..count as u32).map(|i| 100f64.powf(joton::sampling::rng::random4(8, 0, i, 0)[0].into())).collect();
    let warps = vec![Warp::new(&haphazard(0)), Warp::new(&haphazard(1))];
    Guide::new(&scene.emitters, &weights, warps, |i| [Some(0), None, Some(1)][i % 3], 1.0)
}

/// Caustic jotons by a guide, everything else by none.
fn caustic(guide: &Guide) -> Guides {
    Guides { caustic: guide.clone(), ..Guides::default() }
}

/// Two in three bins of a warp's square are hit as often as their weights say, and the density tells it.
#[test]
fn warps_draw_by_their_weights() {
    let scene = three_glass_spheres(|b| b.point_light([0.4, 1.2, -0.3], 3.0));
    let weights = [haphazard(0), haphazard(1)];
    let warps: Vec<Warp> = weights.iter().map(|w| Warp::new(w)).collect();
    let guide = Guide::new(&scene.emitters, &[1.0], warps.clone(), |_| None, 1.0);
    let mut claims = Claims::default();
    let mut claim = |name: String, weights: &[f64], drawn: Vec<([f32; 2], f32)>| {
        let mean = weights.iter().sum::<f64>() / BINS as f64;
        let mut counts = vec![0.0; BINS];
        for ([x, y], density) in drawn {
            assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y), "{name}: {x}, {y}");
            let bin = [x, y].map(|x| (x * WARP_BINS as f32) as usize);
            let bin = bin[0] * WARP_BINS + bin[1];
            counts[bin] += 1.0;
            // a bin has hundreds of steps, and a place at the edge of two may be rounded into the other
            let wanted = weights[bin] / mean;
            let edge = [x, y].iter().any(|x| ((x * 32.0).round() - x * 32.0).abs() < 1e-4);
            assert!(edge || (f64::from(density) / wanted - 1.0).abs() < 0.02, "{name}: {density}, {wanted}");
        }
        let expected: Vec<f64> = weights.iter().map(|w| w / mean * f64::from(COUNT) / BINS as f64).collect();
        claims.add(name, p_value(&counts, &expected));
    };
    for (number, (weights, warp)) in weights.iter().zip(&warps).enumerate() {
        let us = || draws(40 + number as u32, COUNT).map(|u| [u[0], u[1]]);
        claim(format!("host, warp {number}"), weights, us().map(|u| warp.place(u)).collect());
        let Some(context) = crate::common::device() else { continue };
        let inputs: Vec<[Row; 1]> = us().map(|[x, y]| [row([x, y, 0.0, 0.0])]).collect();
        let code =
            format!("let w = warped({number}u, in_f(0u).xy); out_f(0u, vec4(w.place, w.density, 0.0));");
        let out: Vec<[Row; 1]> =
            Device::guided(context, &scene, seed(), &guide).run(&code, (true, EMITTED), &inputs);
        let drawn = out.iter().map(|o| floats(o[0])).map(|[x, y, d, _]| ([x, y], d)).collect();
        claim(format!("device, warp {number}"), weights, drawn);
    }
    claims.hold();
}

/// A joton's flux, its moments along the axes and about the origin.
type Moments = [f64; 7];

fn moments(origin: DVec3, direction: DVec3, flux: f64) -> Moments {
    [1.0, direction.x, direction.y, direction.z, origin.x, origin.y, origin.z].map(|x| x * flux)
}

/// What caustic jotons carry, one by one.
fn emitted(side: Side, scene: &PackedScene, guide: &Guide, purpose: u32) -> Option<Vec<Moments>> {
    let numbers = (0..COUNT).map(|i| joton::sampling::rng::pcg4d([i, purpose, 0, seed()])[0]);
    if side == Side::Host {
        let one = |i| match harness::emit(scene, guide, seed(), true, i, EMITTED) {
            Some((origin, direction, flux)) => {
                moments(origin.as_dvec3(), direction.as_dvec3(), f64::from(flux[0]))
            }
            None => [0.0; 7],
        };
        return Some(numbers.map(one).collect());
    }
    let code = "prepare_emission(); let s = emit(in_u(0u).x);
        out_f(0u, vec4(s.origin, 0.0)); out_f(1u, vec4(s.direction, 0.0)); out_f(2u, vec4(s.flux, 0.0));";
    let inputs: Vec<[Row; 1]> = numbers.map(|i| [[i, 0, 0, 0]]).collect();
    let mut device = Device::guided(crate::common::device()?, scene, seed(), guide);
    let out: Vec<[Row; 3]> = device.run(code, (true, EMITTED), &inputs);
    Some(out.into_iter().map(|[o, d, f]| moments(dvec3(o), dvec3(d), dvec3(f).x)).collect())
}

/// Mean and its variance.
fn mean(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = f64::from(COUNT);
    let mean = values.clone().sum::<f64>() / count;
    [mean, values.map(|x| (x - mean).powi(2)).sum::<f64>() / (count * (count - 1.0))]
}

/// Many lights of every kind, outside of all spheres and within one.
fn every_light(b: &mut Builder) {
    let lamp = b.material(emitter(2.0, 0.0));
    b.quad([-0.5, 1.5, -0.5], [1., 0., 0.], [0., 0., 1.], lamp);
    b.quad([0.3, 0.1, 0.0], [0.1, 0., 0.], [0., 0., 0.1], lamp);
    b.point_light([0.4, 1.2, -0.3], 0.3);
    b.point_light([-0.5, -0.1, 0.4], 0.2);
    let direction = DVec3::new(-1.0, -1.7, -0.5).normalize();
    for position in [DVec3::new(1.0, 1.5, 0.5), DVec3::new(0.3, 0.2, 0.1)] {
        let [angle_inner, angle_outer] = [0.97, 0.9].map(f64::acos);
        b.scene.lights.push(Light::Spot {
            position,
            direction,
            intensity: [2.0; 3],
            angle_inner,
            angle_outer,
        });
    }
    b.scene.lights.push(Light::Sun { direction, irradiance: [0.5; 3] });
}

/// Flux, where it starts and where it goes are those of unguided jotons, whatever the guide has learned: sums over all
/// lights, and over both laws.
#[test]
fn guided_jotons_carry_the_same_light() {
    let scene = three_glass_spheres(every_light);
    let normal = Normal::standard();
    let mut claims = Claims::default();
    for side in [Side::Host, Side::Device] {
        let Some(plain) = emitted(side, &scene, &Guide::default(), 1) else { continue };
        let Some(guided) = emitted(side, &scene, &misled(&scene), 2) else { continue };
        for k in 0..7 {
            let [a, b] = [&plain, &guided].map(|m| mean(m.iter().map(|m| m[k])));
            let z = (a[0] - b[0]) / (a[1] + b[1]).sqrt();
            // a guide that changes nothing would pass, too
            assert!(b[1] > 1.5 * a[1], "{side:?}, sum {k}: variances {} and {}", a[1], b[1]);
            claims.add(format!("{side:?}, sum {k}: {z:+.1}"), 2.0 * normal.sf(z.abs()));
        }
    }
    claims.hold();
}

/// Radii that do not know how many jotons there are: those of the smallest discs.
fn fixed_radius(plan: &mut Plan) {
    plan.caustic.base *= 0.1;
}

/// The caustic is the same by what was learned, unguided, and by nonsense.
#[test]
fn guided_caustics_are_the_same() {
    const SIZE: u32 = 24;
    let scene = Arc::new(PackedScene::new(&file("pool.toml", SIZE)));
    assert!(!plan(&scene, CAUSTIC, 0).guides.caustic.warps().is_empty(), "something is learned");
    let images = |side, guide: Option<Guide>, first: u32| {
        let p = pictures(side, &scene, CAUSTIC, first..first + 6, 4, |plan| {
            fixed_radius(plan);
            if let Some(guide) = &guide {
                plan.guides = Arc::new(caustic(guide));
            }
        });
        layer(&p, Layer::Caustic)
    };
    let mut claims = Claims::default();
    for side in [Side::Host, Side::Device] {
        if side == Side::Device && crate::common::device().is_none() {
            continue;
        }
        let plain = images(side, Some(Guide::default()), 0);
        for (name, guided) in
            [("learned", images(side, None, 10)), ("misled", images(side, Some(misled(&scene)), 20))]
        {
            for block in [4, SIZE] {
                let [a, b] = [&plain, &guided]
                    .map(|i| Estimate::from_renders(i, block).unwrap_or_else(|e| panic!("{e}")));
                let outcome = test_equal(&a, &b).unwrap_or_else(|e| panic!("{e}"));
                claims.add(format!("{side:?}, {name}, blocks of {block}"), outcome.p_value);
            }
        }
    }
    claims.hold();
}

/// A guide that has learned to look away: most jotons go one way, and least to the strongest lights.
fn lopsided(scene: &PackedScene) -> Guide {
    let weights: Vec<f64> = scene.emitters.iter().map(|e| 1.0 / (0.1 + f64::from(e.pick))).collect();
    let bins: Vec<f64> = (0..BINS)
        .map(|i| [1.0, 30.0][usize::from(i < BINS / 2)] * [1.0, 20.0][i / (WARP_BINS / 2) % 2])
        .collect();
    Guide::new(&scene.emitters, &weights, vec![Warp::new(&bins)], |_| Some(0), 1.0)
}

/// A box under a lamp, a point, a spot and a sun.
fn box_under_all_kinds(size: u32) -> PackedScene {
    let mut b = Builder { scene: file("cornell.toml", size) };
    b.point_light([0.2, 0.4, 0.3], 0.3);
    let (center, down) = (DVec3::new(0.4, 0.5, 0.2), DVec3::new(0.1, -1.0, 0.2).normalize());
    let light = |intensity| Light::Spot {
        position: center,
        direction: down,
        intensity: [intensity; 3],
        angle_inner: f64::acos(0.9),
        angle_outer: f64::acos(0.7),
    };
    b.scene.lights.push(light(0.5));
    b.scene
        .lights
        .push(Light::Sun { direction: DVec3::new(0.1, -0.3, 1.0).normalize(), irradiance: [0.5; 3] });
    PackedScene::new(&b.scene)
}

/// Direct and diffuse light are the same unguided and misled, and with a shadow ray for one of eight light samples: shadow
/// rays, starts and ways of all kinds of lights.
#[test]
fn guided_light_is_the_same() {
    const SIZE: u32 = 24;
    let scene = Arc::new(box_under_all_kinds(SIZE));
    let mut claims = Claims::default();
    for side in [Side::Host, Side::Device] {
        if side == Side::Device && crate::common::device().is_none() {
            continue;
        }
        for (way, planner) in [("map", plan_by_map as Planner), ("paths", plan)] {
            let renders = |guide: &Guide, candidates: u32, first: u32| {
                pictures_of(planner, side, &scene, "L.*E", first..first + 10, 4, |plan| {
                    plan.light_candidates = candidates;
                    plan.guides = Arc::new(Guides {
                        diffuse: guide.clone(),
                        direct: guide.clone(),
                        ..Guides::default()
                    });
                })
            };
            let (plain, guided) = (renders(&Guide::default(), 1, 0), renders(&lopsided(&scene), 8, 20));
            for which in [Layer::Direct, Layer::Diffuse] {
                for block in [4, SIZE] {
                    let [a, b] = [&plain, &guided].map(|p| {
                        Estimate::from_renders(&layer(p, which), block).unwrap_or_else(|e| panic!("{e}"))
                    });
                    let outcome = test_equal(&a, &b).unwrap_or_else(|e| panic!("{e}"));
                    claims.add(
                        format!("{side:?}, {way}, {}, blocks of {block}", which.name()),
                        outcome.p_value,
                    );
                }
            }
        }
    }
    claims.hold();
}

/// Lamps of the room beside the pool, and how many times its light's flux each has.
const LAMPS: u32 = 50;
const LAMP_FLUX: f32 = 100.0;
/// Side of the pool's square light.
const LIGHT_SIDE: f64 = 0.1;

/// The pool and, beside it, a closed room with a ball of glass and so many lamps.
fn pool_and_lamps(size: u32, lamps: u32) -> PackedScene {
    let mut b = Builder { scene: file("pool.toml", size) };
    let tiny = b.scene.materials.iter().map(|m| m.emission[0]).fold(0.0, f32::max);
    let walls = b.matte(0.5);
    let ball = b.material(glass(1.5));
    let lamp = b.material(emitter(tiny * LAMP_FLUX, 0.0));
    b.room([2.0, 0.0, 0.0], [4.0, 1.0, 2.0], walls);
    b.icosphere([3.0, 0.4, 1.0], 0.2, 1, false, ball);
    for i in 0..lamps {
        let at = [2.1 + 0.18 * f64::from(i % 10), 0.99, 0.2 + 0.3 * f64::from(i / 10)];
        b.quad(at, [LIGHT_SIDE, 0., 0.], [0., 0., LIGHT_SIDE], lamp);
    }
    PackedScene::new(&b.scene)
}

/// Variance of the caustic layer over its squared mean, by the plan's guide or another.
fn noise(side: Side, lamps: u32, guide: Option<Guide>) -> f64 {
    const SIZE: u32 = 32;
    let scene = Arc::new(pool_and_lamps(SIZE, lamps));
    let p = pictures(side, &scene, CAUSTIC, 0..10, 2, |plan| {
        fixed_radius(plan);
        if let Some(guide) = &guide {
            plan.guides = Arc::new(caustic(guide));
        }
    });
    let e = Estimate::from_renders(&layer(&p, Layer::Caustic), 1).unwrap_or_else(|e| panic!("{e}"));
    let all = |x: &[[f64; 3]]| x.iter().flatten().sum::<f64>();
    all(&e.variance) / all(&e.mean).powi(2)
}

/// A tiny light over a pool, among fifty strong lamps elsewhere: its caustic has as little noise as without them, but for
/// the tenth of the jotons that goes by flux, and for the error of a variance from ten seeds,
/// 0.02.
#[test]
fn a_tiny_light_among_strong_ones_is_found() {
    for side in [Side::Host, Side::Device] {
        if side == Side::Device && crate::common::device().is_none() {
            continue;
        }
        let ratio = noise(side, LAMPS, None) / noise(side, 0, None);
        println!("{side:?}: variance {ratio:.3} times that without lamps");
        assert!(ratio < 1.2, "{side:?}: {ratio}");
    }
}

/// The light lies inside the sphere about the water, where nothing can be aimed: what is learned takes its place. Of the
/// noise that is left a part is the pixels' own.
#[test]
fn learning_lowers_the_noise() {
    let ratio = noise(Side::Host, 0, None) / noise(Side::Host, 0, Some(Guide::default()));
    println!("variance {ratio:.3} times that by the light's law");
    assert!(ratio < 0.7, "{ratio}");
}

/// What is learned is the same whatever paths are wanted, so that parts of an image add up.
#[test]
fn what_is_learned_does_not_depend_on_paths() {
    let scene = pool_and_lamps(24, LAMPS);
    let guides = ["L.*E", CAUSTIC, "LSSDE|LDE"].map(|paths| plan(&scene, paths, 3).guides.caustic.clone());
    assert!(!guides[0].is_empty());
    // no dump of tables where they differ
    assert!(guides[0] == guides[1] && guides[0] == guides[2]);
}

/// Part of the jotons that are picked by flux, whatever was learned.
const BY_FLUX: f64 = 0.1;

/// No light is given up: each keeps its part of a tenth of the jotons, be there two or twenty thousand of them.
#[test]
fn every_light_keeps_a_share() {
    const STEP: f64 = 1.0 / (1 << 24) as f64;
    let many = || {
        let mut b = Builder { scene: file("pool.toml", 24) };
        for i in 0..20_000 {
            let [x, y, z, _] = joton::sampling::rng::random4(9, 0, i, 0).map(f64::from);
            b.point_light([3.0 + x, y, z], 1e-3 * (i % 7 + 1) as f32);
        }
        PackedScene::new(&b.scene)
    };
    for scene in [pool_and_lamps(24, LAMPS), many()] {
        let guide = plan(&scene, CAUSTIC, 0).guides.caustic.clone();
        assert!(!guide.is_empty());
        let picks = guide.emitters(&scene.emitters);
        let total: f64 = scene.total_flux.iter().sum();
        let mut upto = 0.0;
        for (e, plain) in picks.iter().zip(&scene.emitters) {
            let share = plain.flux.iter().map(|&f| f64::from(f)).sum::<f64>() / total;
            assert!(f64::from(e.pick) > BY_FLUX * share * 0.999 - STEP, "{} of {share}", e.pick);
            upto += f64::from(e.pick);
            assert_eq!(f64::from(e.cumulative), upto);
        }
        assert_eq!(upto, 1.0);
    }
}
