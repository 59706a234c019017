// Caustic disc: what the disc of the caustic map holds of the surface of each gather point, where something ends it [E31]. The
// pilot finds about which gather points the surface is whole and flat; discs that lie there, or hold no jotons, are not measured.
// reads  tiles, map_info, gather_points, scene, bucket_starts, radii (.x: base radius)
// writes  fits (.x: one over the area, .w: radius), walls; radii (.yzw: normal of the interior), interiors (pilot); status
// import: camera/strip.wgsl
// import: camera/live.wgsl
// import: sampling/sampling.wgsl
// import: maps/grid.wgsl
// import: maps/disc.wgsl
// import: paths/gather_point.wgsl

override RADIUS_FOOTPRINTS: f32 = 4.0;

@group(1) @binding(0) var<uniform> map_info: MapInfo;
@group(1) @binding(1) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(2) var<storage, read> bucket_starts: array<u32>;
@group(1) @binding(3) var<storage, read_write> radii: array<Fit>;
@group(1) @binding(4) var<storage, read_write> interiors: array<vec4<f32>>;
@group(1) @binding(5) var<storage, read_write> fits: array<Fit>;
@group(1) @binding(6) var<storage, read_write> walls: array<Clip>;
@group(1) @binding(7) var<storage, read_write> status: array<atomic<u32>>;

// Jotons may lie within the radius.
fn has_jotons(p: vec3<f32>, radius: f32) -> bool {
    let grid = Grid(map_info.grid_origin, map_info.cells_per_unit, map_info.row_mask, map_info.columns);
    var found = false;
    var rows = rows_touched(grid, p, radius);
    while rows != 0u {
        let buckets = row_run(grid, p, radius, countTrailingZeros(rows));
        rows &= rows - 1u;
        found = found || bucket_starts[buckets.x] < bucket_starts[buckets.y];
    }
    return found;
}

// The whole disc lies in the surface that the pilot found to be whole.
fn is_interior(at: u32, place: DiscPlace, radius: f32) -> bool {
    let slack = interiors[at].w - radius;
    let d = place.position - interiors[at].xyz;
    return slack > 0.0 && dot(d, d) < slack * slack && dot(radii[at].c.yzw, place.normal) > INTERIOR_COS;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = live_pixel(linear_index(id, groups));
    if pixel == NO_PIXEL {
        return;
    }
    let at = held(pixel);
    let point = gather_points[at];
    let normal = decode_direction(point.normal);
    let front = select(normal, -normal, (point.surface & BACK_SIDE) != 0u);
    let place = DiscPlace(point.position, normal, front);
    let is_here = max_band(point.throughput) > 0.0;
    let is_pilot = own(pass_info.pass_index) == PILOT_PASS;
    let pixel_angle = pass_info.camera.pixel_angle;
    let largest = min(map_info.radius, RADIUS_FOOTPRINTS * point.path_length * pixel_angle);
    var radius = min(map_info.radius, radii[at].c.x * sqrt(map_info.shrink));
    if is_pilot {
        radius = largest + pixel_footprint(point, pixel_angle);
    }
    var disc = whole_disc(select(radius, 0.0, is_pilot));
    if is_here && (is_pilot || !is_interior(at, place, radius) && has_jotons(point.position, radius)) {
        disc = true_disc(place, radius, is_pilot);
    }
    if is_pilot {
        interiors[at] = vec4(point.position, disc.radius);
        radii[at].c = vec4(radii[at].c.x, normal);
    } else {
        fits[at] = Fit(vec4(1.0 / disc.area, 0.0, 0.0, disc.radius));
        walls[at] = Clip(disc.first, disc.second);
    }
    if traversal_cut {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
}
