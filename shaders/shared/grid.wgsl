// The hashed grid: rows (y, z) are hashed, x is added, so that neighbours along x lie side by side in memory.

fn cell_of(position: vec3<f32>, origin: vec3<f32>, cells_per_unit: f32) -> vec3<i32> {
    return vec3<i32>(floor((position - origin) * cells_per_unit));
}

// First bucket of a row of cells (Teschner et al. 2003, two of their primes).
fn row_bucket(y: i32, z: i32, row_mask: u32) -> u32 {
    return ((u32(y) * 19349663u) ^ (u32(z) * 83492791u)) & row_mask;
}

// Column of a cell, always inside the row: positions on the scene's boundary may round to one cell outside.
fn column(x: i32, columns: u32) -> u32 {
    return u32(clamp(x, 0, i32(columns) - 1));
}
