// Lanes where the device has no subgroups: each invocation is alone. See lanes.wgsl.

const NO_INDEX: u32 = 0xffffffffu;

struct Lanes {
    count: u32,
    index: u32,
}

fn lanes_here() -> Lanes {
    return Lanes(1u, 0u);
}

fn lanes_min(x: u32) -> u32 {
    return x;
}

fn lanes_or(x: u32) -> u32 {
    return x;
}

fn from_lane(v: vec4<f32>, lane: u32) -> vec4<f32> {
    return v;
}
