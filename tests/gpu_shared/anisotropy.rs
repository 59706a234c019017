//! Brushed microfacets on both sides against formulas in f64 that share no code with them: by tangents and azimuths [E56].

use crate::common::{Row, Snippet, dvec3, floats, random, random_direction, row, row3, vec3};
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::backend::gpu::harness::Harness;
use joton::optics::shading::bsdf::Scatter;
use joton::packed::PackedMaterial;
use joton::scene::{Anisotropy, FacetKind, Facets, Inner, Material};
use std::f64::consts::PI;

const BSDF: &[&str] = &["scene/features.wgsl", "shading/lobes.wgsl"];
const MATERIALS: &str = "@group(0) @binding(0) var<storage, read> materials: array<PackedMaterial>;\n";

/// Brushed normals: α along a way and across it, and the angle of that from x to y.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    alphas: [f64; 2],
    angle: f64,
}

impl Wanted {
    /// tan²θ and the azimuth from the way, of a direction about z or -z.
    fn polar(&self, w: DVec3, n: DVec3) -> (f64, f64) {
        let cos = w.dot(n);
        // of a normal that looks down y is turned over
        (1.0 / (cos * cos) - 1.0, (w.y * n.z).atan2(w.x) - self.angle)
    }

    /// GGX, 1/sr (Burley 2012).
    fn density(&self, h: DVec3, n: DVec3) -> f64 {
        let [a, b] = self.alphas;
        let (tan2, phi) = self.polar(h, n);
        let e = tan2 * ((phi.cos() / a).powi(2) + (phi.sin() / b).powi(2));
        1.0 / (PI * a * b * h.dot(n).powi(4) * (1.0 + e).powi(2))
    }

    /// Smith's Λ (Heitz 2014).
    fn lambda(&self, w: DVec3, n: DVec3) -> f64 {
        let [a, b] = self.alphas;
        let (tan2, phi) = self.polar(w, n);
        let alpha2 = (a * phi.cos()).powi(2) + (b * phi.sin()).powi(2);
        ((1.0 + alpha2 * tan2).sqrt() - 1.0) / 2.0
    }

    /// f_r of a coat of index 1.5, and pdf of visible normals.
    fn lobe(&self, n: DVec3, wi: DVec3, wo: DVec3) -> (f64, f64) {
        let h = (wi + wo).normalize();
        let (li, lo) = (self.lambda(wi, n), self.lambda(wo, n));
        let (d, ci, co) = (self.density(h, n), wi.dot(n), wo.dot(n));
        let f = fresnel(wo.dot(h)) * d / ((1.0 + li + lo) * 4.0 * ci * co);
        (f, d / ((1.0 + lo) * 4.0 * co))
    }
}

/// Of glass, by angles.
fn fresnel(cos: f64) -> f64 {
    let i = cos.acos();
    if i < 1e-4 {
        return 0.04;
    }
    let t = (i.sin() / 1.5).asin();
    0.5 * (((i - t).sin() / (i + t).sin()).powi(2) + ((i - t).tan() / (i + t).tan()).powi(2))
}

/// Over roughness, strength and angle; what is packed is rounded, and this is the rounded one.
fn brushed() -> Vec<(PackedMaterial, Wanted)> {
    let mut all = Vec::new();
    for alpha in [0.09f32, 0.25, 0.6] {
        for strength in [0.3f32, 0.7, 1.0] {
            for rotation in [0.0f32, 0.5, 2.0, -1.0] {
                let m = Material {
                    glossy: [1.0; 3],
                    facets: Some(Facets { alpha, kind: FacetKind::Coat { ior: 1.5, inner: Inner::Once } }),
                    anisotropy: Some(Anisotropy { strength, rotation, is_around: false }),
                    ..Material::matte("brushed", [0.0; 3])
                };
                let packed = PackedMaterial::new(&m);
                let s2 = f64::from(strength).powi(2);
                let a = f64::from(alpha);
                // steps of a thousandth, and of half a turn over 8192
                let brush = packed.brush().expect("it is brushed");
                assert!((f64::from(brush.strength_squared) - s2).abs() < 6e-4);
                let off = (f64::from(brush.angle) - f64::from(rotation)).rem_euclid(PI);
                assert!(off.min(PI - off) < PI / 8192.0, "{brush:?}, {rotation}");
                let s2 = f64::from(brush.strength_squared);
                all.push((packed, Wanted { alphas: [a + (1.0 - a) * s2, a], angle: f64::from(brush.angle) }));
            }
        }
    }
    all
}

