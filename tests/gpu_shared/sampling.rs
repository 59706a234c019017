//! sampling/sampling.wgsl against its formulas in f64.
//!
//! The kernels take no sine from the driver: Vulkan grants it an error of 2^-11. Tolerances on directions are a few roundings
//! of f32, and three ulp of a square root.

use crate::common::{Row, Snippet, dvec3, floats, random, random_direction, row, row3, vec3};
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::sampling::distributions::unit_circle;
use std::f64::consts::{PI, TAU};

const IMPORTS: &[&str] = &["sampling/sampling.wgsl"];
const COUNT: usize = 4096;

/// Random directions, the axes, and what lies next to the seam of the frame (z = ±0, z = −1).
fn directions() -> Vec<Vec3> {
    let mut all: Vec<Vec3> = (0..COUNT).map(|i| random_direction(1, i)).collect();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        all.extend([axis, -axis]);
    }
    for e in [1e-3f32, 1e-4, 1e-6, 1e-10, 1e-20] {
        for s in [e, -e] {
            all.extend(
                [Vec3::new(s, 0.0, -1.0), Vec3::new(0.0, s, -1.0), Vec3::new(1.0, 0.0, s)]
                    .map(Vec3::normalize),
            );
        }
    }
    all.push(Vec3::new(1.0, 0.0, -0.0));
    all.push(Vec3::new(0.6, 0.8, -0.0));
    all
}

/// Pairs in [0, 1): random ones and the corners that the generator can give.
fn unit_pairs() -> Vec<[f32; 2]> {
    const LAST: f32 = 1.0 - 1.0 / 16_777_216.0;
    let edges = [0.0, 1.0 / 16_777_216.0, 0.25, 0.5, 0.75, LAST];
    let mut all: Vec<[f32; 2]> = edges.iter().flat_map(|&a| edges.map(|b| [a, b])).collect();
    all.extend((0..COUNT).map(|i| [random(2, i)[0], random(2, i)[1]]));
    all
}

#[test]
fn frames_are_orthonormal_and_right_handed() {
    let context = device_or_return!();
    let inputs: Vec<[Row; 1]> = directions().iter().map(|d| [row3(*d, 0.0)]).collect();
    let code = "let b = basis(in_f(0u).xyz);
        out_f(0u, vec4(b[0], 0.0)); out_f(1u, vec4(b[1], 0.0)); out_f(2u, vec4(b[2], 0.0));";
    let out: Vec<[Row; 3]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for ([n], o) in inputs.iter().zip(out) {
        let [x, y, z] = o.map(dvec3);
        assert_eq!(vec3(o[2]), vec3(*n));
        // a few roundings of f32 in products of ones; inputs are unit to 1e-7 themselves
        for (name, value, wanted) in [
            ("x·x", x.dot(x), 1.0),
            ("y·y", y.dot(y), 1.0),
            ("x·y", x.dot(y), 0.0),
            ("x·z", x.dot(z), 0.0),
            ("y·z", y.dot(z), 0.0),
        ] {
            assert!((value - wanted).abs() < 2e-6, "{name} = {value} for {z}");
        }
        assert!((x.cross(y) - z).length() < 3e-6, "left-handed for {z}");
    }
}

/// cos and sin of 2π u, u in f32 as the kernels see it.
fn around(u: f32) -> (f64, f64) {
    let phi = TAU * f64::from(u);
    (phi.cos(), phi.sin())
}

/// Places on the circle: the roundings of three numbers up to one, 2^-24 each, against f64, twice that against the host.
const CIRCLE_ERROR: f64 = 3.0 / 16_777_216.0;

/// Over the whole of [0, 1), at its ends and on both sides of the seams between the polynomials, on every driver.
#[test]
fn the_circle_is_that_of_f64_and_of_the_host() {
    let context = device_or_return!();
    const STEPS: u32 = 1 << 24;
    let seams = (0..=16).flat_map(|k| (0..8).map(move |d| (k * (STEPS / 16) + d).saturating_sub(4)));
    let numbers = seams.chain((0..STEPS).step_by(127)).map(|i| i.min(STEPS - 1) as f32 / STEPS as f32);
    let inputs: Vec<[Row; 1]> = numbers.map(|u| [row([u, 0.0, 0.0, 0.0])]).collect();
    let code = "out_f(0u, vec4(unit_circle(in_f(0u).x), 0.0, 0.0));";
    let out: Vec<[Row; 1]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for ([i], [o]) in inputs.iter().zip(out) {
        let [u, ..] = floats(*i);
        let [x, y, ..] = floats(o).map(f64::from);
        let (cos, sin) = around(u);
        assert!((x - cos).abs() < CIRCLE_ERROR && (y - sin).abs() < CIRCLE_ERROR, "{u}: {x} {y}");
        let host = unit_circle(u).map(f64::from);
        assert!((x - host[0]).abs().max((y - host[1]).abs()) < 2.0 * CIRCLE_ERROR, "{u}: {x} {y}, {host:?}");
    }
}

