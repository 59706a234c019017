// Glint mark: a pixel is left to the glint kernel where it or a neighbour sees light in some of its chains, or sees
// something else than a neighbour does. Pixels inside a lamp, and far from any, stay with the eye kernel.
// reads  glints (of the glint pilot)      writes  gather_points (pixel flags)
// import: shared/strip.wgsl

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<storage, read> glints: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> gather_points: array<GatherPoint>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = strip_pixel(linear_index(id, groups));
    if pixel == NO_PIXEL {
        return;
    }
    let rows = rows_about(pixel);
    let columns = columns_about(pixel);
    var lowest = 2.0;
    var highest = 0.0;
    for (var y = rows.x; y <= rows.y; y += 1u) {
        for (var x = columns.x; x <= columns.y; x += 1u) {
            let glint = glints[held(y * pass_info.width + x)].x;
            lowest = min(lowest, glint);
            highest = max(highest, glint);
        }
    }
    let mixed = highest == 1.0 || lowest != highest;
    gather_points[held(pixel)].pixel_flags = select(0u, PIXEL_GLINT, mixed);
}