/// BRDF, pdf and weights of samples, of both sides; f is symmetric.
#[test]
fn brushed_facets_are_their_formulas() {
    let context = device_or_return!();
    let all = brushed();
    let packed: Vec<PackedMaterial> = all.iter().map(|(packed, _)| *packed).collect();
    let mut inputs: Vec<[Row; 4]> = Vec::new();
    for m in 0..all.len() {
        for i in 0..100 {
            let n = if i % 2 == 0 { Vec3::Z } else { -Vec3::Z };
            let up = |v: Vec3| if v.dot(n) < 0.0 { -v } else { v };
            let (wo, other) = (up(random_direction(7, i)), up(random_direction(8, i)));
            // half of them near the lobe
            let near = up((2.0 * wo.dot(n) * n - wo + 0.2 * random_direction(9, i)).normalize());
            let wi = if i % 4 < 2 { near } else { other };
            let [a, b, ..] = random(9, i);
            if wo.dot(n) > 0.05 && wi.dot(n) > 0.05 {
                inputs.push([row3(n, m as f32), row3(wi, 0.0), row3(wo, 0.0), row([a, b, 0.0, 0.0])]);
            }
        }
    }
    let snippet = Snippet {
        imports: BSDF,
        declarations: MATERIALS,
        code: "let m = materials[u32(in_f(0u).w)]; let n = in_f(0u).xyz; let wi = in_f(1u).xyz; let wo = in_f(2u).xyz;
            out_f(0u, vec4(eval_scatter(m, n, wi, wo).x, pdf_scatter(m, n, wi, wo), eval_scatter(m, n, wo, wi).x, 0.0));
            let s = sample_lobe(m, LOBE_GLOSSY, -wo, n, n, true, in_f(3u).xy);
            let albedo = lobe_albedo(m, LOBE_GLOSSY, at_angle(m, n, -wo, true));
            out_f(1u, vec4(s.direction, s.weight.x * albedo.x));",
        overrides: &[],
    };
    let mut harness = Harness::new(context);
    harness.storage("materials", &packed);
    let out: Vec<[Row; 2]> = snippet.run_in(context, &mut harness, &[], &inputs);
    let mut sampled = 0;
    for (i, [values, sample]) in inputs.iter().zip(out) {
        let (n, wi, wo) = (dvec3(i[0]), dvec3(i[1]), dvec3(i[2]));
        let (p, wanted) = &all[floats(i[0])[3] as usize];
        let what = format!("{wanted:?}, {wi} to {wo} about {n}");
        let (f, pdf) = wanted.lobe(n, wi, wo);
        let host = Scatter::of(p, vec3(i[2]), vec3(i[0]));
        let [of_device, pdf_of_device, exchanged, _] = floats(values);
        let of_host = host.eval(vec3(i[1]), vec3(i[2]), vec3(i[0]))[0];
        for (who, got) in [("device", of_device), ("exchanged", exchanged), ("host", of_host)] {
            assert!((f64::from(got) - f).abs() < 5e-4 * f + 2e-5, "{who}, {what}: {got}, not {f}");
        }
        let pdf_of_host = host.pdf(vec3(i[1]), vec3(i[2]), vec3(i[0]));
        for (who, got) in [("device", pdf_of_device), ("host", pdf_of_host)] {
            assert!((f64::from(got) - pdf).abs() < 5e-4 * pdf + 2e-5, "{who}, {what}: pdf {got}, not {pdf}");
        }
        let w = dvec3(sample);
        if w.dot(n) > 0.02 && (w + wo).length() > 1e-2 {
            sampled += 1;
            let (f, pdf) = wanted.lobe(n, w, wo);
            let carried = f * w.dot(n) / pdf;
            let got = f64::from(floats(sample)[3]);
            assert!((got - carried).abs() < 1e-3 * carried + 1e-4, "{what}: carries {got}, not {carried}");
        }
    }
    assert!(sampled > 1500, "{sampled} samples");
}

