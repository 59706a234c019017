//! Emission: where a joton starts, where to, and with how much flux.
//!
//! By the emitters' own law: flux_i/(pick N). Aimed (caustic map only): L S+ D must meet a specular body first, so
//! directions are drawn into the cones of the targets' spheres and weighed by the pdf of the mixture,
//! pdf_solid_angle = (cones that hold the direction) / ΣΩ [E13]. A guide may steer both, by what was learned [E20].

use crate::optics::lights::cone::{Beam, ConeRay, between, choose, into_targets};
use crate::optics::ray::lift;
use crate::packed::{EmitterKind, Guide, PackedEmitter, PackedScene, PackedTriangle, Target};
use crate::sampling::distributions::{cosine_hemisphere, disc, to_world, triangle};
use crate::spectrum::{BLACK, Bands, scale};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// A joton that has just left its emitter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Flux, internal W per band, divided by the number of jotons.
    pub(crate) flux: Bands,
}

/// The emitter that `u` picks, and what is left of `u`, again uniform in [0, 1).
pub(crate) fn pick(emitters: &[PackedEmitter], u: f32) -> (&PackedEmitter, f32) {
    let i = emitters.partition_point(|e| e.cumulative <= u).min(emitters.len() - 1);
    let below = if i == 0 { 0.0 } else { emitters[i - 1].cumulative };
    let rest = (u - below) / (emitters[i].cumulative - below);
    (&emitters[i], rest.clamp(0.0, 1.0 - f32::EPSILON))
}

/// Kind of an emitter.
pub(crate) fn kind(e: &PackedEmitter) -> EmitterKind {
    match e.kind {
        0 => EmitterKind::Triangle,
        1 => EmitterKind::Point,
        2 => EmitterKind::Spot,
        _ => EmitterKind::Sun,
    }
}

/// Point on an emissive triangle, lifted off its front, and the front's normal.
pub(crate) fn place_on(e: &PackedEmitter, u: [f32; 2]) -> (Vec3, Vec3) {
    let [b, c] = triangle(u);
    let shape = PackedTriangle { v0: e.origin, material: 0, e1: e.e1, flags: 0, e2: e.e2, emitter: 0 };
    let normal = shape.normal();
    (lift(e.origin + e.e1 * b + e.e2 * c, normal, &shape), normal)
}

/// The way from a point or a spot to a place.
pub(crate) fn from_light(e: &PackedEmitter, place: Vec3) -> Vec3 {
    // first what is near, then the way to the light
    (place - e.origin) + e.e1 * e.e2.z
}

