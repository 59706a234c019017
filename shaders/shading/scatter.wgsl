// Scattering at a surface: which normal counts, and where light goes at a specular event.
// import: shading/bsdf.wgsl
// import: shading/surface.wgsl

// The shading normal on the side of -direction; the geometric one where the two disagree about the side.
fn facing_normal(s: Surface, direction: vec3<f32>, geometric: vec3<f32>) -> vec3<f32> {
    if !HAS_SMOOTH || !s.is_smooth {
        return geometric;
    }
    let n = select(-s.shading, s.shading, dot(s.front, geometric) > 0.0);
    return select(geometric, n, dot(direction, n) < 0.0);
}

// A pane without thickness: both faces of a dielectric in one place [E26].
fn is_thin(m: PackedMaterial) -> bool {
    return (m.flag_bits & THIN) != 0u;
}

// n_incident / n_transmitted; behind a thin pane is what is before it.
fn relative_index(m: PackedMaterial, from_front: bool) -> f32 {
    return select(select(m.ior, 1.0 / m.ior, from_front), 1.0, is_thin(m));
}

fn dielectric_reflectance(m: PackedMaterial, n: vec3<f32>, direction: vec3<f32>, from_front: bool) -> f32 {
    if !HAS_DIELECTRIC || (m.flag_bits & DIELECTRIC) == 0u {
        return 0.0;
    }
    let face = fresnel(min(1.0, -dot(direction, n)), select(1.0 / relative_index(m, from_front), m.ior, is_thin(m)));
    return select(face, 2.0 * face / (1.0 + face), is_thin(m));
}

struct Specular {
    direction: vec3<f32>,
    eta_it: f32,
    alive: bool,
}

// The direction after a specular event; `direction` arrives, both normals are on its side. Where a shading normal would
// send a reflection below the surface, or a transmission above it, the geometric one decides.
fn specular_scatter(
    m: PackedMaterial, event: u32, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool,
    u: vec2<f32>,
) -> Specular {
    let eta_it = relative_index(m, from_front);
    if HAS_DIELECTRIC && event == EVENT_TRANSMIT {
        var d = refract_direction(direction, n, eta_it);
        if HAS_SMOOTH && dot(d, geometric) >= 0.0 {
            d = refract_direction(direction, geometric, eta_it);
        }
        d = select(d, direction, is_thin(m));
        return Specular(d, eta_it, any(d != vec3(0.0)));
    }
    var d = normalize(reflect(direction, n));
    if HAS_SMOOTH && dot(d, geometric) <= 0.0 {
        d = normalize(reflect(direction, geometric));
    }
    if HAS_SPECULAR && event == EVENT_MIRROR && m.specular_exponent > 0.0 {
        d = normalize(basis(d) * sample_phong_lobe(u, m.specular_exponent));
        return Specular(d, 1.0, dot(d, geometric) > 0.0);
    }
    return Specular(d, 1.0, true);
}

// Reflectance or transmittance of an event, per band.
fn event_reflectance(m: PackedMaterial, event: u32, reflectance: f32) -> Bands {
    switch event {
        case EVENT_DIFFUSE: { return m.diffuse; }
        case EVENT_GLOSSY: { return m.glossy; }
        case EVENT_MIRROR: { return m.specular; }
        case EVENT_REFLECT: { return m.specular * reflectance; }
        default: { return m.transmission * (1.0 - reflectance); }
    }
}

fn event_chance(c: EventProbabilities, event: u32) -> f32 {
    switch event {
        case EVENT_DIFFUSE: { return c.diffuse; }
        case EVENT_GLOSSY: { return c.glossy; }
        case EVENT_MIRROR: { return c.mirror; }
        case EVENT_REFLECT: { return c.reflect; }
        default: { return c.transmit; }
    }
}
