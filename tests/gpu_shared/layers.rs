//! Clear coats, sheen and the base under them on both sides, against formulas in f64 that share no code with them: Charlie's sheen by angles,
//! GGX by tangents, coats by Schlick's formula [E50–E52].

use crate::common::{Row, Snippet, dvec3, floats, random, random_direction, row, row3, vec3};
use crate::device_or_return;
use crate::facets::{density, lambda, lost_and_mean};
use crate::scatter::with_materials;
use glam::{DVec3, Vec3};
use joton::optics::shading::bsdf::Scatter;
use joton::packed::PackedMaterial;
use joton::packed::constants::SHEEN_ALBEDO;
use joton::scene::{FacetKind, Facets, Layers, Material};
use std::f64::consts::{PI, TAU};

/// From head on to grazing.
fn schlick(head_on: f64, grazing: f64, cos: f64) -> f64 {
    head_on + (grazing - head_on) * (1.0 - cos).powi(5)
}

fn coat(l: &Layers, cos: f64) -> f64 {
    f64::from(l.clear_coat) * schlick(0.04, 1.0, cos)
}

/// The fit, by powers.
fn sheen_albedo(l: &Layers, cos: f64) -> f64 {
    let of = |(j, row): (usize, &[f32; 4])| {
        let term = |(i, k): (usize, &f32)| f64::from(*k) * f64::from(l.sheen_roughness).powi(i as i32);
        row.iter().enumerate().map(term).sum::<f64>() * cos.powf(j as f64 / 2.0)
    };
    SHEEN_ALBEDO.iter().enumerate().map(of).sum::<f64>().clamp(0.0, 1.0)
}

/// Part of light that reaches the base.
fn left(l: &Layers, cos: f64) -> f64 {
    let most = l.sheen.iter().fold(0.0f32, |a, b| a.max(*b));
    (1.0 - coat(l, cos)) * (1.0 - f64::from(most) * sheen_albedo(l, cos))
}

/// f_r of white sheen; half vectors and shadowing by angles.
fn charlie(roughness: f64, n: DVec3, wi: DVec3, wo: DVec3) -> f64 {
    let alpha = roughness * roughness;
    let angle = (wi + wo).normalize().dot(n).clamp(-1.0, 1.0).acos();
    let d = (2.0 + 1.0 / alpha) * angle.sin().powf(1.0 / alpha) / TAU;
    let smooth = 1.0 - (1.0 - alpha) * (1.0 - alpha);
    let term = |at_0: f64, at_1: f64| at_0 * (1.0 - smooth) + at_1 * smooth;
    let l = |x: f64| {
        term(25.3245, 21.5473) / (1.0 + term(3.32435, 3.82987) * x.powf(term(0.16801, 0.19823)))
            + term(-1.27393, -1.97760) * x
            + term(-4.85967, -4.32054)
    };
    let lambda = |c: f64| if c < 0.5 { l(c).exp() } else { (2.0 * l(0.5) - l(1.0 - c)).exp() };
    let (ci, co) = (wi.dot(n), wo.dot(n));
    d / ((1.0 + lambda(ci) + lambda(co)) * 4.0 * ci * co)
}

/// Ways that light goes: by the diffuse base, the facets of the base, sheen, the coat.
struct Lobes {
    f: [f64; 4],
    pdf: [f64; 4],
}

