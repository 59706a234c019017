// In place of brushed_way.wgsl. See no_anisotropy.wgsl.
// import: shading/surface.wgsl

fn brushed_at(m: PackedMaterial, s: Surface, shading: vec3<f32>) -> PackedMaterial {
    return m;
}
