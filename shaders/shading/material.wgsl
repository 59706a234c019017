// The material at a place. Today it is constant over a surface; what varies over one is looked up here.
// Twin: src/optics/shading/material.rs.
// import: scene/scene.wgsl
// reads  scene

fn resolved_material(index: u32) -> PackedMaterial {
    return material_at(index);
}

// Of the surface that a gather point lies on.
fn material_of_point(point: GatherPoint) -> PackedMaterial {
    return resolved_material(point.surface & MATERIAL_MASK);
}
