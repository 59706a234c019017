// The scene, as every kernel reads it: word `at` of each section. scene_small.wgsl is the same where it fits into uniform buffers.
// import: scene/records.wgsl
// reads  heap, scene_info

fn node_word(at: u32) -> vec4<u32> {
    return heap_word(scene_info.nodes + at);
}

fn triangle_word(at: u32) -> vec4<u32> {
    return heap_word(scene_info.triangles + at);
}

fn material_word(at: u32) -> vec4<u32> {
    return heap_word(scene_info.materials + at);
}

fn emitter_word(at: u32) -> vec4<u32> {
    return heap_word(scene_info.emitters + at);
}
