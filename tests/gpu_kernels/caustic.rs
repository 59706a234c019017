//! caustic_count.wgsl and caustic_radius.wgsl: numbers of jotons by a search over all, radii by their formula.

use super::gather::{info, joton, map, point};
use crate::common::{kernel, normal24, pass_info, random, random_direction};
use crate::device_or_return;
use glam::Vec3;
use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::packed::layout::{Fit, GatherPoint};

const WIDTH: u32 = 13;
const HEIGHT: u32 = 7;
/// Width of a pixel at unit distance.
const ANGLE: f32 = 0.01;
const FOOTPRINTS: [f32; 2] = [0.7, 4.0];
const WANTED: f32 = 15.0;

fn points() -> Vec<GatherPoint> {
    (0..(WIDTH * HEIGHT) as usize)
        .map(|i| {
            let [x, z, far, none] = random(60, i);
            let mut p = point(Vec3::new(x * 20.0, 0.0, z * 20.0), Vec3::Y, 0);
            p.path_length = 10.0 + 60.0 * far;
            if none < 0.15 {
                p.throughput = [0.0; 3];
            }
            p
        })
        .collect()
}

#[test]
fn counts_are_those_of_a_search_over_all() {
    let context = device_or_return!();
    let jotons: Vec<_> = (0..8000)
        .map(|i| {
            let [x, y, z, _] = random(61, i);
            let mut j = joton(Vec3::new(x * 20.0, (y - 0.5) * 0.6, z * 20.0), Vec3::Y, 1.0);
            j.normal_state = normal24((Vec3::Y + 0.9 * random_direction(62, i)).normalize());
            j
        })
        .collect();
    let info = info(jotons.len());
    let points = points();
    let mut harness = map(context, &jotons, &info);
    harness.storage("gather_points", &points);
    harness.storage("counts", &vec![PATTERN; points.len()]);
    let mut pass = pass_info();
    pass.set_image([WIDTH, HEIGHT]);
    pass.camera.pixel_angle = ANGLE;
    let count = kernel(
        context,
        "passes/caustic_count.wgsl",
        "main",
        &[("RADIUS_FOOTPRINTS", f64::from(FOOTPRINTS[1]))],
    );
    let at: [(&str, &[u8]); 2] =
        [("pass_info", bytemuck::bytes_of(&pass)), ("map_info", bytemuck::bytes_of(&info))];
    harness.run(&count, &[], &at, Work::Invocations(points.len() as u32)).unwrap_or_else(|e| panic!("{e}"));
    let found: Vec<f32> = harness.read("counts").unwrap_or_else(|e| panic!("{e}"));
    let mut sum = 0.0;
    for (i, (p, n)) in points.iter().zip(found).enumerate() {
        if p.throughput[0] == 0.0 {
            assert_eq!(n, -1.0, "pixel {i} has no gather point");
            continue;
        }
        let r = info.radius.min(FOOTPRINTS[1] * p.path_length * ANGLE);
        let counted = |slack: f32| {
            let inside = |j: &&joton::packed::layout::Joton| {
                let d = j.position - p.position;
                let [x, y, z, _] = j.normal_state.to_le_bytes().map(|b| f32::from(b as i8) / 127.0);
                // near by the plane of the joton's own surface
                let height = d.dot(Vec3::new(x, y, z)).abs();
                d.length() < r + slack && height < 0.2 * r + slack && y > 0.7 - slack
            };
            jotons.iter().filter(inside).count() as f32
        };
        assert!((counted(-1e-5)..=counted(1e-5)).contains(&n), "pixel {i}: {n} against {}", counted(0.0));
        sum += n;
    }
    assert!(sum > 1000.0);
}

#[test]
fn radii_hold_the_wanted_number() {
    let context = device_or_return!();
    let points = points();
    let counts: Vec<f32> = points
        .iter()
        .enumerate()
        .map(|(i, p)| if p.throughput[0] == 0.0 { -1.0 } else { (random(63, i)[0].powi(4) * 400.0).floor() })
        .collect();
    let mut harness = Harness::new(context);
    harness.storage("gather_points", &points);
    harness.storage("counts", &counts);
    harness.storage("fits", &vec![[PATTERN; 4]; points.len()]);
    let info = info(1);
    let mut pass = pass_info();
    pass.set_image([WIDTH, HEIGHT]);
    pass.camera.pixel_angle = ANGLE;
    let overrides = [
        ("RADIUS_FOOTPRINTS", f64::from(FOOTPRINTS[1])),
        ("RADIUS_FOOTPRINTS_MIN", f64::from(FOOTPRINTS[0])),
        ("WANTED", f64::from(WANTED)),
    ];
    let k = kernel(context, "passes/caustic_radius.wgsl", "main", &overrides);
    let at: [(&str, &[u8]); 2] =
        [("pass_info", bytemuck::bytes_of(&pass)), ("map_info", bytemuck::bytes_of(&info))];
    harness.run(&k, &[], &at, Work::Invocations(points.len() as u32)).unwrap_or_else(|e| panic!("{e}"));
    let fits: Vec<Fit> = harness.read("fits").unwrap_or_else(|e| panic!("{e}"));
    let (mut at_least, mut at_most, mut between) = (0, 0, 0);
    for (i, fit) in fits.iter().enumerate() {
        let (x, y) = ((i as u32 % WIDTH) as i32, (i as u32 / WIDTH) as i32);
        let near: Vec<f32> = (-1..=1)
            .flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
            .filter(|&(x, y)| (0..WIDTH as i32).contains(&x) && (0..HEIGHT as i32).contains(&y))
            .map(|(x, y)| counts[(y as u32 * WIDTH + x as u32) as usize])
            .filter(|&c| c >= 0.0)
            .collect();
        let mean = near.iter().sum::<f32>() / near.len() as f32;
        let footprint = points[i].path_length * ANGLE;
        let seen = counts[i] >= 0.0;
        let largest = if seen { info.radius.min(FOOTPRINTS[1] * footprint) } else { info.radius };
        let smallest = largest.min(FOOTPRINTS[0] * footprint);
        // a disc of the largest radius holds `mean`; areas go with the square
        let wanted =
            if mean > 0.0 { (largest * (WANTED / mean).sqrt()).clamp(smallest, largest) } else { largest };
        assert!((fit.c.x / wanted - 1.0).abs() < 1e-5, "pixel {i}: {} against {wanted}", fit.c.x);
        match wanted {
            w if w == smallest => at_least += 1,
            w if w == largest => at_most += 1,
            _ => between += 1,
        }
    }
    assert!(between > 20 && at_least + at_most > 0, "{at_least} least, {between} between, {at_most} most");
}
