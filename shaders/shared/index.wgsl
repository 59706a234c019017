// Dispatches over 65,535 workgroups are folded into two dimensions; workgroups have 64 invocations.

const WORKGROUP: u32 = 64u;

fn linear_index(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.y * groups.x * WORKGROUP + id.x;
}
