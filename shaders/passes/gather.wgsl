// Gather: estimate the radiance leaving each gather point toward the eye from the jotons near it.
// L = Σ f_r(wi, wo) Φ K, K = 1/(π r²) or the corrected kernel's weights [E15]; no cosine, it is in Φ already.  [E7] Jensen 1996
// Two variants: the caustic map (true discs [E31]) and the diffuse map (its kernel corrected at edges and walls).
// reads  tiles, map_info, path_filter, gather_points, scene, sorted_jotons, bucket_starts, fits, clips
// writes  film, status
// import: scene/features.wgsl
// import: scene/scene.wgsl
// import: camera/strip.wgsl
// import: camera/film.wgsl
// import: camera/live.wgsl
// import: maps/grid.wgsl
// import: maps/lanes.wgsl
// import: maps/clip_planes.wgsl
// import: shading/material.wgsl
// import: shading/lobes.wgsl
// import: paths/gather_point.wgsl
// import: paths/paths.wgsl

override CAUSTIC: bool = false;

@group(1) @binding(0) var<uniform> map_info: MapInfo;
@group(1) @binding(1) var<uniform> path_filter: PathFilter;
@group(1) @binding(2) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(3) var<storage, read> sorted_jotons: array<Joton>;
@group(1) @binding(4) var<storage, read> bucket_starts: array<u32>;
// Diffuse map: weights of the fit; caustic map: one over the disc's area in .x, its radius in .w.
@group(1) @binding(5) var<storage, read> fits: array<Fit>;
@group(1) @binding(6) var<storage, read_write> film: array<vec4<f32>>;
@group(1) @binding(7) var<storage, read_write> status: array<atomic<u32>>;
// Diffuse map: walls about each pixel's gather point of the pilot; caustic map: those of each disc, as seen from its middle.
@group(1) @binding(8) var<storage, read> clips: array<Clip>;

// A wall as seen from the disc's middle: unit normal, and how far along it the wall lies.
fn wall_about(plane: vec4<f32>, p: vec3<f32>) -> vec4<f32> {
    return vec4(plane.xyz, plane.w - dot(plane.xyz, p));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let lanes = lanes_here();
    let pixel = live_pixel(linear_index(id, groups));
    if lanes_min(select(1u, 0u, pixel != NO_PIXEL)) != 0u {
        return;
    }
    // lanes without a gather point go along and find nothing
    let at = select(0u, held(pixel), pixel != NO_PIXEL);
    let point = gather_points[at];
    let is_here = pixel != NO_PIXEL && max_band(point.throughput) > 0.0;
    let fit = fits[at].c;
    let m = material_of_point(point);
    let varies = does_vary(m) || is_translucent(m);
    let chain = chain_of(point);
    let normal = decode_direction(point.normal);
    let shading = decode_direction(point.shading_normal);
    let wo = decode_direction(point.wo);
    let frame = basis(normal);
    let r = select(map_info.radius, fit.w, CAUSTIC);
    var first_wall = clips[at].first;
    var second_wall = clips[at].second;
    if !CAUSTIC && is_here {
        let walls = walls_about(pixel, point.position, normal, r);
        first_wall = wall_about(walls.planes[0], point.position);
        second_wall = wall_about(walls.planes[1], point.position);
    }
    let slope = (fit.y * frame[0] + fit.z * frame[1]) / r;
    let r2 = r * r;
    let plane = GATHER_PLANE_SHARE * r;
    let grid = Grid(map_info.grid_origin, map_info.cells_per_unit, map_info.row_mask, map_info.columns);
    var sum = Bands(0.0);
    var rows = lanes_or(select(0u, rows_touched(grid, point.position, r), is_here));
    while rows != 0u {
        let buckets = row_run(grid, point.position, r, countTrailingZeros(rows));
        rows &= rows - 1u;
        var i = 0u;
        var end = 0u;
        if is_here && buckets.x < buckets.y {
            i = bucket_starts[buckets.x];
            end = bucket_starts[buckets.y];
        }
        loop {
            let first = lanes_min(select(NO_INDEX, i, i < end));
            if first == NO_INDEX {
                break;
            }
            let mine = first + lanes.index;
            let normal_state = sorted_jotons[mine].normal_state;
            let place = vec4(sorted_jotons[mine].position, bitcast<f32>(normal_state));
            let facing = vec4(decode_normal24(normal_state), 0.0);
            let flux4 = four_of_bands(sorted_jotons[mine].flux);
            for (var k = 0u; k < lanes.count; k += 1u) {
                let joton = from_lane(place, k);
                let d = joton.xyz - point.position;
                let is_mine = first + k >= i && first + k < end;
                let n = from_lane(facing, k).xyz;
                var flux = bands_of_four(from_lane(flux4, k));
                // a true disc is measured face by face: all of a flat face is near, or nothing
                let side = dot(n, normal);
                // [E55] light of the other side is scattered through
                let is_beyond = is_translucent(m) && side < 0.0;
                let height = abs(dot(d, select(normal, n / 127.0, CAUSTIC)));
                if is_mine && dot(d, d) < r2 && height < plane
                    && select(side, -side, is_beyond) > 127.0 * GATHER_NORMAL_COS
                    && is_before(first_wall, d) && is_before(second_wall, d)
                    && (!HAS_PATH_FILTER || path_wanted(bitcast<u32>(joton.w) >> 24u, chain)) {
                    if is_beyond {
                        flux *= translucent_eval(m);
                    } else if varies {
                        let wi = decode_direction(sorted_jotons[first + k].wi);
                        flux *= eval_reflected(m, shading, wi, wo);
                    }
                    if CAUSTIC {
                        sum += flux;
                    } else {
                        sum += flux * (fit.x + dot(d, slope));
                    }
                }
            }
            i = max(i, first + lanes.count);
        }
        if i < end {
            atomicAdd(&status[STATUS_LOOP_CUT], 1u);
        }
    }
    if !is_here {
        return;
    }
    if CAUSTIC {
        sum *= fit.x;
    }
    if !varies {
        sum *= eval_scatter(m, shading, wo, wo);
    }
    film[at] += to_film(point.throughput * sum);
}