impl Lobes {
    fn of(m: &Material, n: DVec3, wi: DVec3, wo: DVec3, band: usize) -> Self {
        let l = m.layers.as_ref().expect("layers");
        let alpha = f64::from(m.facets.expect("microfacets").alpha);
        let (ci, co) = (wi.dot(n), wo.dot(n));
        let h = (wi + wo).normalize();
        let ggx = |alpha: f64| {
            if alpha == 0.0 {
                return [0.0; 2];
            }
            let d = density(alpha, h.dot(n));
            let (li, lo) = (lambda(alpha, ci), lambda(alpha, co));
            [d / ((1.0 + li + lo) * 4.0 * ci * co), d / ((1.0 + lo) * 4.0 * co)]
        };
        let under = left(l, ci).min(left(l, co));
        // the dielectric part lets through what it does not reflect, of the band that reflects most
        let most = f64::from(l.head_on.iter().fold(0.0f32, |a, b| a.max(*b)));
        let grazing = f64::from(l.grazing);
        let passes = |c: f64| 1.0 - schlick(most, grazing, c);
        const STEPS: u32 = 2000;
        let of_even = |f: &dyn Fn(f64) -> f64| {
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
            (0..STEPS).map(|i| 2.0 * at(i) * f(at(i))).sum::<f64>() / f64::from(STEPS)
        };
        let diffuse = f64::from(m.diffuse[band]) / of_even(&passes) * passes(ci) * passes(co) / PI;
        let reflected = |c: f64| {
            let all = grazing * (1.0 - f64::from(l.metallic)) + f64::from(l.metallic);
            schlick(f64::from(m.glossy[band]), all, c)
        };
        let even = of_even(&reflected);
        let ([lost_i, lost_o], mean) = lost_and_mean(alpha, [ci, co]);
        let again = even * even * (1.0 - mean) / (1.0 - even * mean) * lost_i * lost_o / (PI * mean);
        let [facets, facets_pdf] = ggx(alpha);
        let [coats, coat_pdf] = ggx(f64::from(l.clear_coat_alpha));
        let sheen = f64::from(l.sheen[band])
            * charlie(f64::from(l.sheen_roughness), n, wi, wo)
            * (1.0 - coat(l, ci)).min(1.0 - coat(l, co));
        Self {
            f: [
                diffuse * under,
                (reflected(wo.dot(h)) * facets + again) * under,
                sheen,
                coat(l, wo.dot(h)) * coats,
            ],
            pdf: [ci / PI, facets_pdf, 1.0 / TAU, coat_pdf],
        }
    }
}

/// A principled material with layers.
pub fn layered(diffuse: [f32; 3], glossy: [f32; 3], alpha: f32, layers: Layers) -> Material {
    let root = layers.head_on.iter().fold(0.0f32, |a, b| a.max(*b)).sqrt();
    let kind = FacetKind::Schlick { ior: (1.0 + root) / (1.0 - root) };
    let facets = Some(Facets { alpha, kind });
    Material { glossy, facets, layers: Some(layers), ..Material::matte("layered", diffuse) }
}

/// Coats and sheen of all sorts whose lobes scatter, alone and one over the other.
fn materials() -> Vec<Material> {
    let mut all = Vec::new();
    for roughness in [0.1, 0.3, 1.0f32] {
        let coat = Layers { clear_coat: 0.9, clear_coat_alpha: roughness, ..Layers::PLAIN };
        let sheen = Layers { sheen: [0.9, 0.5, 0.2], sheen_roughness: roughness.max(0.3), ..Layers::PLAIN };
        let red = Layers { head_on: [0.03, 0.01, 0.002], grazing: 0.4, metallic: 0.3, ..Layers::PLAIN };
        let both = Layers { clear_coat: 0.6, clear_coat_alpha: roughness, metallic: 0.3, ..sheen };
        let base = [0.7, 0.4, 0.1];
        for layers in [coat, sheen, red] {
            all.push(layered(base, layers.head_on.map(|x| 0.7 * x + 0.2), 0.25, layers));
        }
        all.push(layered(base, [0.3, 0.2, 0.1], 0.6, Layers { head_on: red.head_on, grazing: 0.4, ..both }));
    }
    all
}

const IMPORTS: &[&str] = &["scene/features.wgsl", "scene/scene.wgsl", "shading/followed.wgsl"];

