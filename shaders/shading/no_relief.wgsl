// Where no surface has a relief: in place of relief.wgsl. See no_facets.wgsl.
// import: shading/surface.wgsl

fn has_relief(m: PackedMaterial) -> bool {
    return false;
}

fn relief_normal(m: PackedMaterial, s: Surface, direction: vec3<f32>, width: f32) -> vec3<f32> {
    return s.shading;
}

fn turned_toward(n: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    return n;
}
