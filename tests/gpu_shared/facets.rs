//! Microfacets on both sides against formulas in f64 that share no code with them: complex numbers for metal, angles for dielectrics,
//! Smith's Λ by tangents.

use crate::common::{Row, Snippet, dvec3, floats, random, random_direction, row, row3, vec3};
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::backend::gpu::harness::Harness;
use joton::optics::shading::bsdf::Scatter;
use joton::packed::PackedMaterial;
use joton::packed::constants::GGX_LOST;
use joton::scene::{FacetKind, Facets, Inner, Material};
use std::f64::consts::PI;

const BSDF: &[&str] = &["scene/features.wgsl", "shading/lobes.wgsl"];
const MATERIALS: &str = "@group(0) @binding(0) var<storage, read> materials: array<PackedMaterial>;\n";

/// A complex number.
type Complex = [f64; 2];

fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn over(a: Complex, [c, d]: Complex) -> Complex {
    let [x, y] = times(a, [c, -d]);
    [x / (c * c + d * d), y / (c * c + d * d)]
}

fn root([a, b]: Complex) -> Complex {
    let (r, phi) = (a.hypot(b).sqrt(), b.atan2(a) / 2.0);
    [r * phi.cos(), r * phi.sin()]
}

/// Reflectance by the amplitudes of Fresnel with a complex index [E40].
fn fresnel(cos: f64, index: Complex) -> f64 {
    let sin2 = 1.0 - cos * cos;
    let squared = times(index, index);
    let inner = root([squared[0] - sin2, squared[1]]);
    let of = |a: Complex, b: Complex| {
        let r = over([a[0] - b[0], a[1] - b[1]], [a[0] + b[0], a[1] + b[1]]);
        r[0] * r[0] + r[1] * r[1]
    };
    0.5 * (of([cos, 0.0], inner) + of(times(squared, [cos, 0.0]), inner))
}

/// What a facet reflects, per band.
fn reflectance(m: &Material, packed: &PackedMaterial, band: usize, cos: f64) -> f64 {
    let tint = f64::from(m.glossy[band]);
    match m.facets.expect("microfacets").kind {
        FacetKind::Conductor { eta, k } => tint * fresnel(cos, [f64::from(eta[band]), f64::from(k[band])]),
        FacetKind::Schlick { .. } => tint + (1.0 - tint) * (1.0 - cos).powi(5),
        _ => tint * fresnel(cos, [f64::from(packed.ior), 0.0]),
    }
}

/// What the coat lets through, by the formula of its lobe.
fn passed(m: &Material, ior: f64, cos: f64) -> f64 {
    match m.facets.expect("microfacets").kind {
        FacetKind::Schlick { .. } => {
            let head_on = fresnel(1.0, [ior, 0.0]);
            (1.0 - head_on) * (1.0 - (1.0 - cos).powi(5))
        }
        _ => 1.0 - fresnel(cos, [ior, 0.0]),
    }
}

/// Smith's Λ by the tangent.
pub fn lambda(alpha: f64, cos: f64) -> f64 {
    let tan2 = 1.0 / (cos * cos) - 1.0;
    ((1.0 + alpha * alpha * tan2).sqrt() - 1.0) / 2.0
}

/// GGX by the tangent, 1/sr.
pub fn density(alpha: f64, cos: f64) -> f64 {
    let tan2 = 1.0 / (cos * cos) - 1.0;
    1.0 / (PI * alpha * alpha * cos.powi(4) * (1.0 + tan2 / (alpha * alpha)).powi(2))
}

/// f_r of the lobes that scatter, and their pdfs: of the diffuse one and of the microfacets.
fn wanted(m: &Material, p: &PackedMaterial, n: DVec3, wi: DVec3, wo: DVec3, band: usize) -> (f64, [f64; 2]) {
    let (ci, co) = (wi.dot(n), wo.dot(n));
    let alpha = f64::from(m.facets.unwrap().alpha);
    let h = (wi + wo).normalize();
    let d = density(alpha, h.dot(n));
    let (li, lo) = (lambda(alpha, ci), lambda(alpha, co));
    let mut f = reflectance(m, p, band, wo.dot(h)) * d / ((1.0 + li + lo) * 4.0 * ci * co);
    f += scattered_again(m, p, band, alpha, [ci, co]);
    if m.diffuse[band] > 0.0 {
        let ior = f64::from(p.ior);
        let passes = |c: f64| passed(m, ior, c);
        f += f64::from(p.diffuse[band]) / PI * passes(ci) * passes(co);
    }
    (f, [ci / PI, d / ((1.0 + lo) * 4.0 * co)])
}