#[test]
fn hemisphere_triangle_and_disc_are_their_formulas() {
    let context = device_or_return!();
    let inputs: Vec<[Row; 1]> = unit_pairs().iter().map(|u| [row([u[0], u[1], 0.0, 0.0])]).collect();
    let code = "let u = in_f(0u).xy;
        out_f(0u, vec4(sample_cosine_hemisphere(u), 0.0));
        out_f(1u, vec4(sample_triangle(u), sample_disc(u)));";
    let out: Vec<[Row; 2]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for ([i], [hemisphere, rest]) in inputs.iter().zip(out) {
        let [u, v, ..] = floats(*i);
        let (cos, sin) = around(v);
        let r = f64::from(u).sqrt();
        let expected = DVec3::new(r * cos, r * sin, (1.0 - f64::from(u)).sqrt());
        assert!((dvec3(hemisphere) - expected).length() < 1e-6, "hemisphere {u} {v}");
        assert!(vec3(hemisphere).z > 0.0, "a direction below the horizon: {u} {v}");
        let [b1, b2, x, y] = floats(rest).map(f64::from);
        assert!((b1 - (1.0 - r)).abs() < 1e-6 && (b2 - f64::from(v) * r).abs() < 1e-6, "triangle {u} {v}");
        assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 + 1e-6, "outside the triangle: {u} {v}");
        assert!((x - r * cos).abs() < 1e-6 && (y - r * sin).abs() < 1e-6, "disc {u} {v}");
    }
}

/// Cones from a hemisphere to one part in 10^12 of it: the tilt keeps its relative accuracy, however narrow.
#[test]
fn cones_keep_their_digits() {
    let context = device_or_return!();
    let sizes = [2.0f32, 1.0, 0.5, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];
    let pairs = unit_pairs();
    let inputs: Vec<[Row; 1]> = sizes
        .iter()
        .flat_map(|&size| pairs.iter().take(600).map(move |u| [row([u[0], u[1], size, 0.0])]))
        .collect();
    let code = "let i = in_f(0u); out_f(0u, vec4(sample_cone(i.xy, i.z), 0.0));";
    let out: Vec<[Row; 1]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for ([i], [o]) in inputs.iter().zip(out) {
        let [u, v, size, _] = floats(*i).map(f64::from);
        let below = u * size;
        let r = (below * (2.0 - below)).max(0.0).sqrt();
        let d = dvec3(o);
        assert!((d.z - (1.0 - below)).abs() < 1e-6, "z of {u} {v} in {size}: {d}");
        let across = d.truncate().length();
        // near the antipode the sine loses digits, where it does not matter: 2 − below rounds
        assert!(
            (across - r).abs() <= 2e-6 * r + if size == 2.0 { 5e-4 } else { 0.0 },
            "sine of {u} {v} in {size}: {d}"
        );
        let (cos, sin) = around(v as f32);
        assert!((d.x - across * cos).abs() < 1e-6 * across.max(1e-30) + 1e-12);
        assert!((d.y - across * sin).abs() < 1e-6 * across.max(1e-30) + 1e-12);
    }
}

#[test]
fn phong_lobe_is_its_formula() {
    let context = device_or_return!();
    let pairs = unit_pairs();
    let inputs: Vec<[Row; 1]> = [0.0f32, 1.0, 5.0, 20.0, 100.0, 300.0, 1000.0, 1e5]
        .iter()
        .flat_map(|&e| pairs.iter().take(600).map(move |u| [row([u[0], u[1], e, 0.0])]))
        .collect();
    let code = "let i = in_f(0u); out_f(0u, vec4(sample_phong_lobe(i.xy, i.z), 0.0));";
    let out: Vec<[Row; 1]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for ([i], [o]) in inputs.iter().zip(out) {
        let [u, _, e, _] = floats(*i).map(f64::from);
        let z = u.powf(1.0 / (e + 1.0));
        let d = dvec3(o);
        // pow may err by 16 ulp and more (exp2 of a rounded product)
        assert!((d.z - z).abs() < 5e-6, "z of {u}, exponent {e}: {} against {z}", d.z);
        assert!((d.length() - 1.0).abs() < 2e-6, "{d}");
    }
}

/// Half a step of the 16-bit grid, 1/65534, in x and y moves the point of the octahedron by √6 of it, and the octahedron's
/// faces lie 1/√3 from the centre: √18/65534, and roundings of f32.
const OCTAHEDRAL_ERROR: f64 = 4.2427 / 65_534.0 + 3e-7;

