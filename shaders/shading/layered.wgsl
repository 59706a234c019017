// Whether a material has layers: a clear coat, sheen, or a base that reflects as glTF's specular says [E50–E52].
// import: scene/features.wgsl

fn is_layered(m: PackedMaterial) -> bool {
    return HAS_LAYERS && (m.flag_bits & LAYERED) != 0u;
}

// Of facets by Schlick's formula, what they reflect at grazing angles: of a layered material's dielectric part less than of its metal [E52].
fn facet_grazing(m: PackedMaterial) -> f32 {
    return select(1.0, m.grazing + m.metallic * (1.0 - m.grazing), is_layered(m));
}
