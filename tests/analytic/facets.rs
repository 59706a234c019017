//! Microfacets in a white furnace: what a surface gives back of even light, by angle and roughness. What is lost is stated in
//! docs/MATERIALS.md; nothing makes any.

use glam::Vec3;
use joton::optics::shading::bsdf::Scatter;
use joton::packed::PackedMaterial;
use joton::sampling::rng::sobol2;
use joton::scene::{FacetKind, Facets, Inner, Material};

const SAMPLES: u32 = 1 << 15;
pub const COSINES: [f32; 5] = [1.0, 0.7, 0.4, 0.15, 0.03];
/// All of them scatter: narrower ones are followed, and lose less.
const ALPHAS: [f32; 5] = [0.1, 0.25, 0.5, 0.75, 1.0];

fn material(diffuse: f32, alpha: f32, kind: FacetKind) -> PackedMaterial {
    let facets = Some(Facets { alpha, kind });
    PackedMaterial::new(&Material { glossy: [1.0; 3], facets, ..Material::matte("white", [diffuse; 3]) })
}

/// ∫ f_r cosθ dω for light at this cosine, by samples of the lobes.
pub fn given_back(m: &PackedMaterial, cosine: f32) -> f64 {
    let (n, wo) = (Vec3::Z, Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine));
    let scatter = Scatter::of(m, wo, n);
    let of = |i: u32| {
        let ([a, b], [lobe, _]) = (sobol2(i, 31), sobol2(i, 32));
        let wi = scatter.sample(wo, n, lobe, [a, b])?;
        Some(f64::from(scatter.eval(wi, wo, n)[0] * wi.z / scatter.pdf(wi, wo, n)))
    };
    (0..SAMPLES).filter_map(of).sum::<f64>() / f64::from(SAMPLES)
}

/// Rows of what is given back: one for each roughness, by angle.
fn table(name: &str, make: impl Fn(f32) -> PackedMaterial) -> Vec<[f64; 5]> {
    println!("{name}: cosines {COSINES:?}");
    let row = |alpha: f32| {
        let row = COSINES.map(|cosine| given_back(&make(alpha), cosine));
        println!("alpha {alpha}: {row:.3?}");
        row
    };
    ALPHAS.map(row).into()
}

/// Metal that reflects all at a facet gives back all, but for what the fit of its masking leaves out; grazing light on smooth metal loses
/// most.
#[test]
fn white_metal_stays_white() {
    let rows = table("white metal", |alpha| material(0.0, alpha, FacetKind::Schlick { ior: 1.0 }));
    for (alpha, row) in ALPHAS.into_iter().zip(&rows) {
        for (cosine, all) in COSINES.into_iter().zip(row) {
            assert!((0.96..=1.0 + 2e-3).contains(all), "alpha {alpha}, cosine {cosine}: {all}");
        }
    }
}

/// What is masked between the roughest facets head on has a closed form: a black lobe of single scattering keeps 1 − ln 2 of its tint's light
/// as the tint goes to zero, when nothing is scattered twice.
#[test]
fn faint_metal_loses_what_is_masked() {
    const TINT: f32 = 1e-3;
    // an index so large that a facet reflects all of what its tint leaves
    let kind = FacetKind::Conductor { eta: [1.0; 3], k: [1e4; 3] };
    let faint = PackedMaterial { glossy: [TINT; 3], ..material(0.0, 1.0, kind) };
    let kept = given_back(&faint, 1.0) / f64::from(TINT);
    assert!((kept - (1.0 - std::f64::consts::LN_2)).abs() < 2e-3, "{kept}");
}

/// White plastic and lacquer give back at most what they get; under a nearly smooth coat white stays white, but for grazing light.
#[test]
fn coats_make_no_light() {
    for (name, inner) in [("even", Inner::Even), ("coloured", Inner::Coloured), ("once", Inner::Once)] {
        let coat = |alpha: f32| material(1.0, alpha, FacetKind::Coat { ior: 1.5, inner });
        let rows = table(&format!("white plastic, {name}"), coat);
        for (alpha, row) in ALPHAS.into_iter().zip(&rows) {
            for (cosine, all) in COSINES.into_iter().zip(row) {
                assert!(*all <= 1.0 + 5e-3, "{name}, alpha {alpha}, cosine {cosine}: {all}");
            }
        }
        let head_on = rows[0][0];
        let wanted = if inner == Inner::Once { 0.9..0.93 } else { 0.995..1.005 };
        assert!(wanted.contains(&head_on), "{name}: {:?}", rows[0]);
    }
    let principled = |alpha: f32| material(1.0, alpha, FacetKind::Schlick { ior: 1.5 });
    let mixed = |alpha: f32| PackedMaterial { glossy: [0.04; 3], ..principled(alpha) };
    let rows = table("white principled", mixed);
    assert!(rows.iter().flatten().all(|all| *all <= 1.0 + 5e-3), "{rows:?}");
    assert!(rows[0][0] > 0.995, "{:?}", rows[0]);
}
