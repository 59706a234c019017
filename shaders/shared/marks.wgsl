// Marks: the cells of space near which the camera looks [E23]. Twin: src/packed/visible_cells.rs.
// reads  marks, map_info

@group(1) @binding(16) var<uniform> marks: array<vec4<u32>, MARK_VECTORS>;

fn is_marked(p: vec3<f32>) -> bool {
    let cell = vec3<u32>(vec3<i32>(floor((p - map_info.grid_origin) * map_info.marks_per_unit)));
    let mixed = (cell.x * MARK_FACTOR_X) ^ (cell.y * MARK_FACTOR_Y) ^ (cell.z * MARK_FACTOR_Z);
    let bit = mixed & (MARK_VECTORS * 128u - 1u);
    return ((marks[bit / 128u][(bit / 32u) & 3u] >> (bit & 31u)) & 1u) == 1u;
}
