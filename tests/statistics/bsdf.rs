//! The D lobes: the pdf is what is sampled and integrates to one; the BRDF is symmetric and gives back no more light than
//! it says.

use crate::chi_square::Cap;
use crate::common::{Row, floats, row3};
use crate::device::Device;
use crate::device_or_return;
use crate::directions::{NORMAL, any_scene, density_d, materials, views, wgsl};
use glam::{DVec3, Vec3};
use joton::optics::shading::bsdf::Scatter;
use joton::packed::PackedMaterial;

/// What a side says of a pair of directions: pdf, BRDF, BRDF with the directions exchanged (first band).
type Answer = [f64; 3];

/// All directions, finely cut where the lobe of a view is.
fn around(wo: Vec3) -> Cap {
    let n = NORMAL.as_dvec3().normalize();
    Cap::new((2.0 * n * n.dot(wo.as_dvec3()) - wo.as_dvec3()).normalize(), 2.0)
}

fn check(m: &PackedMaterial, view: usize, name: &str, answers: &[Answer]) {
    let wo = views()[view];
    let n = NORMAL.as_dvec3().normalize();
    let (mut pdf_total, mut albedo) = (0.0, 0.0);
    // cosᵉ: an error of 1e-6 in the cosine is e times as large in the power
    let tolerance = 1e-4 + 3e-6 * f64::from(m.glossy_exponent);
    for ((w, weight), &[pdf, f, exchanged]) in around(wo).grid().zip(answers) {
        let wanted = density_d(m, wo, w);
        assert!((pdf - wanted).abs() < tolerance * wanted.max(1.0), "{name}: pdf {pdf}, sampled {wanted}");
        pdf_total += pdf * weight;
        assert!(f >= 0.0 && (f - exchanged).abs() < tolerance * f.max(1.0), "{name}: {f} {exchanged}");
        albedo += f * w.dot(n).max(0.0) * weight;
    }
    // midpoints of 256 × 256 cells: 1e-4 for the sharpest lobe
    assert!((pdf_total - 1.0).abs() < 1e-3, "{name}: the pdf integrates to {pdf_total}");
    let [diffuse, glossy] = [m.diffuse[0], m.glossy[0]].map(f64::from);
    assert!(albedo < (diffuse + glossy) * (1.0 + 1e-3), "{name}: albedo {albedo} of {}", diffuse + glossy);
    assert!(albedo > diffuse * (1.0 - 1e-3), "{name}: albedo {albedo} of {diffuse} and {glossy}");
    if view == 0 {
        // [E6] the whole lobe comes back head on
        assert!((albedo / (diffuse + glossy) - 1.0).abs() < 2e-3, "{name}: albedo {albedo} head on");
    }
}

#[test]
fn host_lobes_are_what_they_say() {
    for (i, m) in materials().iter().enumerate() {
        for (view, wo) in views().into_iter().enumerate() {
            let ask = |w: DVec3| {
                let wi = w.as_vec3();
                let f = |a, b| f64::from(Scatter::of(m, b, NORMAL).eval(a, b, NORMAL)[0]);
                [f64::from(Scatter::of(m, wo, NORMAL).pdf(wi, wo, NORMAL)), f(wi, wo), f(wo, wi)]
            };
            let answers: Vec<Answer> = around(wo).grid().map(|(w, _)| ask(w)).collect();
            check(m, view, &format!("host, material {i}, view {view}"), &answers);
        }
    }
}

#[test]
fn device_lobes_are_what_they_say() {
    let context = device_or_return!();
    let mut device = Device::new(context, &any_scene(), 0);
    let materials = materials();
    device.materials(&materials);
    for (i, m) in materials.iter().enumerate() {
        for (view, wo) in views().into_iter().enumerate() {
            let inputs: Vec<[Row; 1]> = around(wo).grid().map(|(w, _)| [row3(w.as_vec3(), 0.0)]).collect();
            let code = format!(
                "let m = material_at({i}); let n = {}; let wo = {}; let wi = in_f(0u).xyz;
                out_f(0u, vec4(pdf_scatter(m, n, wi, wo), eval_scatter(m, n, wi, wo).x, eval_scatter(m, n, wo, wi).x, 0.0));",
                wgsl(NORMAL),
                wgsl(wo)
            );
            let out: Vec<[Row; 1]> = device.run(&code, (false, 1), &inputs);
            let answers: Vec<Answer> = out
                .iter()
                .map(|o| {
                    let [pdf, f, exchanged, _] = floats(o[0]).map(f64::from);
                    [pdf, f, exchanged]
                })
                .collect();
            check(m, view, &format!("device, material {i}, view {view}"), &answers);
        }
    }
}
