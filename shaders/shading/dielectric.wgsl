// A smooth interface of two dielectrics: reflection and transmission [E8]. Twin: src/optics/shading/dielectric.rs.
// import: scene/features.wgsl

// Reflectance for unpolarised light; eta = n_transmitted / n_incident; 1 at total reflection.
fn fresnel(cos_i: f32, eta: f32) -> f32 {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = sqrt(1.0 - sin2_t);
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

// Snell: direction d on to a surface with unit normal n toward d's side; eta_it = n_incident / n_transmitted.
// Zero at total reflection.
fn refract_direction(d: vec3<f32>, n: vec3<f32>, eta_it: f32) -> vec3<f32> {
    let cos_i = -dot(d, n);
    let k = 1.0 - eta_it * eta_it * (1.0 - cos_i * cos_i);
    if k <= 0.0 {
        return vec3(0.0);
    }
    return normalize(eta_it * d + (eta_it * cos_i - sqrt(k)) * n);
}

fn is_dielectric(m: PackedMaterial) -> bool {
    return HAS_DIELECTRIC && (m.flag_bits & DIELECTRIC) != 0u;
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
    if !is_dielectric(m) {
        return 0.0;
    }
    let face = fresnel(min(1.0, -dot(direction, n)), select(1.0 / relative_index(m, from_front), m.ior, is_thin(m)));
    return select(face, 2.0 * face / (1.0 + face), is_thin(m));
}

// The direction of transmission: about the geometric normal where the shading normal would lead back. Zero where there is none.
fn transmitted_direction(
    m: PackedMaterial, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, eta_it: f32,
) -> vec3<f32> {
    var d = refract_direction(direction, n, eta_it);
    if HAS_SMOOTH && dot(d, geometric) >= 0.0 {
        d = refract_direction(direction, geometric, eta_it);
    }
    return select(d, direction, is_thin(m));
}
