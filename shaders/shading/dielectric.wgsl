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

// True where the index differs between the bands [E36].
fn is_dispersive(m: PackedMaterial) -> bool {
    return HAS_DISPERSION && (m.flag_bits & DISPERSIVE) != 0u;
}

// True where bands part: what a thin pane transmits is not bent.
fn parts_bands(m: PackedMaterial) -> bool {
    return is_dispersive(m) && !is_thin(m);
}

// The band that u in [0, 1) picks, each in proportion to what of it is transmitted; the first where nothing is.
fn picked_band(transmitted: Bands, u: f32) -> u32 {
    var rest = u * dot(transmitted, Bands(1.0));
    var band = 0u;
    var is_found = false;
    for (var k = 0u; k < BANDS; k += 1u) {
        // never one of which nothing is, whatever rounding says
        if !is_found && transmitted[k] > 0.0 {
            band = k;
            is_found = rest < transmitted[k];
            rest -= transmitted[k];
        }
    }
    return band;
}

// Of an interface, per band; 0 where there is none.
fn dielectric_reflectance(m: PackedMaterial, n: vec3<f32>, direction: vec3<f32>, from_front: bool) -> Bands {
    if !is_dielectric(m) {
        return Bands(0.0);
    }
    let cosine = min(1.0, -dot(direction, n));
    if is_dispersive(m) {
        var reflectance = Bands(0.0);
        var one = m;
        for (var band = 0u; band < BANDS; band += 1u) {
            one.ior = m.iors[band];
            reflectance[band] = reflectance_of_one(one, cosine, from_front);
        }
        return reflectance;
    }
    return Bands(reflectance_of_one(m, cosine, from_front));
}

// By the index `ior`.
fn reflectance_of_one(m: PackedMaterial, cosine: f32, from_front: bool) -> f32 {
    let face = fresnel(cosine, select(1.0 / relative_index(m, from_front), m.ior, is_thin(m)));
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
