// The scene heap. heap_split.wgsl is the same where it is more than one binding holds.
// reads  heap

@group(0) @binding(2) var<storage, read> heap: array<vec4<u32>>;

fn heap_word(at: u32) -> vec4<u32> {
    return heap[at];
}
