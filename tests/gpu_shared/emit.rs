//! lights/emit.wgsl: aimed emission carries the flux that goes through the cones of the targets and nothing else; plain
//! emission carries all of it, by the emitter's own law. The reference integrates the emitter's law in f64 and knows
//! nothing of aiming.

use crate::common::scenes::{Builder, emitter, glass, three_glass_spheres};
use crate::common::{Row, Snippet, dvec3, map_info, pass_info};
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::backend::cpu::harness::emit;
use joton::backend::gpu::harness::Harness;
use joton::packed::{Guide, PackedEmitter, PackedScene};
use joton::plan::{Plan, Settings};
use joton::sampling::rng::seed_at;
use joton::scene::Light;
use std::f64::consts::{PI, TAU};

const COUNT: u32 = 1 << 18;

/// What is summed over jotons: flux (first band), flux times direction, flux times origin.
type Sums = [f64; 7];

fn add(sums: &mut Sums, flux: f64, direction: DVec3, origin: DVec3) {
    let terms = [1.0, direction.x, direction.y, direction.z, origin.x, origin.y, origin.z];
    for (s, t) in sums.iter_mut().zip(terms) {
        *s += flux * t;
    }
}

/// Emit COUNT jotons on the device.
fn device_jotons(
    context: &joton::backend::gpu::Context,
    scene: &PackedScene,
    caustic: bool,
) -> Vec<[Row; 3]> {
    jotons_from(context, scene, caustic, 0, COUNT)
}

/// Emit so many jotons from this index of the sequences on.
fn jotons_from(
    context: &joton::backend::gpu::Context,
    scene: &PackedScene,
    caustic: bool,
    first: u64,
    count: u32,
) -> Vec<[Row; 3]> {
    let plan = Plan::new(scene, Settings::default());
    let mut harness = Harness::with_scene(context, scene, &plan).unwrap_or_else(|e| panic!("{e}"));
    let snippet = Snippet {
        imports: &["scene/features.wgsl", "scene/scene.wgsl", "shading/surface.wgsl", "lights/emit.wgsl"],
        declarations: "override CAUSTIC: bool = false;
            @group(1) @binding(0) var<uniform> map_info: MapInfo;
            @group(1) @binding(1) var<uniform> targets: array<Target, 16>;\n",
        code: "prepare_emission(); let s = emit(in_u(0u).x);
            out_f(0u, vec4(s.origin, 0.0)); out_f(1u, vec4(s.direction, 0.0)); out_f(2u, vec4(s.flux, 0.0));",
        overrides: &[("CAUSTIC", if caustic { 1.0 } else { 0.0 })],
    };
    let mut pass = pass_info();
    pass.emitters = scene.emitters.len() as u32;
    pass.targets = scene.targets.len() as u32;
    pass.seed = 5;
    let mut map = map_info();
    map.emitted = COUNT;
    map.first_joton = first as u32;
    let high = (first >> 32) as u32;
    (map.seed, map.seed_wrapped) = (seed_at(pass.seed, high), seed_at(pass.seed, high.wrapping_add(1)));
    let per_pass: [(&str, &[u8]); 2] =
        [("pass_info", bytemuck::bytes_of(&pass)), ("map_info", bytemuck::bytes_of(&map))];
    let inputs: Vec<[Row; 1]> = (0..count).map(|i| [[i, 0, 0, 0]]).collect();
    snippet.run_in(context, &mut harness, &per_pass, &inputs)
}

/// Pass p and pass p + 2^32 / jotons start jotons of their own, as the host says; and so do those that lie across a multiple
/// of 2^32.
#[test]
fn starts_do_not_come_again() {
    let context = device_or_return!();
    const FEW: u32 = 512;
    let scene = three_glass_spheres(|b| b.point_light([0.4, 1.2, -0.3], 3.0));
    let period = (1u64 << 32) / u64::from(COUNT);
    let firsts = [3, 3 + period, 3 + 5 * period].map(|pass| pass * u64::from(COUNT));
    let mut seen: Vec<Vec<[Row; 3]>> = Vec::new();
    for first in firsts.into_iter().chain([(1 << 32) - 100]) {
        let found = jotons_from(context, &scene, true, first, FEW);
        let (mut near, mut lit) = (0, 0);
        for (number, [origin, direction, flux]) in (0u64..).zip(&found) {
            let host = emit(&scene, &Guide::default(), 5, true, first + number, COUNT);
            assert_eq!(host.is_some_and(|h| h.2[0] > 0.0), dvec3(*flux).x > 0.0, "{first} + {number}");
            let Some((o, d, f)) = host.filter(|h| h.2[0] > 0.0) else { continue };
            lit += 1;
            let off = (dvec3(*origin) - o.as_dvec3()).length() / 1000.0
                + (dvec3(*direction) - d.as_dvec3()).length();
            let flux = (dvec3(*flux).x / f64::from(f[0]) - 1.0).abs();
            near += u32::from(off < 1e-4 && flux < 1e-3);
        }
        // rounding may send one into another cone
        assert!(lit > FEW / 4 && near + 2 >= lit, "from {first} on: {near} of {lit} are the host's");
        for before in &seen {
            let same = before.iter().zip(&found).filter(|(a, b)| a[..2] == b[..2]).count();
            assert!(same < FEW as usize / 100, "from {first} on: {same} of {FEW} starts came before");
        }
        seen.push(found);
    }
}

