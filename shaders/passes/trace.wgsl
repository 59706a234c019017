// Trace: emit jotons and bounce them with Russian roulette; store them where they meet diffuse surfaces.
// A lane traces its jotons one after the other and puts its work away when its step budget is used up: dispatched until
// all lanes are done. Two variants: the caustic map (L S+ D, emission aimed at the specular bodies) and the diffuse map
// (everything that met a D before).
// reads  scene, targets, warps, visible_cells, map_info, path_filter      writes  lanes, jotons (a region for each lane), tallies
// import: scene/features.wgsl
// import: dispatch/index.wgsl
// import: sampling/rng.wgsl
// import: scene/scene.wgsl
// import: shading/surface.wgsl
// import: shading/bsdf.wgsl
// import: accel/cutout.wgsl
// import: lights/emit.wgsl
// import: paths/path_state.wgsl
// import: paths/paths.wgsl
// import: maps/visible_cells.wgsl

override CAUSTIC: bool = false;

@group(1) @binding(0) var<uniform> map_info: MapInfo;
@group(1) @binding(1) var<uniform> path_filter: PathFilter;
@group(1) @binding(2) var<uniform> targets: array<Target, 16>;
@group(1) @binding(3) var<storage, read_write> lanes: array<PathState>;
@group(1) @binding(4) var<storage, read_write> jotons: array<Joton>;
@group(1) @binding(5) var<storage, read_write> tallies: array<LaneTally>;

