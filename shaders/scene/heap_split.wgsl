// The scene heap where it is more than one binding holds, in parts of a power of two of words. See heap.wgsl.
// reads  heap, heap_1 … heap_7

@group(0) @binding(2) var<storage, read> heap: array<vec4<u32>>;
@group(0) @binding(10) var<storage, read> heap_1: array<vec4<u32>>;
@group(0) @binding(11) var<storage, read> heap_2: array<vec4<u32>>;
@group(0) @binding(12) var<storage, read> heap_3: array<vec4<u32>>;
@group(0) @binding(13) var<storage, read> heap_4: array<vec4<u32>>;
@group(0) @binding(14) var<storage, read> heap_5: array<vec4<u32>>;
@group(0) @binding(15) var<storage, read> heap_6: array<vec4<u32>>;
@group(0) @binding(16) var<storage, read> heap_7: array<vec4<u32>>;

// Binary logarithm of the words in a part.
override HEAP_PART: u32 = 23u;

fn heap_word(at: u32) -> vec4<u32> {
    let i = at & ((1u << HEAP_PART) - 1u);
    switch at >> HEAP_PART {
        case 0u: { return heap[i]; }
        case 1u: { return heap_1[i]; }
        case 2u: { return heap_2[i]; }
        case 3u: { return heap_3[i]; }
        case 4u: { return heap_4[i]; }
        case 5u: { return heap_5[i]; }
        case 6u: { return heap_6[i]; }
        // the last part has all the rest
        default: { return heap_7[at - (7u << HEAP_PART)]; }
    }
}
