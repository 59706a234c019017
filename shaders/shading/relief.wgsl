// Relief: which way a surface faces by a picture of normals or of heights [E48]. Twin: src/optics/shading/relief.rs.
// import: scene/features.wgsl
// import: shading/surface.wgsl
// import: shading/texture.wgsl

// Bits of a material's `relief_texture` with the texture of its relief.
const RELIEF_TEXTURE: u32 = 0xffffu;

fn has_relief(m: PackedMaterial) -> bool {
    return HAS_RELIEF && (m.flag_bits & (NORMAL_MAP | HEIGHT_MAP)) != 0u;
}

// Of no length where v has none.
fn normalized(v: vec3<f32>) -> vec3<f32> {
    let length2 = dot(v, v);
    return select(vec3(0.0), v * inverseSqrt(max(length2, 1e-36)), length2 > 1e-36);
}

// A normal of the front, by the normals that a texture shows.
fn by_normals(s: Surface, number: u32, strength: f32, width: f32) -> vec3<f32> {
    let t = texture_at(number);
    let right = normalized(s.texture.gradient_u * t.scale_u);
    let up = normalized(s.texture.gradient_v * t.scale_v);
    let handed = sign(dot(cross(right, up), s.front));
    let n = s.shading;
    let level = cross(up, s.front) * handed;
    let tangent = normalized(level - n * dot(n, level));
    if dot(tangent, tangent) == 0.0 {
        return n;
    }
    let bitangent = cross(n, tangent) * handed;
    let texel = 2.0 * texture_lookup(number, s.texture.uv, width).xyz - 1.0;
    return normalize(strength * (texel.x * tangent + texel.y * bitangent) + max(texel.z, RELIEF_COS_LEAST) * n);
}

// Of a texture's height on both sides along one of the coordinates: how it grows with that.
fn height_slope(number: u32, uv: vec2<f32>, along: vec2<f32>, texels: f32, width: f32) -> f32 {
    let step = 0.5 * max(1.0 / max(texels, 1e-30), width);
    let before = texture_number(number, uv - step * along, width);
    let behind = texture_number(number, uv + step * along, width);
    return (behind - before) * 0.5 / step;
}

// A normal of the front, by the heights that a texture shows.
fn by_heights(m: PackedMaterial, s: Surface, number: u32, width: f32) -> vec3<f32> {
    let t = texture_at(number);
    let uv = s.texture.uv;
    let gradient = s.texture.gradient_u * height_slope(number, uv, vec2(1.0, 0.0), f32(t.width) * abs(t.scale_u), width)
        + s.texture.gradient_v * height_slope(number, uv, vec2(0.0, 1.0), f32(t.height) * abs(t.scale_v), width);
    // the picture's width; none where coordinates span no area
    let pictures = s.texture.per_unit * sqrt(abs(t.scale_u * t.scale_v));
    let picture = select(0.0, 1.0 / max(pictures, 1e-30), pictures > RELIEF_SPAN_LEAST);
    let height = m.relief * select(1.0, picture, (m.flag_bits & RELATIVE_HEIGHT) != 0u);
    return normalize(s.shading - height * gradient);
}

// The shading normal toward where the ray comes from, to who sees so much of texture coordinates at once.
fn relief_normal(m: PackedMaterial, s: Surface, direction: vec3<f32>, width: f32) -> vec3<f32> {
    let number = (m.relief_texture & RELIEF_TEXTURE) - 1u;
    var n: vec3<f32>;
    if (m.flag_bits & NORMAL_MAP) != 0u {
        n = by_normals(s, number, m.relief, width);
    } else {
        n = by_heights(m, s, number, width);
    }
    n = select(n, -n, dot(direction, s.front) > 0.0);
    return turned_toward(n, -direction);
}

// A normal that faces away from who sees it is turned until it does not.
fn turned_toward(n: vec3<f32>, wo: vec3<f32>) -> vec3<f32> {
    return normalize(n + wo * max(0.0, RELIEF_COS_LEAST - dot(n, wo)));
}