fn sums_of(jotons: &[[Row; 3]]) -> Sums {
    let mut sums = [0.0; 7];
    for [origin, direction, flux] in jotons {
        let d = dvec3(*direction);
        assert!((d.length() - 1.0).abs() < 1e-6, "a direction of length {}", d.length());
        assert!(dvec3(*flux).min_element() >= 0.0);
        add(&mut sums, dvec3(*flux).x, d, dvec3(*origin));
    }
    sums
}

/// A frame about an axis.
fn frame(n: DVec3) -> [DVec3; 2] {
    let a = n.any_orthonormal_vector();
    [a, n.cross(a)]
}

/// The same sums by each emitter's law; with `through`, only what meets the bounding sphere of a target.
fn law(scene: &PackedScene, through: bool) -> Sums {
    const EACH: u32 = 1 << 18;
    let mut sums = [0.0; 7];
    let d64 = |v: Vec3| v.as_dvec3();
    for (k, e) in scene.emitters.iter().enumerate() {
        for i in 0..EACH {
            let [a, b] = joton::sampling::rng::sobol2(i, 1000 + 2 * k as u32).map(f64::from);
            let [c, d] = joton::sampling::rng::sobol2(i, 1001 + 2 * k as u32).map(f64::from);
            let (origin, direction, density) = start(e, [a, b, c, d]);
            let meets = scene.targets.iter().any(|t| {
                let off = d64(t.center) - origin;
                let along = off.dot(direction);
                off.length_squared() < f64::from(t.radius).powi(2)
                    || along > 0.0 && off.length_squared() - along * along < f64::from(t.radius).powi(2)
            });
            if meets || !through {
                let flux = f64::from(e.strength[0]) * density / f64::from(EACH);
                add(&mut sums, flux, direction, origin);
            }
        }
    }
    sums
}

/// Origin, direction and (strength's factor) flux over pdf.
fn start(e: &PackedEmitter, [a, b, c, d]: [f64; 4]) -> (DVec3, DVec3, f64) {
    let [origin, e1, e2] = [e.origin, e.e1, e.e2].map(|v| v.as_dvec3());
    let sphere = || {
        let z = 1.0 - 2.0 * c;
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * (TAU * d).cos(), r * (TAU * d).sin(), z)
    };
    match e.kind {
        0 => {
            let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            let n = e1.cross(e2).normalize();
            let [x, y] = frame(n);
            let r = c.sqrt();
            let direction = x * (r * (TAU * d).cos()) + y * (r * (TAU * d).sin()) + n * (1.0 - c).sqrt();
            (origin + e1 * a + e2 * b, direction, PI * 0.5 * e1.cross(e2).length())
        }
        1 => (origin, sphere(), 4.0 * PI),
        2 => {
            let direction = sphere();
            let x = ((e2.y - 1.0 + direction.dot(e1)) / (e2.y - e2.x)).clamp(0.0, 1.0);
            (origin, direction, 4.0 * PI * x * x * (3.0 - 2.0 * x))
        }
        _ => {
            let [x, y] = frame(e1);
            let (r, phi) = (a.sqrt() * e2.x, TAU * b);
            (origin + x * (r * phi.cos()) + y * (r * phi.sin()), e1, PI * e2.x * e2.x)
        }
    }
}

fn lamp(b: &mut Builder) {
    let m = b.material(emitter(2.0, 0.0));
    b.quad([-0.5, 1.5, -0.5], [1., 0., 0.], [0., 0., 1.], m);
}

fn spot(b: &mut Builder) {
    b.scene.lights.push(Light::Spot {
        position: DVec3::new(1.0, 1.5, 0.5),
        direction: DVec3::new(-1.0, -1.7, -0.5).normalize(),
        intensity: [2.0; 3],
        angle_inner: f64::acos(0.98),
        angle_outer: f64::acos(0.85),
    });
}

