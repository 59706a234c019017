// Gather: estimate the radiance leaving each gather point toward the eye from the jotons near it.
// L = Σ f_r(wi, wo) Φ K, K = 1/(π r²) or the weights of the boundary's fit; no cosine, it is in Φ already.  [E7] Jensen 1996
// Two variants: the caustic map (a radius for each pixel) and the diffuse map (fitted at boundaries).
// reads  map_info, path_filter, gather_points, materials, sorted_jotons, bucket_starts, fits, clips
// writes  film, status
// import: shared/features.wgsl
// import: shared/index.wgsl
// import: shared/grid.wgsl
// import: shared/clip.wgsl
// import: shared/bsdf.wgsl
// import: shared/paths.wgsl

override CAUSTIC: bool = false;

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<uniform> map_info: MapInfo;
@group(0) @binding(2) var<uniform> path_filter: PathFilter;
@group(0) @binding(3) var<storage, read> gather_points: array<GatherPoint>;
@group(0) @binding(4) var<storage, read> materials: array<PackedMaterial>;
@group(0) @binding(5) var<storage, read> sorted_jotons: array<Joton>;
@group(0) @binding(6) var<storage, read> bucket_starts: array<u32>;
// Caustic map: base radius of each pixel in .x; diffuse map: weights of the fit.
@group(0) @binding(7) var<storage, read> fits: array<Fit>;
@group(0) @binding(8) var<storage, read_write> film: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read_write> status: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read> clips: array<Clip>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = linear_index(id, groups);
    if pixel >= pass_info.width * pass_info.height {
        return;
    }
    let point = gather_points[pixel];
    if max_band(point.throughput) <= 0.0 {
        return;
    }
    let fit = fits[pixel].c;
    var r = map_info.radius;
    if CAUSTIC {
        r = min(r, fit.x * sqrt(map_info.shrink));
    }
    let material = point.surface & 0xffffffu;
    let is_glossy = HAS_GLOSSY && (materials[material].flag_bits & GLOSSY) != 0u;
    let chain = (point.surface >> 24u) & 63u;
    let normal = decode_direction(point.normal);
    let shading = decode_direction(point.shading_normal);
    let wo = decode_direction(point.wo);
    let frame = basis(normal);
    let walls = walls_about(pixel, point.position, normal, r);
    let first_wall = walls.planes[0];
    let second_wall = walls.planes[1];
    let slope = (fit.y * frame[0] + fit.z * frame[1]) / r;
    let r2 = r * r;
    let plane = GATHER_PLANE_SHARE * r;
    let lowest = cell_of(point.position - r, map_info.grid_origin, map_info.cells_per_unit);
    let highest = cell_of(point.position + r, map_info.grid_origin, map_info.cells_per_unit);
    let cell = 1.0 / map_info.cells_per_unit;
    var sum = Bands(0.0);
    for (var z = lowest.z; z <= highest.z; z += 1) {
        for (var y = lowest.y; y <= highest.y; y += 1) {
            let reach = reach_in_row(point.position, r2, y, z, map_info.grid_origin, cell);
            if reach < 0.0 {
                continue;
            }
            let row = row_bucket(y, z, map_info.row_mask);
            let x = point.position.x - map_info.grid_origin.x;
            let left = column(i32(floor((x - reach) * map_info.cells_per_unit)), map_info.columns);
            let last = column(i32(floor((x + reach) * map_info.cells_per_unit)), map_info.columns);
            let end = bucket_starts[row + last + 1u];
            var i = bucket_starts[row + left];
            while i < end {
                let position = sorted_jotons[i].position;
                let d = position - point.position;
                let normal_state = sorted_jotons[i].normal_state;
                if dot(d, d) < r2 && abs(dot(d, normal)) < plane
                    && dot(decode_normal24(normal_state), normal) > 127.0 * GATHER_NORMAL_COS
                    && is_before(first_wall, position) && is_before(second_wall, position)
                    && (!HAS_PATH_FILTER || path_wanted(normal_state >> 24u, chain)) {
                    var flux = sorted_jotons[i].flux;
                    if is_glossy {
                        let wi = decode_direction(sorted_jotons[i].wi);
                        flux *= eval_brdf(materials[material], shading, wi, wo);
                    }
                    if CAUSTIC {
                        sum += flux;
                    } else {
                        sum += flux * (fit.x + dot(d, slope));
                    }
                }
                i += 1u;
            }
            if i < end {
                atomicAdd(&status[STATUS_LOOP_CUT], 1u);
            }
        }
    }
    if CAUSTIC {
        // what walls take of the disc carries no light of this side
        let kept = kept_share(first_wall, point.position, r) * kept_share(second_wall, point.position, r);
        sum /= PI * r * r * max(kept, CLIP_KEPT_MIN);
    }
    if !is_glossy {
        sum *= materials[material].diffuse / PI;
    }
    film[pixel] += vec4(point.throughput * sum, 0.0);
}
