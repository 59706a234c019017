// Radix: one digit of a stable least-significant-digit sort of (key, place) pairs. Each invocation has a chunk and a
// private histogram: no atomics, so equal keys keep their order and sums over a cell do not depend on timing.
// reads  sort_info, lane_starts (its entry `total_at` is the number of pairs), keys_in, places_in
// writes  histogram (digit-major, one column a chunk), keys_out, places_out
// import: dispatch/index.wgsl

@group(0) @binding(0) var<uniform> sort_info: SortInfo;
@group(0) @binding(1) var<storage, read> lane_starts: array<u32>;
@group(0) @binding(2) var<storage, read> keys_in: array<u32>;
@group(0) @binding(3) var<storage, read> places_in: array<u32>;
@group(0) @binding(4) var<storage, read_write> histogram: array<u32>;
@group(0) @binding(5) var<storage, read_write> keys_out: array<u32>;
@group(0) @binding(6) var<storage, read_write> places_out: array<u32>;

const DIGITS: u32 = 256u;

@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let chunk = linear_index(id, groups);
    if chunk >= sort_info.chunks {
        return;
    }
    var counts: array<u32, DIGITS>;
    let end = min(lane_starts[sort_info.total_at], (chunk + 1u) * sort_info.chunk);
    for (var i = chunk * sort_info.chunk; i < end; i += 1u) {
        counts[(keys_in[i] >> sort_info.shift) & (DIGITS - 1u)] += 1u;
    }
    for (var d = 0u; d < DIGITS; d += 1u) {
        histogram[d * sort_info.chunks + chunk] = counts[d];
    }
}

@compute @workgroup_size(64)
fn scatter(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let chunk = linear_index(id, groups);
    if chunk >= sort_info.chunks {
        return;
    }
    var next: array<u32, DIGITS>;
    for (var d = 0u; d < DIGITS; d += 1u) {
        next[d] = histogram[d * sort_info.chunks + chunk];
    }
    let end = min(lane_starts[sort_info.total_at], (chunk + 1u) * sort_info.chunk);
    for (var i = chunk * sort_info.chunk; i < end; i += 1u) {
        let key = keys_in[i];
        let digit = (key >> sort_info.shift) & (DIGITS - 1u);
        let to = next[digit];
        next[digit] = to + 1u;
        keys_out[to] = key;
        places_out[to] = places_in[i];
    }
}
