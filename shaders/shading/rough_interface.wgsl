// A rough interface of two dielectrics: it reflects and transmits at microfacets [E43] (Walter et al. 2007), and rough panes without
// thickness [E58]. Both lobes are followed.
// Twin: src/optics/shading/rough_interface.rs.
// import: shading/microfacet.wgsl

fn is_rough_interface(m: PackedMaterial) -> bool {
    return HAS_DIELECTRIC && has_facets(m) && is_dielectric(m);
}

// True where light is bent: what goes through a pane is the mirror image, about the sheet, of what facets reflect.
fn is_bent(m: PackedMaterial, transmits: bool) -> bool {
    return transmits && !is_thin(m);
}

// The mirror image of a direction about the plane of a normal.
fn mirrored_in(n: vec3<f32>, w: vec3<f32>) -> vec3<f32> {
    return w - 2.0 * dot(w, n) * n;
}

// The direction in which facets reflect what leaves in w; w itself where light is bent.
fn unfolded(m: PackedMaterial, transmits: bool, n: vec3<f32>, w: vec3<f32>) -> vec3<f32> {
    if transmits && is_thin(m) {
        return mirrored_in(n, w);
    }
    return w;
}

// About what is reflected: by a facet that lies flat, per band; neither way is ever without a share.
fn rough_reflectance(m: PackedMaterial, n: vec3<f32>, direction: vec3<f32>, from_front: bool) -> Bands {
    let flat = dielectric_reflectance(m, n, direction, from_front);
    return clamp(flat, Bands(ROUGH_SHARE_MIN), Bands(1.0 - ROUGH_SHARE_MIN));
}

// Reflectance of a facet, per band.
fn rough_facet(m: PackedMaterial, cos_h: f32, from_front: bool) -> Bands {
    if is_dispersive(m) {
        var reflectance = Bands(0.0);
        var one = m;
        for (var band = 0u; band < BANDS; band += 1u) {
            one.ior = m.iors[band];
            reflectance[band] = reflectance_of_one(one, cos_h, from_front);
        }
        return reflectance;
    }
    return Bands(reflectance_of_one(m, cos_h, from_front));
}

// The normal of the facet that sends light between the ray and w, on the ray's side; w its length before it was made one.
fn rough_facet_normal(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, n: vec3<f32>, from_front: bool, w: vec3<f32>,
) -> vec4<f32> {
    // of refraction tangential parts add up to nothing
    let sum = select(w - direction, direction * relative_index(m, from_front) - w, is_bent(m, transmits));
    let size = max(length(sum), 1e-20);
    let h = sum / size;
    return vec4(select(h, -h, dot(h, n) < 0.0), size);
}

// pdf_solid_angle of rough_sample: the density of the facets that the ray sees over the solid angle that turning one sweeps.
fn rough_pdf(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, n: vec3<f32>, from_front: bool, w: vec3<f32>,
) -> f32 {
    let bent = is_bent(m, transmits);
    let reflected = unfolded(m, transmits, n, w);
    let facet = rough_facet_normal(m, transmits, direction, n, from_front, reflected);
    let h = facet.xyz;
    let cos_o = -dot(direction, n);
    let cos_h = -dot(direction, h);
    let cos_w = dot(reflected, h);
    if cos_o <= 0.0 || cos_h <= 0.0 || (cos_w < 0.0) != bent || (is_thin(m) && (dot(w, n) < 0.0) != transmits) {
        return 0.0;
    }
    let seen = 2.0 * facet_density(m, n, h) / (cos_o + facet_slope(m, n, -direction));
    return seen * select(0.25, cos_h * -cos_w / (facet.w * facet.w), bent);
}

// f cosθ / (share pdf) of a facet's light toward w, the share that of rough_reflectance.
fn rough_carried(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, n: vec3<f32>, from_front: bool, h: vec3<f32>, w: vec3<f32>,
) -> Bands {
    let reflected = rough_facet(m, clamp(-dot(direction, h), 0.0, 1.0), from_front);
    let share = rough_reflectance(m, n, direction, from_front);
    if transmits {
        let seen = select(facet_seen_again(m, n, unfolded(m, transmits, n, w), -direction), facet_seen(m, n, w), is_bent(m, transmits));
        return (1.0 - reflected) / (1.0 - share) * seen;
    }
    return reflected / share * facet_seen_again(m, n, w, -direction);
}

// The same toward w; 0 where that is on the other side.
fn rough_weight(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, n: vec3<f32>, from_front: bool, w: vec3<f32>,
) -> Bands {
    let h = rough_facet_normal(m, transmits, direction, n, from_front, unfolded(m, transmits, n, w)).xyz;
    let cos_w = dot(w, n);
    if (cos_w < 0.0) != transmits {
        return Bands(0.0);
    }
    return rough_carried(m, transmits, direction, n, from_front, h, w);
}

struct RoughSample {
    direction: vec3<f32>,
    // f cosθ / (share pdf), the share that of rough_reflectance.
    weight: Bands,
}

// `direction` arrives; n is on its side.
fn rough_sample(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool, u: vec2<f32>,
) -> RoughSample {
    let h = facet_normal(m, n, -direction, u);
    if transmits {
        var d = mirrored_in(n, normalize(reflect(direction, h)));
        if is_bent(m, transmits) {
            d = refract_direction(direction, h, relative_index(m, from_front));
        }
        let is_across = dot(d, geometric) < 0.0 && dot(d, n) < 0.0;
        let weight = rough_carried(m, transmits, direction, n, from_front, h, d);
        return RoughSample(d, select(Bands(0.0), weight, is_across));
    }
    let d = normalize(reflect(direction, h));
    let is_above = dot(d, geometric) > 0.0 && dot(d, n) > 0.0;
    let weight = rough_carried(m, transmits, direction, n, from_front, h, d);
    return RoughSample(d, select(Bands(0.0), weight, is_above));
}
