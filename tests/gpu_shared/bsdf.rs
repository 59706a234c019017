//! shading/lobes.wgsl against the laws of Fresnel and Snell in f64, and the lobes against their formulas.

use crate::common::{Row, Snippet, dvec3, floats, random, random_direction, row, row3};
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::packed::PackedMaterial;
use joton::packed::constants::{SURE_EVENTS, SURVIVAL_MAX};
use joton::scene::{Dielectric, Material};
use std::f64::consts::{PI, TAU};

const BSDF: &[&str] = &["scene/features.wgsl", "shading/lobes.wgsl"];

/// Reflectance by the amplitudes with angles [E8], in another form than the kernels': tangents and sines.
fn fresnel_by_angles(cos_i: f64, eta: f64) -> f64 {
    let i = cos_i.acos();
    let sin_t = i.sin() / eta;
    if sin_t >= 1.0 {
        return 1.0;
    }
    let t = sin_t.asin();
    if i < 1e-4 {
        return ((1.0 - eta) / (1.0 + eta)).powi(2);
    }
    let s = ((i - t).sin() / (i + t).sin()).powi(2);
    let p = ((i - t).tan() / (i + t).tan()).powi(2);
    0.5 * (s + p)
}

const INDICES: [f32; 8] = [1.000_3, 1.1, 1.33, 1.5, 2.417, 1.0 / 1.33, 1.0 / 1.5, 1.0 / 2.417];

#[test]
fn fresnel_is_the_law_of_fresnel() {
    let context = device_or_return!();
    let mut inputs: Vec<[Row; 1]> = Vec::new();
    for eta in INDICES {
        let edges = [1.0f32, 0.999_999, 0.5, 1e-2, 1e-4, 0.0];
        let cosines = edges.into_iter().chain((0..500).map(|i| random(3, i)[0]));
        inputs.extend(cosines.map(|c| [row([c, eta, 0.0, 0.0])]));
    }
    let out: Vec<[Row; 1]> =
        Snippet::new(BSDF, "let i = in_f(0u); out_f(0u, vec4(fresnel(i.x, i.y), 0.0, 0.0, 0.0));")
            .run(context, &inputs);
    let mut totals = 0;
    for ([i], [o]) in inputs.iter().zip(out) {
        let [cos, eta, ..] = floats(*i).map(f64::from);
        let (got, wanted) = (f64::from(floats(o)[0]), fresnel_by_angles(cos, eta));
        let sin2_t = (1.0 - cos * cos) / (eta * eta);
        // at the critical angle the slope is infinite: there only the range is asked for
        let tolerance =
            if (sin2_t - 1.0).abs() < 1e-5 { 5e-3 } else { 2e-5 / (1.0 - sin2_t).abs().sqrt().max(0.05) };
        assert!((got - wanted).abs() < tolerance, "cos {cos}, eta {eta}: {got} against {wanted}");
        assert!((0.0..=1.0 + 1e-6).contains(&got));
        if sin2_t > 1.0 + 1e-5 {
            totals += 1;
            assert_eq!(got, 1.0, "total reflection at cos {cos}, eta {eta}");
        }
    }
    assert!(totals > 300, "total reflection was met {totals} times");
}

#[test]
fn refraction_is_snells() {
    let context = device_or_return!();
    let mut inputs: Vec<[Row; 2]> = Vec::new();
    for eta_it in INDICES.map(|i| 1.0 / i) {
        for i in 0..500 {
            let n = random_direction(4, i);
            let mut d = random_direction(5, i);
            if d.dot(n) > 0.0 {
                d = -d;
            }
            inputs.push([row3(d, eta_it), row3(n, 0.0)]);
        }
        for n in [Vec3::X, -Vec3::Y, Vec3::Z] {
            inputs.push([row3(-n, eta_it), row3(n, 0.0)]);
            let grazing = (n.any_orthonormal_vector() - 1e-3 * n).normalize();
            inputs.push([row3(grazing, eta_it), row3(n, 0.0)]);
        }
    }
    let code = "out_f(0u, vec4(refract_direction(in_f(0u).xyz, in_f(1u).xyz, in_f(0u).w), 0.0));";
    let out: Vec<[Row; 1]> = Snippet::new(BSDF, code).run(context, &inputs);
    let mut totals = 0;
    for ([d_eta, n], [o]) in inputs.iter().zip(out) {
        let (d, n, t) = (dvec3(*d_eta), dvec3(*n), dvec3(o));
        let eta = f64::from(floats(*d_eta)[3]);
        let cos_i = -d.dot(n);
        let k = 1.0 - eta * eta * (1.0 - cos_i * cos_i);
        if k.abs() < 1e-5 {
            continue;
        }
        if k < 0.0 {
            totals += 1;
            assert_eq!(t, DVec3::ZERO, "total reflection: {d} on {n} with {eta}");
            continue;
        }
        // the tangential part is scaled by the ratio of the indices; the rest follows from unit length
        let tangential = |v: DVec3| v - n * v.dot(n);
        assert!((tangential(t) - tangential(d) * eta).length() < 3e-6, "{d} on {n} with {eta}: {t}");
        assert!(t.dot(n) < 0.0 && (t.length() - 1.0).abs() < 1e-6, "{d} on {n} with {eta}: {t}");
    }
    assert!(totals > 300, "total reflection was met {totals} times");
}

