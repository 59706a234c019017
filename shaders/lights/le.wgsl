// Le: emitted radiance along a ray, of the surface that it meets or where it leaves the scene.
// import: shading/bsdf.wgsl

// What the surface that it meets sends back along it: lights shine from their front.
fn le_at(b: Bsdf) -> Bands {
    return select(Bands(0.0), b.material.emission, b.from_front && (b.material.flag_bits & EMISSIVE) != 0u);
}

// What it finds where it leaves the scene. A sun has no extent: no ray meets it.
fn on_miss(direction: vec3<f32>) -> Bands {
    return Bands(0.0);
}
