// Kernel correction: what part of a gather point's disc is surface at all, and the weights of a local linear fit over it.
// Σ a (c0 + c1 x + c2 y) (1, x, y) = (1, 0, 0) over the area points in the disc [E15]: exact for a linear field, so what a
// disc loses at an edge or in a corner neither darkens nor bends the estimate.
// reads  tiles, map_info, gather_points, area_points (bucket order), area_starts, clips (passes)
// writes  fits, edges (pilot: 1 cut, 2 other surfaces near; passes read the first)
// import: camera/strip.wgsl
// import: camera/live.wgsl
// import: sampling/sampling.wgsl
// import: maps/grid.wgsl
// import: maps/lanes.wgsl
// import: maps/clip_planes.wgsl
// import: paths/gather_point.wgsl

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<uniform> map_info: MapInfo;
@group(0) @binding(2) var<storage, read> gather_points: array<GatherPoint>;
@group(0) @binding(3) var<storage, read> area_points: array<AreaPoint>;
@group(0) @binding(4) var<storage, read> area_starts: array<u32>;
@group(0) @binding(5) var<storage, read_write> fits: array<Fit>;
@group(0) @binding(6) var<storage, read_write> edges: array<u32>;
@group(0) @binding(7) var<storage, read> clips: array<Clip>;
@group(0) @binding(8) var<storage, read_write> status: array<atomic<u32>>;

// The pilot finds the pixels whose discs are not whole; later passes look at these, their neighbours and at what is seen
// through specular surfaces. The radius only shrinks: what is whole stays whole.
// Something in the scene mirrors or refracts.
override SPECULAR_BODIES: bool = false;

// To the pilot a disc is whole where it has this part of its area and its centroid lies this near (in radii); the rest
// is noise of the area points. Elsewhere the fit is always solved.
const WHOLE_AREA: f32 = 0.97;
const WHOLE_CENTROID: f32 = 0.04;
// The pilot looks a little further than the largest radius, because pixels are jittered.
const PILOT_REACH: f32 = 1.15;

fn edge_near(pixel: u32) -> bool {
    let rows = rows_about(pixel);
    let columns = columns_about(pixel);
    var near = 0u;
    for (var y = rows.x; y <= rows.y; y += 1u) {
        for (var x = columns.x; x <= columns.y; x += 1u) {
            near |= edges[held(y * pass_info.width + x)];
        }
    }
    return (near & EDGE_CUT) != 0u;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let lanes = lanes_here();
    let pixel = live_pixel(linear_index(id, groups));
    let is_pixel = pixel != NO_PIXEL;
    let at = select(0u, held(pixel), is_pixel);
    let point = gather_points[at];
    let pilot = own(pass_info.pass_index) == PILOT_PASS;
    let r = map_info.radius * select(1.0, PILOT_REACH, pilot);
    let disc = PI * r * r;
    let direct_view = chain_of(point) == 0u;
    let normal = decode_direction(point.normal);
    // lanes with nothing to solve go along and find nothing
    var is_here = is_pixel && max_band(point.throughput) > 0.0;
    var walls = no_walls(r);
    if !pilot && is_here {
        walls = walls_about(pixel, point.position, normal, r);
        if direct_view && all(walls.planes[0].xyz == vec3(0.0)) && !edge_near(pixel) {
            fits[at] = Fit(vec4(1.0 / disc, 0.0, 0.0, 0.0));
            is_here = false;
        }
    }
    if lanes_min(select(1u, 0u, is_here)) != 0u {
        return;
    }
    let front = select(normal, -normal, (point.surface & BACK_SIDE) != 0u);
    let frame = basis(normal);
    let r2 = r * r;
    let grid = Grid(map_info.grid_origin, map_info.area_cells_per_unit, map_info.area_row_mask, map_info.area_columns);
    var m = vec3(0.0); // n, Σx, Σy
    var mm = vec3(0.0); // Σxx, Σxy, Σyy
    var others = false;
    var rows = lanes_or(select(0u, rows_touched(grid, point.position, r), is_here));
    while rows != 0u {
        let buckets = row_run(grid, point.position, r, countTrailingZeros(rows));
        rows &= rows - 1u;
        var i = 0u;
        var end = 0u;
        if is_here && buckets.x < buckets.y {
            i = area_starts[buckets.x];
            end = area_starts[buckets.y];
        }
        loop {
            let first = lanes_min(select(NO_INDEX, i, i < end));
            if first == NO_INDEX {
                break;
            }
            let mine = area_points[first + lanes.index];
            let place = vec4(mine.position, 0.0);
            let normals = vec4(decode_normal24(mine.normal), 0.0);
            for (var k = 0u; k < lanes.count; k += 1u) {
                let a = from_lane(place, k).xyz;
                let d = a - point.position;
                let facing = dot(from_lane(normals, k).xyz, front);
                if first + k >= i && first + k < end && dot(d, d) < r2 {
                    let share = select(GATHER_SHEET_SHARE, GATHER_PLANE_SHARE, facing > 0.0);
                    if abs(facing) <= 127.0 * GATHER_NORMAL_COS {
                        others = true;
                    } else if abs(dot(d, normal)) < share * r && is_before(walls.planes[0], a)
                        && is_before(walls.planes[1], a) {
                        let u = dot(d, frame[0]);
                        let v = dot(d, frame[1]);
                        m += vec3(1.0, u, v);
                        mm += vec3(u * u, u * v, v * v);
                    }
                }
            }
            i = max(i, first + lanes.count);
        }
        if i < end {
            atomicAdd(&status[STATUS_LOOP_CUT], 1u);
        }
    }
    if !is_here {
        return;
    }
    m = vec3(m.x, m.yz / r);
    mm /= r2;
    let area = m.x * map_info.area_each;
    var edge = 0u;
    var c = vec4(1.0 / disc, 0.0, 0.0, 0.0);
    if m.x > 0.0 {
        let center = m.yz / m.x;
        if !pilot || area < WHOLE_AREA * disc || dot(center, center) > WHOLE_CENTROID * WHOLE_CENTROID {
            // covariance of the area about its centroid; the weights are (1 − centerᵀ C⁻¹ (x − center)) / area
            let xx = mm.x / m.x - center.x * center.x;
            let xy = mm.y / m.x - center.x * center.y;
            let yy = mm.z / m.x - center.y * center.y;
            let det = xx * yy - xy * xy;
            let least = FIT_DETERMINANT_MIN * DISC_DETERMINANT;
            let slope = vec2(yy * center.x - xy * center.y, xx * center.y - xy * center.x) / max(det, least);
            let amplification = 1.0 + dot(center, slope);
            if det >= least && amplification < FIT_AMPLIFICATION_MAX {
                c = vec4(amplification, -slope, 0.0) / area;
            } else {
                c = vec4(1.0 / area, 0.0, 0.0, 0.0);
            }
            edge = EDGE_CUT;
        }
    }
    if pilot {
        // mirrors have no area points, and --paths must not change what is found; where pixels are large the pilot's point
        // does not speak for the others
        others = others || SPECULAR_BODIES || pixel_footprint(point, pass_info.camera.pixel_angle) > (PILOT_REACH - 1.0) * map_info.radius;
        edges[at] = edge | select(0u, EDGE_OTHERS, others);
    }
    fits[at] = Fit(c);
}
