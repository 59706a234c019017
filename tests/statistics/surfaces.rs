//! Surfaces that vary by textures of other than colour: device, host and path tracer estimate the same radiance, as in `images.rs`.

use crate::chi_square::Claims;
use crate::common::twins::{brushed, of_paper, with_facet_board, with_glow, with_relief};
use crate::images::{by_wavelength, claim, narrow, pack};
use crate::renders::{EVERYTHING, Planner, Side, file, pictures, pictures_of, plan, plan_by_map};
use joton::film::Layer;
use joton::scene::Scene;

/// Fewer and smaller than those of `images.rs`: a kernel's compilation is most of the time.
const SIZE: u32 = 16;
const SEEDS: u32 = 4;
/// Passes of the path tracer.
const PASSES: u64 = 64;
const BLOCKS: [u32; 3] = [1, 4, SIZE];

/// Device and host have the same radii: every pixel of every layer agrees.
fn device_and_host_agree(name: &str, scene: &Scene) {
    let mut claims = Claims::default();
    let scene = pack(scene);
    let [a, b] = [Side::Device, Side::Host].map(|s| pictures(s, &scene, EVERYTHING, 0..SEEDS, 24, |_| ()));
    claim(&mut claims, name, &a, &b, &Layer::ALL, &BLOCKS);
    claims.hold();
}

/// At narrow radii the maps, and eye paths that go on, have the light of so many passes of the path tracer.
fn all_agree(name: &str, scene: &Scene, planner: Planner, passes: u64) {
    let mut claims = Claims::default();
    let scene = pack(scene);
    let paths = pictures(Side::PathTracer, &scene, EVERYTHING, 0..SEEDS, passes, |_| ());
    for side in [Side::Host, Side::Device] {
        let maps = pictures_of(planner, side, &scene, EVERYTHING, 0..SEEDS, 8, narrow);
        claim(&mut claims, &format!("{name}, {side:?}"), &maps, &paths, &Layer::ALL, &BLOCKS);
    }
    claims.hold();
}

/// [E47] Roughness, metal and its colour vary, by colour and by wavelength.
#[test]
fn facets_that_vary_are_the_same_for_all() {
    crate::device_or_return!();
    let cornell = || with_facet_board(file("cornell.toml", SIZE));
    device_and_host_agree("cornell with a board of facets, by wavelength", &by_wavelength(cornell()));
    all_agree("furnace with a board of facets", &with_facet_board(file("furnace.toml", SIZE)), plan, PASSES);
}

/// [E55] Light that is scattered through a surface: lamps and mirrors on either side, by shadow rays, by hits, by jotons that cross and those
/// that lie on the far side.
#[test]
fn paper_is_the_same_for_all() {
    crate::device_or_return!();
    // the path tracer sees the light of glass seldom
    all_agree("spheres of paper, map", &of_paper(file("spheres.toml", SIZE)), plan_by_map, 64 * PASSES);
}

/// [E56] Brushed walls, metal and glass whose roughness and metal vary.
#[test]
fn brushed_facets_are_the_same_for_all() {
    crate::device_or_return!();
    let board = brushed(with_facet_board(file("spheres.toml", SIZE)));
    all_agree("spheres with a brushed board of facets", &board, plan, PASSES);
}

/// [E49] Light from pictures: seen by itself, by shadow rays, by hits, and by jotons, aimed and by the map.
#[test]
fn pictures_of_light_are_the_same_for_all() {
    crate::device_or_return!();
    let spheres = || by_wavelength(with_glow(file("spheres.toml", SIZE)));
    device_and_host_agree("spheres with a picture of light, by wavelength", &spheres());
    all_agree(
        "cornell with a picture of light, map",
        &with_glow(file("cornell.toml", SIZE)),
        plan_by_map,
        PASSES,
    );
}

/// [E48] Normals and heights from pictures; the map has their light through the adjoint of shading normals [E11].
#[test]
fn reliefs_are_the_same_for_all() {
    crate::device_or_return!();
    device_and_host_agree("cornell with a relief", &with_relief(file("cornell.toml", SIZE)));
    all_agree("cornell with a relief, map", &with_relief(file("cornell.toml", SIZE)), plan_by_map, PASSES);
}