#[test]
fn directions_survive_32_bits() {
    let context = device_or_return!();
    let all = directions();
    let inputs: Vec<[Row; 1]> = all
        .iter()
        .map(|d| [row3(*d, f32::from_bits(joton::backend::gpu::harness::encode_direction(*d)))])
        .collect();
    let code = "let i = in_f(0u);
        let e = encode_direction(i.xyz);
        out_f(0u, vec4(decode_direction(e), bitcast<f32>(e)));
        out_f(1u, vec4(decode_direction(in_u(0u).w), 0.0));
        out_f(2u, vec4(from_octahedral(octahedral(i.xyz)), 0.0));";
    let out: Vec<[Row; 3]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    let mut worst = 0.0f64;
    for (d, [device, host, unrounded]) in all.iter().zip(out) {
        let d = d.as_dvec3().normalize();
        let error = (dvec3(device) - d).length();
        worst = worst.max(error);
        assert!(error < OCTAHEDRAL_ERROR, "{d} comes back as {}", dvec3(device));
        assert!((dvec3(host) - d).length() < OCTAHEDRAL_ERROR, "the host's code of {d} is {}", dvec3(host));
        assert!((dvec3(unrounded) - d).length() < 1e-6, "{d} through the plane is {}", dvec3(unrounded));
        assert!((dvec3(device).length() - 1.0).abs() < 1e-6);
    }
    assert!(worst > 1e-6, "the bound is of the right order: worst error {worst}");
}

/// Half of 1/127 a component: at most √3/254 off.
#[test]
fn normals_survive_24_bits() {
    let context = device_or_return!();
    let all = directions();
    let inputs: Vec<[Row; 1]> = all.iter().map(|d| [row3(*d, 0.0)]).collect();
    let code = "let e = encode_normal24(in_f(0u).xyz);
        out_f(0u, vec4(decode_normal24(e), 0.0));
        out_f(1u, vec4(decode_normal24(e | 0xab000000u), f32(e >> 24u)));";
    let out: Vec<[Row; 2]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for (d, [clean, with_state]) in all.iter().zip(out) {
        let back = dvec3(clean) / 127.0;
        assert!((back - d.as_dvec3()).length() <= 3f64.sqrt() / 254.0 + 1e-6, "{d} comes back as {back}");
        assert_eq!(vec3(with_state), vec3(clean), "the state in the top bits changes the normal");
        assert_eq!(floats(with_state)[3], 0.0, "the code of a normal has 24 bits");
    }
}

/// The laws that the formulas stand for: moments over a stratified square.
#[test]
fn samples_have_the_moments_of_their_laws() {
    let context = device_or_return!();
    const N: u32 = 1 << 14;
    let inputs: Vec<[Row; 1]> = (0..N)
        .map(|i| {
            let [a, b] = joton::sampling::rng::sobol2(i, 5);
            [row([a, b, 0.0, 0.0])]
        })
        .collect();
    let code = "let u = in_f(0u).xy;
        out_f(0u, vec4(sample_cosine_hemisphere(u), 0.0));
        out_f(1u, vec4(sample_cone(u, 0.1), 0.0));
        out_f(2u, vec4(sample_phong_lobe(u, 20.0), 0.0));
        out_f(3u, vec4(sample_triangle(u), sample_disc(u)));";
    let out: Vec<[Row; 4]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    let mean = |f: &dyn Fn(&[[f64; 4]; 4]) -> f64| {
        out.iter().map(|o| f(&o.map(|r| floats(r).map(f64::from)))).sum::<f64>() / f64::from(N)
    };
    let c = 0.9;
    for (name, got, wanted) in [
        ("E cosθ of the cosine law", mean(&|o| o[0][2]), 2.0 / 3.0),
        ("E cos²θ of the cosine law", mean(&|o| o[0][2] * o[0][2]), 0.5),
        ("E x of the cosine law", mean(&|o| o[0][0]), 0.0),
        ("E z of the cone", mean(&|o| o[1][2]), (1.0 + c) / 2.0),
        ("E z of Phong's lobe", mean(&|o| o[2][2]), 21.0 / 22.0),
        ("E z² of Phong's lobe", mean(&|o| o[2][2] * o[2][2]), 21.0 / 23.0),
        ("E of the first weight", mean(&|o| o[3][0]), 1.0 / 3.0),
        ("E of the second weight", mean(&|o| o[3][1]), 1.0 / 3.0),
        ("E of their product", mean(&|o| o[3][0] * o[3][1]), 1.0 / 12.0),
        ("area of the disc by r²", mean(&|o| o[3][2] * o[3][2] + o[3][3] * o[3][3]) * 2.0 * PI, PI),
    ] {
        // 2^14 stratified points of smooth functions: errors of 1e-4
        assert!((got - wanted).abs() < 1e-3, "{name}: {got} against {wanted}");
    }
}
