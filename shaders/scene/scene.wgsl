// The scene, as every kernel reads it. scene_small.wgsl is the same where it fits into uniform buffers.
// import: scene/records.wgsl
// reads  heap, scene_info

fn node_at(index: u32) -> Node {
    let at = scene_info.nodes + 5u * index;
    return Node(heap_word(at), heap_word(at + 1u), heap_word(at + 2u), heap_word(at + 3u), heap_word(at + 4u));
}

fn triangle_at(index: u32) -> PackedTriangle {
    let at = scene_info.triangles + 3u * index;
    return triangle_of_words(heap_word(at), heap_word(at + 1u), heap_word(at + 2u));
}

fn material_at(index: u32) -> PackedMaterial {
    let at = scene_info.materials + 5u * index;
    return material_of_words(heap_word(at), heap_word(at + 1u), heap_word(at + 2u), heap_word(at + 3u), heap_word(at + 4u));
}

fn emitter_at(index: u32) -> PackedEmitter {
    let at = scene_info.emitters + 5u * index;
    return emitter_of_words(heap_word(at), heap_word(at + 1u), heap_word(at + 2u), heap_word(at + 3u), heap_word(at + 4u));
}
