//! Sampling: unit numbers to directions and places. Twin: shaders/sampling/sampling.wgsl.
//!
//! Directions are local: z is the axis; `to_world` turns them to the world. φ = 2π u1 throughout.

use glam::Vec3;

/// sin 2πt = t Σ aₖ t²ᵏ for |t| ≤ 1/8, of the least relative error: 3.2e-9.
pub const CIRCLE_SINE: [f32; 4] = [6.283_185_5, -41.341_663, 81.592_354, -75.393_56];
/// cos 2πt = 1 + t² Σ bₖ t²ᵏ for |t| ≤ 1/8, of the least error: 5.4e-11.
pub const CIRCLE_COSINE: [f32; 4] = [-19.739_208, 64.939_32, -85.443_74, 59.245_964];

/// cos 2πu and sin 2πu for `u` in [0, 1), to 2e-7, the same on every machine: the nearest quarter of the circle, and by
/// polynomials what is left of `u`, which is exact.
pub fn unit_circle(u: f32) -> [f32; 2] {
    let quarter = (4.0 * u + 0.5).floor();
    let t = u - 0.25 * quarter;
    let z = t * t;
    let series = |c: [f32; 4]| c[0] + z * (c[1] + z * (c[2] + z * c[3]));
    let (sine, cosine) = (t * series(CIRCLE_SINE), 1.0 + z * series(CIRCLE_COSINE));
    let quarters = quarter as u32;
    let [x, y] = if quarters & 1 == 0 { [cosine, sine] } else { [-sine, cosine] };
    if quarters & 2 == 0 { [x, y] } else { [-x, -y] }
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al. 2017).
pub fn basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = 1f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let b1 = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let b2 = Vec3::new(b, sign + n.y * n.y * a, -n.y);
    (b1, b2)
}

/// A local direction turned so that z becomes `axis`.
pub fn to_world(local: Vec3, axis: Vec3) -> Vec3 {
    let (b1, b2) = basis(axis);
    b1 * local.x + b2 * local.y + axis * local.z
}

fn around_z(z: f32, radius: f32, u1: f32) -> Vec3 {
    let [cos, sin] = unit_circle(u1);
    Vec3::new(radius * cos, radius * sin, z)
}

/// Cosine-weighted direction: pdf_solid_angle = cosθ/π.
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    around_z((1.0 - u[0]).sqrt(), u[0].sqrt(), u[1])
}

/// Barycentric weights of the second and third vertex: pdf_area = 1/area.
pub fn triangle(u: [f32; 2]) -> [f32; 2] {
    let s = u[0].sqrt();
    [1.0 - s, u[1] * s]
}

/// Direction uniform in the cone 1 − cosθ ≤ size: pdf_solid_angle = 1/(2π size).
pub fn cone(u: [f32; 2], size: f32) -> Vec3 {
    let below = u[0] * size;
    // 1 − z² = (1 − z)(1 + z) keeps its digits in narrow cones
    around_z(1.0 - below, (below * (2.0 - below)).max(0.0).sqrt(), u[1])
}

/// Direction uniform on the sphere: pdf_solid_angle = 1/4π.
pub fn sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    around_z(z, (1.0 - z * z).max(0.0).sqrt(), u[1])
}

/// Place uniform on the unit disc: pdf_area = 1/π.
pub fn disc(u: [f32; 2]) -> [f32; 2] {
    let [cos, sin] = unit_circle(u[1]);
    let r = u[0].sqrt();
    [r * cos, r * sin]
}

