// Anisotropy: GGX normals with an α along a way of the surface and another one across it [E56] (Heitz 2014). The way is in the bits of
// a material's `glossy_exponent`, as an angle in the basis of the shading normal where a surface has been met (brushed_way.wgsl).
// no_anisotropy.wgsl stands in place of this where none is brushed. Twin: src/optics/shading/anisotropy.rs.
// import: scene/features.wgsl
// import: sampling/sampling.wgsl

const BRUSH_STRENGTHS: u32 = (1u << BRUSH_STRENGTH_BITS) - 1u;
const BRUSH_ANGLES: u32 = 1u << BRUSH_ANGLE_BITS;

fn is_anisotropic(m: PackedMaterial) -> bool {
    return HAS_ANISOTROPY && (m.flag_bits & ANISOTROPIC) != 0u;
}

fn brush_bits(m: PackedMaterial) -> u32 {
    return bitcast<u32>(m.glossy_exponent);
}

// Of the way, from 0 to below π.
fn brush_angle(m: PackedMaterial) -> f32 {
    return f32((brush_bits(m) >> BRUSH_STRENGTH_BITS) & (BRUSH_ANGLES - 1u)) * (PI / f32(BRUSH_ANGLES));
}

// The material with another way: its code, 0 to BRUSH_ANGLES.
fn with_brush_code(m: PackedMaterial, code: u32) -> PackedMaterial {
    var turned = m;
    let others = brush_bits(m) & ~((BRUSH_ANGLES - 1u) << BRUSH_STRENGTH_BITS);
    turned.glossy_exponent = bitcast<f32>(others | ((code & (BRUSH_ANGLES - 1u)) << BRUSH_STRENGTH_BITS));
    return turned;
}

fn brush_code(m: PackedMaterial) -> u32 {
    return (brush_bits(m) >> BRUSH_STRENGTH_BITS) & (BRUSH_ANGLES - 1u);
}

// The code of an angle in radians.
fn code_of_angle(angle: f32) -> u32 {
    let half_turns = angle / PI;
    return u32((half_turns - floor(half_turns)) * f32(BRUSH_ANGLES) + 0.5);
}

// α along the way and across it.
fn brushed_alphas(m: PackedMaterial) -> vec2<f32> {
    let strength2 = f32(brush_bits(m) & BRUSH_STRENGTHS) / f32(BRUSH_STRENGTHS);
    return vec2(m.alpha + (1.0 - m.alpha) * strength2, m.alpha);
}

// α of even microfacets of the same solid angle.
fn mean_alpha(m: PackedMaterial) -> f32 {
    if !is_anisotropic(m) {
        return m.alpha;
    }
    let alphas = brushed_alphas(m);
    return sqrt(alphas.x * alphas.y);
}

// α of even microfacets that mask as much from each other, of even light.
fn masking_alpha(m: PackedMaterial) -> f32 {
    if !is_anisotropic(m) {
        return m.alpha;
    }
    let alphas = brushed_alphas(m);
    return sqrt(0.5 * dot(alphas, alphas));
}

// Along the way, across it, and the normal.
fn brushed_frame(m: PackedMaterial, n: vec3<f32>) -> mat3x3<f32> {
    let b = basis(n);
    let angle = brush_angle(m);
    let c = cos(angle);
    let s = sin(angle);
    return mat3x3(c * b[0] + s * b[1], c * b[1] - s * b[0], n);
}

// Density of normals, 1/sr.
fn brushed_density(m: PackedMaterial, n: vec3<f32>, h: vec3<f32>) -> f32 {
    let alphas = brushed_alphas(m);
    let local = h * brushed_frame(m, n);
    let flat = vec3(local.xy / alphas, local.z);
    let s = dot(flat, flat);
    return 1.0 / (PI * alphas.x * alphas.y * s * s);
}

// √(cos²θ + (α cosφ sinθ)² + (β sinφ sinθ)²).
fn brushed_slope(m: PackedMaterial, n: vec3<f32>, w: vec3<f32>) -> f32 {
    let local = w * brushed_frame(m, n);
    return length(vec3(brushed_alphas(m) * local.xy, local.z));
}

// What a gather point keeps: the way, roughness and the metallic part, of as many bits as a picture of them has.
const KEPT_ROUGHNESS: f32 = 1023.0;
const KEPT_METALLIC: f32 = 255.0;
const KEPT_METALLIC_SHIFT: u32 = 10u;
const KEPT_ANGLE_SHIFT: u32 = 18u;

fn kept_brush(m: PackedMaterial) -> u32 {
    let roughness = u32(sqrt(m.alpha) * KEPT_ROUGHNESS + 0.5);
    let metallic = u32(clamp(m.metallic, 0.0, 1.0) * KEPT_METALLIC + 0.5);
    return roughness | (metallic << KEPT_METALLIC_SHIFT) | (brush_code(m) << KEPT_ANGLE_SHIFT);
}

// α and the metallic part that it keeps …
fn kept_numbers(kept: u32) -> vec2<f32> {
    let roughness = f32(kept & 1023u) / KEPT_ROUGHNESS;
    return vec2(roughness * roughness, f32((kept >> KEPT_METALLIC_SHIFT) & 255u) / KEPT_METALLIC);
}

// … and the way.
fn with_kept_way(m: PackedMaterial, kept: u32) -> PackedMaterial {
    return with_brush_code(m, kept >> KEPT_ANGLE_SHIFT);
}
