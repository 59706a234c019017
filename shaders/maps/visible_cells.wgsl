// Visible cells: the cells of space near which the camera looks [E23]. Twin: src/packed/visible_cells.rs.
// reads  visible_cells, map_info

@group(1) @binding(16) var<uniform> visible_cells: array<vec4<u32>, VISIBLE_CELL_VECTORS>;

fn is_marked(p: vec3<f32>) -> bool {
    let cell = vec3<u32>(vec3<i32>(floor((p - map_info.grid_origin) * map_info.cells_marked_per_unit)));
    let mixed = (cell.x * VISIBLE_CELL_FACTOR_X) ^ (cell.y * VISIBLE_CELL_FACTOR_Y) ^ (cell.z * VISIBLE_CELL_FACTOR_Z);
    let bit = mixed & (VISIBLE_CELL_VECTORS * 128u - 1u);
    return ((visible_cells[bit / 128u][(bit / 32u) & 3u] >> (bit & 31u)) & 1u) == 1u;
}
