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

// Rows that a sphere no wider than two cells may touch: four each way.
const ROW_STEPS: u32 = 16u;

// Buckets [x, y) that a sphere of radius r about p reaches in one of its rows; empty where it reaches none. Step s is the
// row whose y and z are s % 4 and s / 4 modulo 4: spheres near each other come to a row in the same step.
fn row_run(grid: Grid, p: vec3<f32>, r: f32, step: u32) -> vec2<u32> {
    let lowest = cell_of(p - r, grid.origin, grid.cells_per_unit).yz;
    let highest = cell_of(p + r, grid.origin, grid.cells_per_unit).yz;
    let at = lowest + ((vec2<i32>(vec2(step & 3u, step >> 2u)) - lowest) & vec2(3));
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
