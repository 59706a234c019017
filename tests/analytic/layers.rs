//! Clear coats and sheen in a white furnace: what a surface gives back of even light, by angle and roughness. Nothing makes any; what is lost
//! is stated in docs/MATERIALS.md.

use crate::facets::{COSINES, given_back};
use joton::packed::PackedMaterial;
use joton::scene::{FacetKind, Facets, Layers, Material};

const ROUGHNESSES: [f32; 4] = [0.3, 0.5, 0.75, 1.0];

/// A white base of this diffuse and glossy reflectance under layers.
fn white(diffuse: f32, glossy: f32, layers: Layers) -> PackedMaterial {
    let kind = FacetKind::Schlick { ior: 1.0 };
    let facets = Some(Facets { alpha: 0.25, kind });
    PackedMaterial::new(&Material {
        glossy: [glossy; 3],
        facets,
        layers: Some(layers),
        ..Material::matte("white", [diffuse; 3])
    })
}

fn coat(clear_coat: f32, alpha: f32) -> Layers {
    Layers {
        clear_coat,
        clear_coat_alpha: alpha,
        head_on: [0.0; 3],
        grazing: 0.0,
        metallic: 1.0,
        ..Layers::PLAIN
    }
}

fn sheen(roughness: f32) -> Layers {
    Layers { sheen: [1.0; 3], sheen_roughness: roughness, ..coat(0.0, 0.1) }
}

/// What is given back, one row for each roughness, and the range in which all of it must be.
fn hold(name: &str, range: std::ops::RangeInclusive<f64>, make: impl Fn(f32) -> PackedMaterial) {
    println!("{name}: cosines {COSINES:?}");
    for roughness in ROUGHNESSES {
        let row = COSINES.map(|cosine| given_back(&make(roughness), cosine));
        println!("roughness {roughness}: {row:.3?}");
        for (cosine, all) in COSINES.into_iter().zip(row) {
            assert!(range.contains(&all), "{name}, roughness {roughness}, cosine {cosine}: {all}");
        }
    }
}

/// A coat over black reflects no more than Fresnel's law has it; over white nothing is made, and little lost.
#[test]
fn clear_coats_make_no_light() {
    hold("coat over black", 0.0..=0.9, |r| white(0.0, 0.0, coat(1.0, r * r)));
    hold("coat over white matte", 0.1..=1.002, |r| white(1.0, 0.0, coat(1.0, r * r)));
    hold("coat over white metal", 0.1..=1.002, |r| white(0.0, 1.0, coat(1.0, r * r)));
    hold("half a coat over white matte", 0.1..=1.002, |r| white(1.0, 0.0, coat(0.5, r * r)));
}

/// Sheen likewise; the fit of its albedo is from above, so the base never gives back more than is left.
#[test]
fn sheen_makes_no_light() {
    hold("sheen over black", 0.0..=0.96, |r| white(0.0, 0.0, sheen(r)));
    hold("sheen over white matte", 0.7..=1.0, |r| white(1.0, 0.0, sheen(r)));
    hold("coat over sheen over white matte", 0.1..=1.002, |r| {
        white(1.0, 0.0, Layers { clear_coat: 1.0, clear_coat_alpha: 0.25, ..sheen(r) })
    });
}
