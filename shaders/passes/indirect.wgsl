// Indirect: light that reaches a gather point by way of other D surfaces, by an eye path that goes on (E S* D (S* D)+ … L) [E28].
// The path leaves the gather point by its D lobes and goes through mirrors and glass to the next D surface, adds the direct
// light and the caustic map there, and goes on by Russian roulette. Each path of light counts once: what light does between
// its lamp and the first D surface is direct light or caustic; emission that the path meets itself is neither, and is left out.
// Paths end after different numbers of bounces: an invocation whose path has ended takes the next pixel from a queue (Aila &
// Laine 2009), as long as its loops may go on. There are as many invocations as pixels, so none is left over.
// reads  scene, tiles, gather_points, path_filter, map_info, sorted_jotons, bucket_starts (of the caustic map)
// writes  film_diffuse, status, queue (zero before)
// import: scene/features.wgsl
// import: camera/strip.wgsl
// import: camera/film.wgsl
// import: camera/live.wgsl
// import: dispatch/count.wgsl
// import: sampling/rng.wgsl
// import: scene/scene.wgsl
// import: shading/surface.wgsl
// import: shading/bsdf.wgsl
// import: lights/direct.wgsl
// import: maps/grid.wgsl
// import: maps/disc.wgsl
// import: paths/gather_point.wgsl
// import: paths/survival.wgsl
// import: paths/paths.wgsl

// There is a caustic map.
override HAS_CAUSTIC_MAP: bool = true;
// Largest caustic radius, in footprints.
override RADIUS_FOOTPRINTS: f32 = 4.0;

@group(1) @binding(0) var<uniform> map_info: MapInfo;
@group(1) @binding(1) var<uniform> path_filter: PathFilter;
@group(1) @binding(2) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(3) var<storage, read> sorted_jotons: array<Joton>;
@group(1) @binding(4) var<storage, read> bucket_starts: array<u32>;
@group(1) @binding(5) var<storage, read_write> film_diffuse: array<vec4<f32>>;
@group(1) @binding(6) var<storage, read_write> status: array<atomic<u32>>;
// Pixels that have been taken.
@group(1) @binding(7) var<storage, read_write> queue: array<atomic<u32>>;

// Loop iterations of a path beside those of discs, at most: an invocation that has not spent as many takes another one.
override PATH_STEPS: u32 = CAMERA_STEPS / 2u;

// Loop iterations of this path that measured discs. They depend on which paths are wanted, so they decide about no chance.
var<private> disc_steps: u32;

// Draws of an event: the way on through mirrors and glass; where to from a D surface; its light.
const DRAWS: u32 = 3u;

// How a path leaves a D surface: f cosθ / pdf_solid_angle of its direction; 0 below the surface.
struct Leaving {
    direction: vec3<f32>,
    weight: Bands,
}

