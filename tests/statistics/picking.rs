//! Picking: emitters by their flux, and places in a pixel.

use crate::chi_square::{Claims, draws, in_square, p_value, seed};
use crate::common::scenes::{Builder, emitter};
use crate::common::{Row, dvec3, floats};
use crate::device::Device;
use crate::directions::inputs;
use glam::DVec3;
use joton::backend::cpu::harness;
use joton::packed::PackedScene;
use joton::spectrum::sum;

const COUNT: u32 = 1 << 20;
/// Bins across what is left of the number that picks.
const REST_BINS: usize = 16;

/// Lights of very different flux.
fn lights() -> PackedScene {
    let mut b = Builder::new([0., 0., 3.], [0.; 3], [0., 1., 0.], 0.5, 96);
    b.scene.resize([96, 64]);
    let floor = b.matte(0.5);
    b.quad([-1., -1., -1.], [0., 0., 2.], [2., 0., 0.], floor);
    for (i, radiance) in [0.01, 1.0, 0.3, 5.0].into_iter().enumerate() {
        let lamp = b.material(emitter(radiance, 0.0));
        b.quad([-1.0 + 0.5 * i as f64, 1., 0.], [0.3, 0., 0.], [0., 0., 0.2 + 0.1 * i as f64], lamp);
    }
    b.point_light([0.5; 3], 0.02);
    PackedScene::new(&b.scene)
}

/// Each emitter is picked by its share of the flux, and what is left of the number is uniform whatever it picked.
#[test]
fn emitters_are_picked_by_flux() {
    let scene = lights();
    let emitters = &scene.emitters;
    assert_eq!(emitters.len(), 9);
    let total: f64 = emitters.iter().map(|e| sum(&e.flux)).sum();
    let mut claims = Claims::default();
    let mut claim = |side: &str, picks: &mut dyn Iterator<Item = (usize, f32)>| {
        let mut counts = vec![0.0; emitters.len() * REST_BINS];
        let mut all = 0.0;
        for (i, rest) in picks {
            assert!((0.0..1.0).contains(&rest), "{side}: {rest} is left");
            counts[i * REST_BINS + (rest * REST_BINS as f32) as usize] += 1.0;
            all += 1.0;
        }
        let expected: Vec<f64> = emitters
            .iter()
            .flat_map(|e| [all * sum(&e.flux) / total / REST_BINS as f64; REST_BINS])
            .collect();
        claims.add(side, p_value(&counts, &expected));
    };
    claim("host", &mut draws(30, COUNT).map(|u| harness::pick(emitters, u[0])));
    if let Some(context) = crate::common::device() {
        let code = "let p = pick_emitter(in_f(0u).x, pass_info.emitters);
            out_u(0u, vec4(p.emitter, bitcast<u32>(p.rest), 0u, 0u));";
        let out: Vec<[Row; 1]> =
            Device::new(context, &scene, seed()).run(code, (false, 1), &inputs(31, COUNT));
        claim("device", &mut out.iter().map(|o| (o[0][0] as usize, f32::from_bits(o[0][1]))));
    }
    claims.hold();
}

/// Camera rays fill their pixels evenly (box filter, one pixel wide), and each pixel on its own.
#[test]
fn camera_rays_fill_the_pixels() {
    const PASSES: u32 = 64;
    let scene = lights();
    let [width, height] = scene.size;
    let [eye_right, eye_up, forward] =
        [scene.camera.right, scene.camera.up, scene.camera.forward].map(|v| v.as_dvec3());
    // where in its pixel a direction leads; rays are rounded at 1e-5 of a pixel
    let place = |pixel: u32, d: DVec3| {
        let d = d / d.dot(forward);
        let along = |v: DVec3| d.dot(v) / v.length_squared();
        let x = (1.0 + along(eye_right)) / 2.0 * f64::from(width) - f64::from(pixel % width);
        let y = (1.0 - along(eye_up)) / 2.0 * f64::from(height) - f64::from(pixel / width);
        [x, y].map(|x| {
            assert!((-1e-3..1.0 + 1e-3).contains(&x), "pixel {pixel}: {x}");
            x.clamp(0.0, 1.0 - 1e-9)
        })
    };
    let samples: Vec<(u32, u32)> =
        (0..width * height).flat_map(|pixel| (0..PASSES).map(move |pass| (pixel, pass))).collect();
    let mut claims = Claims::default();
    let mut claim = |side: &str, directions: &[DVec3]| {
        let places: Vec<[f64; 2]> =
            samples.iter().zip(directions).map(|(&(pixel, _), &d)| place(pixel, d)).collect();
        for pass in [0, 1, 5, PASSES - 1] {
            // pixels are independent of each other
            let of_pass = places.iter().skip(pass as usize).step_by(PASSES as usize);
            claims.add(format!("{side}, pass {pass}"), in_square(of_pass.map(|p| Some(*p)), |_| 1.0));
        }
        claims.add(format!("{side}, all"), in_square(places.iter().map(|p| Some(*p)), |_| 1.0));
        for (pixel, of_pixel) in places.chunks_exact(PASSES as usize).enumerate() {
            // stratified over the passes: one in each of 64 cells
            let mut cells = [0; PASSES as usize];
            for [x, y] in of_pixel {
                cells[(y * 8.0) as usize * 8 + (x * 8.0) as usize] += 1;
            }
            let misplaced = cells.iter().filter(|c| **c != 1).count();
            // a ray on the edge of a cell may be rounded into the next
            assert!(misplaced <= 2, "{side}, pixel {pixel}: {cells:?}");
        }
    };
    let host =
        |&(pixel, pass): &(u32, u32)| harness::camera_direction(&scene, seed(), pixel, pass).as_dvec3();
    claim("host", &samples.iter().map(host).collect::<Vec<_>>());
    if let Some(context) = crate::common::device() {
        let code = "let i = in_u(0u);
            let jitter = sobol2(i.y, sequence_seed(pass_info.seed, i.x, STREAM_JITTER));
            out_f(0u, vec4(camera_ray(i.x, jitter).direction, 0.0));";
        let inputs: Vec<[Row; 1]> = samples.iter().map(|&(pixel, pass)| [[pixel, pass, 0, 0]]).collect();
        let out: Vec<[Row; 1]> = Device::new(context, &scene, seed()).run(code, (false, 1), &inputs);
        assert!(out.iter().all(|o| floats(o[0])[0].is_finite()));
        claim("device", &out.iter().map(|o| dvec3(o[0])).collect::<Vec<_>>());
    }
    claims.hold();
}
