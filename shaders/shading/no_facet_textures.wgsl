// Where no microfacets vary over a surface: in place of facet_textures.wgsl. See no_facets.wgsl.
// import: scene/features.wgsl

fn is_varied(m: PackedMaterial) -> bool {
    return false;
}

fn packed_facets(alpha: f32, metallic: f32) -> u32 {
    return 0u;
}

fn with_facets(m: PackedMaterial, kept: u32) -> PackedMaterial {
    return m;
}

fn varied_material(m: PackedMaterial, uv: vec2<f32>, width: f32, glass: f32) -> PackedMaterial {
    return m;
}

fn unmixed_colour(m: PackedMaterial) -> Bands {
    return m.diffuse;
}
