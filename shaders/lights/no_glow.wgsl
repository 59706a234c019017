// Where nothing shines by a texture: in place of glow.wgsl. See shading/no_facets.wgsl.

fn has_glow(e: PackedEmitter) -> bool {
    return false;
}

fn glow_on(e: PackedEmitter, weights: vec2<f32>) -> Bands {
    return Bands(1.0);
}

fn glow_at(e: PackedEmitter, u: vec2<f32>) -> Bands {
    return Bands(1.0);
}
