//! Lobes that are followed but have a width: what they send from a direction, and with which density, against formulas in f64 that share no
//! code. Phong's about the mirror direction, GGX by tangents, rough glass by Walter's half vectors.

use crate::common::{Row, Snippet, dvec3, floats, random, random_direction, row3};
use crate::device_or_return;
use crate::scatter::with_materials;
use glam::DVec3;
use joton::packed::PackedMaterial;
use joton::scene::{Dielectric, FacetKind, Facets, Material};
use std::f64::consts::{PI, TAU};

/// Smith's Λ by the tangent.
fn lambda(alpha: f64, cos: f64) -> f64 {
    let tan2 = 1.0 / (cos * cos) - 1.0;
    ((1.0 + alpha * alpha * tan2).sqrt() - 1.0) / 2.0
}

/// GGX, 1/sr, by the sine: a tangent near the normal has no digits of a cosine.
fn density(alpha: f64, n: DVec3, h: DVec3) -> f64 {
    let tan2 = n.cross(h).length_squared() / n.dot(h).powi(2);
    1.0 / (PI * alpha * alpha * n.dot(h).powi(4) * (1.0 + tan2 / (alpha * alpha)).powi(2))
}

/// Reflectance of an interface by sines and tangents of the angles; `eta` of the far side over the near one.
fn fresnel(cos_i: f64, eta: f64) -> f64 {
    let i = cos_i.acos();
    if i.sin() >= eta {
        return 1.0;
    }
    let t = (i.sin() / eta).asin();
    if i < 1e-4 {
        return ((1.0 - eta) / (1.0 + eta)).powi(2);
    }
    0.5 * (((i - t).sin() / (i + t).sin()).powi(2) + ((i - t).tan() / (i + t).tan()).powi(2))
}

/// f |cos| of radiance toward `wo`, and pdf_solid_angle of following `wo` to `w`; of the first band.
fn wanted(m: &Material, n: DVec3, w: DVec3, wo: DVec3, from_front: bool) -> [f64; 2] {
    let Some(facets) = m.facets else {
        let e = f64::from(m.glossy_exponent);
        let below = 0.5 * (2.0 * wo.dot(n) * n - wo - w).length_squared();
        let pdf = (e + 1.0) / TAU * (e * (-below).ln_1p()).exp();
        return [f64::from(m.glossy[0]) * pdf, pdf];
    };
    let alpha = f64::from(facets.alpha);
    let (co, cw) = (wo.dot(n), w.dot(n).abs());
    let (lo, lw) = (lambda(alpha, co), lambda(alpha, cw));
    let Some(glass) = m.dielectric else {
        let h = (wo + w).normalize();
        let d = density(alpha, n, h);
        let tint = f64::from(m.glossy[0]);
        let reflectance = tint + (1.0 - tint) * (1.0 - wo.dot(h)).powi(5);
        return [reflectance * d / ((1.0 + lo + lw) * 4.0 * co), d / ((1.0 + lo) * 4.0 * co)];
    };
    // indices of the side of the eye, and of the other
    let ior = f64::from(glass.ior);
    let (near, far) = if from_front { (1.0, ior) } else { (ior, 1.0) };
    if m.thin {
        // a pane sends as much through as facets without their faces' reflectance would reflect, to where its mirror image is
        let seen = if w.dot(n) > 0.0 { w } else { w - 2.0 * w.dot(n) * n };
        let h = (wo + seen).normalize();
        let d = density(alpha, n, h);
        let face = fresnel(wo.dot(h), ior);
        // what goes to and fro between the faces: R + T² R (1 + R² + R⁴ + …)
        let pane = face + (1.0 - face).powi(2) * face / (1.0 - face * face);
        let kept = match w.dot(n) > 0.0 {
            true => f64::from(glass.reflection_tint[0]) * pane,
            false => f64::from(glass.transmission_tint[0]) * (1.0 - pane),
        };
        return [kept * d / ((1.0 + lo + lw) * 4.0 * co), d / ((1.0 + lo) * 4.0 * co)];
    }
    if w.dot(n) > 0.0 {
        let h = (wo + w).normalize();
        let d = density(alpha, n, h);
        let tint = f64::from(glass.reflection_tint[0]);
        let reflectance = tint * fresnel(wo.dot(h), far / near);
        return [reflectance * d / ((1.0 + lo + lw) * 4.0 * co), d / ((1.0 + lo) * 4.0 * co)];
    }
    let across = -(near * wo + far * w);
    let h = across.normalize() * across.dot(n).signum();
    let (ho, hw) = (wo.dot(h), w.dot(h));
    if ho <= 0.0 || hw >= 0.0 {
        return [0.0; 2];
    }
    let d = density(alpha, n, h);
    let seen = d / ((1.0 + lo) * co) * ho;
    // (21) and (17) of Walter et al., light going from w to wo: f cosθ has near², the turn of a facet's normal far²
    let turned = -hw / (near * ho + far * hw).powi(2);
    let passed = f64::from(glass.transmission_tint[0]) * (1.0 - fresnel(ho, far / near));
    [passed * seen * turned * near * near / (1.0 + lw), seen * turned * far * far]
}

