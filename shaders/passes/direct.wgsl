// Direct: light that reaches a gather point straight from an emitter, by shadow rays (E S* D L), averaged over them [E5].
// reads  scene, tiles, gather_points, path_filter      writes  film_direct, status
// import: scene/features.wgsl
// import: camera/strip.wgsl
// import: camera/film.wgsl
// import: camera/live.wgsl
// import: dispatch/count.wgsl
// import: sampling/rng.wgsl
// import: scene/scene.wgsl
// import: shading/material.wgsl
// import: lights/direct.wgsl
// import: paths/gather_point.wgsl
// import: paths/paths.wgsl

@group(1) @binding(0) var<uniform> path_filter: PathFilter;
@group(1) @binding(1) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(2) var<storage, read_write> film_direct: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    let pixel = live_pixel(index);
    if pixel == NO_PIXEL {
        return;
    }
    let point = gather_points[held(pixel)];
    let chain = chain_of(point);
    if max_band(point.throughput) <= 0.0
        || (HAS_PATH_FILTER && !path_wanted(path_step(PATH_START, EVENT_D), chain)) {
        return;
    }
    let m = material_of_point(point);
    let receiver = Receiver(
        m, point.position, decode_direction(point.normal), decode_direction(point.shading_normal), decode_direction(point.wo),
        does_vary(m) || near_emitter(point.position), point.inside,
        lift_of_point(m, point),
    );
    let sample = sequence_index(index);
    var sum = Bands(0.0);
    var rays = 0u;
    var saved = 0u;
    for (var ray = 0u; ray < own(pass_info.shadow_rays); ray += 1u) {
        let u = random4(pass_info.seed, sample, pixel, DIMENSION_DIRECT + ray);
        let first = wide_sum(wide_product(sample, pass_info.shadow_rays * pass_info.light_candidates),
            ray * pass_info.light_candidates);
        let found = direct_light(receiver, LightDraws(first, pixel, STREAM_LIGHT), u);
        sum += found.by_light;
        sum += found.by_lobe;
        rays += found.rays;
        saved += found.saved;
    }
    count(STATUS_RAYS, STATUS_RAYS_HIGH, rays);
    if saved > 0u {
        count(STATUS_SHADOW_RAYS_SAVED, STATUS_SHADOW_RAYS_SAVED_HIGH, saved);
    }
    if traversal_cut {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
    film_direct[held(pixel)] += to_film(point.throughput * sum / f32(pass_info.shadow_rays));
}
