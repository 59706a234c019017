// Lanes: invocations that run in step can look at what one of them loaded. Neighbouring pixels look at the same jotons:
// each lane loads one and all test it. lanes_alone.wgsl is the same where the device has no subgroups: one lane.

const NO_INDEX: u32 = 0xffffffffu;

struct Lanes {
    count: u32,
    // Of this invocation.
    index: u32,
}

// Of the lanes that are here together; called where all of a workgroup are.
fn lanes_here() -> Lanes {
    return Lanes(subgroupAdd(1u), subgroupExclusiveAdd(1u));
}

fn lanes_min(x: u32) -> u32 {
    return subgroupMin(x);
}

fn lanes_or(x: u32) -> u32 {
    return subgroupOr(x);
}

fn from_lane(v: vec4<f32>, lane: u32) -> vec4<f32> {
    return subgroupShuffle(v, lane);
}
