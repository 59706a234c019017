// Glint: emission seen through specular surfaces (E S* L) where it is small in the image: a few camera trees, which take
// both ways at a dielectric interface, find it. A lamp's four percent in a water surface is then seen by every tree instead of
// by every twenty-fifth eye path. Only for pixels in the list; each weighs what the eye path would not find [E25].
// reads  scene, tiles, path_filter, glints      writes  seen, status
// import: scene/features.wgsl
// import: camera/strip.wgsl
// import: camera/live.wgsl
// import: dispatch/count.wgsl
// import: sampling/rng.wgsl
// import: scene/scene.wgsl
// import: shading/surface.wgsl
// import: shading/bsdf.wgsl
// import: lights/le.wgsl
// import: camera/camera.wgsl
// import: paths/survival.wgsl
// import: paths/paths.wgsl
// import: lights/reservoir.wgsl
// import: lights/followed.wgsl
// import: paths/splits.wgsl
// import: paths/trees.wgsl

@group(1) @binding(0) var<uniform> path_filter: PathFilter;
@group(1) @binding(1) var<storage, read> glints: array<u32>;
// Emission of each tree; of each pixel in the pilot.
@group(1) @binding(2) var<storage, read_write> seen: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;

// What a pilot's trees saw of light in a pixel. Twin: Light in src/estimators/split_paths.rs.
const LIGHT_NOWHERE: f32 = 0.0;
const LIGHT_IN_PART: f32 = 1.0;
const LIGHT_EVERYWHERE: f32 = 2.0;

struct Seen {
    emission: Bands,
    // Everything that was seen is the front of a light, without a specular surface between.
    direct: bool,
    // It took both ways somewhere.
    branched: bool,
    rays: u32,
}

// A way that is still to be followed.
struct Way {
    origin: vec3<f32>,
    events: u32,
    direction: vec3<f32>,
    splits: Splits,
    throughput: Bands,
    // Back faces nearer than this are not met.
    t_back: f32,
    // From the eye.
    length: f32,
    // The bodies that it is in.
    inside: u32,
}

// Tree `number`, 64 bits, of a pixel. It ends before `steps` comes to `budget`. What it sees is weighed beside so many trees a
// pass; in the pilot it is not.
fn tree(pixel: u32, number: vec2<u32>, trees: f32, pilot: bool, budget: u32) -> Seen {
    let seed = seed_at(pass_info.seed, number.y);
    var waiting: array<Way, WAITING_MAX>;
    var waits = 0u;
    var found = Seen(Bands(0.0), false, false, 0u);
    var node = 0u;
    let camera = sample_camera(pixel, number.x, seed, STREAM_GLINT_JITTER);
    var way = Way(camera.origin, 0u, camera.direction, Splits(1.0, 1.0, 0.0), Bands(1.0), 0.0, camera.travelled, inside_of_camera());
    var alive = true;
    // A tree may have more rays than an invocation's loops. From half of its steps on one way goes on for all that are left,
    // picked by what they carry: to let each end by chance instead makes the few that remain hundreds of times too bright.
    let shared_steps = steps + (budget - min(steps, budget)) / 2u;
    var alone = false;
    // each turn is a ray of whatever way: lanes that run in step do not wait for the ends of each other's ways
    while alive || waits > 0u {
        if !alone && steps > shared_steps {
            alone = true;
            var all = Reservoir(0.0, random4(seed, number.x, pixel, DIMENSION_GLINT_ALONE).x);
            if alive {
                takes(&all, max_band(way.throughput));
            }
            for (var w = 0u; w < waits; w += 1u) {
                if takes(&all, max_band(waiting[w].throughput)) {
                    way = waiting[w];
                }
            }
            way.throughput *= all.total / max_band(way.throughput);
            waits = 0u;
        } else if !alive {
            waits -= 1u;
            way = waiting[waits];
        }
        alive = false;
        found.rays += 1u;
        let hit = nearest_hit(way.origin, way.direction, way.t_back);
        let is_wanted = pilot || !HAS_PATH_FILTER || path_wanted(PATH_START, way.events);
        if hit.triangle == MISS {
            let weight = select(weight_of_tree(way.splits, trees, 0.0), 1.0, pilot);
            let left = transmittance(way.inside, AFAR);
            found.emission += select(Bands(0.0), way.throughput * on_miss(way.direction) * left * weight, is_wanted);
            continue;
        }
        way.length += hit.t;
        let s = surface_at(hit);
        var b = bsdf_at(s, way.direction, seen_width(way.length), way.inside);
        if HAS_MEDIA {
            way.throughput *= transmittance(b.before, hit.t);
        }
        let light = le_at(b);
        if max_band(light) > 0.0 && is_wanted {
            let weight = weight_of_tree(way.splits, trees, pdf_of_lights(s, b, hit.t));
            found.emission += way.throughput * light * select(weight, 1.0, pilot);
            found.direct = way.events == 0u;
        }
        let weights = weights_at(b, way.throughput);
        let followed = delta_weight(weights);
        if followed <= 0.0 {
            continue;
        }
        found.direct = false;
        if HAS_DISPERSION {
            b = with_band(b, way.throughput, golden(number.x, sequence_seed(seed, pixel, STREAM_GLINT_BAND)));
        }
        let random = random4(seed, number.x, pixel, DIMENSION_GLINT + node);
        node += 1u;
        // nothing is scattered or absorbed by chance here: only delta lobes lead to light
        let both = HAS_DIELECTRIC && !alone && takes_both(way.splits, weights);
        let pair = interface_lobes(weights);
        let lobe = select(chosen_delta(weights, random.x * followed), pair.lesser, both);
        var next: Next;
        // one call for both: it is most of what there is to compile
        for (var left = select(1u, 2u, both); left > 0u; left -= 1u) {
            next = after(way, s, b, weights, select(lobe, pair.greater, left == 2u), random.yz);
            if left == 2u && next.alive {
                // the greater waits: so many are never waiting
                waiting[waits] = next.way;
                waits += 1u;
            }
        }
        found.branched = found.branched || both;
        let taken = weight_of(weights, lobe);
        let survives = survival(way.events, select(followed, taken, both), budget);
        if !next.alive || random.w >= survives {
            continue;
        }
        alive = true;
        way = next.way;
        way.throughput *= select(followed / taken, 1.0, both) / survives;
        if steps > budget {
            atomicAdd(&status[STATUS_TRUNCATED], 1u);
            break;
        }
    }
    return found;
}

