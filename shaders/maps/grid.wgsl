// The hashed grid: rows (y, z) are hashed, x is added, so that neighbours along x lie side by side in memory.

fn cell_of(position: vec3<f32>, origin: vec3<f32>, cells_per_unit: f32) -> vec3<i32> {
    return vec3<i32>(floor((position - origin) * cells_per_unit));
}

// First bucket of a row of cells. Linear in y and z, with factors such that rows less than four apart never come nearer
// than four buckets (a test tries them all): the rows and columns that one gather visits share no bucket, so no joton is
// met twice. Jotons of far cells that do share a bucket fail the test of distance.
fn row_bucket(y: i32, z: i32, row_mask: u32) -> u32 {
    return (u32(y) * ROW_FACTOR_Y + u32(z) * ROW_FACTOR_Z) & row_mask;
}

// Column of a cell, always inside the row: positions on the scene's boundary may round to one cell outside.
fn column(x: i32, columns: u32) -> u32 {
    return u32(clamp(x, 0, i32(columns) - 1));
}

// Half of the width that a sphere about `position` has within a row of cells; negative where it does not reach the row.
fn reach_in_row(position: vec3<f32>, radius_squared: f32, y: i32, z: i32, origin: vec3<f32>, cell: f32) -> f32 {
    let low = origin.yz + vec2<f32>(vec2(y, z)) * cell;
    let off = max(max(low - position.yz, position.yz - low - cell), vec2(0.0));
    let left = radius_squared - dot(off, off);
    return select(-1.0, sqrt(max(left, 0.0)), left >= 0.0);
}

struct Grid {
    origin: vec3<f32>,
    cells_per_unit: f32,
    row_mask: u32,
    columns: u32,
}

// Rows of cells that a sphere no wider than two cells touches are at most four each way. Bit 4 z + y stands for the row
// whose y and z leave these remainders by four: spheres near each other share rows, and the bits of these.
fn rows_touched(grid: Grid, p: vec3<f32>, r: f32) -> u32 {
    let lowest = cell_of(p - r, grid.origin, grid.cells_per_unit).yz;
    let highest = cell_of(p + r, grid.origin, grid.cells_per_unit).yz;
    // as many ones as rows, turned to where they belong
    let ones = (vec2(1u) << vec2<u32>(min(highest - lowest, vec2(3)) + 1)) - 1u;
    let turn = vec2<u32>(lowest) & vec2(3u);
    let bits = ((ones << turn) | ((ones << turn) >> vec2(4u))) & vec2(15u);
    return bits.x * ((bits.y & 1u) | (bits.y & 2u) << 3u | (bits.y & 4u) << 6u | (bits.y & 8u) << 9u);
}

// Buckets [x, y) that a sphere of radius r about p reaches in the row of a bit; empty where it does not reach it.
fn row_run(grid: Grid, p: vec3<f32>, r: f32, bit: u32) -> vec2<u32> {
    let lowest = cell_of(p - r, grid.origin, grid.cells_per_unit).yz;
    let highest = cell_of(p + r, grid.origin, grid.cells_per_unit).yz;
    let at = lowest + ((vec2<i32>(vec2(bit & 3u, bit >> 2u)) - lowest) & vec2(3));
    let reach = reach_in_row(p, r * r, at.x, at.y, grid.origin, 1.0 / grid.cells_per_unit);
    if any(at > highest) || reach < 0.0 {
        return vec2(0u);
    }
    let row = row_bucket(at.x, at.y, grid.row_mask);
    let x = p.x - grid.origin.x;
    let left = column(i32(floor((x - reach) * grid.cells_per_unit)), grid.columns);
    let last = column(i32(floor((x + reach) * grid.cells_per_unit)), grid.columns);
    return vec2(row + left, row + last + 1u);
}