/// Falloff of a spot along `way`: 1 inside the inner cone, cubic smoothstep of the cosine to 0 at the outer [E12].
pub(crate) fn falloff(e: &PackedEmitter, way: Vec3) -> f32 {
    let (inner, outer) = (e.e2.x, e.e2.y);
    let at = between(way, e.e1);
    if at <= inner {
        return 1.0;
    }
    let x = ((outer - at) / (outer - inner)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// A start by the law of an emitter that the guide picks, the way that it steers; `count` jotons a pass.
pub(crate) fn by_law(
    scene: &PackedScene,
    guide: &Guide,
    place: [f32; 2],
    towards: [f32; 2],
    count: f32,
) -> Start {
    let (e, rest) = pick(guide.emitters(&scene.emitters), place[0]);
    let (towards, density) = guide.steer(e, towards);
    law_of(e, [rest, place[1]], towards, 1.0 / (e.pick * count * density))
}

/// A start by the law of one emitter; `share` of its flux.
pub(crate) fn law_of(e: &PackedEmitter, place: [f32; 2], towards: [f32; 2], share: f32) -> Start {
    match kind(e) {
        EmitterKind::Triangle => {
            let (origin, normal) = place_on(e, place);
            let direction = to_world(cosine_hemisphere(towards), normal);
            Start { origin, direction, flux: scale(&e.flux, share) }
        }
        EmitterKind::Point | EmitterKind::Spot => {
            let beam = Beam::of(e);
            start_in_cone(e, &beam, beam.own(e.area / TAU, towards), e.area * share)
        }
        EmitterKind::Sun => {
            // one direction, from any place: it is the place that can be steered
            let [x, y] = disc(towards);
            let offset = to_world(Vec3::new(x * e.e2.x, y * e.e2.x, 0.0), e.e1);
            Start { origin: e.origin + offset, direction: e.e1, flux: scale(&e.flux, share) }
        }
    }
}

/// A start aimed at the specular bodies, of an emitter that the guide picks, the way that it steers. None where no flux
/// goes the way that was drawn.
pub(crate) fn aimed(
    scene: &PackedScene,
    guide: &Guide,
    place: [f32; 2],
    towards: [f32; 2],
    count: f32,
) -> Option<Start> {
    let (e, rest) = pick(guide.emitters(&scene.emitters), place[0]);
    let (towards, density) = guide.steer(e, towards);
    aimed_of(scene, e, [rest, place[1]], towards, 1.0 / (e.pick * count * density))
}

/// A start of one emitter aimed at the specular bodies, `share` of its flux; by its law where it starts inside one.
pub(crate) fn aimed_of(
    scene: &PackedScene,
    e: &PackedEmitter,
    place: [f32; 2],
    towards: [f32; 2],
    share: f32,
) -> Option<Start> {
    if scene.targets.is_empty() {
        return Some(law_of(e, place, towards, share));
    }
    if kind(e) == EmitterKind::Sun {
        let (origin, pdf_area) = onto_discs(&scene.targets, e, towards)?;
        return Some(Start { origin, direction: e.e1, flux: scale(&e.strength, share / pdf_area) });
    }
    let is_triangle = kind(e) == EmitterKind::Triangle;
    let beam = if is_triangle {
        let (origin, normal) = place_on(e, place);
        Beam { through: origin, axis: normal, distance: 0.0 }
    } else {
        Beam::of(e)
    };
    // where its own cone is narrower than those of the targets, a light's own law serves better
    let is_narrow = !is_triangle && e.area <= beam.solid_angle_of(&scene.targets);
    if is_narrow || scene.targets.iter().any(|t| beam.is_inside(t)) {
        return Some(law_of(e, place, towards, share));
    }
    let (ray, pdf_solid_angle) = into_targets(&scene.targets, &beam, towards)?;
    let weight = share / pdf_solid_angle;
    let start = if is_triangle {
        let sent = ray.direction.dot(beam.axis).max(0.0) * e.area;
        Start { origin: beam.through, direction: ray.direction, flux: scale(&e.strength, sent * weight) }
    } else {
        start_in_cone(e, &beam, ray, weight)
    };
    (start.flux != BLACK).then_some(start)
}

/// A start of a point or a spot along a ray; `weight` in sr.
fn start_in_cone(e: &PackedEmitter, beam: &Beam, ray: ConeRay, weight: f32) -> Start {
    let way = if beam.distance > 0.0 { from_light(e, ray.foot) } else { ray.direction };
    let shape = if kind(e) == EmitterKind::Spot { falloff(e, way) } else { 1.0 };
    Start { origin: beam.start(&ray), direction: ray.direction, flux: scale(&e.strength, shape * weight) }
}

/// A start on the sun's disc from which the beam runs into the targets, and its pdf_area across the beam.
fn onto_discs(targets: &[Target], sun: &PackedEmitter, u: [f32; 2]) -> Option<(Vec3, f32)> {
    let (chosen, rest, total) = choose(targets, u[0], |t| t.radius * t.radius);
    let flat = |p: Vec3| p - sun.e1 * (p - sun.origin).dot(sun.e1);
    let t = &targets[chosen];
    let [x, y] = disc([rest, u[1]]);
    let origin = flat(t.center) + to_world(Vec3::new(x * t.radius, y * t.radius, 0.0), sun.e1);
    let holding = targets
        .iter()
        .enumerate()
        .filter(|(i, t)| *i == chosen || (flat(t.center) - origin).length() <= t.radius);
    let pdf = holding.count() as f32 / (PI * total);
    pdf.is_finite().then_some((origin, pdf))
}