/// Moments of the directions that samples take, of those above the surface, by even numbers: those of the pdf, over even directions.
#[test]
fn brushed_samples_are_as_their_pdf() {
    let context = device_or_return!();
    const SIDE: usize = 96;
    let all = brushed();
    // a few of them, seen along the way, across it and between
    let cases: Vec<(usize, Vec3)> = [0, 5, 14, 22, 31, 35]
        .into_iter()
        .zip([[0.6f32, 0.0], [0.0, 0.7], [0.5, 0.5], [-0.8, 0.3], [0.2, -0.9], [0.1, 0.1]])
        .map(|(m, [x, y])| (m, Vec3::new(x, y, (1.0 - x * x - y * y).sqrt())))
        .collect();
    let packed: Vec<PackedMaterial> = all.iter().map(|(packed, _)| *packed).collect();
    let place = |i: usize| (i as f32 + 0.5) / SIDE as f32;
    let mut inputs: Vec<[Row; 2]> = Vec::new();
    for (m, wo) in &cases {
        for i in 0..SIDE * SIDE {
            inputs.push([row3(*wo, *m as f32), row([place(i % SIDE), place(i / SIDE), 0.0, 0.0])]);
        }
    }
    let snippet = Snippet {
        imports: BSDF,
        declarations: MATERIALS,
        code: "let m = materials[u32(in_f(0u).w)];
            out_f(0u, vec4(sample_scatter(m, vec3(0.0, 0.0, 1.0), in_f(0u).xyz, vec3(in_f(1u).xy, 0.5)), 0.0));",
        overrides: &[],
    };
    let mut harness = Harness::new(context);
    harness.storage("materials", &packed);
    let out: Vec<[Row; 1]> = snippet.run_in(context, &mut harness, &[], &inputs);
    let moments = |w: DVec3| [1.0, w.x, w.y, w.z, w.x * w.x, w.y * w.y, w.x * w.y];
    let above = |w: DVec3| if w.z > 0.0 { moments(w) } else { [0.0; 7] };
    let sum = |a: [f64; 7], b: [f64; 7], s: f64| std::array::from_fn::<f64, 7, _>(|k| a[k] + s * b[k]);
    for (case, samples) in cases.iter().zip(out.chunks(SIDE * SIDE)) {
        let (m, wo) = *case;
        let (p, wanted) = &all[m];
        let each = 1.0 / (SIDE * SIDE) as f64;
        let of_device = samples.iter().fold([0.0; 7], |s, [w]| sum(s, above(dvec3(*w)), each));
        let host = Scatter::of(p, wo, Vec3::Z);
        let of_host = (0..SIDE * SIDE).fold([0.0; 7], |s, i| {
            let w = host.sample(wo, Vec3::Z, 0.5, [place(i % SIDE), place(i / SIDE)]);
            w.map_or(s, |w| sum(s, above(w.as_dvec3()), each))
        });
        // over the half vector's slopes, as far as they matter: the pdf is narrow in them, not in directions
        const STEPS: usize = 1500;
        let wo = wo.as_dvec3();
        let [a, b] = wanted.alphas;
        let mut by_pdf = [0.0; 7];
        for i in 0..STEPS {
            // 1/(1 + r²) is even where slopes are stretched by α
            let v = (i as f64 + 0.5) / STEPS as f64;
            let r = (v / (1.0 - v)).sqrt();
            for j in 0..STEPS / 4 {
                let phi = 2.0 * PI * (j as f64 + 0.5) / (STEPS / 4) as f64;
                let (x, y) = (a * r * phi.cos(), b * r * phi.sin());
                let (s, c) = wanted.angle.sin_cos();
                let h = DVec3::new(x * c - y * s, x * s + y * c, 1.0).normalize();
                let to_facet = wo.dot(h);
                let w = 2.0 * to_facet * h - wo;
                if to_facet <= 0.0 || w.z <= 0.0 {
                    continue;
                }
                let (_, pdf) = wanted.lobe(DVec3::Z, w, wo);
                // d(v) d(φ) → d(slopes) → d(h) → d(w)
                let slopes = PI * a * b / (1.0 - v).powi(2);
                let weight = pdf * slopes * h.z.powi(3) * 4.0 * to_facet / (STEPS * STEPS / 4) as f64;
                by_pdf = sum(by_pdf, moments(w), weight);
            }
        }
        for k in 0..7 {
            for (who, got) in [("device", of_device[k]), ("host", of_host[k])] {
                assert!(
                    (got - by_pdf[k]).abs() < 4e-3,
                    "{who}, {wanted:?} from {wo}, moment {k}: {got}, not {}",
                    by_pdf[k]
                );
            }
        }
        assert!(by_pdf[0] > 0.5 && by_pdf[0] < 1.0 + 1e-3, "{by_pdf:?}");
    }
}