fn glossy(exponent: f32) -> PackedMaterial {
    PackedMaterial::new(&Material {
        glossy: [0.6, 0.2, 0.1],
        glossy_exponent: exponent,
        specular: [0.05, 0.1, 0.15],
        ..Material::matte("glossy", [0.1, 0.3, 0.7])
    })
}

fn dielectric() -> PackedMaterial {
    PackedMaterial::new(&Material {
        dielectric: Some(Dielectric {
            ior: 1.5,
            reflection_tint: [1.0, 0.9, 0.8],
            transmission_tint: [0.7, 0.8, 0.9],
        }),
        ..Material::matte("glass", [0.0; 3])
    })
}

/// A harness with materials that a snippet reads as `materials`.
fn with_materials<'a>(
    context: &'a joton::backend::gpu::Context,
    materials: &[PackedMaterial],
) -> joton::backend::gpu::harness::Harness<'a> {
    let mut harness = joton::backend::gpu::harness::Harness::new(context);
    harness.storage("materials", materials);
    harness
}

const MATERIALS: &str = "@group(0) @binding(0) var<storage, read> materials: array<PackedMaterial>;\n";

#[test]
fn brdf_is_lambert_plus_phong() {
    let context = device_or_return!();
    let exponents = [1.0f32, 5.0, 30.0, 100.0, 300.0];
    let mut materials: Vec<PackedMaterial> = exponents.map(glossy).into();
    materials.push(PackedMaterial::new(&Material::matte("matte", [0.2, 0.4, 0.8])));
    let mut inputs: Vec<[Row; 3]> = Vec::new();
    for (m, _) in materials.iter().enumerate() {
        for i in 0..500 {
            let n = random_direction(6, i);
            let up = |v: Vec3| if v.dot(n) < 0.0 { -v } else { v };
            let wi = up(random_direction(7, i));
            // half of them near the lobe
            let mirrored = 2.0 * wi.dot(n) * n - wi;
            let near = (mirrored + 0.1 * random_direction(8, i)).normalize();
            let wo = up(if i % 2 == 0 { near } else { random_direction(8, i) });
            inputs.push([row3(n, m as f32), row3(wi, 0.0), row3(wo, 0.0)]);
        }
    }
    let snippet = Snippet {
        imports: BSDF,
        declarations: MATERIALS,
        code: "let m = materials[u32(in_f(0u).w)];
            out_f(0u, vec4(eval_scatter(m, in_f(0u).xyz, in_f(1u).xyz, in_f(2u).xyz), 0.0));
            out_f(1u, vec4(eval_scatter(m, in_f(0u).xyz, in_f(2u).xyz, in_f(1u).xyz), 0.0));",
        overrides: &[],
    };
    let mut harness = with_materials(context, &materials);
    let out: Vec<[Row; 2]> = snippet.run_in(context, &mut harness, &[], &inputs);
    let mut bright = 0;
    for (i, [forth, back]) in inputs.iter().zip(out) {
        let (n, wi, wo) = (dvec3(i[0]), dvec3(i[1]), dvec3(i[2]));
        let m = &materials[floats(i[0])[3] as usize];
        let e = f64::from(m.glossy_exponent);
        let cos = (2.0 * wi.dot(n) * n - wi).dot(wo).max(0.0);
        let lobe = if m.flags().has_glossy() { (e + 2.0) / TAU * cos.powf(e) } else { 0.0 };
        for b in 0..3 {
            let wanted = f64::from(m.diffuse[b]) / PI + f64::from(m.glossy[b]) * lobe;
            bright += usize::from(lobe > 1.0);
            // cos^e: an error of 1e-6 in the cosine is e times as large in the power
            let tolerance = 1e-6 + wanted * (2e-6 * e + 2e-5);
            for (way, o) in [("", forth), (", exchanged", back)] {
                let got = f64::from(floats(o)[b]);
                assert!(
                    (got - wanted).abs() < tolerance,
                    "exponent {e}, band {b}{way}: {got} against {wanted}"
                );
            }
        }
    }
    assert!(bright > 100, "the lobe was met {bright} times");
}

