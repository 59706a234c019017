// Random numbers by address: random(seed, pass, path, dimension). Twin: src/sampling/rng.rs.
// pcg4d: Jarzynski & Olano 2020. Owen scrambling by hash: Laine & Karras 2011, constants by Vegdahl 2021; Burley 2020.

fn pcg4d(input: vec4<u32>) -> vec4<u32> {
    var v = input * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> vec4<u32>(16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// A number in [0, 1): the top 24 bits, so that rounding never gives 1.
fn unit(x: u32) -> f32 {
    return f32(x >> 8u) * (1.0 / 16777216.0);
}

fn random4(seed: u32, pass_index: u32, path: u32, dimension: u32) -> vec4<f32> {
    let r = pcg4d(vec4(path, dimension, pass_index, seed));
    return vec4(unit(r.x), unit(r.y), unit(r.z), unit(r.w));
}

// A seed for one scrambled sequence: different for each stream (kernel and purpose) and path.
fn sequence_seed(seed: u32, path: u32, stream: u32) -> u32 {
    return pcg4d(vec4(path, stream, 0x9e3779b9u, seed)).w;
}

// The seed of indices with this high word, one to one; its own for 0. A sequence has 2^32 points: another one goes on behind
// them. What seeds a sequence is mixed well by pcg4d, so a product with an odd number is enough here.
fn seed_at(seed: u32, high: u32) -> u32 {
    return seed ^ (high * 0x9e3779b1u);
}

// Number `index` of a sequence in [0, 1) that any part of is even: multiples of the golden ratio from a random start.
fn golden(index: u32, seed: u32) -> f32 {
    return unit(seed + index * 0x9e3779b9u);
}

// The sum in 64 bits, the low word first.
fn wide_sum(a: vec2<u32>, b: u32) -> vec2<u32> {
    let low = a.x + b;
    return vec2(low, a.y + select(0u, 1u, low < b));
}

// The product in 64 bits, the low word first; b is less than 2^16.
fn wide_product(a: u32, b: u32) -> vec2<u32> {
    let low = (a & 0xffffu) * b;
    let high = (a >> 16u) * b + (low >> 16u);
    return vec2((high << 16u) | (low & 0xffffu), high >> 16u);
}

fn owen(input: u32, seed: u32) -> u32 {
    var x = reverseBits(input);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

// Second dimension of Sobol's sequence: Pascal's triangle modulo 2, in five steps.
fn sobol_second(index: u32) -> u32 {
    var v = reverseBits(index);
    v ^= v << 16u;
    v ^= (v & 0x00ff00ffu) << 8u;
    v ^= (v & 0x0f0f0f0fu) << 4u;
    v ^= (v & 0x33333333u) << 2u;
    v ^= (v & 0x55555555u) << 1u;
    return v;
}

// Point `index` of a scrambled, shuffled Sobol pair.
fn sobol2(index: u32, seed: u32) -> vec2<f32> {
    return sobol_point(index, sobol_seeds(seed));
}

// What shuffles the points of a pair of a seed, and what scrambles each of its dimensions.
fn sobol_seeds(seed: u32) -> vec3<u32> {
    return vec3(seed, pcg4d(vec4(seed, 1u, 2u, 3u)).xy);
}

// Point `index` of the pair with these seeds: for whom takes many points of one.
fn sobol_point(index: u32, seeds: vec3<u32>) -> vec2<f32> {
    let shuffled = owen(index, seeds.x);
    return vec2(unit(owen(reverseBits(shuffled), seeds.y)), unit(owen(sobol_second(shuffled), seeds.z)));
}

// Streams of low-discrepancy pairs.
const STREAM_JITTER: u32 = 0u;
const STREAM_LIGHT: u32 = 1u;
const STREAM_CAUSTIC_PLACE: u32 = 2u;
const STREAM_CAUSTIC_DIRECTION: u32 = 3u;
const STREAM_DIFFUSE_PLACE: u32 = 4u;
const STREAM_DIFFUSE_DIRECTION: u32 = 5u;
const STREAM_CHOICE: u32 = 6u;
const STREAM_GLINT_JITTER: u32 = 7u;
// First direction of the paths that go on, and light at their first surface: one sequence a tile of pixels. Light at
// later ones: one a pixel, the number of the event as the high word of the index.
const STREAM_INDIRECT: u32 = 8u;
const STREAM_INDIRECT_LIGHT: u32 = 9u;
const STREAM_INDIRECT_LATER_LIGHT: u32 = 10u;
// The band that a path is transmitted in, one number a path.
const STREAM_EYE_BAND: u32 = 11u;
const STREAM_GLINT_BAND: u32 = 12u;
const STREAM_INDIRECT_BAND: u32 = 13u;
const STREAM_CAUSTIC_BAND: u32 = 14u;
const STREAM_DIFFUSE_BAND: u32 = 15u;
// A shadow ray at a vertex whose lobe is followed: one a pixel, the number of the event as the high word of the index.
const STREAM_FOLLOWED_LIGHT: u32 = 16u;
// Dimensions of hashed numbers: one for each event of a path, in a range for each kind of path.
const DIMENSION_EYE: u32 = 0u;
const DIMENSION_DIRECT: u32 = 0x10000u;
const DIMENSION_CAUSTIC: u32 = 0x20000u;
const DIMENSION_DIFFUSE: u32 = 0x30000u;
const DIMENSION_GLINT: u32 = 0x40000u;
const DIMENSION_UNSEEN: u32 = 0x50000u;
const DIMENSION_GLINT_ALONE: u32 = 0x60000u;
// Three for each event.
const DIMENSION_INDIRECT: u32 = 0x70000u;
const DIMENSION_FOLLOWED: u32 = 0x80000u;