struct Next {
    way: Way,
    alive: bool,
}

// What of a way goes on by a lobe; not divided by the chance to take it.
fn after(way: Way, s: Surface, b: Bsdf, weights: LobeWeights, lobe: u32, u: vec2<f32>) -> Next {
    let sample = sample_delta_at(b, lobe, u);
    let start = departure(s, sample.direction, b.from_front);
    var throughput = way.throughput * albedo_at(b, lobe) * sample.radiance_scale;
    if HAS_FACETS {
        throughput *= sample.weight;
    }
    let splits = splits_after(way.splits, weights, lobe, pdf_delta_at(b, lobe, sample.direction));
    let inside = inside_after(b, lobe);
    let next = Way(start.origin, way.events + 1u, sample.direction, splits, throughput, start.t_back, way.length, inside);
    return Next(next, max_band(sample.weight) > 0.0 && max_band(throughput) > 0.0);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    let pilot = own(pass_info.pass_index) == PILOT_PASS;
    var pixel = NO_PIXEL;
    var trees = PILOT_TREES;
    var a_pass = 0.0;
    // no pass has so high a number
    var first = vec2(0u, PILOT_PASS);
    if pilot {
        pixel = live_pixel(index);
    } else if index < pass_info.glint_count {
        // a tree each; the trees of one pixel begin at a multiple of their number
        let entry = glints[pass_info.glint_first + index];
        let level = glint_level(entry);
        pixel = glint_pixel(entry);
        a_pass = trees_a_pass(level);
        trees = 1u;
        first = wide_sum(wide_product(pass_info.pass_index, trees_of(level)), index % trees_of(level));
        first = select(first, vec2(pass_info.pass_index / pass_info.glint_turns, 0u), level == GLINT_TURNS);
    }
    if pixel == NO_PIXEL {
        return;
    }
    var emission = Bands(0.0);
    var square = 0.0;
    var lit = 0u;
    var lit_directly = 0u;
    var branched = false;
    var rays = 0u;
    for (var i = 0u; i < trees; i += 1u) {
        // the trees to come keep their part
        let budget = CAMERA_STEPS - STEP_RAMP * (trees - 1u - i);
        let found = tree(pixel, wide_sum(first, i), a_pass, pilot, budget);
        emission += found.emission;
        square += dot(found.emission, found.emission);
        rays += found.rays;
        lit += select(0u, 1u, max_band(found.emission) > 0.0);
        lit_directly += select(0u, 1u, found.direct);
        branched = branched || found.branched;
    }
    if traversal_cut {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
    if pilot {
        let in_part = select(LIGHT_NOWHERE, LIGHT_IN_PART, lit > 0u);
        let light = select(in_part, LIGHT_EVERYWHERE, lit_directly == trees);
        let mean = emission / f32(trees);
        seen[held(pixel)] = vec4(light, select(0.0, 1.0, branched), square / f32(trees), dot(mean, mean));
        return;
    }
    count(STATUS_RAYS, STATUS_RAYS_HIGH, rays);
    seen[index] = four_of_bands(emission);
}