/// A white surface keeps next to all of the light of any angle, and makes next to none: what is scattered more than once goes by the root
/// mean square of the two α.
#[test]
fn brushed_white_is_about_white() {
    const SIDE: usize = 128;
    let place = |i: usize| (i as f32 + 0.5) / SIDE as f32;
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    let (mut even_least, mut even_most) = (f64::INFINITY, 0.0f64);
    for alpha in [0.09f32, 0.2, 0.4, 0.7] {
        for strength in [0.3f32, 0.6, 0.8, 1.0] {
            let m = Material {
                glossy: [1.0; 3],
                facets: Some(Facets { alpha, kind: FacetKind::Schlick { ior: 1.0 } }),
                anisotropy: Some(Anisotropy { strength, rotation: 0.0, is_around: false }),
                ..Material::matte("brushed", [0.0; 3])
            };
            let p = PackedMaterial::new(&m);
            let mut even = 0.0;
            for cos2 in [0.05f32, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95] {
                for phi in [0.25f32, 1.3] {
                    let cos = cos2.sqrt();
                    let sin = (1.0 - cos * cos).sqrt();
                    let wo = Vec3::new(sin * phi.cos(), sin * phi.sin(), cos);
                    let lobes = Scatter::of(&p, wo, Vec3::Z);
                    let mut kept = 0.0;
                    for i in 0..SIDE * SIDE {
                        let u = [place(i % SIDE), place(i / SIDE)];
                        if let Some(w) = lobes.sample(wo, Vec3::Z, 0.5, u) {
                            let f = lobes.eval(w, wo, Vec3::Z)[0];
                            kept += f64::from(f * w.z / lobes.pdf(w, wo, Vec3::Z)) / (SIDE * SIDE) as f64;
                        }
                    }
                    (least, most) = (least.min(kept), most.max(kept));
                    even += kept / 20.0;
                }
            }
            (even_least, even_most) = (even_least.min(even), even_most.max(even));
        }
    }
    println!("brushed white keeps {least:.4} to {most:.4}, of even light {even_least:.4} to {even_most:.4}");
    assert!(least > 0.84 && most < 1.08, "{least} to {most}");
    assert!(even_least > 0.96 && even_most < 1.01, "{even_least} to {even_most}");
}
