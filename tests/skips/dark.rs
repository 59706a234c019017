//! What is skipped because light cannot go there: it cannot.

use crate::common::scenes::{Builder, emitter, mirror};
use crate::common::twins::{self, EVERYTHING, TURNED, ball_above_lamp};
use crate::renders::{Side, is_black, plan, run};
use glam::DVec3;
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::plan::{Part, Reason};
use joton::scene::{Light, Scene};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

const SIZE: u32 = 24;
/// Paths a pixel.
const PATHS: u64 = 512;

/// Why the plan of a scene leaves a part out.
fn why(scene: &PackedScene, part: Part) -> Option<Reason> {
    plan(scene, EVERYTHING, 1, &[]).skipped.iter().find(|s| s.what == part).map(|s| s.why)
}

/// The path tracer, which knows nothing of it, finds no light where a map is skipped for the way that lights or surfaces
/// face; where they face otherwise, it finds some, and the map is there.
#[test]
fn skipped_maps_are_dark_to_the_path_tracer() {
    /// Far enough to the ball for paths to meet its caustic by chance.
    const FAR: f64 = 0.8;
    let plane = twins::all(SIZE).into_iter().find(|t| t.why == Reason::OnePlane).expect("twins");
    let cases = [
        (Layer::Caustic, ball_above_lamp(0.0, SIZE), true),
        (Layer::Caustic, ball_above_lamp(FAR, SIZE), false),
        (Layer::Diffuse, plane.without.scene, true),
        (Layer::Diffuse, plane.with.scene, false),
    ];
    for (layer, scene, dark) in cases {
        let scene = Arc::new(PackedScene::new(&scene));
        let plan = plan(&scene, EVERYTHING, 1, &[]);
        assert_eq!(plan.traces(layer), !dark, "{}", layer.name());
        let picture = run(Side::PathTracer, &scene, plan, PATHS).picture;
        assert_eq!(is_black(&picture, layer), dark, "{}", layer.name());
    }
}

/// The lamp's plane passes the ball: just before, there is no caustic map, just behind, there is.
#[test]
fn a_lamp_turned_to_the_ball_brings_the_map_back() {
    let maps = [0.0, 0.6, 0.65, 0.7, 1.0].map(|part| {
        why(&PackedScene::new(&ball_above_lamp(part * TURNED, SIZE)), Part::CausticMap).is_none()
    });
    // the ball's sphere is met from a slope of 0.067 on
    assert_eq!(maps, [false, false, false, true, true]);
}

/// A mirror ball of radius 0.5 above a floor, and a spot 2 units away from it, turned by `off` from its centre, rad, with a
/// cone of `half`.
fn spot(half: f64, off: f64) -> Scene {
    let mut b = Builder::new([0., 3., 4.], [0.; 3], [0., 1., 0.], 0.6, SIZE);
    let (white, ball) = (b.matte(0.7), b.material(mirror(0.9)));
    b.room([-3., -1., -3.], [4., 4., 5.], white);
    b.icosphere([0.; 3], 0.5, 3, false, ball);
    let direction = DVec3::new(-off.cos(), 0.0, off.sin());
    b.scene.lights.push(Light::Spot {
        position: DVec3::new(2.0, 0.0, 0.0),
        direction,
        intensity: [1.0; 3],
        angle_inner: f64::acos(0.5 * (1.0 + half.cos())),
        angle_outer: half,
    });
    b.scene
}

/// Spots of all widths, turned away step by step: the map goes where the cone leaves the ball, and no sooner. Where it is
/// gone, no caustic joton is stored though they are traced; where it is not, some are, but for the last step.
#[test]
fn spots_light_the_ball_up_to_their_edge() {
    // the ball is seen under this half angle, its sphere is a little wider
    let ball = (0.5f64 / 2.0).asin();
    const STEP: f64 = 0.01;
    for half in [0.001, 0.05, 0.5, FRAC_PI_2, 2.5] {
        let edge = half + ball;
        for (off, lit) in [(0.0, true), (edge - STEP, true), (edge + STEP, false), (edge + 0.3, false)] {
            if off > TAU / 2.0 {
                continue;
            }
            let packed = Arc::new(PackedScene::new(&spot(half, off)));
            let reason = why(&packed, Part::CausticMap);
            let wanted = (!lit).then_some(Reason::SpecularInTheDark);
            assert_eq!(reason, wanted, "a cone of {half} turned by {off}");
            let kept = run(Side::Host, &packed, plan(&packed, "LS+DE", 1, &[Part::CausticMap]), 1);
            assert_eq!(kept.tally.jotons_stored > 0, lit, "a cone of {half} turned by {off}");
        }
    }
}

/// A lamp between a mirror ball and the floor that faces the floor lights no ball; a second lamp, or one that shines both
/// ways, does. One that touches the ball does, too.
#[test]
fn every_lamp_and_every_ball_is_looked_at() {
    let lamps = |facing_up: &[bool]| {
        let mut b = Builder { scene: ball_above_lamp(0.0, SIZE) };
        let lamp = b.material(emitter(1.0, 0.0));
        for (i, up) in facing_up.iter().enumerate() {
            let corner = [0.4 * i as f64, 0.5, 0.5];
            let [u, v] = [[0.1, 0., 0.], [0., 0., 0.1]];
            if *up { b.quad(corner, v, u, lamp) } else { b.quad(corner, u, v, lamp) }
        }
        why(&PackedScene::new(&b.scene), Part::CausticMap)
    };
    assert_eq!(lamps(&[]), Some(Reason::SpecularInTheDark));
    assert_eq!(lamps(&[false, false]), Some(Reason::SpecularInTheDark));
    assert_eq!(lamps(&[false, true]), None);
    assert_eq!(lamps(&[true]), None);
}

/// What is small and stands on a large plane is not in it: a corner of two millionths of the plane's width.
#[test]
fn what_stands_on_a_plane_is_not_in_it() {
    let corner = |height: f64| {
        let mut b = Builder::new([0., 0.004, 0.006], [0.; 3], [0., 1., 0.], 0.2, SIZE);
        let (white, lamp) = (b.matte(0.7), b.material(emitter(10.0, 0.0)));
        b.quad([-1000., 0., -1000.], [0., 0., 2000.], [2000., 0., 0.], white);
        b.quad([-0.002, 0., 0.], [0.004, 0., 0.], [0., height, 0.], white);
        b.quad([-1., 10., -1.], [2., 0., 0.], [0., 0., 2.], lamp);
        b.scene
    };
    let standing = Arc::new(PackedScene::new(&corner(0.002)));
    let plan = plan(&standing, EVERYTHING, 1, &[]);
    assert!(plan.traces(Layer::Diffuse), "{:?}", plan.skipped);
    let picture = run(Side::PathTracer, &standing, plan, PATHS).picture;
    assert!(!is_black(&picture, Layer::Diffuse), "light goes from the floor to the wall");
}
