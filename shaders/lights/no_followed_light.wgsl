// Where no lobe that is followed has a width, or there are no lights: in place of followed.wgsl and what it imports.
// import: shading/bsdf.wgsl
// import: lights/samples.wgsl
// import: paths/splits.wgsl

fn pdf_delta_at(b: Bsdf, lobe: u32, w: vec3<f32>) -> f32 {
    return 0.0;
}

fn pdf_of_lights(s: Surface, b: Bsdf, distance: f32) -> f32 {
    return 0.0;
}

fn light_in_lobes(s: Surface, b: Bsdf, w: LobeWeights, splits: Splits, trees: f32, draws: LightDraws, u: f32) -> FollowedLight {
    return FollowedLight(Bands(0.0), 0u, 0u);
}
