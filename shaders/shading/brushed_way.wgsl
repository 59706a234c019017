// Which way the microfacets of a surface that has been met are brushed [E56]. Twin: src/optics/shading/anisotropy.rs.
// import: shading/anisotropy.wgsl
// import: shading/surface.wgsl

// Along v without what of it goes along n; the other vector where nothing is left.
fn along_surface(v: vec3<f32>, n: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let flat = v - n * dot(n, v);
    let length2 = dot(flat, flat);
    return select(other, flat * inverseSqrt(max(length2, 1e-36)), length2 > 1e-36);
}

// The material with the angle of its way in the basis of the shading normal.
fn brushed_at(m: PackedMaterial, s: Surface, shading: vec3<f32>) -> PackedMaterial {
    let n = s.shading;
    let level = along_surface(cross(vec3(0.0, 1.0, 0.0), n), n, vec3(1.0, 0.0, 0.0));
    // around an axis, or where the picture goes right and stays as high; of no sense
    let around = s.texture.uv.x * s.texture.gradient_v - s.texture.uv.y * s.texture.gradient_u;
    let right = cross(s.texture.gradient_v, s.front);
    let way = along_surface(select(right, around, (m.flag_bits & AROUND) != 0u), n, level);
    let angle = brush_angle(m);
    let along = way * cos(angle) + cross(n, way) * sin(angle);
    let b = basis(shading);
    return with_brush_code(m, code_of_angle(atan2(dot(along, b[1]), dot(along, b[0]))));
}