/// Weights are the shares of the flux that events take; those of the roulette are scaled down to one event, and late in a
/// path to a little less: what is drawn must be what the flux is divided by, or coloured lobes lose light.
#[test]
fn weights_share_out_the_flux() {
    let context = device_or_return!();
    let materials =
        [glossy(20.0), dielectric(), PackedMaterial::new(&Material::matte("matte", [0.2, 0.4, 0.8]))];
    let mut inputs: Vec<[Row; 2]> = Vec::new();
    for m in 0..materials.len() {
        for i in 0..700 {
            let [r, g, b, reflectance] = random(9, i);
            // fluxes of any size, and pure bands
            let scale = 10f32.powi((i % 41) as i32 - 20);
            let mask = if i % 5 == 0 { Vec3::X } else { Vec3::ONE };
            // early and late in a path
            let events = (i as u32 / 2 % 2) * SURE_EVENTS;
            inputs.push([
                row3(Vec3::new(r, g, b) * mask * scale, m as f32),
                row([reflectance, events as f32, 0.0, 0.0]),
            ]);
        }
    }
    let snippet = Snippet {
        imports: BSDF,
        declarations: MATERIALS,
        code:
            "let w = lobe_weights(materials[u32(in_f(0u).w)], in_f(0u).xyz, AtAngle(Bands(in_f(1u).x), 1.0, 0.0, 0.0));
            let r = roulette(w, u32(in_f(1u).y));
            out_f(0u, vec4(w.diffuse, w.glossy, w.mirror, w.reflection));
            out_f(1u, vec4(w.transmission, r.transmission, 0.0, 0.0));
            out_f(2u, vec4(r.diffuse, r.glossy, r.mirror, r.reflection));",
        overrides: &[],
    };
    let mut harness = with_materials(context, &materials);
    let out: Vec<[Row; 3]> = snippet.run_in(context, &mut harness, &[], &inputs);
    let mut over = 0;
    for ([i, r], [four, last, roulette]) in inputs.iter().zip(out) {
        let m = &materials[floats(*i)[3] as usize];
        let carried = dvec3(*i);
        let reflectance = f64::from(floats(*r)[0]);
        let share = |tint: joton::spectrum::Bands, f: f64| {
            let left = carried * DVec3::from(tint.map(f64::from)) * f;
            left.max_element() / carried.max_element()
        };
        let wanted = if m.flags().is_dielectric() {
            [0.0, 0.0, 0.0, share(m.specular, reflectance), share(m.transmission, 1.0 - reflectance)]
        } else {
            [share(m.diffuse, 1.0), share(m.glossy, 1.0), share(m.specular, 1.0), 0.0, 0.0]
        };
        let sum = wanted.iter().sum::<f64>();
        over += usize::from(sum > 1.0);
        let [transmit, drawn_transmit, ..] = floats(last);
        let all = |row: Row, last: f32| {
            let [a, b, c, d] = floats(row);
            [a, b, c, d, last].map(f64::from)
        };
        let (got, drawn) = (all(four, transmit), all(roulette, drawn_transmit));
        for (k, w) in wanted.iter().enumerate() {
            assert!((got[k] - w).abs() < 1e-5, "event {k} of {carried}: {} against {w}", got[k]);
            let limit = f64::from(if floats(*r)[1] == 0.0 { 1.0 } else { SURVIVAL_MAX });
            let w = w * limit / sum.max(limit);
            assert!((drawn[k] - w).abs() < 1e-5, "drawn, event {k} of {carried}: {} against {w}", drawn[k]);
        }
        assert!(drawn.iter().sum::<f64>() <= 1.0 + 1e-5, "{carried}: {drawn:?}");
    }
    assert!(over > 100, "coloured lobes that ask for more than one event were met {over} times");
}

