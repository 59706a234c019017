// Triangles that are more than one binding holds, in parts of a power of two. See triangles.wgsl.
// reads  triangles, triangles_1, triangles_2, triangles_3

@group(2) @binding(1) var<storage, read> triangles_1: array<PackedTriangle>;
@group(2) @binding(2) var<storage, read> triangles_2: array<PackedTriangle>;
@group(2) @binding(3) var<storage, read> triangles_3: array<PackedTriangle>;

// The exponent.
override TRIANGLES_PART: u32 = 21u;

struct Corners {
    v0: vec3<f32>,
    e1: vec3<f32>,
    e2: vec3<f32>,
    flags: u32,
}

fn triangle_corners(index: u32) -> Corners {
    let t = triangle_at(index);
    return Corners(t.v0, t.e1, t.e2, t.flags);
}

fn triangle_at(index: u32) -> PackedTriangle {
    let i = index & ((1u << TRIANGLES_PART) - 1u);
    switch index >> TRIANGLES_PART {
        case 0u: {
            return triangles[i];
        }
        case 1u: {
            return triangles_1[i];
        }
        case 2u: {
            return triangles_2[i];
        }
        default: {
            return triangles_3[i];
        }
    }
}
