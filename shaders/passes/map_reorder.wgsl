// Map reorder: the jotons themselves in the order of their buckets.
// reads  map_info, lane_starts, places, jotons      writes  sorted_jotons
// import: dispatch/index.wgsl

@group(0) @binding(0) var<uniform> map_info: MapInfo;
@group(0) @binding(1) var<storage, read> lane_starts: array<u32>;
@group(0) @binding(2) var<storage, read> places: array<u32>;
@group(0) @binding(3) var<storage, read> jotons: array<Joton>;
@group(0) @binding(4) var<storage, read_write> sorted_jotons: array<Joton>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = linear_index(id, groups);
    if i < lane_starts[map_info.lanes] {
        sorted_jotons[i] = jotons[places[i]];
    }
}
