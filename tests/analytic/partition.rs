//! Every path is counted once: path expressions that share no path add up, and each class is the path tracer's.

use crate::build::{Build, Look, clear, glowing, matte, v};
use crate::harness::{EVERYTHING, Renderer, Seen, everyone, mappers, render, render_keeping};
use joton::film::Layer;
use joton::plan::Part;
use joton::scene::Material;

/// A room with a glass ball under a glowing ceiling, large enough that a path tracer finds its caustics.
fn room(size: u32) -> Build {
    let mut b = Build::new(v(0., -0.95, 0.1), v(0., 0., -0.2), 1.2, size);
    let (low, high) = (v(-1., -1., -1.), v(1., 1., 1.));
    b.cuboid(low, high, false, &matte([0.7, 0.5, 0.3]));
    b.ceiling(v(0., 0., 0.99), 0.8, &glowing([1.0, 2.0, 3.0], [0.0; 3]));
    b.sphere(v(0.1, 0.1, -0.5), 0.4, 2, Look::OutwardSmooth, &clear(1.5));
    b
}

/// The same with a point light, and a floor whose lobe is followed and yet shows the point.
fn polished_room(size: u32) -> Build {
    let mut b = room(size);
    b.point(v(0.3, -0.2, 0.5), [1.0; 3]);
    let polished =
        Material { glossy: [0.4; 3], glossy_exponent: 1000.0, ..Material::matte("polished", [0.3; 3]) };
    b.floor(v(0., 0., -0.99), 0.99, &polished);
    b
}

/// Sets of paths that share none and are all paths together add up to the image, pixel by pixel: the same random
/// numbers, summed in another order.
#[test]
fn path_sets_add_up_to_the_whole() {
    add_up(&room(16), &[BY_LAYER, BY_FIRST, BY_LAST], &[Part::DiffuseMap]);
    add_up(&room(16), &[BY_LAST, BY_NUMBER], &[]);
}

/// So do they where a lobe is followed by some paths and looked at by others.
#[test]
fn path_sets_add_up_where_lobes_are_narrow() {
    add_up(&polished_room(8), &[BY_LAYER], &[Part::DiffuseMap]);
    // a path in 500 of a device is so long here
    add_up_for(&[Renderer::Cpu, Renderer::PathTracer], &polished_room(8), &[BY_LAST], &[]);
}

/// The layers.
const BY_LAYER: &[&str] = &["LS*E", "LDS*E", "LS+DS*E", "L.*D.*DS*E"];
/// What light meets first and last, and the number of events: eye paths find diffuse light where caustics are wanted, too, as in
/// each of the last two.
const BY_FIRST: &[&str] = &["LE", "LD.*E", "LS.*E"];
const BY_LAST: &[&str] = &["L.*DE|LE", "L.*SE"];
const BY_NUMBER: &[&str] = &["L(..)*E", "L.(..)*E"];

fn add_up(b: &Build, all_sets: &[&[&str]], keep: &[Part]) {
    // a long path on a device ends by a chance that counts the work of a filter, too: few do, in this room none
    add_up_for(&everyone(), b, all_sets, keep);
}

fn add_up_for(all: &[Renderer], b: &Build, all_sets: &[&[&str]], keep: &[Part]) {
    for &who in all {
        let render = |paths| render_keeping(who, &b.0, paths, 8, keep).pixels(&Layer::ALL);
        let whole = render(EVERYTHING);
        for sets in all_sets {
            let parts: Vec<_> = sets.iter().map(|paths| render(paths)).collect();
            for (i, want) in whole.iter().enumerate() {
                for band in 0..3 {
                    let sum: f64 = parts.iter().map(|p| p[i][band]).sum();
                    let off = (sum - want[band]).abs();
                    assert!(off <= 1e-4 * want[band].max(0.1), "{who:?} {sets:?}: {sum}, {}", want[band]);
                }
            }
        }
    }
}

/// Each layer holds as much light as the path tracer finds of its class.
#[test]
fn each_class_is_the_path_tracers() {
    let b = room(32);
    let traced = render(Renderer::PathTracer, &b.0, EVERYTHING, 128);
    for who in mappers() {
        let shot = render(who, &b.0, EVERYTHING, 48);
        // noise, and in the caustic what the gather radius smears at 32 pixels
        for (layer, tolerance) in
            [(Layer::Emission, 0.03), (Layer::Direct, 0.03), (Layer::Caustic, 0.05), (Layer::Diffuse, 0.03)]
        {
            let (seen, want) = (shot.layer(layer), traced.layer(layer));
            // the noise of both
            let error = std::array::from_fn(|b| seen.error[b].hypot(want.error[b]));
            shot.claim(layer.name(), Seen { error, ..seen }, want.mean, tolerance);
        }
    }
}
