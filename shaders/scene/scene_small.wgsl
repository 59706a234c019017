// The scene where it fits into uniform buffers, which are read faster. See scene.wgsl.
// import: scene/records.wgsl
// reads  nodes, triangles, materials, emitters, heap, scene_info

@group(0) @binding(6) var<uniform> nodes: array<vec4<u32>, SMALL_WORDS>;
@group(0) @binding(7) var<uniform> triangles: array<vec4<u32>, SMALL_WORDS>;
@group(0) @binding(8) var<uniform> materials: array<vec4<u32>, SMALL_WORDS>;
@group(0) @binding(9) var<uniform> emitters: array<vec4<u32>, SMALL_WORDS>;

fn node_word(at: u32) -> vec4<u32> {
    return nodes[at];
}

fn triangle_word(at: u32) -> vec4<u32> {
    return triangles[at];
}

fn material_word(at: u32) -> vec4<u32> {
    return materials[at];
}

fn emitter_word(at: u32) -> vec4<u32> {
    return emitters[at];
}
