// What both ways to read the scene have in common.
// import: scene/heap.wgsl
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

// Shading normals of a smooth triangle's corners, octahedral.
fn normals_at(triangle: u32) -> vec3<u32> {
    return heap_word(scene_info.normals + triangle).xyz;
}