/// What facets mask at two cosines, by the fit, and its mean by the midpoint rule.
pub fn lost_and_mean(alpha: f64, cosines: [f64; 2]) -> ([f64; 2], f64) {
    let lost = |c: f64| {
        let term = |(j, row): (usize, &[f32; 4])| {
            let of =
                |(i, k): (usize, &f32)| f64::from(*k) * alpha.powf(i as f64 / 2.0) * c.powf(j as f64 / 2.0);
            row.iter().enumerate().map(of).sum::<f64>()
        };
        GGX_LOST.iter().enumerate().map(term).sum::<f64>()
    };
    (cosines.map(|c| lost(c).max(0.0)), even(&lost).max((0.9 * alpha * alpha).min(0.0152)))
}

/// Mean over even light, by the midpoint rule.
fn even(of: &dyn Fn(f64) -> f64) -> f64 {
    const STEPS: usize = 200;
    let at = |i: usize| (i as f64 + 0.5) / STEPS as f64;
    (0..STEPS).map(|i| 2.0 * at(i) * of(at(i))).sum::<f64>() / STEPS as f64
}

/// What is scattered more than once [E41].
fn scattered_again(m: &Material, p: &PackedMaterial, band: usize, alpha: f64, [ci, co]: [f64; 2]) -> f64 {
    let ([lost_i, lost_o], mean) = lost_and_mean(alpha, [ci, co]);
    let head_on = reflectance(m, p, band, 1.0);
    let tint = f64::from(m.glossy[band]);
    let of_even = match m.facets.unwrap().kind {
        // Schlick's formula from what is reflected head on, metal times its tint
        FacetKind::Schlick { .. } => even(&|c| head_on + (1.0 - head_on) * (1.0 - c).powi(5)),
        FacetKind::Conductor { .. } => {
            let bare = head_on / tint;
            tint * even(&|c| bare + (1.0 - bare) * (1.0 - c).powi(5))
        }
        _ => return 0.0,
    };
    let kept = of_even * of_even * (1.0 - mean) / (1.0 - of_even * mean);
    kept * lost_i * lost_o / (PI * mean)
}

fn with_facets(diffuse: [f32; 3], glossy: [f32; 3], alpha: f32, kind: FacetKind) -> Material {
    Material { glossy, facets: Some(Facets { alpha, kind }), ..Material::matte("f", diffuse) }
}

/// Gold, a principled surface, lacquer and plastic of all sorts.
fn materials() -> Vec<Material> {
    let gold = FacetKind::Conductor { eta: [0.2, 0.4, 1.4], k: [3.3, 2.4, 1.9] };
    let coat = |inner| FacetKind::Coat { ior: 1.5, inner };
    let mut all = Vec::new();
    for alpha in [0.1, 0.25, 0.6, 1.0] {
        all.push(with_facets([0.0; 3], [1.0, 0.9, 0.8], alpha, gold));
        all.push(with_facets([0.0; 3], [0.9, 0.5, 0.1], alpha, FacetKind::Schlick { ior: 1.0 }));
        all.push(with_facets([0.4, 0.2, 0.1], [0.3, 0.2, 0.1], alpha, FacetKind::Schlick { ior: 1.5 }));
        all.push(with_facets([0.8, 0.4, 0.1], [1.0; 3], alpha, coat(Inner::Even)));
        all.push(with_facets([0.8, 0.4, 0.1], [0.5, 0.9, 0.7], alpha, coat(Inner::Coloured)));
    }
    all
}

