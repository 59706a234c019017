// Glint: emission seen through specular surfaces (E S* L) where it is small in the image: a few camera chains that branch
// evenly between reflection and refraction. A lamp's four percent in a water surface is then found by every other chain
// instead of by every twenty-fifth. Only for pixels that the pilot marked; the eye kernel leaves these to us.
// reads  scene, tiles, path_filter, gather_points (its pixel flags)      writes  film (emission; counts in the pilot), status
// import: shared/features.wgsl
// import: shared/strip.wgsl
// import: shared/live.wgsl
// import: shared/count.wgsl
// import: shared/rng.wgsl
// import: shared/scene.wgsl
// import: shared/surface.wgsl
// import: shared/bsdf.wgsl
// import: shared/scatter.wgsl
// import: shared/camera.wgsl
// import: shared/survival.wgsl
// import: shared/paths.wgsl

// The pilot counts in how many of its chains light is seen: 0 none, 1 some, 2 all, directly.

@group(1) @binding(0) var<uniform> path_filter: PathFilter;
@group(1) @binding(1) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(2) var<storage, read_write> film: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;

// Chains for each pixel and pass.
const CHAINS: u32 = 4u;
const PILOT_CHAINS: u32 = 8u;
// Events at which both branches get the same chance.
const EVEN_EVENTS: u32 = 3u;

struct Seen {
    emission: Bands,
    // Everything that was seen is the front of a light, without a specular surface between.
    direct: bool,
    rays: u32,
}

// Chain `number` of a pixel, which ends before `steps` comes to `budget`.
fn chain(pixel: u32, number: u32, budget: u32) -> Seen {
    let jitter = sobol2(number, sequence_seed(pass_info.seed, pixel, STREAM_GLINT_JITTER));
    let choices = sobol2(number, sequence_seed(pass_info.seed, pixel, STREAM_GLINT_CHOICE));
    var origin = pass_info.eye;
    var direction = camera_direction(pixel, jitter);
    var throughput = Bands(1.0);
    var seen = Seen(Bands(0.0), false, 0u);
    for (var events = 0u;; events += 1u) {
        seen.rays += 1u;
        let hit = traverse(origin, direction, 1e30, false);
        if hit.triangle == MISS {
            break;
        }
        let s = surface_at(hit);
        let m = materials[s.material];
        let from_front = dot(direction, s.front) < 0.0;
        if (m.flag_bits & EMISSIVE) != 0u && from_front
            && (!HAS_PATH_FILTER || path_wanted(PATH_START, events)) {
            seen.emission += throughput * m.emission;
            seen.direct = events == 0u;
        }
        let geometric = s.front * select(-1.0, 1.0, from_front);
        let shading = facing_normal(s, direction, geometric);
        let reflectance = dielectric_reflectance(m, shading, direction, from_front);
        let c = chances(m, throughput, reflectance);
        let specular = c.mirror + c.reflect + c.transmit;
        if specular <= 0.0 {
            break;
        }
        seen.direct = false;
        let random = random4(pass_info.seed, number, pixel, DIMENSION_GLINT + events);
        // nothing is scattered or absorbed by chance here: only specular events lead to light
        var chance_reflect = (c.mirror + c.reflect) / specular;
        if events < EVEN_EVENTS && c.reflect > 0.0 && c.transmit > 0.0 {
            chance_reflect = 0.5;
        }
        var choice = random.x;
        if events < 2u {
            choice = select(choices.y, choices.x, events == 0u);
        }
        let reflects = choice < chance_reflect;
        var event = select(EVENT_TRANSMIT, EVENT_REFLECT, reflects);
        if c.mirror > 0.0 {
            event = EVENT_MIRROR;
        }
        let next = specular_scatter(m, event, direction, geometric, shading, from_front, random.yz);
        if !next.alive {
            break;
        }
        let radiance_scale = select(1.0, next.eta_it * next.eta_it, event == EVENT_TRANSMIT);
        throughput *= event_reflectance(m, event, reflectance)
            * (radiance_scale / select(1.0 - chance_reflect, chance_reflect, reflects));
        direction = next.direction;
        origin = offset_origin(s.position, s.front * select(-1.0, 1.0, dot(direction, s.front) >= 0.0));
        let survives = survival(events, specular, budget);
        if random.w >= survives {
            break;
        }
        throughput /= survives;
        if steps > budget {
            atomicAdd(&status[STATUS_TRUNCATED], 1u);
            break;
        }
    }
    return seen;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    let pixel = live_pixel(index);
    if pixel == NO_PIXEL {
        return;
    }
    let pilot = pass_info.pass_index == PILOT_PASS;
    if !pilot && (gather_points[held(pixel)].pixel_flags & PIXEL_GLINT) == 0u {
        return;
    }
    let sample = sequence_index(index);
    let chains = select(CHAINS, PILOT_CHAINS, pilot);
    var emission = Bands(0.0);
    var lit = 0u;
    var lit_directly = 0u;
    var rays = 0u;
    for (var i = 0u; i < chains; i += 1u) {
        // the chains to come keep their part
        let budget = CAMERA_STEPS - STEP_RAMP * (chains - 1u - i);
        let seen = chain(pixel, sample * chains + i, budget);
        emission += seen.emission;
        rays += seen.rays;
        lit += select(0u, 1u, max_band(seen.emission) > 0.0);
        lit_directly += select(0u, 1u, seen.direct);
    }
    if pilot {
        if traversal_cut {
            atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
        }
        let all = lit_directly == chains;
        film[held(pixel)] = vec4(select(select(0.0, 1.0, lit > 0u), 2.0, all), 0.0, 0.0, 0.0);
        return;
    }
    count(STATUS_RAYS, STATUS_RAYS_HIGH, rays);
    if traversal_cut {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
    film[held(pixel)] += vec4(emission / f32(chains), 0.0);
}
