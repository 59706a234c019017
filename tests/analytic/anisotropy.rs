//! Brushed microfacets in the sun [E56].

use crate::build::{Build, v};
use crate::harness::{everyone, render};
use glam::{DMat2, DVec2, DVec3};
use joton::film::Layer;
use joton::scene::{Anisotropy, FacetKind, Facets, Inner, Material};
use std::f64::consts::PI;

const ALPHA: f64 = 0.2;
const STRENGTH: f64 = 0.75;

fn brushed(rotation: f64, is_around: bool) -> Material {
    Material {
        glossy: [1.0, 0.5, 0.25],
        facets: Some(Facets { alpha: ALPHA as f32, kind: FacetKind::Coat { ior: 1.5, inner: Inner::Once } }),
        anisotropy: Some(Anisotropy { strength: STRENGTH as f32, rotation: rotation as f32, is_around }),
        ..Material::matte("brushed", [0.0; 3])
    }
}

/// f_r of a coat over nothing, by slopes of the half vector along the rougher way and across it.
fn lobe(way: DVec3, n: DVec3, wi: DVec3, wo: DVec3) -> f64 {
    let [a, b] = [ALPHA + (1.0 - ALPHA) * STRENGTH * STRENGTH, ALPHA];
    let across = n.cross(way);
    let h = (wi + wo).normalize();
    let [x, y] = [way, across].map(|t| h.dot(t) / h.dot(n));
    let d = 1.0 / (PI * a * b * h.dot(n).powi(4) * (1.0 + (x / a).powi(2) + (y / b).powi(2)).powi(2));
    let lambda = |w: DVec3| {
        let [x, y] = [way, across].map(|t| w.dot(t) / w.dot(n));
        ((1.0 + (a * x).powi(2) + (b * y).powi(2)).sqrt() - 1.0) / 2.0
    };
    let cos = wi.dot(h);
    let inner = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let [s, p] = [[cos, 1.5 * inner], [1.5 * cos, inner]].map(|[a, b]| ((a - b) / (a + b)).powi(2));
    0.5 * (s + p) * d / ((1.0 + lambda(wi) + lambda(wo)) * 4.0 * wi.dot(n) * wo.dot(n))
}

/// A plate about the origin in the sun, seen at a slant from the side on which z has this sign; its texture coordinates are a matrix times
/// the place, and more.
fn plate(material: &Material, side: f64, coordinates: DMat2, more: DVec2) -> (Build, DVec3, DVec3) {
    let eye = v(1.2, 0.7, 2.0 * side);
    let mut b = Build::new(eye, v(0., 0., 0.), 0.01, 8);
    b.floor(v(0., 0., 0.), 1.0, material);
    let uv = |p: &DVec3| (coordinates * DVec2::new(p.x, p.y) + more).as_vec2().to_array();
    b.0.mesh.uvs = b.0.mesh.positions.iter().map(uv).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    let sun = v(0.9, -0.4, -1.5 * side).normalize();
    b.sun(sun, [1.0; 3]);
    (b, eye.normalize(), -sun)
}

fn holds(name: &str, b: &Build, way: DVec3, side: f64, wo: DVec3, wi: DVec3) {
    let n = v(0., 0., side);
    let f = lobe(way.normalize(), n, wi, wo) * wi.dot(n);
    for who in everyone() {
        let shot = render(who, &b.0, "LDE", 8);
        // the sun is one direction, and what varies over a pixel is small; steps of the packed angle
        shot.claim(name, shot.layer(Layer::Direct), [f, 0.5 * f, 0.25 * f], 5e-3);
    }
}

/// Where texture coordinates grow to the right the surface is rougher, or at an angle to that, counter-clockwise from the front: as they
/// lie, turned, and on both sides.
#[test]
fn brushed_plates_shine_along_their_texture() {
    for (name, m, rotation, side) in [
        ("as it is", DMat2::IDENTITY, 0.0, 1.0),
        ("turned", DMat2::from_angle(-0.8), 0.0, 1.0),
        ("stretched", DMat2::from_cols_array(&[3., 3., -0.5, 0.5]), 0.3, 1.0),
        ("mirrored", DMat2::from_cols_array(&[-1., 0.2, 0., 1.]), 0.0, 1.0),
        ("rotated", DMat2::IDENTITY, 0.9, 1.0),
        ("from behind", DMat2::from_angle(0.4), 0.9, -1.0),
    ] {
        let (b, wo, wi) = plate(&brushed(rotation, false), side, m, DVec2::splat(0.5));
        // along which u grows and v stays
        let right = m.inverse().x_axis.normalize();
        let along = DVec2::from_angle(rotation).rotate(right);
        holds(name, &b, along.extend(0.0), side, wo, wi);
    }
}

/// Around an axis at places across it, and, without any coordinates, along x where a surface faces up or down the world's y, which is level
/// elsewhere.
#[test]
fn brushed_plates_shine_around_an_axis() {
    let at = DVec2::new(0.6, -0.9);
    let (b, wo, wi) = plate(&brushed(0.0, true), 1.0, DMat2::IDENTITY, at);
    holds("around", &b, at.perp().extend(0.0), 1.0, wo, wi);
    let (mut b, wo, wi) = plate(&brushed(0.2, false), 1.0, DMat2::IDENTITY, at);
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = None);
    // level: at right angles to y and to the normal
    holds("without coordinates", &b, DVec2::from_angle(0.2).extend(0.0), 1.0, wo, wi);
}