/// BRDF, pdf and what samples carry: as the formulas say, on both sides, and the same both ways.
#[test]
fn layers_are_their_formulas() {
    let context = device_or_return!();
    let stated = materials();
    let packed: Vec<PackedMaterial> = stated.iter().map(PackedMaterial::new).collect();
    let mut inputs: Vec<[Row; 4]> = Vec::new();
    for (m, material) in packed.iter().enumerate() {
        assert!(material.flags().is_layered() && !material.flags().has_delta());
        for i in 0..150 {
            let n = random_direction(6, i);
            let up = |v: Vec3| if v.dot(n) < 0.0 { -v } else { v };
            let (wo, wi) = (up(random_direction(7, i)), up(random_direction(8, i)));
            let [a, b, ..] = random(9, i);
            if wo.dot(n) > 0.02 && wi.dot(n) > 0.02 {
                inputs.push([row3(n, m as f32), row3(wi, 0.0), row3(wo, 0.0), row([a, b, 0.0, 0.0])]);
            }
        }
    }
    let code = "let m = material_at(u32(in_f(0u).w)); let n = in_f(0u).xyz; let wi = in_f(1u).xyz; let wo = in_f(2u).xyz;
        let at = at_angle(m, n, -wo, true);
        out_f(0u, vec4(eval_scatter(m, n, wi, wo), pdf_scatter(m, n, wi, wo)));
        out_f(1u, vec4(eval_scatter(m, n, wo, wi), 0.0));
        let w = lobe_weights(m, Bands(1.0), at);
        out_f(2u, vec4(w.diffuse, w.glossy, w.sheen, w.clear_coat));
        var lobes = array<u32, 4>(LOBE_DIFFUSE, LOBE_GLOSSY, LOBE_SHEEN, LOBE_CLEAR_COAT);
        for (var k = 0u; k < 4u; k += 1u) {
            let s = sample_lobe(m, lobes[k], -wo, n, n, true, in_f(3u).xy);
            out_f(3u + k, vec4(s.direction, s.weight.y * lobe_albedo(m, lobes[k], at).y));
        }";
    let snippet = Snippet { imports: IMPORTS, declarations: "", code, overrides: &[] };
    let mut harness = with_materials(context, &packed);
    let out: Vec<[Row; 7]> = snippet.run_in(context, &mut harness, &[], &inputs);
    let mut sampled = [0; 4];
    for (i, o) in inputs.iter().zip(out) {
        let (n, wi, wo) = (dvec3(i[0]), dvec3(i[1]), dvec3(i[2]));
        let at = floats(i[0])[3] as usize;
        let what = format!("material {at}, {wi} to {wo} about {n}");
        let near = |got: f32, wanted: f64| (f64::from(got) - wanted).abs() < 4e-4 * wanted + 3e-5;
        let host = Scatter::of(&packed[at], vec3(i[2]), vec3(i[0]));
        let on_host = host.eval(vec3(i[1]), vec3(i[2]), vec3(i[0]));
        let weights = floats(o[2]).map(f64::from);
        let total: f64 = weights.iter().sum();
        for (band, of_host) in on_host.into_iter().enumerate() {
            let lobes = Lobes::of(&stated[at], n, wi, wo, band);
            let f: f64 = lobes.f.iter().sum();
            for (who, got) in
                [("device", floats(o[0])[band]), ("exchanged", floats(o[1])[band]), ("host", of_host)]
            {
                assert!(near(got, f), "{who}, band {band}, {what}: {got}, not {f}");
            }
            if band == 0 {
                let pdf: f64 = lobes.pdf.iter().zip(weights).map(|(pdf, w)| pdf * w / total).sum();
                let of_host = host.pdf(vec3(i[1]), vec3(i[2]), vec3(i[0]));
                for (who, got) in [("device", floats(o[0])[3]), ("host", of_host)] {
                    assert!(near(got, pdf), "{who}, {what}: pdf {got}, not {pdf}");
                }
            }
        }
        // what a lobe's sample carries is f cos / pdf of that lobe alone
        for k in 0..4 {
            let (w, carried) = (dvec3(o[3 + k]), floats(o[3 + k])[3]);
            if weights[k] > 0.0 && w.dot(n) > 0.02 && (w + wo).length() > 1e-2 {
                sampled[k] += 1;
                let lobes = Lobes::of(&stated[at], n, w, wo, 1);
                let wanted = lobes.f[k] * w.dot(n) / lobes.pdf[k];
                let off = (f64::from(carried) - wanted).abs();
                assert!(off < 2e-3 * wanted + 1e-4, "lobe {k}, {what}: carries {carried}, not {wanted}");
            }
        }
    }
    assert!(sampled.iter().all(|count| *count > 500), "{sampled:?} samples");
}

