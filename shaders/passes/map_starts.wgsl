// Map starts: where each bucket begins in the sorted list, by binary search; one entry more than buckets.
// reads  map_info, lane_starts, keys      writes  bucket_starts
// import: dispatch/index.wgsl

@group(0) @binding(0) var<uniform> map_info: MapInfo;
@group(0) @binding(1) var<storage, read> lane_starts: array<u32>;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
@group(0) @binding(3) var<storage, read_write> bucket_starts: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let bucket = linear_index(id, groups);
    if bucket > map_info.row_mask + 1u + map_info.columns {
        return;
    }
    var low = 0u;
    var high = lane_starts[map_info.lanes];
    while low < high {
        let middle = (low + high) / 2u;
        if keys[middle] < bucket {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    bucket_starts[bucket] = low;
}
