// Glint mark: the eye kernel must know in which pixels trees look for emission besides it.
// reads  glints      writes  gather_points (their levels)
// import: dispatch/index.wgsl
// import: camera/strip.wgsl
// import: paths/trees.wgsl

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<storage, read> glints: array<u32>;
@group(0) @binding(2) var<storage, read_write> gather_points: array<GatherPoint>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    if index >= pass_info.glint_count {
        return;
    }
    let entry = glints[pass_info.glint_first + index];
    let level = glint_level(entry);
    if index % trees_of(level) == 0u {
        gather_points[held(glint_pixel(entry))].glint_level = level;
    }
}
