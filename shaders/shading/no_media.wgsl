// Where no body's inside matters: in place of media.wgsl. See no_facets.wgsl.
// import: scene/scene.wgsl

const AFAR: f32 = 1e30;

fn inside_of_camera() -> u32 {
    return 0u;
}

fn inside_of_emitter(number: u32) -> u32 {
    return 0u;
}

fn inside_before(inside: u32, m: PackedMaterial, from_front: bool) -> u32 {
    return inside;
}

fn inside_beyond(before: u32, m: PackedMaterial, from_front: bool) -> u32 {
    return before;
}

fn is_no_boundary(m: PackedMaterial, before: u32, beyond: u32) -> bool {
    return false;
}

fn boundary_between(m: PackedMaterial, from_front: bool, before: u32, beyond: u32) -> PackedMaterial {
    return m;
}

fn transmittance(inside: u32, distance: f32) -> Bands {
    return Bands(1.0);
}
