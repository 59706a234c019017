// Eye: one camera path per pixel, through mirrors and glass to the first diffuse surface: a gather point.
// Emission that is met on the way, and that light samples find in lobes that are followed, goes to the film (E S* L), weighed beside that
// of the glint kernel's trees [E25, E46].
// reads  scene, tiles, path_filter      writes  gather_points, film_emission, status
// import: scene/features.wgsl
// import: camera/strip.wgsl
// import: camera/film.wgsl
// import: camera/live.wgsl
// import: dispatch/count.wgsl
// import: sampling/rng.wgsl
// import: scene/scene.wgsl
// import: shading/surface.wgsl
// import: shading/bsdf.wgsl
// import: lights/le.wgsl
// import: lights/followed.wgsl
// import: camera/camera.wgsl
// import: paths/gather_point.wgsl
// import: paths/survival.wgsl
// import: paths/paths.wgsl
// import: paths/splits.wgsl
// import: paths/trees.wgsl

@group(1) @binding(0) var<uniform> path_filter: PathFilter;
@group(1) @binding(1) var<storage, read_write> gather_points: array<GatherPoint>;
@group(1) @binding(2) var<storage, read_write> film_emission: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    let pixel = live_pixel(index);
    if pixel == NO_PIXEL {
        return;
    }
    let sample = sequence_index(index);
    let choices = sobol2(sample, sequence_seed(pass_info.seed, pixel, STREAM_CHOICE));
    let level = gather_points[held(pixel)].glint_level;
    let trees = trees_a_pass(level);
    var splits = Splits(1.0, 1.0, 0.0);
    let camera = sample_camera(pixel, sample, pass_info.seed, STREAM_JITTER);
    var start = Departure(camera.origin, 0.0);
    var direction = camera.direction;
    var throughput = Bands(1.0);
    var emission = Bands(0.0);
    var path_length = camera.travelled;
    var point = GatherPoint(vec3(0.0), 0u, Bands(0.0), 0.0, 0u, 0u, 0u, level, 0u, 0u, 0u, 0u);
    var events = 0u;
    var rays = 0u;
    var saved = 0u;
    var inside = inside_of_camera();

    loop {
        rays += 1u;
        let hit = nearest_hit(start.origin, direction, start.t_back);
        let is_wanted = !HAS_PATH_FILTER || path_wanted(PATH_START, events);
        if hit.triangle == MISS {
            let light = throughput * on_miss(direction) * transmittance(inside, AFAR);
            emission += select(Bands(0.0), light * weight_of_eye(splits, trees, 0.0), is_wanted);
            break;
        }
        path_length += hit.t;
        let s = surface_at(hit);
        var b = bsdf_at(s, direction, seen_width(path_length), inside);
        if HAS_MEDIA {
            throughput *= transmittance(b.before, hit.t);
        }
        if is_wanted {
            emission += throughput * le_at(b) * weight_of_eye(splits, trees, pdf_of_lights(s, b, hit.t));
        }
        let weights = weights_at(b, throughput);
        let followed = delta_weight(weights);
        let kept = scatter_weight(weights) + followed;
        if kept <= 0.0 {
            break;
        }
        if HAS_DISPERSION {
            b = with_band(b, throughput, golden(sample, sequence_seed(pass_info.seed, pixel, STREAM_EYE_BAND)));
        }
        if HAS_FOLLOWED_LIGHT && (!HAS_PATH_FILTER || path_wanted(PATH_START, events + 1u)) {
            let first = wide_product(sample, pass_info.light_candidates);
            let draws = LightDraws(vec2(first.x, first.y + events), pixel, STREAM_FOLLOWED_LIGHT);
            let choice = random4(pass_info.seed, sample, pixel, DIMENSION_FOLLOWED + events).x;
            let found = light_in_lobes(s, b, weights, splits, trees, draws, choice);
            emission += throughput * found.light;
            rays += found.rays;
            saved += found.saved;
        }
        let random = random4(pass_info.seed, sample, pixel, DIMENSION_EYE + events);
        var choice = random.x;
        if events < 2u {
            choice = select(choices.y, choices.x, events == 0u);
        }
        let stop = scatter_weight(weights);
        choice *= kept;
        if choice < stop {
            let albedo = kept_albedo(b.material);
            point = GatherPoint(
                s.position + b.geometric * s.lift, gather_surface(b.number, events, b.from_front, is_translucent(b.material)),
                throughput * (kept / stop), path_length,
                encode_direction(b.geometric), encode_direction(b.shading), encode_direction(-direction), level,
                albedo.x, albedo.y, b.before, kept_facets(b.material, s.lift),
            );
            break;
        }
        let lobe = chosen_delta(weights, choice - stop);
        let next = sample_delta_at(b, lobe, random.yz);
        // Nothing is absorbed by chance on the way from the eye: what the surface takes is in the throughput. But late in
        // a path that goes on, where it ends as a joton's does [E3].
        let survives = survival(events, kept, CAMERA_STEPS);
        if max_band(next.weight) <= 0.0 || random.w >= survives {
            break;
        }
        throughput *= albedo_at(b, lobe) * (kept / (survives * weight_of(weights, lobe)) * next.radiance_scale);
        if HAS_FACETS {
            throughput *= next.weight;
        }
        splits = splits_after(splits, weights, lobe, pdf_delta_at(b, lobe, next.direction));
        inside = inside_after(b, lobe);
        direction = next.direction;
        start = departure(s, direction, b.from_front);
        events += 1u;
        if steps > CAMERA_STEPS {
            atomicAdd(&status[STATUS_TRUNCATED], 1u);
            break;
        }
    }
    count(STATUS_RAYS, STATUS_RAYS_HIGH, rays);
    if HAS_FOLLOWED_LIGHT && saved > 0u {
        count(STATUS_SHADOW_RAYS_SAVED, STATUS_SHADOW_RAYS_SAVED_HIGH, saved);
    }
    if traversal_cut {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
    gather_points[held(pixel)] = point;
    film_emission[held(pixel)] += to_film(emission);
}
