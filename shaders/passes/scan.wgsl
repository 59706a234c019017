// Scan: exclusive prefix sums, in place, in three steps without barriers (they are dear on software devices): sums of
// blocks, a serial scan of the sums, sums within blocks. Integers: the order does not matter.
// reads  scan_info      reads and writes  values, block_sums
// import: dispatch/index.wgsl

@group(0) @binding(0) var<uniform> scan_info: ScanInfo;
@group(0) @binding(1) var<storage, read_write> values: array<u32>;
@group(0) @binding(2) var<storage, read_write> block_sums: array<u32>;

@compute @workgroup_size(64)
fn reduce(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let block = linear_index(id, groups);
    if block >= scan_info.blocks {
        return;
    }
    let end = min(scan_info.count, (block + 1u) * scan_info.block);
    var sum = 0u;
    for (var i = block * scan_info.block; i < end; i += 1u) {
        sum += values[i];
    }
    block_sums[block] = sum;
}

@compute @workgroup_size(1)
fn spine(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    var sum = 0u;
    linear_index(id, groups);
    for (var i = 0u; i < own(scan_info.blocks); i += 1u) {
        let value = block_sums[i];
        block_sums[i] = sum;
        sum += value;
    }
}

@compute @workgroup_size(64)
fn apply(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let block = linear_index(id, groups);
    if block >= scan_info.blocks {
        return;
    }
    let end = min(scan_info.count, (block + 1u) * scan_info.block);
    var sum = block_sums[block];
    for (var i = block * scan_info.block; i < end; i += 1u) {
        let value = values[i];
        values[i] = sum;
        sum += value;
    }
}
