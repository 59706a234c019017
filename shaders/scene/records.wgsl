// Records of the scene: what both ways to read it have in common. Triangles, materials, emitters and textures are read by functions
// that Rust writes from their structs.
// import: scene/heap.wgsl
// import: scene/readers.wgsl
// reads  heap, scene_info

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<uniform> scene_info: SceneInfo;

// A node of the hierarchy: its words.
struct Node {
    w0: vec4<u32>,
    w1: vec4<u32>,
    w2: vec4<u32>,
    w3: vec4<u32>,
    w4: vec4<u32>,
}

fn node_at(index: u32) -> Node {
    let at = 5u * index;
    return Node(node_word(at), node_word(at + 1u), node_word(at + 2u), node_word(at + 3u), node_word(at + 4u));
}

fn texture_word(at: u32) -> vec4<u32> {
    return heap_word(scene_info.textures + at);
}

// Shading normals of a smooth triangle's corners, octahedral.
fn normals_at(triangle: u32) -> vec3<u32> {
    return heap_word(scene_info.normals + triangle).xyz;
}
