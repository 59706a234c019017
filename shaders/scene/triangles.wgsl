// Triangles by their index. triangles_split.wgsl is the same where they are more than one binding holds.
// reads  triangles

struct Corners {
    v0: vec3<f32>,
    e1: vec3<f32>,
    e2: vec3<f32>,
    flags: u32,
}

fn triangle_corners(index: u32) -> Corners {
    return Corners(triangles[index].v0, triangles[index].e1, triangles[index].e2, triangles[index].flags);
}

fn triangle_at(index: u32) -> PackedTriangle {
    return triangles[index];
}
