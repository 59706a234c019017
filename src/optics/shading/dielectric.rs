//! A smooth interface of two dielectrics: reflection and transmission \[E8\], and thin panes \[E26\]. Twin:
//! shaders/shading/dielectric.wgsl.

use crate::optics::shading::frame::Frame;
use crate::optics::shading::mirror::Mirror;
use crate::packed::PackedMaterial;
use crate::spectrum::{BANDS, BLACK, Bands, mul};
use glam::Vec3;

/// Unpolarised reflectance of a dielectric interface \[E8\]; `eta` = n_t / n_i. 1 at total reflection.
pub(crate) fn fresnel(cos_i: f32, eta: f32) -> f32 {
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
pub(super) fn pane_reflectance(face: f32) -> f32 {
    2.0 * face / (1.0 + face)
}

/// Direction of refraction; `n` on the side that `d` comes from. None at total reflection.
pub(super) fn refract(d: Vec3, n: Vec3, eta_i_over_t: f32) -> Option<Vec3> {
    let cos_i = -d.dot(n);
    let sin2_t = eta_i_over_t * eta_i_over_t * (1.0 - cos_i * cos_i).max(0.0);
    (sin2_t < 1.0)
        .then(|| (d * eta_i_over_t + n * (eta_i_over_t * cos_i - (1.0 - sin2_t).sqrt())).normalize())
}

/// One of the two ways on from an interface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Way {
    pub(crate) albedo: Bands,
    pub(crate) direction: Vec3,
    /// (η_i/η_t)², by which radiance scales on crossing [E9]; a joton's flux does not.
    pub(crate) radiance_scale: f32,
}

/// Reflection and transmission at an interface. Where bands part, the direction of transmission is that of `ior`: [`in_one_band`] has
/// the others.
pub(crate) fn ways(m: &PackedMaterial, f: &Frame) -> [Way; 2] {
    let (reflectance, refracted, eta_i_over_t) = crossing(m, m.ior, f);
    let reflectance = if m.flags().is_dispersive() {
        m.iors.map(|ior| crossing(m, ior, f).0)
    } else {
        [reflectance; BANDS]
    };
    [
        Way { albedo: mul(&m.specular, &reflectance), direction: Mirror::direction(f), radiance_scale: 1.0 },
        Way {
            albedo: mul(&m.transmission, &reflectance.map(|r| 1.0 - r)),
            direction: refracted,
            radiance_scale: eta_i_over_t * eta_i_over_t,
        },
    ]
}

/// What is transmitted where bands part: one band, picked by what of each would be, p = c/Σc; that of the others is black \[E36\].
/// `transmission` is the second of the [`ways`], `u` in [0, 1).
pub(crate) fn in_one_band(m: &PackedMaterial, f: &Frame, transmission: &Way, carried: &Bands, u: f32) -> Way {
    let parts = mul(carried, &transmission.albedo).map(f64::from);
    let Some(band) = picked_band(&parts, u) else { return Way { albedo: BLACK, ..*transmission } };
    let (_, direction, eta_i_over_t) = crossing(m, m.iors[band], f);
    let mut albedo = BLACK;
    albedo[band] = (f64::from(transmission.albedo[band]) * parts.iter().sum::<f64>() / parts[band]) as f32;
    Way { albedo, direction, radiance_scale: eta_i_over_t * eta_i_over_t }
}

/// The band that `u` in [0, 1) picks, each in proportion to its part; none where nothing is.
pub(super) fn picked_band(parts: &[f64; BANDS], u: f32) -> Option<usize> {
    let total: f64 = parts.iter().sum();
    let mut upto = 0.0;
    let is_picked = |part: &f64| {
        upto += part;
        *part > 0.0 && f64::from(u) * total < upto
    };
    // rounding may leave a sum below the total
    parts.iter().position(is_picked).or_else(|| parts.iter().rposition(|part| *part > 0.0))
}

