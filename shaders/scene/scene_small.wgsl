// The scene where it fits into uniform buffers, which are read faster. See scene.wgsl.
// import: scene/records.wgsl
// reads  nodes, triangles, materials, emitters, heap, scene_info

@group(0) @binding(6) var<uniform> nodes: array<Node, SMALL_NODES>;
@group(0) @binding(7) var<uniform> triangles: array<PackedTriangle, SMALL_TRIANGLES>;
@group(0) @binding(8) var<uniform> materials: array<PackedMaterial, SMALL_MATERIALS>;
@group(0) @binding(9) var<uniform> emitters: array<PackedEmitter, SMALL_EMITTERS>;

fn node_at(index: u32) -> Node {
    return nodes[index];
}

fn triangle_at(index: u32) -> PackedTriangle {
    return triangles[index];
}

fn material_at(index: u32) -> PackedMaterial {
    return materials[index];
}

fn emitter_at(index: u32) -> PackedEmitter {
    return emitters[index];
}