/// Coat and base that are both followed: what each sends from a direction, and with which density.
#[test]
fn followed_coats_are_their_formulas() {
    let context = device_or_return!();
    let mut stated = Vec::new();
    for (alpha, clear_coat_alpha) in [(0.08, 0.02), (0.02, 0.08), (0.3, 0.05), (0.05, 0.0)] {
        let layers = Layers { clear_coat: 0.8, clear_coat_alpha, sheen: [0.3; 3], ..Layers::PLAIN };
        stated.push(layered([0.5; 3], [0.2, 0.1, 0.04], alpha, layers));
    }
    let packed: Vec<PackedMaterial> = stated.iter().map(PackedMaterial::new).collect();
    let mut inputs: Vec<[Row; 3]> = Vec::new();
    for m in 0..stated.len() {
        for i in 0..300 {
            let n = random_direction(6, i);
            let wo = random_direction(7, i);
            let wo = if wo.dot(n) < 0.0 { -wo } else { wo };
            let h = (n + 0.15 * random(11, i)[0] * random_direction(12, i)).normalize();
            let w = (2.0 * wo.dot(h) * h - wo).normalize();
            if wo.dot(n) > 0.05 && w.dot(n) > 0.05 {
                inputs.push([row3(n, m as f32), row3(w, 0.0), row3(wo, 0.0)]);
            }
        }
    }
    let code = "let m = material_at(u32(in_f(0u).w)); let n = in_f(0u).xyz; let w = in_f(1u).xyz; let wo = in_f(2u).xyz;
        let b = Bsdf(m, -wo, true, n, n, at_angle(m, n, -wo, true), Bands(1.0), 0u, 0u, 0u);
        let base = followed_from(b, w);
        let coat = clear_coat_from(b, w);
        out_f(0u, vec4(base.f_cos, base.pdf));
        out_f(1u, vec4(coat.f_cos, coat.pdf));
        out_f(2u, vec4(lobe_weights(m, Bands(1.0), b.at).reflection, 0.0, 0.0, 0.0));";
    let snippet = Snippet { imports: IMPORTS, declarations: "", code, overrides: &[] };
    let mut harness = with_materials(context, &packed);
    let out: Vec<[Row; 3]> = snippet.run_in(context, &mut harness, &[], &inputs);
    for (i, o) in inputs.iter().zip(out) {
        let (n, w, wo) = (dvec3(i[0]), dvec3(i[1]), dvec3(i[2]));
        let at = floats(i[0])[3] as usize;
        let (m, layers) = (&stated[at], stated[at].layers.unwrap());
        assert!(packed[at].has_narrow_lobe() || layers.clear_coat_alpha == 0.0);
        let lobes = Lobes::of(m, n, w, wo, 0);
        let alphas = [m.facets.unwrap().alpha, layers.clear_coat_alpha];
        for (k, got, alpha) in [(1, floats(o[0]), alphas[0]), (3, floats(o[1]), alphas[1])] {
            // what is wide is gathered, and what is smooth has no density; the fit of masking fades in at .02 to .05
            let is_followed = alpha > 0.0 && alpha <= 0.0814;
            let again = if k == 1 { 0.02 } else { 0.0 };
            let (f_cos, pdf) = if is_followed { (lobes.f[k] * w.dot(n), lobes.pdf[k]) } else { (0.0, 0.0) };
            let off = |got: f32, wanted: f64| (f64::from(got) - wanted).abs() / (wanted + 1e-6);
            let tolerance = 1e-3 + 1e-5 / f64::from(alpha.max(1e-3));
            assert!(off(got[3], pdf) < tolerance, "lobe {k} of {at}: pdf {}, not {pdf}", got[3]);
            let lowest = f_cos * (1.0 - again) - again;
            assert!(
                f64::from(got[0]) >= lowest - tolerance * f_cos
                    && f64::from(got[0]) < f_cos * (1.0 + tolerance) + 1e-6,
                "lobe {k} of {at}: {}, not {f_cos}",
                got[0]
            );
        }
        let reflection = f64::from(floats(o[2])[0]);
        assert!((reflection - coat(&layers, wo.dot(n))).abs() < 1e-5, "{reflection}");
    }
}