/// Direction about the mirror direction: pdf_solid_angle = (e + 1)/2π cosᵉα.
pub fn phong_lobe(u: [f32; 2], exponent: f32) -> Vec3 {
    // 1 − z without the loss of digits of a large exponent
    let below = -(u[0].ln() / (exponent + 1.0)).exp_m1();
    around_z(1.0 - below, (below * (2.0 - below)).max(0.0).sqrt(), u[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::sobol2;
    use std::f64::consts::PI;

    const N: u32 = 1 << 16;

    /// Mean of `f` over the stratified unit square; its error is far below 1e-3 for the smooth f used here.
    fn mean(f: impl Fn([f32; 2]) -> f64) -> f64 {
        (0..N).map(|i| f(sobol2(i, 7))).sum::<f64>() / f64::from(N)
    }

    fn assert_near(name: &str, got: f64, want: f64) {
        assert!((got - want).abs() < 1e-3, "{name}: {got}, expected {want}");
    }

    /// What a place on the circle may be off: the roundings of three numbers up to one, 2^-24 each.
    const CIRCLE_ERROR: f64 = 3.0 / 16_777_216.0;

    /// Over the whole of [0, 1), at its ends and on both sides of the seams between the polynomials.
    #[test]
    fn the_circle_is_that_of_f64() {
        const STEPS: u32 = 1 << 24;
        let seams = (0..=16).flat_map(|k| (0..8).map(move |d| (k * (STEPS / 16) + d).saturating_sub(4)));
        for i in seams.chain((0..STEPS).step_by(61)).map(|i| i.min(STEPS - 1)) {
            let u = i as f32 / STEPS as f32;
            let [x, y] = unit_circle(u).map(f64::from);
            let (sin, cos) = (2.0 * PI * f64::from(u)).sin_cos();
            assert!((x - cos).abs() < CIRCLE_ERROR && (y - sin).abs() < CIRCLE_ERROR, "{u}: {x} {y}");
        }
        assert_eq!([0.0, 0.25, 0.5, 0.75].map(unit_circle), [[1., 0.], [0., 1.], [-1., 0.], [0., -1.]]);
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for i in 0..1000 {
            let n = sphere(sobol2(i, 3));
            let (a, b) = basis(n);
            assert!(a.dot(b).abs() < 1e-5 && a.dot(n).abs() < 1e-5 && b.dot(n).abs() < 1e-5);
            assert!((a.cross(b) - n).length() < 1e-5, "{n}");
        }
        for n in [Vec3::Z, -Vec3::Z, Vec3::X, -Vec3::Y] {
            let (a, b) = basis(n);
            assert!((a.cross(b) - n).length() < 1e-6, "{n}");
        }
    }

    /// First and second moments of each law, from its pdf: E[z], E[z²], E[x²] = (1 − E[z²])/2, E[x] = 0.
    #[test]
    fn directions_have_the_moments_of_their_laws() {
        let e = 20.0f64;
        let c = 0.9f64;
        type Law<'a> = (&'a str, &'a dyn Fn([f32; 2]) -> Vec3, f64, f64);
        let laws: [Law; 4] = [
            ("cosine", &cosine_hemisphere, 2.0 / 3.0, 0.5),
            ("sphere", &sphere, 0.0, 1.0 / 3.0),
            ("cone", &|u| cone(u, (1.0 - c) as f32), (1.0 + c) / 2.0, (1.0 + c + c * c) / 3.0),
            ("phong", &|u| phong_lobe(u, e as f32), (e + 1.0) / (e + 2.0), (e + 1.0) / (e + 3.0)),
        ];
        for (name, law, z1, z2) in laws {
            assert_near(name, mean(|u| f64::from(law(u).z)), z1);
            assert_near(name, mean(|u| f64::from(law(u).z).powi(2)), z2);
            assert_near(name, mean(|u| f64::from(law(u).x).powi(2)), (1.0 - z2) / 2.0);
            assert_near(name, mean(|u| f64::from(law(u).x)), 0.0);
            assert_near(name, mean(|u| f64::from(law(u).length())), 1.0);
        }
    }

    #[test]
    fn triangle_weights_are_uniform() {
        // E[b] = 1/3, E[b²] = 1/6, E[b c] = 1/12 for uniform barycentric weights
        for i in 0..2 {
            assert_near("mean", mean(|u| f64::from(triangle(u)[i])), 1.0 / 3.0);
            assert_near("square", mean(|u| f64::from(triangle(u)[i]).powi(2)), 1.0 / 6.0);
        }
        assert_near("product", mean(|u| f64::from(triangle(u)[0] * triangle(u)[1])), 1.0 / 12.0);
    }

    #[test]
    fn disc_is_uniform() {
        assert_near("r²", mean(|u| disc(u).iter().map(|&x| f64::from(x).powi(2)).sum()), 0.5);
        assert_near("x⁴", mean(|u| f64::from(disc(u)[0]).powi(4)), 0.125);
    }

    /// Directions integrate a known function: ∫ cosθ over the hemisphere is π, by two different laws.
    #[test]
    fn two_laws_give_one_integral() {
        let by_cone = mean(|u| f64::from(cone(u, 1.0).z) * 2.0 * PI);
        assert_near("cone", by_cone / PI, 1.0);
    }
}