fn leave(m: PackedMaterial, geometric: vec3<f32>, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> Leaving {
    let wi = sample_scatter(m, n, wo, u);
    let cosine = scatter_cosine(m, geometric, n, wi);
    var weight = m.diffuse;
    if does_vary(m) || is_translucent(m) {
        weight = eval_scatter(m, n, wi, wo) * (cosine / max(pdf_scatter(m, n, wi, wo), 1e-37));
    }
    return Leaving(wi, select(Bands(0.0), weight, cosine > 0.0));
}

// Radiance of the caustic map's jotons at a surface, in a disc as large as it may be at this length of the path [E7, E31].
// `accepted` masks the states of jotons that are wanted; u picks one of those that stand for each other.
fn caustic_light(r: Receiver, front: vec3<f32>, path_length: f32, accepted: u32, u: f32) -> Bands {
    let footprint = path_length * pass_info.camera.pixel_angle;
    let radius = INDIRECT_DISC * min(map_info.radius, RADIUS_FOOTPRINTS * footprint * sqrt(map_info.shrink));
    var disc = whole_disc(radius);
    var sum = Bands(0.0);
    var before = steps;
    for (var turn = 0u; turn < 2u; turn += 1u) {
        sum = joton_flux(r, disc, radius, accepted, u);
        if turn == 0u {
            before = steps;
        }
        // most discs hold nothing that is worth a measured area, and in a body of many triangles a path meets too many of them
        if turn > 0u || max_band(sum) <= 0.0 || (HAS_MIXTURES && disc_steps > PATH_STEPS / 2u) {
            break;
        }
        disc = true_disc(DiscPlace(r.origin, r.geometric, front), radius, false);
        if all(disc.first.xyz == vec3(0.0)) && disc.radius == radius {
            break;
        }
    }
    disc_steps += steps - before;
    steps = before;
    if !does_vary(r.material) && !is_translucent(r.material) {
        sum *= eval_scatter(r.material, r.shading, r.wo, r.wo);
    }
    return sum / disc.area;
}

// Flux of the jotons in a disc, times f where it varies; of those that are looked at within `reach`: the same ones for a smaller disc.
fn joton_flux(r: Receiver, disc: TrueDisc, reach: f32, accepted: u32, u: f32) -> Bands {
    let radius = disc.radius;
    let r2 = radius * radius;
    let varies = does_vary(r.material) || is_translucent(r.material);
    let grid = Grid(map_info.grid_origin, map_info.cells_per_unit, map_info.row_mask, map_info.columns);
    var sum = Bands(0.0);
    var rows = rows_touched(grid, r.origin, reach);
    while rows != 0u {
        let buckets = row_run(grid, r.origin, reach, countTrailingZeros(rows));
        rows &= rows - 1u;
        steps += 1u;
        if buckets.x >= buckets.y {
            continue;
        }
        let first = bucket_starts[buckets.x];
        let end = bucket_starts[buckets.y];
        let stride = (end - first) / (CELL_JOTONS * (buckets.y - buckets.x)) + 1u;
        var i = first + u32(u * f32(stride));
        while i < end {
            let d = sorted_jotons[i].position - r.origin;
            if dot(d, d) < r2 && height_over(disc.first, d) >= 0.0 && height_over(disc.second, d) >= 0.0 {
                let normal_state = sorted_jotons[i].normal_state;
                let facing = decode_normal24(normal_state);
                let is_beyond = is_translucent(r.material) && dot(facing, r.geometric) < 0.0;
                if select(dot(facing, r.geometric), -dot(facing, r.geometric), is_beyond) > 127.0 * GATHER_NORMAL_COS
                    && abs(dot(d, facing)) < 127.0 * GATHER_PLANE_SHARE * radius
                    && (!HAS_PATH_FILTER || ((accepted >> (normal_state >> 24u)) & 1u) != 0u) {
                    var flux = sorted_jotons[i].flux * f32(stride);
                    if is_beyond {
                        flux *= translucent_eval(r.material);
                    } else if varies {
                        flux *= eval_reflected(r.material, r.shading, decode_direction(sorted_jotons[i].wi), r.wo);
                    }
                    sum += flux;
                }
            }
            steps += 1u;
            i += stride;
        }
        if i < end {
            atomicAdd(&status[STATUS_LOOP_CUT], 1u);
        }
    }
    return sum;
}

// A path on its way.
struct Path {
    pixel: u32,
    // Its number in the pixel's sequences.
    sample: u32,
    departs: Departure,
    direction: vec3<f32>,
    length: f32,
    // Radiance at the eye per radiance that comes against `direction`.
    throughput: Bands,
    // Events so far, that of the gather point among them.
    events: u32,
    is_first: bool,
    // Masks the states of the automaton, before the surface that the path has left, from which the rest is wanted.
    accepted: u32,
    // What it has found.
    sum: Bands,
    rays: u32,
    saved: u32,
    // The bodies that it is in.
    inside: u32,
}

// The paths of a tile in one pass are an aligned block of its sequence, which covers the square evenly, and each pixel takes
// another part of it in each pass. Twin: src/estimators/indirect.rs.
struct TilePoint {
    tile: u32,
    place: u32,
}

fn tile_point(pixel: u32, sample: u32) -> TilePoint {
    let x = pixel % pass_info.width;
    let y = pixel / pass_info.width;
    let tile = y / TILE * ((pass_info.width + TILE - 1u) / TILE) + x / TILE;
    return TilePoint(tile, (y % TILE * TILE + x % TILE) ^ (sample % WORKGROUP));
}

// The path of a pixel leaves its gather point; false where there is none, or nothing of it is wanted.
fn set_out(p: ptr<function, Path>, pixel: u32, sample: u32) -> bool {
    let point = gather_points[held(pixel)];
    if max_band(point.throughput) <= 0.0 {
        return false;
    }
    let at = tile_point(pixel, sample);
    let number = wide_sum(wide_product(sample, WORKGROUP), at.place);
    let way = sobol2(number.x, sequence_seed(seed_at(pass_info.seed, number.y), at.tile, STREAM_INDIRECT));
    let u = random4(pass_info.seed, sample, pixel, DIMENSION_INDIRECT);
    let m = material_of_point(point);
    let geometric = decode_direction(point.normal);
    let start = leave(m, geometric, decode_direction(point.shading_normal), decode_direction(point.wo), vec3(way, u.x));
    // the first bounce is taken for sure: neighbours share what it finds
    let throughput = point.throughput * start.weight;
    var accepted = 0u;
    if HAS_PATH_FILTER {
        accepted = states_before(states_wanted(chain_of(point)), EVENT_D);
    }
    var origin = point.position;
    if is_translucent(m) && dot(start.direction, geometric) < 0.0 {
        origin -= 2.0 * lift_of_point(m, point) * geometric;
    }
    *p = Path(
        pixel, sample, Departure(origin, 0.0), start.direction, point.path_length, throughput, 1u, true, accepted,
        Bands(0.0), (*p).rays, (*p).saved, point.inside,
    );
    return max_band(throughput) > 0.0 && !(HAS_PATH_FILTER && accepted == 0u);
}

// One ray, and the light where it ends; false where the path does.
fn go_on(p: ptr<function, Path>) -> bool {
    (*p).rays += 1u;
    steps += 1u;
    let direction = (*p).direction;
    let hit = nearest_hit((*p).departs.origin, direction, (*p).departs.t_back);
    if hit.triangle == MISS {
        return false;
    }
    (*p).length += hit.t;
    let s = surface_at(hit);
    var b = bsdf_at(s, direction, 0.0, (*p).inside);
    if HAS_MEDIA {
        (*p).throughput *= transmittance(b.before, hit.t);
        (*p).inside = b.before;
    }
    let weights = weights_at(b, (*p).throughput);
    let scattered = scatter_weight(weights);
    let kept = scattered + delta_weight(weights);
    if kept <= 0.0 {
        return false;
    }
    let dimension = DIMENSION_INDIRECT + DRAWS * (*p).events;
    let random = random4(pass_info.seed, (*p).sample, (*p).pixel, dimension);
    let choice = random.x * kept;
    let scatters = !(HAS_SPECULAR || HAS_DIELECTRIC) || choice < scattered;
    if scatters {
        let throughput = (*p).throughput * (kept / scattered);
        let origin = s.position + b.geometric * s.lift;
        let receiver = Receiver(
            b.material, origin, b.geometric, b.shading, -direction, does_vary(b.material) || near_emitter(origin), b.before,
            s.lift,
        );
        steps += min(pass_info.emitters, NEAR_EMITTERS_MAX);
        if !HAS_PATH_FILTER || (((*p).accepted >> path_step(PATH_START, EVENT_D)) & 1u) != 0u {
            let candidates = pass_info.light_candidates;
            var draws = LightDraws(wide_product((*p).sample, candidates), (*p).pixel, STREAM_INDIRECT_LATER_LIGHT);
            draws.first.y += (*p).events;
            if (*p).is_first {
                let at = tile_point((*p).pixel, (*p).sample);
                let first = wide_sum(wide_product((*p).sample, WORKGROUP * candidates), at.place * candidates);
                draws = LightDraws(first, at.tile, STREAM_INDIRECT_LIGHT);
            }
            let found = direct_light(receiver, draws, random4(pass_info.seed, (*p).sample, (*p).pixel, dimension + 2u));
            (*p).sum += throughput * (found.by_light + found.by_lobe);
            (*p).rays += found.rays;
            (*p).saved += found.saved;
            steps += candidates * (33u - countLeadingZeros(pass_info.emitters));
        }
        if HAS_CAUSTIC_MAP {
            (*p).sum += throughput * caustic_light(receiver, s.front, (*p).length, (*p).accepted, random.y);
        }
        let u = random4(pass_info.seed, (*p).sample, (*p).pixel, dimension + 1u);
        let next = leave(b.material, b.geometric, b.shading, -direction, u.yzx);
        let carried = throughput * next.weight;
        // roulette by what the D lobes keep
        let survives = min(max_band(carried) / max_band(throughput), survival_limit((*p).events, PATH_STEPS));
        if u.w >= survives || max_band(carried) <= 0.0 {
            return false;
        }
        (*p).throughput = carried / survives;
        (*p).direction = next.direction;
        (*p).departs = Departure(origin_toward(receiver, next.direction), 0.0);
        (*p).is_first = false;
    } else {
        if HAS_DISPERSION {
            let seed = sequence_seed(pass_info.seed, (*p).pixel, STREAM_INDIRECT_BAND);
            b = with_band(b, (*p).throughput, golden((*p).sample, seed));
        }
        let lobe = chosen_delta(weights, choice - scattered);
        let next = sample_delta_at(b, lobe, random.yz);
        let survives = survival((*p).events, kept, PATH_STEPS);
        if max_band(next.weight) <= 0.0 || random.w >= survives {
            return false;
        }
        (*p).throughput *= albedo_at(b, lobe) * (kept / (survives * weight_of(weights, lobe)) * next.radiance_scale);
        if HAS_FACETS {
            (*p).throughput *= next.weight;
        }
        (*p).inside = inside_after(b, lobe);
        (*p).direction = next.direction;
        (*p).departs = departure(s, next.direction, b.from_front);
    }
    if HAS_PATH_FILTER {
        steps += 31u;
        (*p).accepted = states_before((*p).accepted, select(EVENT_S, EVENT_D, scatters));
        if (*p).accepted == 0u {
            return false;
        }
    }
    (*p).events += 1u;
    if steps > PATH_STEPS {
        atomicAdd(&status[STATUS_TRUNCATED], 1u);
        return false;
    }
    return true;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    // sets what `own` needs
    let first = linear_index(id, groups);
    let last = groups.x * groups.y * WORKGROUP;
    var p = Path(
        0u, first, Departure(vec3(0.0), 0.0), vec3(0.0), 0.0, Bands(0.0), 0u, false, 0u, Bands(0.0), 0u, 0u, 0u,
    );
    var is_under_way = false;
    // loop iterations of the paths before
    var spent = 0u;
    loop {
        if !is_under_way {
            if spent > PATH_STEPS {
                break;
            }
            let index = atomicAdd(&queue[0], 1u);
            if index >= last {
                break;
            }
            spent += 1u;
            let pixel = live_pixel(index);
            if pixel != NO_PIXEL {
                is_under_way = set_out(&p, pixel, sequence_index(index));
            }
        }
        if is_under_way {
            is_under_way = go_on(&p);
            if !is_under_way {
                film_diffuse[held(p.pixel)] += to_film(p.sum);
                spent += steps + disc_steps;
                steps = 0u;
                disc_steps = 0u;
            }
        }
    }
    if p.rays > 0u {
        count(STATUS_RAYS, STATUS_RAYS_HIGH, p.rays);
    }
    if p.saved > 0u {
        count(STATUS_SHADOW_RAYS_SAVED, STATUS_SHADOW_RAYS_SAVED_HIGH, p.saved);
    }
    if traversal_cut {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
}
