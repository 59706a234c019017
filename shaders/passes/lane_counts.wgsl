// Lane counts: how many jotons each lane has stored, as input of the scan that makes the lists dense.
// reads  map_info, lanes      writes  lane_starts
// import: dispatch/index.wgsl

@group(0) @binding(0) var<uniform> map_info: MapInfo;
@group(0) @binding(1) var<storage, read> lanes: array<PathState>;
@group(0) @binding(2) var<storage, read_write> lane_starts: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let lane = linear_index(id, groups);
    // one entry more than lanes: after the scan it is the number of jotons
    if lane < map_info.lanes {
        lane_starts[lane] = min(lanes[lane].stored, map_info.lane_capacity);
    } else if lane == map_info.lanes {
        lane_starts[lane] = 0u;
    }
}
