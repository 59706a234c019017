// Caustic radius: the base radius of each pixel, so that its disc holds about WANTED jotons of a pass: small where the
// caustic is bright, never under a footprint's share nor over the largest radius. Counts are averaged over 3×3 pixels.
// reads  map_info, gather_points, counts      writes  fits (.x: base radius)
// import: shared/index.wgsl

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
    let pixel = linear_index(id, groups);
    if pixel >= pass_info.width * pass_info.height {
        return;
    }
    let x0 = i32(pixel % pass_info.width);
    let y0 = i32(pixel / pass_info.width);
    var sum = 0.0;
    var near = 0.0;
    for (var y = max(y0 - 1, 0); y <= min(y0 + 1, i32(pass_info.height) - 1); y += 1) {
        for (var x = max(x0 - 1, 0); x <= min(x0 + 1, i32(pass_info.width) - 1); x += 1) {
            let count = counts[u32(y) * pass_info.width + u32(x)];
            if count >= 0.0 {
                sum += count;
                near += 1.0;
            }
        }
    }
    var largest = map_info.radius;
    let footprint = gather_points[pixel].path_length * pass_info.pixel_angle;
    if counts[pixel] >= 0.0 {
        largest = min(largest, RADIUS_FOOTPRINTS * footprint);
    }
    var r = largest;
    if sum > 0.0 {
        r = clamp(largest * sqrt(WANTED * near / sum), min(largest, RADIUS_FOOTPRINTS_MIN * footprint), largest);
    }
    fits[pixel] = Fit(vec4(r, 0.0, 0.0, 0.0));
}
