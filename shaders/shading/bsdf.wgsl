// The BSDF at a hit: kernels that follow rays ask it. Gather points ask lobes.wgsl. Twin: src/optics/shading/bsdf.rs.
// import: shading/surface.wgsl
// import: shading/material.wgsl
// import: shading/relief.wgsl
// import: shading/brushed_way.wgsl
// import: shading/lobes.wgsl
// import: shading/media.wgsl
// import: shading/mixture.wgsl

struct Bsdf {
    material: PackedMaterial,
    // Unit, along the ray.
    direction: vec3<f32>,
    from_front: bool,
    // Unit normals on the ray's side.
    geometric: vec3<f32>,
    shading: vec3<f32>,
    at: AtAngle,
    // Factor on what is transmitted: one, but where bands part [E36].
    parted: Bands,
    // The bodies before the surface and beyond it [E44].
    before: u32,
    beyond: u32,
    // Number of the material.
    number: u32,
}

// To who comes in these bodies, and sees so wide a part of the surface at once, internal units; 0 sees textures as fine as they are.
fn bsdf_at(s: Surface, direction: vec3<f32>, width: f32, inside: u32) -> Bsdf {
    let from_front = dot(direction, s.front) < 0.0;
    let met = met_at(s, direction, from_front, inside);
    var m = resolved_material(met.material, s.texture.uv, width * s.texture.per_unit, met.glass);
    let geometric = s.front * select(-1.0, 1.0, from_front);
    var shading = facing_normal(s, direction, geometric);
    if has_relief(m) {
        shading = relief_normal(m, s, direction, width * s.texture.per_unit);
    }
    if is_anisotropic(m) {
        // as a gather point has it, of whose basis the angle is
        shading = decode_direction(encode_direction(shading));
        m = brushed_at(m, s, shading);
    }
    let before = inside_before(inside, m, from_front);
    let beyond = inside_beyond(before, m, from_front);
    m = boundary_between(m, from_front, before, beyond);
    let at = at_angle(m, shading, direction, from_front);
    return Bsdf(m, direction, from_front, geometric, shading, at, Bands(1.0), before, beyond, met.material);
}

// The bodies in which light is that left by a lobe.
fn inside_after(b: Bsdf, lobe: u32) -> u32 {
    return select(b.before, b.beyond, lobe == LOBE_TRANSMISSION);
}

// Where bands part, one of them is transmitted, picked by what of each would be: p = c / Σc [E36]. u in [0, 1), one number for a path:
// from then on there is one band to pick.
fn with_band(b: Bsdf, carried: Bands, u: f32) -> Bsdf {
    var picked = b;
    if !parts_bands(b.material) {
        return picked;
    }
    let transmitted = carried * lobe_albedo(b.material, LOBE_TRANSMISSION, b.at);
    let band = picked_band(transmitted, u);
    picked.material.ior = b.material.iors[band];
    picked.parted = Bands(0.0);
    picked.parted[band] = select(0.0, dot(transmitted, Bands(1.0)) / transmitted[band], transmitted[band] > 0.0);
    return picked;
}

// The shading normal on the side of -direction; the geometric one where the two disagree about the side.
fn facing_normal(s: Surface, direction: vec3<f32>, geometric: vec3<f32>) -> vec3<f32> {
    if !HAS_SMOOTH || !s.is_smooth {
        return geometric;
    }
    let n = select(-s.shading, s.shading, dot(s.front, geometric) > 0.0);
    return select(geometric, n, dot(direction, n) < 0.0);
}

// Part of the flux that takes each lobe.
fn weights_at(b: Bsdf, carried: Bands) -> LobeWeights {
    return lobe_weights(b.material, carried, b.at);
}

// The same for Russian roulette, as probabilities.
fn roulette_at(b: Bsdf, carried: Bands, events: u32) -> LobeWeights {
    return roulette(weights_at(b, carried), events);
}

fn albedo_at(b: Bsdf, lobe: u32) -> Bands {
    let albedo = lobe_albedo(b.material, lobe, b.at);
    if HAS_DISPERSION && lobe == LOBE_TRANSMISSION {
        return albedo * b.parted;
    }
    return albedo;
}

fn sample_at(b: Bsdf, lobe: u32, u: vec2<f32>) -> LobeSample {
    return sample_lobe(b.material, lobe, b.direction, b.geometric, b.shading, b.from_front, u);
}

// True where a joton leaves by sample_off_relief.
fn is_off_relief(b: Bsdf, lobe: u32) -> bool {
    return has_relief(b.material) && (lobe == LOBE_DIFFUSE || (HAS_TRANSLUCENT && lobe == LOBE_TRANSLUCENT));
}

// A joton leaves what is diffuse about the geometric normal, since eyes see it from all sides: the adjoint is in the weight [E48].
fn sample_off_relief(b: Bsdf, lobe: u32, u: vec2<f32>) -> LobeSample {
    if HAS_TRANSLUCENT && lobe == LOBE_TRANSLUCENT {
        return weighed(translucent_sample(b.geometric, u), 1.0, 1.0);
    }
    let d = lambert_sample(b.geometric, u);
    var weight = 1.0;
    if is_coated(b.material) {
        weight = undercoat_weight(b.material, dot(d, turned_toward(b.shading, d)));
    }
    if is_layered(b.material) {
        weight *= under_layers_weight(b.material, dot(d, turned_toward(b.shading, d)), -dot(b.direction, b.shading));
    }
    return weighed(d, weight, 1.0);
}

// Of a delta lobe: nothing else is compiled.
fn sample_delta_at(b: Bsdf, lobe: u32, u: vec2<f32>) -> LobeSample {
    return sample_delta(b.material, lobe, b.direction, b.geometric, b.shading, b.from_front, u);
}
