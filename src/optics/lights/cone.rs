//! Cones: rays into them that keep their digits where they arrive, however narrow the cone and far away its apex; and
//! angles by their sines, since cosines of small ones have none. Sizes of cones are 1 − cos of the half angle.
//! Twin: shaders/lights/cone.wgsl.

use crate::packed::Target;
use crate::packed::constants::SCENE_RADIUS;
use crate::sampling::distributions::{basis, cone};
use glam::Vec3;
use std::f32::consts::TAU;

/// Where light starts, and the axis about which directions are drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    /// A place on the axis: the light itself, but where that is far away.
    pub(crate) through: Vec3,
    /// Unit vector.
    pub(crate) axis: Vec3,
    /// Distance from the light to `through`.
    pub(crate) distance: f32,
}

/// A ray in a cone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ConeRay {
    /// Unit vector.
    pub(crate) direction: Vec3,
    /// The point of the ray nearest to the middle of what the cone holds.
    pub(crate) foot: Vec3,
}

impl Beam {
    /// A ray in the light's own cone.
    pub(crate) fn own(&self, size: f32, u: [f32; 2]) -> ConeRay {
        into_cone(self.through, self.axis, self.distance, size, u)
    }

    /// From the light to a target.
    fn to(&self, t: &Target) -> Vec3 {
        (t.center - self.through) + self.axis * self.distance
    }

    /// Of the cones of all targets together, sr.
    pub(crate) fn solid_angle_of(&self, targets: &[Target]) -> f32 {
        TAU * targets.iter().map(|t| size(t, self.to(t))).sum::<f32>()
    }

    /// True where the light is inside the sphere of a target.
    pub(crate) fn is_inside(&self, t: &Target) -> bool {
        self.to(t).length_squared() <= t.radius * t.radius
    }

    /// Where a ray starts: at the light or, where that is far away, on a plane before the scene.
    pub(crate) fn start(&self, ray: &ConeRay) -> Vec3 {
        if self.distance <= 0.0 {
            return self.through;
        }
        let back = (SCENE_RADIUS + ray.foot.dot(self.axis)) / ray.direction.dot(self.axis);
        ray.foot - ray.direction * back
    }
}

/// 1 − cosine of the angle between a vector and a unit vector.
pub(crate) fn between(v: Vec3, axis: Vec3) -> f32 {
    let along = v.dot(axis);
    let across = v - axis * along;
    let (length_squared, cos) = (v.length_squared(), along / v.length());
    if cos > 0.0 { across.length_squared() / (length_squared * (1.0 + cos)) } else { 1.0 - cos }
}

/// A ray in a cone of this size about the way, `distance` long, that leads along `axis` to `middle`.
fn into_cone(middle: Vec3, axis: Vec3, distance: f32, size: f32, u: [f32; 2]) -> ConeRay {
    let local = cone(u, size);
    let (x, y) = basis(axis);
    let across = x * local.x + y * local.y;
    let sine_squared = local.x * local.x + local.y * local.y;
    let foot = middle + (across * local.z - axis * sine_squared) * distance;
    ConeRay { direction: across + axis * local.z, foot }
}

/// Pick among `targets` by `weight`: the index and what is left of `u`, and the sum of the weights.
pub(crate) fn choose(targets: &[Target], u: f32, weight: impl Fn(&Target) -> f32) -> (usize, f32, f32) {
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

/// Size of the cone that holds a target `d` away.
fn size(t: &Target, d: Vec3) -> f32 {
    let sin2 = t.radius * t.radius / d.length_squared();
    let cos = (1.0 - sin2).max(0.0).sqrt();
    // 1 − cos = sin²/(1 + cos) keeps its digits for far targets
    sin2.min(1.0) / (1.0 + cos)
}

/// A ray into the cones of the targets and its pdf_solid_angle.
pub(crate) fn into_targets(targets: &[Target], beam: &Beam, u: [f32; 2]) -> Option<(ConeRay, f32)> {
    let (chosen, rest, total) = choose(targets, u[0], |t| size(t, beam.to(t)));
    let d = beam.to(&targets[chosen]);
    let distance = d.length();
    let size = size(&targets[chosen], d);
    let ray = into_cone(targets[chosen].center, d / distance, distance, size, [rest, u[1]]);
    let holding = targets.iter().enumerate().filter(|(i, t)| {
        // a cone holds what passes its sphere within the radius: told at the sphere, where angles have no digits
        let passes = (t.center - ray.foot).cross(ray.direction).length() <= t.radius;
        // the cone that was chosen holds its own direction, whatever rounding says
        *i == chosen || passes && beam.to(t).dot(ray.direction) > 0.0
    });
    let pdf = holding.count() as f32 / (TAU * total);
    (pdf.is_finite() && ray.direction.is_finite()).then_some((ray, pdf))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::distributions::sphere;
    use crate::sampling::rng::sobol2;

    /// Overlapping cones: the mean of 1/pdf over the draws is the solid angle of their union, which a uniform sphere
    /// of directions measures too.
    #[test]
    fn cones_cover_their_union_once() {
        let targets = [
            Target { center: Vec3::new(0.0, 0.0, 5.0), radius: 2.0 },
            Target { center: Vec3::new(1.0, 0.0, 6.0), radius: 2.0 },
            Target { center: Vec3::new(-9.0, 2.0, 0.0), radius: 1.0 },
        ];
        let from = Beam { through: Vec3::ZERO, axis: Vec3::Z, distance: 0.0 };
        let n = 1 << 16;
        let (mut by_cones, mut by_sphere) = (0.0f64, 0.0f64);
        for i in 0..n {
            let u = sobol2(i, 11);
            let (_, pdf) = into_targets(&targets, &from, u).expect("outside all targets");
            by_cones += 1.0 / f64::from(pdf);
            let w = sphere(u);
            let inside = |t: &Target| w.dot(t.center.normalize()) >= 1.0 - size(t, t.center);
            by_sphere += if targets.iter().any(inside) { f64::from(2.0 * TAU) } else { 0.0 };
        }
        assert!((by_cones / by_sphere - 1.0).abs() < 0.01, "{}", by_cones / by_sphere);
    }
}
