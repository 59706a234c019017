// Mappings from the unit square to directions and places. Twin: src/sampling/distributions.rs.

const PI: f32 = 3.14159265358979;
const TAU: f32 = 6.28318530717959;

// cos 2πu and sin 2πu for u in [0, 1), to 2e-7 on every device: Vulkan grants its own sines an error of 2^-11. The nearest
// quarter of the circle, and by polynomials what is left of u, which is exact.
fn unit_circle(u: f32) -> vec2<f32> {
    let quarter = floor(4.0 * u + 0.5);
    let t = u - 0.25 * quarter;
    let z = t * t;
    let a = CIRCLE_SINE;
    let b = CIRCLE_COSINE;
    let sine = t * (a.x + z * (a.y + z * (a.z + z * a.w)));
    let cosine = 1.0 + z * (b.x + z * (b.y + z * (b.z + z * b.w)));
    let quarters = u32(quarter);
    let p = select(vec2(cosine, sine), vec2(-sine, cosine), (quarters & 1u) != 0u);
    return select(p, -p, (quarters & 2u) != 0u);
}

// An orthonormal frame with z = n (Duff et al. 2017): columns x, y, n.
fn basis(n: vec3<f32>) -> mat3x3<f32> {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return mat3x3(
        vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3(b, s + n.y * n.y * a, -n.y),
        n,
    );
}

// pdf_solid_angle = cosθ / π.
fn sample_cosine_hemisphere(u: vec2<f32>) -> vec3<f32> {
    let r = sqrt(u.x);
    return vec3(r * unit_circle(u.y), sqrt(max(0.0, 1.0 - u.x)));
}

// Barycentric weights of the second and third vertex; uniform by area.
fn sample_triangle(u: vec2<f32>) -> vec2<f32> {
    let s = sqrt(u.x);
    return vec2(1.0 - s, u.y * s);
}

// pdf_solid_angle = 1 / (2π (1 − cos_max)). The sine is computed without cancellation: narrow cones keep their digits.
fn sample_cone(u: vec2<f32>, one_minus_cos_max: f32) -> vec3<f32> {
    let one_minus_z = u.x * one_minus_cos_max;
    let r = sqrt(max(0.0, one_minus_z * (2.0 - one_minus_z)));
    return vec3(r * unit_circle(u.y), 1.0 - one_minus_z);
}

fn sample_disc(u: vec2<f32>) -> vec2<f32> {
    return sqrt(u.x) * unit_circle(u.y);
}

// ln(1 − s), s in [0, 1], by 2 artanh x: Vulkan grants its own logarithm an absolute error of 2^-21 near one, which a
// large exponent would multiply.
fn log_one_minus(s: f32) -> f32 {
    let x = s / (2.0 - s);
    let x2 = x * x;
    let series = 1.0 + x2 * (1.0 / 3.0 + x2 * (1.0 / 5.0 + x2 * (1.0 / 7.0 + x2 * (1.0 / 9.0 + x2 / 11.0))));
    return select(log(max(1.0 - s, 1e-37)), -2.0 * x * series, s < 0.5);
}

// 1 − exp(x), x <= 0.
fn one_minus_exp(x: f32) -> f32 {
    let series = 1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0 * (1.0 + x / 6.0 * (1.0 + x / 7.0)))));
    return select(1.0 - exp(x), -x * series, x > -0.5);
}

// pdf_solid_angle = (e+1)/(2π) cosθ^e.
fn sample_phong_lobe(u: vec2<f32>, exponent: f32) -> vec3<f32> {
    let one_minus_z = select(1.0, one_minus_exp(log_one_minus(1.0 - u.x) / (exponent + 1.0)), u.x > 0.0);
    let r = sqrt(max(0.0, one_minus_z * (2.0 - one_minus_z)));
    return vec3(r * unit_circle(u.y), 1.0 - one_minus_z);
}

// Unit vectors in 32 bits (octahedral map: Meyer et al. 2010).
fn octahedral(n: vec3<f32>) -> vec2<f32> {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return select(p, folded, n.z < 0.0);
}

fn from_octahedral(e: vec2<f32>) -> vec3<f32> {
    var n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    let t = max(-n.z, 0.0);
    n.x += select(t, -t, n.x >= 0.0);
    n.y += select(t, -t, n.y >= 0.0);
    return normalize(n);
}

fn encode_direction(n: vec3<f32>) -> u32 {
    return pack2x16snorm(octahedral(n));
}

fn decode_direction(e: u32) -> vec3<f32> {
    return from_octahedral(unpack2x16snorm(e));
}

// A unit vector in 24 bits, signed 8 a component: coarse, but read without a square root. Tests only.
fn encode_normal24(n: vec3<f32>) -> u32 {
    let e = vec3<u32>(vec3<i32>(round(n * 127.0))) & vec3(0xffu);
    return e.x | (e.y << 8u) | (e.z << 16u);
}

// 127 times the vector.
fn decode_normal24(e: u32) -> vec3<f32> {
    return vec3<f32>(vec3<i32>(vec3(e << 24u, e << 16u, e << 8u)) >> vec3(24u));
}
