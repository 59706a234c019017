//! What happens at a surface: Fresnel, the D lobes (Lambert and glossy Phong), the S lobes. Twin: shaders/shading/bsdf.wgsl.
//!
//! f_r(wi, wo) = diffuse/π + glossy (e + 2)/2π cosᵉα, α between wo and the mirror direction of wi \[E6\] (Lafortune &
//! Willems 1994). Symmetric in wi and wo, so eye paths and jotons sample the same functions.

use crate::optics::ray::SurfaceInteraction;
use crate::packed::PackedMaterial;
use crate::sampling::distributions::{cosine_hemisphere, phong_lobe, to_world};
use crate::spectrum::{BLACK, Bands, add, max, scale};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// Unpolarised reflectance of a dielectric interface \[E8\]; `eta` = n_t / n_i. 1 at total reflection.
pub fn fresnel(cos_i: f32, eta: f32) -> f32 {
    let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Reflectance of a thin pane whose faces reflect `face` each: what goes to and fro between them adds up as flux \[E26\].
pub fn pane_reflectance(face: f32) -> f32 {
    2.0 * face / (1.0 + face)
}

/// Direction of refraction; `n` on the side that `d` comes from. None at total reflection.
pub fn refract(d: Vec3, n: Vec3, eta_i_over_t: f32) -> Option<Vec3> {
    let cos_i = -d.dot(n);
    let sin2_t = eta_i_over_t * eta_i_over_t * (1.0 - cos_i * cos_i).max(0.0);
    (sin2_t < 1.0)
        .then(|| (d * eta_i_over_t + n * (eta_i_over_t * cos_i - (1.0 - sin2_t).sqrt())).normalize())
}

/// The mirror image of `w` about `n`, both leaving the surface.
pub fn mirror(w: Vec3, n: Vec3) -> Vec3 {
    n * (2.0 * w.dot(n)) - w
}

/// Reflectance of the D lobes together, per band.
pub fn reflectance_d(m: &PackedMaterial) -> Bands {
    add(&m.diffuse, &m.glossy)
}

/// cosᵉα of a Phong lobe, from 1 − cosα: near one a cosine has no digits for a large exponent.
fn lobe(exponent: f32, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
    let below = 0.5 * (mirror(wi, n) - wo).length_squared();
    if below >= 1.0 { 0.0 } else { (exponent * (-below).ln_1p()).exp() }
}

/// f_r of a lobe that is followed, 1/sr, for lights without area: following it never meets them \[E6\].
pub fn eval_narrow(m: &PackedMaterial, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
    if !m.has_narrow_lobe() {
        return BLACK;
    }
    scale(&m.specular, (m.specular_exponent + 2.0) / TAU * lobe(m.specular_exponent, wi, wo, n))
}

/// f_r of the D lobes, 1/sr.
pub fn eval_d(m: &PackedMaterial, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
    let matte = scale(&m.diffuse, FRAC_1_PI);
    if !m.flags().has_glossy() {
        return matte;
    }
    add(&matte, &scale(&m.glossy, (m.glossy_exponent + 2.0) / TAU * lobe(m.glossy_exponent, wi, wo, n)))
}

/// Probability of sampling the Lambert lobe.
fn share_matte(m: &PackedMaterial) -> f32 {
    let (d, g) = (max(&m.diffuse), max(&m.glossy));
    if g > 0.0 { d / (d + g) } else { 1.0 }
}

/// pdf_solid_angle of [`sample_d`].
pub fn pdf_d(m: &PackedMaterial, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
    let matte = share_matte(m);
    let pdf = matte * wi.dot(n).max(0.0) * FRAC_1_PI;
    if matte == 1.0 {
        return pdf;
    }
    pdf + (1.0 - matte) * (m.glossy_exponent + 1.0) / TAU * lobe(m.glossy_exponent, wi, wo, n)
}

/// A direction from the D lobes given the other, `wo`, both about `n`. None where it falls below the surface.
pub fn sample_d(m: &PackedMaterial, wo: Vec3, n: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<Vec3> {
    let wi = if u_lobe < share_matte(m) {
        to_world(cosine_hemisphere(u), n)
    } else {
        to_world(phong_lobe(u, m.glossy_exponent), mirror(wo, n))
    };
    (wi.dot(n) > 0.0).then_some(wi)
}

/// A direction of the S lobe: the mirror's, or about it where the mirror is not perfect. None below the surface.
pub(crate) fn sample_mirror(s: &SurfaceInteraction, u: [f32; 2]) -> Option<Vec3> {
    let above = |w: Vec3| (w.dot(s.ng) > 0.0).then_some(w);
    let perfect = above(mirror(s.back, s.specular_normal())).unwrap_or_else(|| mirror(s.back, s.ng));
    let exponent = s.material.specular_exponent;
    if exponent <= 0.0 { Some(perfect) } else { above(to_world(phong_lobe(u, exponent), perfect)) }
}

/// Both ways on from a dielectric interface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DielectricInterface {
    /// Share that is reflected, 0 to 1.
    pub(crate) fresnel: f32,
    pub(crate) reflected: Vec3,
    /// Arbitrary where `fresnel` is 1.
    pub(crate) refracted: Vec3,
    /// η of the side the ray comes from over that of the side it would go to.
    pub(crate) eta_i_over_t: f32,
}

impl DielectricInterface {
    pub(crate) fn at(s: &SurfaceInteraction) -> Self {
        let n = s.specular_normal();
        let reflected = mirror(s.back, n);
        let reflected = if reflected.dot(s.ng) > 0.0 { reflected } else { mirror(s.back, s.ng) };
        if s.flags().is_thin() {
            let fresnel = pane_reflectance(fresnel(s.back.dot(n), s.material.ior));
            return Self { fresnel, reflected, refracted: -s.back, eta_i_over_t: 1.0 };
        }
        let eta_i_over_t = if s.front { 1.0 / s.material.ior } else { s.material.ior };
        let along = -s.back;
        let about = |n: Vec3| {
            let crossing = refract(along, n, eta_i_over_t).filter(|w| w.dot(s.ng) < 0.0);
            crossing.map(|w| (fresnel(s.back.dot(n), 1.0 / eta_i_over_t), w))
        };
        let total = fresnel(s.back.dot(n), 1.0 / eta_i_over_t) >= 1.0;
        let (fresnel, refracted) =
            if total { None } else { about(n).or_else(|| about(s.ng)) }.unwrap_or((1.0, along));
        Self { fresnel, reflected, refracted, eta_i_over_t }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::{random4, sobol2};
    use crate::scene::Material;

    /// Values from the equations: ((n−1)/(n+1))² head on, 0 at Brewster's angle for half the light, 1 beyond critical.
    #[test]
    fn fresnel_has_its_textbook_values() {
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((fresnel(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        // 45° into glass: Rs = 0.0920, Rp = Rs² = 0.00847
        assert!((fresnel(std::f32::consts::FRAC_1_SQRT_2, 1.5) - 0.050_23).abs() < 1e-4);
        // Brewster: tan θ = n; only the perpendicular half reflects: ½ ((1 − n²)/(1 + n²))²
        let cos_brewster = 1.0 / (1.0f32 + 1.5 * 1.5).sqrt();
        assert!((fresnel(cos_brewster, 1.5) - 0.5 * (1.25f32 / 3.25).powi(2)).abs() < 1e-5);
        let critical = (1.0f32 - 1.0 / 2.25).sqrt();
        assert_eq!(fresnel(critical - 1e-3, 1.0 / 1.5), 1.0);
        assert!(fresnel(critical + 1e-2, 1.0 / 1.5) < 0.9);
        assert_eq!(fresnel(0.0, 1.5), 1.0);
    }

    /// A pane reflects what the sum over all ways between its faces says: R + (1−R)² R Σ R^2k.
    #[test]
    fn panes_add_up_their_faces() {
        for i in 0..=10 {
            let r = i as f32 / 10.0;
            let sum = r + (1.0 - r) * (1.0 - r) * r * (0..2000).map(|k| r.powi(2 * k)).sum::<f32>();
            assert!((pane_reflectance(r) - if i == 10 { 1.0 } else { sum }).abs() < 1e-5, "{r}");
        }
    }

    #[test]
    fn refraction_obeys_snell_and_reverses() {
        for i in 0..200 {
            let [a, b] = sobol2(i, 5);
            let d = -cosine_hemisphere([a, b]);
            let t = refract(d, Vec3::Z, 1.0 / 1.5).expect("no total reflection into the denser side");
            assert!((d.cross(Vec3::Z).length() - 1.5 * t.cross(Vec3::Z).length()).abs() < 1e-5);
            let again = refract(-t, -Vec3::Z, 1.5).expect("reversible");
            assert!((again + d).length() < 1e-3, "{again} against {d}");
        }
    }

    fn glossy(exponent: f32) -> PackedMaterial {
        PackedMaterial::new(&Material {
            glossy: [0.5; 3],
            glossy_exponent: exponent,
            ..Material::matte("m", [0.3; 3])
        })
    }

    /// Sampling by its pdf gives the same albedo as uniform directions do; f is symmetric.
    #[test]
    fn glossy_sampling_matches_its_pdf() {
        let (m, n) = (glossy(30.0), Vec3::Z);
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let count = 1 << 17;
        let (mut by_lobe, mut by_cone, mut total_pdf) = (0.0, 0.0, 0.0);
        for i in 0..count {
            let [a, b, c, _] = random4(1, 0, i, 0);
            if let Some(wi) = sample_d(&m, wo, n, c, [a, b]) {
                by_lobe += f64::from(eval_d(&m, wi, wo, n)[0] * wi.z / pdf_d(&m, wi, wo, n));
            }
            let wi = crate::sampling::distributions::cone([a, b], 1.0);
            by_cone += f64::from(eval_d(&m, wi, wo, n)[0] * wi.z * TAU);
            total_pdf += f64::from(pdf_d(&m, wi, wo, n) * TAU);
            assert!((eval_d(&m, wi, wo, n)[0] - eval_d(&m, wo, wi, n)[0]).abs() < 1e-4);
        }
        let n = f64::from(count);
        assert!((by_lobe / by_cone - 1.0).abs() < 0.02, "{} {}", by_lobe / n, by_cone / n);
        // the part of the lobe below the surface is lost: a little less than one
        assert!(total_pdf / n > 0.97 && total_pdf / n < 1.01, "{}", total_pdf / n);
        assert!(by_lobe / n < 0.8);
    }
}
