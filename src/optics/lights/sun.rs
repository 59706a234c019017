//! A sun: parallel light along `e1` from a disc of radius `e2.x` outside the scene; `strength` is irradiance across the beam. Twin:
//! shaders/lights/sun.wgsl.

use crate::optics::lights::cone::choose;
use crate::optics::lights::samples::{LightSample, Start};
use crate::packed::{PackedEmitter, Target};
use crate::sampling::distributions::{disc, to_world};
use crate::spectrum::scale;
use glam::Vec3;
use std::f32::consts::PI;

/// Shadow rays end outside the scene: its radius is below 1024 internal units.
const BEYOND: f32 = 4096.0;

/// A start by its own law, `share` of its flux: one direction, from any place of the disc. It is the place that can be steered.
pub(super) fn by_law(e: &PackedEmitter, towards: [f32; 2], share: f32) -> Start {
    let [x, y] = disc(towards);
    let offset = to_world(Vec3::new(x * e.e2.x, y * e.e2.x, 0.0), e.e1);
    Start { origin: e.origin + offset, direction: e.e1, flux: scale(&e.flux, share), ..Start::default() }
}

/// A start from which the beam runs into the targets; none where its probability has no digits.
pub(super) fn aimed(e: &PackedEmitter, targets: &[Target], u: [f32; 2], share: f32) -> Option<Start> {
    let (chosen, rest, total) = choose(targets, u[0], |t| t.radius * t.radius);
    let flat = |p: Vec3| p - e.e1 * (p - e.origin).dot(e.e1);
    let t = &targets[chosen];
    let [x, y] = disc([rest, u[1]]);
    let origin = flat(t.center) + to_world(Vec3::new(x * t.radius, y * t.radius, 0.0), e.e1);
    let holding = targets
        .iter()
        .enumerate()
        .filter(|(i, t)| *i == chosen || (flat(t.center) - origin).length() <= t.radius);
    // across the beam
    let pdf_area = holding.count() as f32 / (PI * total);
    pdf_area.is_finite().then(|| Start {
        origin,
        direction: e.e1,
        flux: scale(&e.strength, share / pdf_area),
        ..Start::default()
    })
}

/// Light sample; its light does not depend on the place.
pub(super) fn sample_li(e: &PackedEmitter, position: Vec3) -> LightSample {
    let target = position - e.e1 * BEYOND;
    LightSample { wi: -e.e1, target, distance: f32::INFINITY, irradiance: e.strength, pdf: 0.0 }
}
