//! Emission: where a joton starts, where to, and with how much flux.
//!
//! By the emitters' own law: flux_i/(pick N). Aimed (caustic map only): L S+ D must meet a specular body first, so
//! directions are drawn into the cones of the targets' spheres and weighed by the pdf of the mixture,
//! pdf_solid_angle = (cones that hold the direction) / ΣΩ [E13]. A guide may steer both, by what was learned [E20].

use super::ray::lift;
use super::sampling::{cone, cosine_hemisphere, disc, sphere, to_world, triangle};
use crate::bands::{BLACK, Bands, scale};
use crate::pack::{EmitterKind, Guide, PackedEmitter, PackedScene, PackedTriangle, Target};
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

/// Falloff of a spot: 1 inside the inner cone, cubic smoothstep of the cosine to 0 at the outer [E12].
pub(crate) fn falloff(e: &PackedEmitter, direction: Vec3) -> f32 {
    let (inner, outer) = (e.e2.x, e.e2.y);
    let cos = direction.dot(e.e1);
    if cos >= inner {
        return 1.0;
    }
    let x = ((cos - outer) / (inner - outer)).clamp(0.0, 1.0);
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
        EmitterKind::Point => {
            Start { origin: e.origin, direction: sphere(towards), flux: scale(&e.flux, share) }
        }
        EmitterKind::Spot => {
            let direction = to_world(cone(towards, e.e2.y), e.e1);
            let solid_angle = TAU * (1.0 - e.e2.y);
            Start {
                origin: e.origin,
                direction,
                flux: scale(&e.strength, falloff(e, direction) * solid_angle * share),
            }
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
    let start = |origin: Vec3, radiant: &dyn Fn(Vec3) -> Bands| {
        if scene.targets.iter().any(|t| (origin - t.center).length_squared() <= t.radius * t.radius) {
            return Some(law_of(e, place, towards, share));
        }
        let (direction, pdf_solid_angle) = into_cones(&scene.targets, origin, towards)?;
        let flux = scale(&radiant(direction), share / pdf_solid_angle);
        (flux != BLACK).then_some(Start { origin, direction, flux })
    };
    if scene.targets.is_empty() {
        return Some(law_of(e, place, towards, share));
    }
    match kind(e) {
        EmitterKind::Triangle => {
            let (origin, normal) = place_on(e, place);
            start(origin, &|w| scale(&e.strength, w.dot(normal).max(0.0) * e.area))
        }
        EmitterKind::Point => start(e.origin, &|_| e.strength),
        EmitterKind::Spot => start(e.origin, &|w| scale(&e.strength, falloff(e, w))),
        EmitterKind::Sun => {
            let (origin, pdf_area) = onto_discs(&scene.targets, e, towards)?;
            Some(Start { origin, direction: e.e1, flux: scale(&e.strength, share / pdf_area) })
        }
    }
}

/// Pick among `targets` by `weight`: the index and what is left of `u`.
fn choose(targets: &[Target], u: f32, weight: impl Fn(&Target) -> f32) -> (usize, f32, f32) {
    let total: f32 = targets.iter().map(&weight).sum();
    let mut left = u * total;
    for (i, t) in targets.iter().enumerate() {
        let w = weight(t);
        if left < w || i + 1 == targets.len() {
            return (i, (left / w).clamp(0.0, 1.0 - f32::EPSILON), total);
        }
        left -= w;
    }
    unreachable!("targets are not empty")
}

/// 1 − cosine of the half angle of the cone from `origin` around a target.
fn narrowness(t: &Target, origin: Vec3) -> f32 {
    let sin2 = t.radius * t.radius / (t.center - origin).length_squared();
    let cos = (1.0 - sin2).max(0.0).sqrt();
    // 1 − cos = sin²/(1 + cos) keeps its digits for far targets
    sin2.min(1.0) / (1.0 + cos)
}

/// A direction from `origin` into the cones of the targets and its pdf_solid_angle.
pub(crate) fn into_cones(targets: &[Target], origin: Vec3, u: [f32; 2]) -> Option<(Vec3, f32)> {
    let (chosen, rest, total) = choose(targets, u[0], |t| narrowness(t, origin));
    let t = &targets[chosen];
    let axis = (t.center - origin).normalize();
    let direction = to_world(cone([rest, u[1]], 1.0 - narrowness(t, origin)), axis);
    let holding = targets.iter().enumerate().filter(|(i, t)| {
        // the cone that was chosen holds its own direction, whatever rounding says
        *i == chosen || (t.center - origin).normalize().dot(direction) >= 1.0 - narrowness(t, origin)
    });
    let pdf = holding.count() as f32 / (TAU * total);
    (pdf.is_finite() && direction.is_finite()).then_some((direction, pdf))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::sobol2;

    /// Overlapping cones: the mean of 1/pdf over the draws is the solid angle of their union, which a uniform sphere
    /// of directions measures too.
    #[test]
    fn cones_cover_their_union_once() {
        let targets = [
            Target { center: Vec3::new(0.0, 0.0, 5.0), radius: 2.0 },
            Target { center: Vec3::new(1.0, 0.0, 6.0), radius: 2.0 },
            Target { center: Vec3::new(-9.0, 2.0, 0.0), radius: 1.0 },
        ];
        let n = 1 << 16;
        let (mut by_cones, mut by_sphere) = (0.0f64, 0.0f64);
        for i in 0..n {
            let u = sobol2(i, 11);
            let (_, pdf) = into_cones(&targets, Vec3::ZERO, u).expect("outside all targets");
            by_cones += 1.0 / f64::from(pdf);
            let w = sphere(u);
            let inside = |t: &Target| w.dot(t.center.normalize()) >= 1.0 - narrowness(t, Vec3::ZERO);
            by_sphere += if targets.iter().any(inside) { f64::from(2.0 * TAU) } else { 0.0 };
        }
        assert!((by_cones / by_sphere - 1.0).abs() < 0.01, "{}", by_cones / by_sphere);
    }
}
