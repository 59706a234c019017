// The material at a place: what varies over a surface is looked up here. Twin: src/optics/shading/material.rs.
// import: scene/features.wgsl
// import: scene/scene.wgsl
// import: shading/texture.wgsl
// import: shading/facet_textures.wgsl
// import: shading/translucent.wgsl
// import: shading/anisotropy.wgsl
// reads  scene, pass_info

// Low bits of a material's `textures`: the texture of its diffuse reflectance.
const COLOUR_TEXTURE: u32 = 0xffffu;
// Bits of a material's `relief_texture` below the texture of what it emits.
const EMISSION_SHIFT: u32 = 16u;

fn is_textured(m: PackedMaterial) -> bool {
    return HAS_TEXTURES && (m.textures & COLOUR_TEXTURE) != 0u;
}

// What a texel reflects in the bands of this pass.
fn texel_bands(texel: vec4<f32>) -> Bands {
    if !HAS_WAVELENGTHS {
        return bands_of_four(texel);
    }
    return bands_of_four(texel.x * pass_info.texel_red + texel.y * pass_info.texel_green + texel.z * pass_info.texel_blue);
}

// At texture coordinates, to who sees so much of these at once [E37]. Where it is the rest of what is glass in part, so much of the
// surface is glass.
fn resolved_material(index: u32, uv: vec2<f32>, width: f32, glass: f32) -> PackedMaterial {
    var m = material_at(index);
    if is_textured(m) {
        let texel = texel_bands(texture_lookup((m.textures & COLOUR_TEXTURE) - 1u, uv, width));
        m.diffuse *= texel;
        if is_translucent(m) {
            m.transmission *= texel;
        } else if HAS_DIELECTRIC && (m.flag_bits & DIELECTRIC) != 0u {
            // a body is passed by two faces
            m.transmission *= select(sqrt(max(texel, Bands(0.0))), texel, (m.flag_bits & THIN) != 0u);
        }
    }
    if HAS_GLOW && (m.relief_texture >> EMISSION_SHIFT) != 0u {
        m.emission *= texel_bands(texture_lookup((m.relief_texture >> EMISSION_SHIFT) - 1u, uv, width));
    }
    if is_varied(m) {
        m = varied_material(m, uv, width, glass);
    }
    return m;
}

// The diffuse reflectance of a gather point, as it keeps it; of what is translucent with what goes through.
fn kept_albedo(m: PackedMaterial) -> vec2<u32> {
    if !is_textured(m) {
        return vec2(0u);
    }
    let four = four_of_bands(select(unmixed_colour(m), m.diffuse + m.transmission, is_translucent(m)));
    return vec2(pack2x16float(four.xy), pack2x16float(four.zw));
}

// What of its microfacets a gather point keeps, and their way where they are brushed; of what is translucent, which has none, how far rays from there are lifted.
fn kept_facets(m: PackedMaterial, lift: f32) -> u32 {
    if is_translucent(m) {
        return bitcast<u32>(lift);
    }
    if is_anisotropic(m) {
        return kept_brush(m);
    }
    return select(0u, packed_facets(m.alpha, m.metallic), is_varied(m));
}

// How far a gather point is lifted off its surface; 0 where all that leaves it does so on its side.
fn lift_of_point(m: PackedMaterial, point: GatherPoint) -> f32 {
    return select(0.0, bitcast<f32>(point.facets), is_translucent(m));
}

// Of what is brushed and varies: α and the metallic part as others keep them.
fn packed_kept_facets(kept: u32) -> u32 {
    let numbers = kept_numbers(kept);
    return packed_facets(numbers.x, numbers.y);
}

// Of the surface that a gather point lies on.
fn material_of_point(point: GatherPoint) -> PackedMaterial {
    var m = material_at(point.surface & MATERIAL_MASK);
    if is_textured(m) {
        let kept = bands_of_four(vec4(unpack2x16float(point.albedo_low), unpack2x16float(point.albedo_high)));
        if is_translucent(m) {
            let texel = kept / max(m.diffuse + m.transmission, Bands(1e-20));
            m.diffuse *= texel;
            m.transmission *= texel;
        } else {
            m.diffuse = kept;
        }
    }
    if is_anisotropic(m) {
        m = with_kept_way(m, point.facets);
        if is_varied(m) {
            m = with_facets(m, packed_kept_facets(point.facets));
        }
    } else if is_varied(m) {
        m = with_facets(m, point.facets);
    }
    return m;
}
