// How light is sampled where a material has layers: the part of the table of lobes.wgsl that others do not need [E50, E51]. The stand-ins
// are in no_layers.wgsl. lobes.wgsl, which imports it, has what it tells of lobes.
// import: shading/lambert.wgsl
// import: shading/microfacet.wgsl
// import: shading/layers.wgsl

// pdf_solid_angle of sample_scatter where there are layers: each lobe by its albedo.
fn pdf_layered(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let w = lobe_weights(m, Bands(1.0), at_angle(m, n, -wo, true));
    var sum = w.diffuse * lambert_pdf(n, wi) + w.sheen * sheen_pdf(n, wi);
    // what is followed may be smooth, and has no density then
    if w.glossy > 0.0 {
        sum += w.glossy * microfacet_pdf(m, n, wi, wo);
    }
    if w.clear_coat > 0.0 {
        sum += w.clear_coat * microfacet_pdf(coat_facets(m), n, wi, wo);
    }
    return sum / max(scatter_weight(w), 1e-30);
}

fn sample_layered(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> vec3<f32> {
    let w = lobe_weights(m, Bands(1.0), at_angle(m, n, -wo, true));
    let x = u.z * scatter_weight(w);
    if x < w.diffuse {
        return lambert_sample(n, u.xy);
    }
    if w.sheen > 0.0 && x >= w.diffuse + w.glossy && (x < w.diffuse + w.glossy + w.sheen || w.clear_coat <= 0.0) {
        return sheen_sample(n, u.xy);
    }
    let is_coat = w.clear_coat > 0.0 && x >= w.diffuse + w.glossy;
    if is_coat {
        return microfacet_sample(coat_facets(m), n, wo, u.xy);
    }
    return microfacet_sample(m, n, wo, u.xy);
}

// What layers leave of a base's light from one cosine to another, over what they let through at the second: albedos have that.
fn under_layers_weight(m: PackedMaterial, cos_i: f32, cos_o: f32) -> f32 {
    return base_under_layers(m, cos_i, cos_o) / max(layers_pass(m, cos_o), 1e-20);
}

// Light by a clear coat, and f cosθ / pdf over the albedo.
fn clear_coat_sample(
    m: PackedMaterial, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, u: vec2<f32>,
) -> LobeSample {
    let d = microfacet_sample(coat_facets(m), n, -direction, u);
    let flat = clear_coat_reflectance(m, -dot(direction, n));
    let weight = clear_coat_carried(m, n, d, -direction) / max(flat, 1e-20);
    return weighed(d, select(0.0, weight, dot(d, geometric) > 0.0), 1.0);
}

// f cosθ 2π over the albedo.
fn sheen_sample_at(
    m: PackedMaterial, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, u: vec2<f32>,
) -> LobeSample {
    let d = sheen_sample(n, u);
    let cos_o = -dot(direction, n);
    let albedo = sheen_albedo(m, cos_o) * (1.0 - clear_coat_reflectance(m, cos_o));
    let weight = sheen_eval(m, n, d, -direction) * dot(d, n) * TAU / max(albedo, 1e-20);
    return weighed(d, select(0.0, weight, dot(d, geometric) > 0.0), 1.0);
}
