// Map keys: the grid bucket of every stored joton, gathered from the lanes' regions into one dense list.
// reads  map_info, lanes, lane_starts, jotons      writes  keys, places (slot of each joton), status
// import: dispatch/index.wgsl
// import: maps/grid.wgsl
// import: paths/path_state.wgsl

@group(0) @binding(0) var<uniform> map_info: MapInfo;
@group(0) @binding(1) var<storage, read> lanes: array<PathState>;
@group(0) @binding(2) var<storage, read> lane_starts: array<u32>;
@group(0) @binding(3) var<storage, read> jotons: array<Joton>;
@group(0) @binding(4) var<storage, read_write> keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> places: array<u32>;
@group(0) @binding(6) var<storage, read_write> status: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let lane = linear_index(id, groups);
    if lane >= map_info.lanes {
        return;
    }
    if (lanes[lane].status & LANE_DONE) == 0u {
        atomicAdd(&status[STATUS_UNFINISHED], 1u);
    }
    if (lanes[lane].status & LANE_CUT) != 0u {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
    if lanes[lane].stored > map_info.lane_capacity {
        atomicMax(&status[STATUS_LANE_STORED_MAX], lanes[lane].stored);
    }
    let stored = min(lanes[lane].stored, map_info.lane_capacity);
    let start = lane_starts[lane];
    var done = 0u;
    for (var i = 0u; i < stored; i += 1u) {
        let place = lane * map_info.lane_capacity + i;
        let cell = cell_of(jotons[place].position, map_info.grid_origin, map_info.cells_per_unit);
        keys[start + i] = row_bucket(cell.y, cell.z, map_info.row_mask) + column(cell.x, map_info.columns);
        places[start + i] = place;
        done = i + 1u;
    }
    if done != stored {
        atomicAdd(&status[STATUS_LOOP_CUT], 1u);
    }
}