fn sun(b: &mut Builder) {
    b.scene
        .lights
        .push(Light::Sun { direction: DVec3::new(0.3, -1.0, 0.2).normalize(), irradiance: [2.0; 3] });
}

/// Sums agree: each within this part of the flux (times the scene's size for origins). Standard errors of 2^18 jotons and
/// of the reference's 2^18 samples are 2e-3 at most.
const SHARE: f64 = 6e-3;

fn assert_alike(name: &str, got: &Sums, wanted: &Sums, scene: &PackedScene) {
    let size = f64::from((scene.bounds[1] - scene.bounds[0]).length());
    for (k, (g, w)) in got.iter().zip(wanted).enumerate() {
        let unit = wanted[0] * if k < 4 { 1.0 } else { size };
        assert!((g - w).abs() < SHARE * unit, "{name}, sum {k}: {g} against {w}");
    }
}

type Case = (&'static str, fn(&mut Builder));
const CASES: [Case; 5] = [
    ("lamp", lamp),
    ("point", |b| b.point_light([0.4, 1.2, -0.3], 3.0)),
    ("spot", spot),
    ("sun", sun),
    ("all of them", |b| {
        lamp(b);
        b.point_light([0.4, 1.2, -0.3], 3.0);
        spot(b);
        sun(b);
    }),
];

#[test]
fn aimed_emission_is_the_flux_through_the_cones() {
    let context = device_or_return!();
    for (name, build) in CASES {
        let scene = three_glass_spheres(build);
        assert_eq!(scene.targets.len(), 3);
        let jotons = device_jotons(context, &scene, true);
        let wanted = law(&scene, true);
        let total = law(&scene, false)[0];
        assert!(wanted[0] < 0.5 * total, "{name}: aiming has something to do");
        assert_alike(name, &sums_of(&jotons), &wanted, &scene);
    }
}

#[test]
fn plain_emission_is_all_of_the_flux() {
    let context = device_or_return!();
    for (name, build) in CASES {
        let scene = three_glass_spheres(build);
        let jotons = device_jotons(context, &scene, false);
        let sums = sums_of(&jotons);
        assert_alike(name, &sums, &law(&scene, false), &scene);
        // a spot's jotons are weighted by the falloff, all others carry the same
        let tolerance = if name.contains("spot") || name.contains("all") { 2e-3 } else { 1e-5 };
        assert!(
            (sums[0] / scene.total_flux[0] - 1.0).abs() < tolerance,
            "{name}: {} of {}",
            sums[0],
            scene.total_flux[0]
        );
    }
}

/// A light inside a target's sphere cannot be aimed: it emits by its own law, and nothing is lost.
#[test]
fn a_light_inside_a_target_emits_everywhere() {
    let context = device_or_return!();
    let scene = three_glass_spheres(|b| b.point_light([0.3, 0.1, 0.0], 1.0));
    let sums = sums_of(&device_jotons(context, &scene, true));
    assert!((sums[0] / scene.total_flux[0] - 1.0).abs() < 1e-5);
    assert_alike("inside", &sums, &law(&scene, false), &scene);
}

/// Very small and very distant targets: the cone's measure keeps its digits.
#[test]
fn narrow_cones_carry_their_flux() {
    let context = device_or_return!();
    for radius in [1e-1, 1e-2, 1e-3, 1e-4] {
        let mut b = Builder::new([0., 1., 5.], [0.; 3], [0., 1., 0.], 0.5, 16);
        let floor = b.matte(0.5);
        let g = b.material(glass(1.5));
        b.quad([-2., -1., -2.], [0., 0., 4.], [4., 0., 0.], floor);
        b.icosphere([0.3, -0.5, 0.], radius, 0, false, g);
        b.point_light([-1.0, 0.9, 0.7], 1.0);
        let scene = PackedScene::new(&b.scene);
        let sums = sums_of(&device_jotons(context, &scene, true));
        let t = scene.targets[0];
        let d2 = (t.center - scene.emitters[0].origin).as_dvec3().length_squared();
        let sine2 = f64::from(t.radius).powi(2) / d2;
        let wanted = f64::from(scene.emitters[0].strength[0]) * TAU * (sine2 / (1.0 + (1.0 - sine2).sqrt()));
        assert!((sums[0] / wanted - 1.0).abs() < 1e-4, "radius {radius}: {} against {wanted}", sums[0]);
    }
}
