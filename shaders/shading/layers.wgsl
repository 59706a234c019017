// What a clear coat, and sheen under it, leave to the base [E50, E51]. Twin: src/optics/shading/layers.rs.
// import: shading/layered.wgsl
// import: shading/clear_coat.wgsl
// import: shading/sheen.wgsl

// Part of the light at this cosine that they let through.
fn layers_pass(m: PackedMaterial, cosine: f32) -> f32 {
    var passed = 1.0 - clear_coat_reflectance(m, cosine);
    let most = sheen_most(m);
    if most > 0.0 {
        passed *= 1.0 - most * sheen_albedo(m, cosine);
    }
    return passed;
}

// Factor on what the base sends from one cosine to another: the lesser of both, so that it is the same both ways and no more leaves than
// arrives.
fn base_under_layers(m: PackedMaterial, cos_i: f32, cos_o: f32) -> f32 {
    return min(layers_pass(m, cos_i), layers_pass(m, cos_o));
}
