// Glint sum: what the trees of a pixel saw goes to the film.
// reads  glints, seen      writes  film_emission
// import: dispatch/index.wgsl
// import: camera/strip.wgsl
// import: camera/film.wgsl
// import: paths/trees.wgsl

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<storage, read> glints: array<u32>;
@group(0) @binding(2) var<storage, read> seen: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> film_emission: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    if index >= pass_info.glint_count {
        return;
    }
    let entry = glints[pass_info.glint_first + index];
    let trees = trees_of(glint_level(entry));
    if index % trees == 0u {
        var emission = vec4(0.0);
        for (var i = 0u; i < trees; i += 1u) {
            emission += seen[index + i];
        }
        film_emission[held(glint_pixel(entry))] += to_film(bands_of_four(emission));
    }
}