fn materials() -> Vec<Material> {
    let faceted = |alpha, kind| Some(Facets { alpha, kind });
    let mut all: Vec<Material> = [301.0, 1e3, 1e4, 1e5, 1e6]
        .map(|glossy_exponent| Material {
            glossy: [0.6, 0.2, 0.1],
            glossy_exponent,
            ..Material::matte("phong", [0.3; 3])
        })
        .into();
    // narrower than .02 nothing is scattered again, and up to .0814 lobes are followed
    for alpha in [0.002, 0.005, 0.02] {
        all.push(Material {
            glossy: [0.6, 0.2, 0.1],
            facets: faceted(alpha, FacetKind::Schlick { ior: 1.0 }),
            ..Material::matte("metal", [0.0; 3])
        });
    }
    let glass = Dielectric { ior: 1.5, reflection_tint: [0.9, 0.8, 0.7], transmission_tint: [0.8, 0.9, 1.0] };
    for (alpha, thin) in [0.01, 0.1, 0.5, 1.0].into_iter().flat_map(|alpha| [(alpha, false), (alpha, true)]) {
        all.push(Material {
            dielectric: Some(glass),
            facets: faceted(alpha, FacetKind::Interface),
            thin,
            ..Material::matte("glass", [0.0; 3])
        });
    }
    all
}

/// Where light leaves by a facet about the normal as wide as the lobe: its mirror image, or what it refracts.
fn sent(m: &Material, n: DVec3, wo: DVec3, from_front: bool, i: usize) -> Option<DVec3> {
    let width = m.facets.map_or(1.0 / f64::from(m.glossy_exponent).sqrt(), |f| f64::from(f.alpha));
    let [radius, way, ..] = random(11, i);
    let h = (n + 1.5 * f64::from(radius) * width * random_direction(12, i).as_dvec3()).normalize();
    let ho = wo.dot(h);
    if ho <= 0.02 {
        return None;
    }
    let reflected = Some(2.0 * ho * h - wo).filter(|w| w.dot(n) > 0.02);
    let Some(glass) = m.dielectric.filter(|_| way < 0.5) else { return reflected };
    if m.thin {
        return reflected.map(|w| w - 2.0 * w.dot(n) * n);
    }
    let eta = f64::from(if from_front { 1.0 / glass.ior } else { glass.ior });
    let cos2 = 1.0 - eta * eta * (1.0 - ho * ho);
    let w = -eta * wo + (eta * ho - cos2.max(0.0).sqrt()) * h;
    Some(w).filter(|w| cos2 > 0.01 && w.dot(n) < -0.02)
}

#[test]
fn followed_lobes_are_their_formulas() {
    let context = device_or_return!();
    let stated = materials();
    let packed: Vec<PackedMaterial> = stated.iter().map(PackedMaterial::new).collect();
    let mut inputs: Vec<[Row; 3]> = Vec::new();
    for (m, material) in stated.iter().enumerate() {
        assert!(packed[m].has_narrow_lobe());
        for i in 0..400 {
            let n = random_direction(6, i);
            let wo = random_direction(7, i);
            let wo = if wo.dot(n) < 0.0 { -wo } else { wo };
            let from_front = i % 2 == 0;
            let w = sent(material, n.as_dvec3().normalize(), wo.as_dvec3(), from_front, i);
            let Some(w) = w.filter(|_| wo.dot(n) > 0.05) else { continue };
            let side = if from_front { 1.0 } else { 0.0 };
            inputs.push([row3(n, m as f32), row3(w.as_vec3(), side), row3(wo, 0.0)]);
        }
    }
    let snippet = Snippet {
        imports: &["scene/features.wgsl", "scene/scene.wgsl", "shading/followed.wgsl"],
        declarations: "",
        code: "let m = material_at(u32(in_f(0u).w)); let n = in_f(0u).xyz; let w = in_f(1u).xyz; let wo = in_f(2u).xyz;
            let front = in_f(1u).w > 0.5;
            let f = followed_from(Bsdf(m, -wo, front, n, n, at_angle(m, n, -wo, front), Bands(1.0), 0u, 0u, 0u), w);
            out_f(0u, vec4(f.f_cos, f.pdf));",
        overrides: &[],
    };
    let mut harness = with_materials(context, &packed);
    let out: Vec<[Row; 1]> = snippet.run_in(context, &mut harness, &[], &inputs);
    let mut across = 0;
    for (i, [o]) in inputs.iter().zip(out) {
        let (n, w, wo) = (dvec3(i[0]), dvec3(i[1]), dvec3(i[2]));
        let m = &stated[floats(i[0])[3] as usize];
        across += usize::from(w.dot(n) < 0.0);
        let [f_cos, pdf] = wanted(m, n, w, wo, floats(i[1])[3] > 0.5);
        // directions of f32 are off by some 1e-7, and how far that is depends on the width
        let width = m.facets.map_or(1.0 / f64::from(m.glossy_exponent).sqrt(), |f| f64::from(f.alpha));
        let tolerance = 2e-4 + 4e-6 / width;
        let got = floats(o).map(f64::from);
        for (what, got, wanted) in [("f cos", got[0], f_cos), ("pdf", got[3], pdf)] {
            assert!(
                (got - wanted).abs() < tolerance * wanted + 1e-6,
                "{what} of {} {width}, {w} to {wo} about {n}: {got}, not {wanted}",
                m.name
            );
        }
    }
    assert!(across > 300, "{across} directions across");
}