/// BRDF, pdf and weights of samples: as the formulas say, on both sides.
#[test]
fn facets_are_their_formulas() {
    let context = device_or_return!();
    let stated = materials();
    let packed: Vec<PackedMaterial> = stated.iter().map(PackedMaterial::new).collect();
    let mut inputs: Vec<[Row; 4]> = Vec::new();
    for (m, material) in packed.iter().enumerate() {
        assert!(material.flags().has_glossy(), "lobes this wide scatter");
        for i in 0..200 {
            let n = random_direction(6, i);
            let up = |v: Vec3| if v.dot(n) < 0.0 { -v } else { v };
            let wo = up(random_direction(7, i));
            let wi = up(random_direction(8, i));
            let [a, b, ..] = random(9, i);
            if wo.dot(n) > 0.02 && wi.dot(n) > 0.02 {
                inputs.push([row3(n, m as f32), row3(wi, 0.0), row3(wo, 0.0), row([a, b, 0.0, 0.0])]);
            }
        }
    }
    let snippet = Snippet {
        imports: BSDF,
        declarations: MATERIALS,
        code: "let m = materials[u32(in_f(0u).w)]; let n = in_f(0u).xyz; let wi = in_f(1u).xyz; let wo = in_f(2u).xyz;
            out_f(0u, vec4(eval_scatter(m, n, wi, wo), pdf_scatter(m, n, wi, wo)));
            out_f(1u, vec4(eval_scatter(m, n, wo, wi), diffuse_share(m, n, wo)));
            let s = sample_lobe(m, LOBE_GLOSSY, -wo, n, n, true, in_f(3u).xy);
            let albedo = lobe_albedo(m, LOBE_GLOSSY, at_angle(m, n, -wo, true));
            out_f(2u, vec4(s.direction, s.weight.x * albedo.x));
            let d = sample_lobe(m, LOBE_DIFFUSE, -wo, n, n, true, in_f(3u).xy);
            let under = lobe_albedo(m, LOBE_DIFFUSE, at_angle(m, n, -wo, true));
            out_f(3u, vec4(d.direction, d.weight.x * under.x));
            let w = lobe_weights(m, Bands(1.0), at_angle(m, n, -wo, true));
            out_f(4u, vec4(w.diffuse, w.glossy, w.mirror, w.reflection + w.transmission));",
        overrides: &[],
    };
    let mut harness = Harness::new(context);
    harness.storage("materials", &packed);
    let out: Vec<[Row; 5]> = snippet.run_in(context, &mut harness, &[], &inputs);
    let mut sampled = 0;
    for (i, [forth, back, glossy, diffuse, weights]) in inputs.iter().zip(out) {
        let (n, wi, wo) = (dvec3(i[0]), dvec3(i[1]), dvec3(i[2]));
        let at = floats(i[0])[3] as usize;
        let (m, p) = (&stated[at], &packed[at]);
        let what = format!("material {at}, {wi} to {wo} about {n}");
        let host = Scatter::of(p, vec3(i[2]), vec3(i[0]));
        let on_host = host.eval(vec3(i[1]), vec3(i[2]), vec3(i[0]));
        let share = f64::from(floats(back)[3]);
        for (b, of_host) in on_host.into_iter().enumerate() {
            let (f, [pdf_diffuse, pdf_facets]) = wanted(m, p, n, wi, wo, b);
            for (who, got) in
                [("device", floats(forth)[b]), ("exchanged", floats(back)[b]), ("host", of_host)]
            {
                assert!(
                    (f64::from(got) - f).abs() < 2e-4 * f + 2e-5,
                    "{who}, band {b}, {what}: {got}, not {f}"
                );
            }
            let pdf = share * pdf_diffuse + (1.0 - share) * pdf_facets;
            let of_host = host.pdf(vec3(i[1]), vec3(i[2]), vec3(i[0]));
            for (who, got) in [("device", floats(forth)[3]), ("host", of_host)] {
                assert!(
                    (f64::from(got) - pdf).abs() < 2e-4 * pdf + 2e-5,
                    "{who}, {what}: pdf {got}, not {pdf}"
                );
            }
        }
        // of light that arrives so: what a flat facet reflects, and what passes the coat twice
        let co = wo.dot(n);
        let most = |of: &dyn Fn(usize) -> f64| (0..3).map(of).fold(0.0, f64::max);
        let reflected = most(&|b| reflectance(m, p, b, co));
        let passes = passed(m, f64::from(p.ior), co);
        let base = most(&|b| f64::from(p.diffuse[b])) * passes * f64::from(p.coat_transmittance);
        for (got, wanted) in floats(weights).into_iter().zip([base, reflected, 0.0, 0.0]) {
            assert!((f64::from(got) - wanted).abs() < 2e-5, "{what}: weight {got}, not {wanted}");
        }
        // what a lobe's sample carries is f cos / pdf of that lobe alone
        let facets_alone = Material { diffuse: [0.0; 3], ..m.clone() };
        let w = dvec3(glossy);
        if w.dot(n) > 0.02 && (w + wo).length() > 1e-2 {
            sampled += 1;
            let (f, [_, pdf]) = wanted(&facets_alone, p, n, w, wo, 0);
            let carried = f * w.dot(n) / pdf;
            let got = f64::from(floats(glossy)[3]);
            assert!((got - carried).abs() < 1e-3 * carried + 1e-4, "{what}: carries {got}, not {carried}");
        }
        if m.diffuse[0] > 0.0 {
            let w = dvec3(diffuse);
            let (both, [pdf, _]) = wanted(m, p, n, w, wo, 0);
            let (facets, _) = wanted(&facets_alone, p, n, w, wo, 0);
            let carried = (both - facets) * w.dot(n) / pdf;
            let got = f64::from(floats(diffuse)[3]);
            assert!(
                (got - carried).abs() < 1e-3 * carried + 1e-4,
                "{what}: base carries {got}, not {carried}"
            );
        }
    }
    assert!(sampled > 3000, "{sampled} samples");
}
