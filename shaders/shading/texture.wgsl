// Textures: what a picture shows at a place of a surface [E37]. Twin: src/optics/shading/texture.rs.
// import: scene/scene.wgsl
// import: scene/features.wgsl
// import: shading/texture_place.wgsl
// reads  heap, scene_info

fn texture_place(triangle: u32, t: PackedTriangle, b: vec2<f32>) -> TexturePlace {
    let at = scene_info.uvs + 2u * triangle;
    let first = bitcast<vec4<f32>>(heap_word(at));
    let third = bitcast<vec4<f32>>(heap_word(at + 1u)).xy;
    let d1 = first.zw - first.xy;
    let d2 = third - first.xy;
    let across = cross(t.e1, t.e2);
    let area = length(across);
    let per_unit = sqrt(abs(d1.x * d2.y - d1.y * d2.x) / max(area, 1e-30));
    var place = TexturePlace(first.xy + b.x * d1 + b.y * d2, per_unit, vec3(0.0), vec3(0.0));
    if HAS_RELIEF || HAS_ANISOTROPY {
        let unit = across / max(area, 1e-30);
        let along1 = cross(t.e2, unit) / max(area, 1e-30);
        let along2 = cross(unit, t.e1) / max(area, 1e-30);
        place.gradient_u = d1.x * along1 + d2.x * along2;
        place.gradient_v = d1.y * along1 + d2.y * along2;
    }
    return place;
}

// A number in proportion to light, of one that is encoded by the curve of sRGB.
fn from_srgb(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, c <= vec3(0.04045));
}

// Texel number `at` of a level that begins with word `first` of the heap: linear red, green and blue, and opacity.
fn texel_at(t: PackedTexture, first: u32, at: u32) -> vec4<f32> {
    if (t.flag_bits & TEXTURE_HALVES) != 0u {
        let word = heap_word(first + at / 2u);
        let halves = select(word.xy, word.zw, (at & 1u) != 0u);
        return vec4(unpack2x16float(halves.x), unpack2x16float(halves.y));
    }
    let c = unpack4x8unorm(heap_word(first + at / 4u)[at & 3u]);
    return vec4(select(c.rgb, from_srgb(c.rgb), (t.flag_bits & TEXTURE_SRGB) != 0u), c.a);
}

// A coordinate within the unit interval.
fn folded(x: f32, flag_bits: u32) -> f32 {
    if (flag_bits & TEXTURE_CLAMPED) != 0u {
        return clamp(x, 0.0, 1.0);
    }
    if (flag_bits & TEXTURE_MIRRORED) != 0u {
        let twice = x - 2.0 * floor(0.5 * x);
        return min(twice, 2.0 - twice);
    }
    return x - floor(x);
}

// The texel of a row of `count` that number `i`, at most one beyond either end, stands for.
fn texel_number(i: i32, count: u32, flag_bits: u32) -> u32 {
    let last = i32(count) - 1;
    let around = select(select(i, 0, i > last), last, i < 0);
    let is_repeated = (flag_bits & (TEXTURE_CLAMPED | TEXTURE_MIRRORED)) == 0u;
    return u32(clamp(select(i, around, is_repeated), 0, last));
}

// What a level shows at a place of the unit square.
fn level_at(t: PackedTexture, level: u32, place: vec2<f32>) -> vec4<f32> {
    var first = scene_info.texels + t.first;
    var size = vec2(t.width, t.height);
    let in_word = select(4u, 2u, (t.flag_bits & TEXTURE_HALVES) != 0u);
    for (var l = 0u; l < level; l += 1u) {
        first += (size.x * size.y + in_word - 1u) / in_word;
        size = max(size / 2u, vec2(1u));
    }
    // rows run down
    let p = vec2(place.x, 1.0 - place.y) * vec2<f32>(size);
    if (t.flag_bits & TEXTURE_NEAREST) != 0u {
        let near = min(vec2<u32>(max(p, vec2(0.0))), size - 1u);
        return texel_at(t, first, near.y * size.x + near.x);
    }
    let corner = floor(p - 0.5);
    let f = p - 0.5 - corner;
    let i = vec2<i32>(corner);
    let x0 = texel_number(i.x, size.x, t.flag_bits);
    let x1 = texel_number(i.x + 1, size.x, t.flag_bits);
    let y0 = texel_number(i.y, size.y, t.flag_bits) * size.x;
    let y1 = texel_number(i.y + 1, size.y, t.flag_bits) * size.x;
    let upper = mix(texel_at(t, first, y0 + x0), texel_at(t, first, y0 + x1), f.x);
    let lower = mix(texel_at(t, first, y1 + x0), texel_at(t, first, y1 + x1), f.x);
    return mix(upper, lower, f.y);
}

// What texture `number`, from 0, shows at texture coordinates, to who sees so much of these at once: linear red, green and blue, and
// opacity. A width of 0 sees the largest level.
fn texture_lookup(number: u32, uv: vec2<f32>, width: f32) -> vec4<f32> {
    let t = texture_at(number);
    let scale = vec2(t.scale_u, t.scale_v);
    let at = uv * scale + vec2(t.offset_u, t.offset_v);
    let place = vec2(folded(at.x, t.flag_bits), folded(at.y, t.flag_bits));
    let texels = width * sqrt(abs(scale.x * scale.y) * f32(t.width) * f32(t.height));
    let level = clamp(log2(max(texels, 1.0)), 0.0, f32(t.levels - 1u));
    let finer = u32(level);
    var found = level_at(t, finer, place);
    if level > f32(finer) {
        found = mix(found, level_at(t, finer + 1u, place), level - f32(finer));
    }
    return found;
}

// The one number that texture `number`, from 0, is asked for: a factor on one of the four.
fn texture_number(number: u32, uv: vec2<f32>, width: f32) -> f32 {
    let t = texture_at(number);
    return texture_lookup(number, uv, width)[t.channel] * t.factor;
}
