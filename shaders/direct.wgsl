// Direct: light that reaches a gather point straight from an emitter, by shadow rays (E S* D L).
// L = f_r Le V G / (pick pdf_area), averaged over the shadow rays [E5]
// reads  scene, gather_points, path_filter      writes  film_direct, status
// import: shared/features.wgsl
// import: shared/index.wgsl
// import: shared/rng.wgsl
// import: shared/scene.wgsl
// import: shared/intersect.wgsl
// import: shared/surface.wgsl
// import: shared/bsdf.wgsl
// import: shared/emitter.wgsl
// import: shared/paths.wgsl

@group(1) @binding(0) var<uniform> path_filter: PathFilter;
@group(1) @binding(1) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(2) var<storage, read_write> film_direct: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;

// A shadow ray ends this much (relative) before the light, so that the light does not shade itself.
const SHADOW_END: f32 = 0.9999;

struct LightSample {
    // Unit, toward the light.
    wi: vec3<f32>,
    distance: f32,
    // Irradiance across the beam over the probability of this sample.
    weight: Bands,
}

fn sample_light(p: vec3<f32>, u: vec2<f32>) -> LightSample {
    let pick = pick_emitter(u.x, pass_info.emitters);
    let e = emitters[pick.emitter];
    if e.kind == EMITTER_TRIANGLE {
        let b = sample_triangle(vec2(pick.rest, u.y));
        let d = e.origin + b.x * e.e1 + b.y * e.e2 - p;
        let distance2 = dot(d, d);
        let wi = d * inverseSqrt(max(distance2, 1e-30));
        let cos_light = max(0.0, -dot(wi, normalize(cross(e.e1, e.e2))));
        return LightSample(wi, sqrt(distance2), e.strength * (cos_light * e.area / (max(distance2, 1e-30) * e.pick)));
    }
    if e.kind == EMITTER_SUN {
        return LightSample(-e.e1, 1e30, e.strength / e.pick);
    }
    let d = e.origin - p;
    let distance2 = max(dot(d, d), 1e-30);
    let wi = d * inverseSqrt(distance2);
    let fall = select(1.0, spot_falloff(-dot(wi, e.e1), e.e2.x, e.e2.y), e.kind == EMITTER_SPOT);
    return LightSample(wi, sqrt(distance2), e.strength * (fall / (distance2 * e.pick)));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = linear_index(id, groups);
    if pixel >= pass_info.width * pass_info.height {
        return;
    }
    let point = gather_points[pixel];
    let chain = (point.surface >> 24u) & 63u;
    if max_band(point.throughput) <= 0.0
        || (HAS_PATH_FILTER && !path_wanted(path_step(PATH_START, EVENT_D), chain)) {
        return;
    }
    let m = materials[point.surface & 0xffffffu];
    let geometric = decode_direction(point.normal);
    let shading = decode_direction(point.shading_normal);
    let wo = decode_direction(point.wo);
    let origin = offset_origin(point.position, geometric);
    let seed = sequence_seed(pass_info.seed, pixel, STREAM_LIGHT);
    var sum = Bands(0.0);
    var rays = 0u;
    for (var ray = 0u; ray < pass_info.shadow_rays; ray += 1u) {
        let light = sample_light(origin, sobol2(pass_info.pass_index * pass_info.shadow_rays + ray, seed));
        let cos_receiver = dot(light.wi, shading);
        if cos_receiver <= 0.0 || dot(light.wi, geometric) <= 0.0 || max_band(light.weight) <= 0.0 {
            continue;
        }
        rays += 1u;
        if traverse(origin, light.wi, light.distance * SHADOW_END, true).triangle == MISS {
            sum += eval_brdf(m, shading, light.wi, wo) * light.weight * cos_receiver;
        }
    }
    atomicAdd(&status[STATUS_RAYS], rays);
    film_direct[pixel] += vec4(point.throughput * sum / f32(pass_info.shadow_rays), 0.0);
}