/// Share that is reflected, direction of the rest (arbitrary where all is), and η of the side that the ray comes from over
/// that of the side it would go to.
fn crossing(m: &PackedMaterial, ior: f32, f: &Frame) -> (f32, Vec3, f32) {
    let n = f.specular_normal();
    let along = -f.back;
    if m.flags().is_thin() {
        return (pane_reflectance(fresnel(f.back.dot(n), ior)), along, 1.0);
    }
    let eta_i_over_t = if f.front { 1.0 / ior } else { ior };
    let about = |n: Vec3| {
        let crossing = refract(along, n, eta_i_over_t).filter(|w| w.dot(f.ng) < 0.0);
        crossing.map(|w| (fresnel(f.back.dot(n), 1.0 / eta_i_over_t), w))
    };
    let is_total = fresnel(f.back.dot(n), 1.0 / eta_i_over_t) >= 1.0;
    let (reflectance, refracted) =
        if is_total { None } else { about(n).or_else(|| about(f.ng)) }.unwrap_or((1.0, along));
    (reflectance, refracted, eta_i_over_t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::distributions::cosine_hemisphere;
    use crate::sampling::rng::sobol2;
    use crate::scene::{Dielectric, Material};

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

    /// Bands part without bias: over even numbers each carries what it would, one at a time, and goes by its own index.
    #[test]
    fn bands_part_and_add_up() {
        let glass = Material {
            dielectric: Some(Dielectric {
                ior: 1.5,
                reflection_tint: [1.0; 3],
                transmission_tint: [0.9, 0.5, 0.8],
            }),
            ..Material::matte("glass", BLACK)
        };
        let mut m = PackedMaterial::new(&glass);
        m.iors = [1.4, 1.5, 1.7];
        m.set_dispersive();
        const COUNT: usize = 3000;
        for (i, carried) in
            [[1.0f32, 1.0, 1.0], [0.2, 0.0, 3.0], [0.0, 0.7, 0.0], BLACK].into_iter().enumerate()
        {
            let back = Vec3::new(0.6, 0.0, 0.8);
            let f = Frame { back, ng: Vec3::Z, ns: Vec3::Z, front: i % 2 == 0 };
            let [reflected, transmitted] = ways(&m, &f);
            let mut sum = [0.0f64; BANDS];
            for k in 0..COUNT {
                let way = in_one_band(&m, &f, &transmitted, &carried, (k as f32 + 0.5) / COUNT as f32);
                let goes_on = mul(&carried, &way.albedo);
                assert!(goes_on.iter().filter(|&&x| x > 0.0).count() <= 1, "one band: {goes_on:?}");
                (0..BANDS).for_each(|b| sum[b] += f64::from(goes_on[b]) / COUNT as f64);
                if let Some(band) = goes_on.iter().position(|&x| x > 0.0) {
                    let eta = if f.front { m.iors[band] } else { 1.0 / m.iors[band] };
                    let sine = way.direction.cross(Vec3::Z).length();
                    assert!((eta * sine - 0.6).abs() < 1e-6, "band {band}: Snell's sine {sine}");
                    assert!((way.radiance_scale * eta * eta - 1.0).abs() < 1e-5, "band {band}");
                    let face = fresnel(0.8, eta);
                    assert!((reflected.albedo[band] - face).abs() < 1e-6, "band {band} by its own index");
                }
            }
            for b in 0..BANDS {
                let eta = if f.front { m.iors[b] } else { 1.0 / m.iors[b] };
                let wanted = carried[b] * m.transmission[b] * (1.0 - fresnel(0.8, eta));
                assert!(
                    (sum[b] - f64::from(wanted)).abs()
                        < 1e-9 + 2e-3 * f64::from(carried[0] + carried[1] + carried[2]),
                    "band {b} of {carried:?}: {} {wanted}",
                    sum[b]
                );
            }
        }
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
}
