// Where no surface is of microfacets: in place of fresnel.wgsl; undercoat.wgsl, microfacet.wgsl and rough_interface.wgsl are left out. What
// is compiled out takes a driver's time and memory all the same.
// import: shading/dielectric.wgsl

struct RoughSample {
    direction: vec3<f32>,
    weight: Bands,
}

fn has_facets(m: PackedMaterial) -> bool {
    return false;
}

fn is_coated(m: PackedMaterial) -> bool {
    return false;
}

fn is_rough_interface(m: PackedMaterial) -> bool {
    return false;
}

fn facet_reflectance(m: PackedMaterial, tint: Bands, cosine: f32) -> Bands {
    return tint;
}

fn undercoat_eval(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    return Bands(0.0);
}

fn undercoat_albedo(m: PackedMaterial, cosine: f32) -> f32 {
    return 1.0;
}

fn undercoat_weight(m: PackedMaterial, cos_out: f32) -> f32 {
    return 1.0;
}

fn microfacet_eval(m: PackedMaterial, tint: Bands, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    return Bands(0.0);
}

fn microfacet_pdf(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return 0.0;
}

fn microfacet_sample(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    return n;
}

fn microfacet_weight(m: PackedMaterial, tint: Bands, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>, albedo: Bands) -> Bands {
    return Bands(0.0);
}

fn rough_reflectance(m: PackedMaterial, n: vec3<f32>, direction: vec3<f32>, from_front: bool) -> Bands {
    return Bands(0.0);
}

fn rough_pdf(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, n: vec3<f32>, from_front: bool, w: vec3<f32>,
) -> f32 {
    return 0.0;
}

fn rough_weight(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, n: vec3<f32>, from_front: bool, w: vec3<f32>,
) -> Bands {
    return Bands(0.0);
}

fn rough_sample(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool, u: vec2<f32>,
) -> RoughSample {
    return RoughSample(n, Bands(0.0));
}