// Loop iterations of picking an emitter and of its warp, at most.
const EMIT_STEPS: u32 = 34u;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    if index >= map_info.lanes {
        return;
    }
    var lane = lanes[index];
    if (lane.status & LANE_DONE) != 0u {
        return;
    }
    var tally = tallies[index];
    let region = index * map_info.lane_capacity;
    let stored_before = lane.stored;
    let rays_before = tally.rays;
    let first_dimension = select(DIMENSION_DIFFUSE, DIMENSION_CAUSTIC, CAUSTIC);

    prepare_emission();
    while steps < STEP_BUDGET {
        steps += 1u;
        if (lane.status & LANE_ALIVE) == 0u {
            let number = index + lane.started * map_info.lanes;
            if number >= map_info.emitted {
                lane.status = LANE_DONE;
                break;
            }
            lane.started += 1u;
            steps += EMIT_STEPS + 3u * pass_info.targets;
            let start = emit(number);
            lane.origin = start.origin;
            lane.t_back = 0.0;
            lane.direction = start.direction;
            lane.flux = start.flux;
            lane.inside = inside_of_emitter(emitted_by);
            lane.status = PATH_START;
            if max_band(start.flux) <= 0.0 {
                continue;
            }
            lane.status |= LANE_ALIVE;
            tally.emitted += four_of_bands(start.flux);
        }
        let number = index + (lane.started - 1u) * map_info.lanes;
        let is_first = tally.rays == rays_before;
        let hit = nearest_hit(lane.origin, lane.direction, lane.t_back);
        if traversal_cut {
            // the next dispatch has the driver's whole budget for this ray; where that was not enough, nothing is
            lane.status |= select(0u, LANE_CUT | LANE_DONE, is_first);
            break;
        }
        tally.rays += 1u;
        if hit.triangle == MISS {
            let left = transmittance(lane.inside, AFAR);
            tally.escaped += four_of_bands(lane.flux * left);
            tally.absorbed += four_of_bands(lane.flux * (1.0 - left));
            lane.status = 0u;
            continue;
        }
        let s = surface_at(hit);
        var b = bsdf_at(s, lane.direction, 0.0, lane.inside);
        if HAS_MEDIA {
            let left = transmittance(b.before, hit.t);
            tally.absorbed += four_of_bands(lane.flux * (1.0 - left));
            lane.flux *= left;
        }
        let wi = -lane.direction;
        // [E11] jotons see shading normals through their adjoint
        var adjoint_in = 1.0;
        if HAS_SMOOTH && s.is_smooth {
            adjoint_in = min(ADJOINT_MAX, dot(wi, b.shading) / max(1e-6, dot(wi, b.geometric)));
        }
        let scatters = does_scatter(b.material);
        let wanted = select((lane.status & LANE_MET_DIFFUSE) != 0u, (lane.status & LANE_MET_SPECULAR) != 0u, CAUSTIC);
        // [E23] of the jotons that the camera does not look at a few stand for all
        let unseen = HAS_VISIBLE_CELLS && !CAUSTIC && scatters && wanted && !is_marked(s.position);
        var counts_as = 1.0;
        if unseen {
            let u = random4(pass_info.seed, map_info.pass_index, number, DIMENSION_UNSEEN + lane.status / LANE_EVENT).x;
            counts_as = select(0.0, f32(UNSEEN_STORED), u * f32(UNSEEN_STORED) < 1.0);
            tally.not_stored += select(0u, 1u, counts_as == 0.0);
        }
        if HAS_CUTOUTS && scatters && wanted {
            // [E38] fewer jotons meet what is there in part, but discs have all of its area
            counts_as /= max(opacity_of(b.material, s.texture.uv), OPACITY_LEAST);
        }
        if scatters && wanted && counts_as > 0.0 {
            if lane.stored < map_info.lane_capacity {
                var state = 0u;
                if HAS_PATH_FILTER {
                    state = path_step(lane.status & 31u, EVENT_D);
                }
                jotons[region + lane.stored] = Joton(
                    s.position, encode_normal24(b.geometric) | (state << 24u), lane.flux * (adjoint_in * counts_as),
                    encode_direction(wi),
                );
            }
            lane.stored += 1u;
        }

        let events = lane.status / LANE_EVENT;
        let weights = roulette_at(b, lane.flux, events);
        let random = random4(pass_info.seed, map_info.pass_index, number, first_dimension + events);
        let lobe = chosen_lobe(weights, random.x);
        tally.absorbed += four_of_bands(lane.flux * (1.0 - total_albedo(b.material, b.at)));
        if lobe == LOBE_NONE || (CAUSTIC && !is_delta(lobe)) {
            lane.status = 0u;
            continue;
        }
        if HAS_DISPERSION {
            let stream = select(STREAM_DIFFUSE_BAND, STREAM_CAUSTIC_BAND, CAUSTIC);
            b = with_band(b, lane.flux, golden(map_info.first_joton + number, sequence_seed(map_info.seed, 0u, stream)));
        }
        lane.flux *= albedo_at(b, lobe) / weight_of(weights, lobe);
        var next: LobeSample;
        if CAUSTIC {
            next = sample_delta_at(b, lobe, random.yz);
        } else {
            next = sample_at(b, lobe, random.yz);
        }
        let off_relief = !CAUSTIC && is_off_relief(b, lobe);
        if off_relief {
            next = sample_off_relief(b, lobe, random.yz);
        }
        // what the sampled direction carries of it: the rest is absorbed, so that the balance is exact in expectation
        var carried = next.weight;
        if HAS_SMOOTH && s.is_smooth {
            let out = abs(dot(next.direction, b.geometric)) / max(1e-6, abs(dot(next.direction, b.shading)));
            carried *= min(ADJOINT_MAX, select(adjoint_in * out, adjoint_in, off_relief));
        }
        lane.direction = next.direction;
        lane.status |= select(LANE_MET_DIFFUSE, LANE_MET_SPECULAR, is_delta(lobe));
        tally.absorbed += four_of_bands(lane.flux * (1.0 - carried));
        lane.flux *= carried;
        if max_band(lane.flux) <= 0.0 {
            lane.status = 0u;
            continue;
        }
        if HAS_PATH_FILTER {
            lane.status = (lane.status & ~31u)
                | path_step(lane.status & 31u, select(EVENT_D, EVENT_S, is_delta(lobe)));
            if CAUSTIC && (lane.status & 31u) == PATH_DEAD {
                lane.status = 0u;
                continue;
            }
        }
        lane.inside = inside_after(b, lobe);
        let start = departure(s, lane.direction, b.from_front);
        lane.origin = start.origin;
        lane.t_back = start.t_back;
        lane.status += LANE_EVENT;
    }
    tally.stored += lane.stored - stored_before;
    lanes[index] = lane;
    tallies[index] = tally;
}
