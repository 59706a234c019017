//! Glints: a lamp whose image is far smaller than a pixel [E25].

use crate::build::{Build, Look, glowing, mirror, v};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};

/// A ball that mirrors shows a lamp beside the eye with the focal length f = R/2: at the distance s it is f / (s + f) times as
/// wide, and lies f s / (s + f) behind the face of the ball. A camera ray in a million meets it; the plan finds its pixel.
#[test]
fn the_plan_finds_images_of_lamps_that_are_far_smaller_than_a_pixel() {
    const DISTANCE: f64 = 7.0;
    const FOCAL: f64 = 0.5;
    const WIDTH: f64 = 0.01;
    const TAN: f64 = 0.2;
    const SIZE: u32 = 96;
    let places = [[1.0, 1.3], [-1.2, 0.9], [-0.4, -1.6], [1.3, 0.2]];
    for (seed, [x, z]) in (0..).zip(places) {
        let mut b = Build::new(v(0., -1. - DISTANCE, 0.), v(0., 0., 0.), TAN, SIZE);
        b.sphere(v(0., 0., 0.), 2.0 * FOCAL, 5, Look::OutwardSmooth, &mirror([0.9; 3]));
        let corner = v(x - 0.5 * WIDTH, -1. - DISTANCE, z - 0.5 * WIDTH);
        b.quad(corner, v(0., 0., WIDTH), v(WIDTH, 0., 0.), &glowing([100.0; 3], [0.0; 3]));
        let scene = PackedScene::whole(&b.0);
        let plan = Plan::new(&scene, Settings { seed, ..Settings::default() });
        // from the middle of the picture, in half its width
        let from_eye = DISTANCE + FOCAL * DISTANCE / (DISTANCE + FOCAL);
        let at = |offset: f64| offset * FOCAL / (DISTANCE + FOCAL) / from_eye / TAN;
        let pixel = |across: f64| (0.5 * (1.0 + across) * f64::from(SIZE)) as u32;
        let want = pixel(-at(z)) * SIZE + pixel(at(x));
        assert_eq!(plan.lamp_images[..], [want], "a lamp at {x}, {z}");
    }
}
