// Microfacets whose roughness, or whose part that is metal, is looked up at each place [E47]. Twin: src/optics/shading/facet_textures.rs.
// import: scene/features.wgsl
// import: shading/texture.wgsl
// import: shading/anisotropy.wgsl
// import: shading/layered.wgsl

// Bits of a material's `facet_textures` with the texture of its roughness; that of its metallic part is above.
const ROUGHNESS_TEXTURE: u32 = 0xffffu;
const METALLIC_SHIFT: u32 = 16u;

fn is_varied(m: PackedMaterial) -> bool {
    return HAS_FACET_TEXTURES && (m.flag_bits & VARIED) != 0u;
}

// α and the metallic part as a gather point keeps them: all go by these, so that its lobes are those of its eye path.
fn packed_facets(alpha: f32, metallic: f32) -> u32 {
    return pack2x16float(vec2(alpha, metallic));
}

// What a base reflects over what it reflects under its coat.
fn uncoated(m: PackedMaterial) -> f32 {
    return select(1.0, m.coat_transmittance, (m.flag_bits & COATED) != 0u);
}

// What its lobe reflects, wherever that is packed: where it is followed at some places and not at others both say the same.
fn varied_tint(m: PackedMaterial) -> Bands {
    return select(m.specular, m.glossy, (m.flag_bits & GLOSSY) != 0u);
}

// What its dielectric part reflects head on.
fn dielectric_head_on(m: PackedMaterial) -> Bands {
    let root = (m.ior - 1.0) / (m.ior + 1.0);
    return select(Bands(root * root), m.iors, is_layered(m));
}

// The material where its microfacets are these. Its `diffuse` is the colour of base and metal, over what its coat takes.
fn with_facets(varied: PackedMaterial, kept: u32) -> PackedMaterial {
    var m = varied;
    let numbers = unpack2x16float(kept);
    m.alpha = select(numbers.x, 0.0, numbers.x < SMOOTH_ALPHA);
    m.metallic = numbers.y;
    if (m.flag_bits & DIELECTRIC) != 0u {
        m.flag_bits &= ~select(0u, FACETS, m.alpha == 0.0);
        return m;
    }
    var tint = varied_tint(m);
    if (m.flag_bits & MIXED) != 0u {
        let head_on = dielectric_head_on(m);
        tint = head_on + m.metallic * (m.diffuse * uncoated(m) - head_on);
        m.diffuse *= 1.0 - m.metallic;
    }
    let is_followed = mean_alpha(m) <= FOLLOWED_ALPHA;
    let has_lobe = any(tint > Bands(0.0));
    m.flag_bits = (m.flag_bits & ~(GLOSSY | SPECULAR)) | select(0u, select(GLOSSY, SPECULAR, is_followed), has_lobe);
    m.glossy = select(tint, Bands(0.0), is_followed);
    m.specular = select(Bands(0.0), tint, is_followed);
    return m;
}

// The material at texture coordinates, to who sees so much of these at once; of a surface of which so much is glass.
fn varied_material(m: PackedMaterial, uv: vec2<f32>, width: f32, glass: f32) -> PackedMaterial {
    var alpha = m.alpha;
    var metallic = m.metallic;
    let of_roughness = m.facet_textures & ROUGHNESS_TEXTURE;
    if of_roughness != 0u {
        let roughness = min(1.0, texture_number(of_roughness - 1u, uv, width));
        alpha = roughness * roughness;
    }
    let of_metal = m.facet_textures >> METALLIC_SHIFT;
    if of_metal != 0u {
        metallic = min(1.0, texture_number(of_metal - 1u, uv, width));
    }
    if HAS_MIXTURES && (m.flag_bits & MIXED) != 0u {
        // what is stated is of all of the surface
        metallic = select(min(1.0, metallic / (1.0 - glass)), 0.0, glass >= 1.0);
    }
    if is_anisotropic(m) {
        // as a gather point keeps it, so that both have the same lobes
        var rounded = m;
        rounded.alpha = alpha;
        rounded.metallic = metallic;
        let numbers = kept_numbers(kept_brush(rounded));
        return with_facets(m, packed_facets(numbers.x, numbers.y));
    }
    return with_facets(m, packed_facets(alpha, metallic));
}

// The `diffuse` of a material before base and metal were told apart.
fn unmixed_colour(m: PackedMaterial) -> Bands {
    if !is_varied(m) || (m.flag_bits & MIXED) == 0u {
        return m.diffuse;
    }
    // the two parts together, which have no coat's share twice
    return m.diffuse + (varied_tint(m) - dielectric_head_on(m) * (1.0 - m.metallic)) / uncoated(m);
}
