// Caustic count: how many jotons of the pilot pass lie in the largest disc of each gather point.
// reads  map_info, gather_points, sorted_jotons, bucket_starts      writes  counts (−1 where there is no gather point)
// import: camera/strip.wgsl
// import: sampling/sampling.wgsl
// import: maps/grid.wgsl

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<uniform> map_info: MapInfo;
@group(0) @binding(2) var<storage, read> gather_points: array<GatherPoint>;
@group(0) @binding(3) var<storage, read> sorted_jotons: array<Joton>;
@group(0) @binding(4) var<storage, read> bucket_starts: array<u32>;
@group(0) @binding(5) var<storage, read_write> counts: array<f32>;

override RADIUS_FOOTPRINTS: f32 = 4.0;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = strip_pixel(linear_index(id, groups));
    if pixel == NO_PIXEL {
        return;
    }
    let point = gather_points[held(pixel)];
    if max_band(point.throughput) <= 0.0 {
        counts[held(pixel)] = -1.0;
        return;
    }
    let r = min(map_info.radius, RADIUS_FOOTPRINTS * point.path_length * pass_info.camera.pixel_angle);
    let normal = decode_direction(point.normal);
    let grid = Grid(map_info.grid_origin, map_info.cells_per_unit, map_info.row_mask, map_info.columns);
    let both_sides = (point.surface & BOTH_SIDES) != 0u;
    var count = 0.0;
    var rows = rows_touched(grid, point.position, r);
    while rows != 0u {
        let buckets = row_run(grid, point.position, r, countTrailingZeros(rows));
        rows &= rows - 1u;
        let end = bucket_starts[buckets.y];
        for (var i = bucket_starts[buckets.x]; i < end; i += 1u) {
            let d = sorted_jotons[i].position - point.position;
            let facing = decode_normal24(sorted_jotons[i].normal_state);
            let side = select(dot(facing, normal), abs(dot(facing, normal)), both_sides);
            if dot(d, d) < r * r && abs(dot(d, facing)) < 127.0 * GATHER_PLANE_SHARE * r
                && side > 127.0 * GATHER_NORMAL_COS {
                count += 1.0;
            }
        }
    }
    counts[held(pixel)] = count;
}
