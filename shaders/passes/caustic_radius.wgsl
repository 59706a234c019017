// Caustic radius: the base radius of each pixel, so that its disc holds about WANTED jotons of a pass: small where the
// caustic is bright, never under a footprint's share nor over the largest radius. Counts are averaged over 3×3 pixels.
// reads  map_info, gather_points, counts      writes  fits (.x: base radius)
// import: camera/strip.wgsl

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<uniform> map_info: MapInfo;
@group(0) @binding(2) var<storage, read> gather_points: array<GatherPoint>;
@group(0) @binding(3) var<storage, read> counts: array<f32>;
@group(0) @binding(4) var<storage, read_write> fits: array<Fit>;

override RADIUS_FOOTPRINTS: f32 = 4.0;
override RADIUS_FOOTPRINTS_MIN: f32 = 0.7;
override WANTED: f32 = 15.0;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = strip_pixel(linear_index(id, groups));
    if pixel == NO_PIXEL {
        return;
    }
    let rows = rows_about(pixel);
    let columns = columns_about(pixel);
    var sum = 0.0;
    var near = 0.0;
    for (var y = rows.x; y <= rows.y; y += 1u) {
        for (var x = columns.x; x <= columns.y; x += 1u) {
            let count = counts[held(y * pass_info.width + x)];
            if count >= 0.0 {
                sum += count;
                near += 1.0;
            }
        }
    }
    var largest = map_info.radius;
    let footprint = gather_points[held(pixel)].path_length * pass_info.camera.pixel_angle;
    if counts[held(pixel)] >= 0.0 {
        largest = min(largest, RADIUS_FOOTPRINTS * footprint);
    }
    var r = largest;
    if sum > 0.0 {
        r = clamp(largest * sqrt(WANTED * near / sum), min(largest, RADIUS_FOOTPRINTS_MIN * footprint), largest);
    }
    fits[held(pixel)] = Fit(vec4(r, 0.0, 0.0, 0.0));
}
