// Glint mark: a pixel is left to the glint kernel where it or a neighbour sees light in some of its chains, or sees
// something else than a neighbour does. Pixels inside a lamp, and far from any, stay with the eye kernel.
// reads  glints (of the glint pilot)      writes  gather_points (pixel flags)
// import: shared/index.wgsl

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<storage, read> glints: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> gather_points: array<GatherPoint>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = linear_index(id, groups);
    if pixel >= pass_info.width * pass_info.height {
        return;
    }
    let x0 = pixel % pass_info.width;
    let y0 = pixel / pass_info.width;
    var lowest = 2.0;
    var highest = 0.0;
    for (var y = max(y0, 1u) - 1u; y <= min(y0 + 1u, pass_info.height - 1u); y += 1u) {
        for (var x = max(x0, 1u) - 1u; x <= min(x0 + 1u, pass_info.width - 1u); x += 1u) {
            let glint = glints[y * pass_info.width + x].x;
            lowest = min(lowest, glint);
            highest = max(highest, glint);
        }
    }
    let mixed = highest == 1.0 || lowest != highest;
    gather_points[pixel].pixel_flags = select(0u, PIXEL_GLINT, mixed);
}