/// The band that goes on where bands part is picked in proportion to what each transmits, and never one that transmits nothing.
#[test]
fn bands_are_picked_by_what_they_transmit() {
    let context = device_or_return!();
    const COUNT: usize = 2000;
    let all = [[1.0f32, 1.0, 1.0], [0.2, 0.0, 3.0], [0.0, 0.7, 0.0], [0.0, 0.0, 1e-20], [5.0, 1e-7, 0.0]];
    let inputs: Vec<[Row; 2]> = (0..all.len() * COUNT)
        .map(|i| {
            let u = ((i % COUNT) as f32 + 0.5) / COUNT as f32;
            [row3(Vec3::from(all[i / COUNT]), 0.0), row([u.min(0.999_999_94), 0.0, 0.0, 0.0])]
        })
        .collect();
    let code = "out_f(0u, vec4(f32(picked_band(in_f(0u).xyz, in_f(1u).x)), 0.0, 0.0, 0.0));";
    let out: Vec<[Row; 1]> = Snippet::new(BSDF, code).run(context, &inputs);
    for (transmitted, picked) in all.iter().zip(out.chunks(COUNT)) {
        let total: f32 = transmitted.iter().sum();
        for band in 0..3 {
            let count = picked.iter().filter(|[o]| floats(*o)[0] as usize == band).count();
            let wanted = f64::from(transmitted[band] / total) * COUNT as f64;
            assert!(
                (count as f64 - wanted).abs() <= 1.0,
                "{transmitted:?}, band {band}: {count} of {COUNT}, not {wanted}"
            );
            assert!(transmitted[band] > 0.0 || count == 0, "{transmitted:?}: band {band} transmits nothing");
        }
    }
}

/// sample_scatter draws by pdf_scatter: weighted by f cos / pdf its samples integrate to what even directions integrate to.
#[test]
fn brdf_samples_follow_their_pdf() {
    let context = device_or_return!();
    const COUNT: usize = 1 << 16;
    let materials =
        [glossy(5.0), glossy(60.0), PackedMaterial::new(&Material::matte("matte", [0.2, 0.4, 0.8]))];
    let n = Vec3::new(0.36, -0.48, 0.8);
    let wo = (n + 0.8 * n.any_orthonormal_vector()).normalize();
    for m in 0..materials.len() {
        let inputs: Vec<[Row; 1]> = (0..COUNT)
            .map(|i| {
                let [a, b] = joton::sampling::rng::sobol2(i as u32, 70);
                let [c, _] = joton::sampling::rng::sobol2(i as u32, 71);
                [row([a, b, c, 0.0])]
            })
            .collect();
        let code = format!(
            "let m = materials[{m}]; let n = vec3({:?}, {:?}, {:?}); let wo = vec3({:?}, {:?}, {:?});
            let u = in_f(0u).xyz;
            let wi = sample_scatter(m, n, wo, u);
            out_f(0u, vec4(wi, pdf_scatter(m, n, wi, wo)));
            out_f(1u, vec4(eval_scatter(m, n, wi, wo), 0.0));
            let even = basis(n) * sample_cone(u.xy, 1.0);
            out_f(2u, vec4(even, pdf_scatter(m, n, even, wo)));
            out_f(3u, vec4(eval_scatter(m, n, even, wo), 0.0));",
            n.x, n.y, n.z, wo.x, wo.y, wo.z
        );
        let snippet = Snippet { imports: BSDF, declarations: MATERIALS, code: &code, overrides: &[] };
        let mut harness = with_materials(context, &materials);
        let out: Vec<[Row; 4]> = snippet.run_in(context, &mut harness, &[], &inputs);
        let (mut by_sample, mut by_even, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let n = n.as_dvec3();
        for [wi, f, even, g] in out {
            let pdf = |r: Row| f64::from(floats(r)[3]);
            let cos = dvec3(wi).dot(n).max(0.0);
            if cos > 0.0 {
                by_sample += dvec3(f) * cos / pdf(wi) / COUNT as f64;
            }
            by_even += dvec3(g) * dvec3(even).dot(n).max(0.0) * TAU / COUNT as f64;
            total += pdf(even) * TAU / COUNT as f64;
        }
        // 2^16 stratified samples of a lobe of exponent 60 by even directions: half a per cent
        let off = (by_sample / by_even - 1.0).abs().max_element();
        assert!(off < 0.01, "material {m}: {by_sample} against {by_even}");
        // what a lobe has below the horizon is the only part that is missing
        assert!(total < 1.005 && total > 0.85, "material {m}: the pdf integrates to {total}");
    }
}