/// The fit of the sheen's albedo: nowhere below the integral, nor more than .018 above it; and the lobe reflects no more than it gets.
#[test]
fn sheen_albedo_is_its_integral() {
    let mut most: f64 = 0.0;
    for roughness in [0.3, 0.37, 0.5, 0.68, 0.85, 1.0] {
        let layers = Layers { sheen: [1.0; 3], sheen_roughness: roughness as f32, ..Layers::PLAIN };
        for cos in [0.004, 0.03, 0.1, 0.22, 0.4, 0.63, 0.81, 0.97] {
            let wo = DVec3::new((1.0f64 - cos * cos).sqrt(), 0.0, cos);
            const STEPS: usize = 300;
            let at = |i: usize| (i as f64 + 0.5) / STEPS as f64;
            let mut sum = 0.0;
            for i in 0..STEPS {
                // cosines are denser where light is grazing
                let (z, dz) = (at(i).powi(2), 2.0 * at(i) / STEPS as f64);
                for k in 0..STEPS {
                    let r = (1.0 - z * z).sqrt();
                    let wi = DVec3::new(r * (PI * at(k)).cos(), r * (PI * at(k)).sin(), z);
                    sum += charlie(roughness, DVec3::Z, wi, wo) * z * dz * TAU / STEPS as f64;
                }
            }
            let off = sheen_albedo(&layers, cos) - sum;
            most = most.max(off);
            assert!((-2e-4..0.018).contains(&off), "roughness {roughness}, cosine {cos}: {off} over {sum}");
            assert!(sum < 1.0, "roughness {roughness}, cosine {cos}: {sum}");
        }
    }
    println!("the fit is up to {most:.4} above");
}

/// sample_scatter draws by pdf_scatter: weighted by f cos / pdf its samples integrate to what even directions integrate to.
#[test]
fn layered_samples_follow_their_pdf() {
    let context = device_or_return!();
    const COUNT: usize = 1 << 15;
    let stated = materials();
    let packed: Vec<PackedMaterial> = stated.iter().map(PackedMaterial::new).collect();
    let n = Vec3::new(0.36, -0.48, 0.8);
    let wo = (n + 2.0 * n.any_orthonormal_vector()).normalize();
    let sobol = |i: usize, k: u32| joton::sampling::rng::sobol2(i as u32, k);
    let inputs: Vec<[Row; 1]> = (0..COUNT)
        .map(|i| row([sobol(i, 70)[0], sobol(i, 70)[1], sobol(i, 71)[0], 0.0]))
        .map(|row| [row])
        .collect();
    let mut harness = with_materials(context, &packed);
    for m in 1..8 {
        let code = format!(
            "let m = material_at({m}u); let n = vec3({:?}, {:?}, {:?}); let wo = vec3({:?}, {:?}, {:?});
            let u = in_f(0u).xyz;
            let wi = sample_scatter(m, n, wo, u);
            out_f(0u, vec4(wi, pdf_scatter(m, n, wi, wo)));
            out_f(1u, vec4(eval_scatter(m, n, wi, wo), 0.0));
            let even = basis(n) * sample_cone(u.xy, 1.0);
            out_f(2u, vec4(eval_scatter(m, n, even, wo), pdf_scatter(m, n, even, wo)));
            out_f(3u, vec4(even, 0.0));",
            n.x, n.y, n.z, wo.x, wo.y, wo.z
        );
        let snippet = Snippet { imports: IMPORTS, declarations: "", code: &code, overrides: &[] };
        let out: Vec<[Row; 4]> = snippet.run_in(context, &mut harness, &[], &inputs);
        let (mut by_sample, mut by_even, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let n = n.as_dvec3();
        for [wi, f, g, even] in out {
            let cos = dvec3(wi).dot(n).max(0.0);
            if cos > 0.0 {
                by_sample += dvec3(f) * cos / f64::from(floats(wi)[3]) / COUNT as f64;
            }
            by_even += dvec3(g) * dvec3(even).dot(n).max(0.0) * TAU / COUNT as f64;
            total += f64::from(floats(g)[3]) * TAU / COUNT as f64;
        }
        let off = (by_sample / by_even - 1.0).abs().max_element();
        assert!(off < 0.004, "material {m}: {by_sample} against {by_even}");
        assert!((0.94..1.001).contains(&total), "material {m}: pdfs add up to {total}");
        assert!(by_sample.max_element() < 1.0, "material {m}: {by_sample}");
    }
}
