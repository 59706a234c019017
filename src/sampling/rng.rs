//! Random numbers, addressed and not streamed: random(seed, pass, path, dimension). Twin: shaders/sampling/rng.wgsl.
//!
//! Two kinds: hashed (pcg4d, Jarzynski & Olano 2020) where any number will do, and the first two dimensions of Sobol's
//! sequence with Owen's scrambling (hash-based: Laine & Karras 2011, constants by Vegdahl 2021; shuffled and padded in
//! pairs: Burley 2020) where even coverage pays.

/// pcg4d: four well mixed words from four.
pub fn pcg4d(mut v: [u32; 4]) -> [u32; 4] {
    for x in &mut v {
        *x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    }
    let cross = |v: &mut [u32; 4]| {
        v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
        v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
        v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
        v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
    };
    cross(&mut v);
    for x in &mut v {
        *x ^= *x >> 16;
    }
    cross(&mut v);
    v
}

/// A number in [0, 1): the top 24 bits, so that rounding never gives 1.
pub fn unit(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Four numbers in [0, 1) at an address.
pub fn random4(seed: u32, pass: u32, path: u32, dimension: u32) -> [f32; 4] {
    pcg4d([path, dimension, pass, seed]).map(unit)
}

/// Number `index` of a sequence in [0, 1) that any part of is even: multiples of the golden ratio from a random start.
pub fn golden(index: u32, seed: u32) -> f32 {
    unit(seed.wrapping_add(index.wrapping_mul(0x9e37_79b9)))
}

/// A seed for one scrambled sequence: different for each stream (kernel and purpose) and path.
pub fn sequence_seed(seed: u32, path: u32, stream: u32) -> u32 {
    pcg4d([path, stream, 0x9e37_79b9, seed])[3]
}

/// The seed of indices with this high word, one to one; its own for 0. A sequence has 2^32 points: another one goes on behind
/// them. What seeds a sequence is mixed well by [`pcg4d`], so a product with an odd number is enough here.
pub fn seed_at(seed: u32, high: u32) -> u32 {
    seed ^ high.wrapping_mul(0x9e37_79b1)
}

/// Point `index` of a path's sequence for a purpose: none comes again before 2^64.
pub fn sequence2(index: u64, seed: u32, path: u32, stream: u32) -> [f32; 2] {
    let seed = seed_at(seed, (index >> 32) as u32);
    sobol2(index as u32, sequence_seed(seed, path, stream))
}

/// Owen's nested uniform scrambling of the bits of x, by hash.
pub fn owen(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// Second dimension of Sobol's sequence; the first is the reversed index. The generator matrix is Pascal's triangle
/// modulo 2, applied in five steps instead of a loop over bits.
pub fn sobol_second(index: u32) -> u32 {
    let mut v = index.reverse_bits();
    v ^= v << 16;
    v ^= (v & 0x00ff_00ff) << 8;
    v ^= (v & 0x0f0f_0f0f) << 4;
    v ^= (v & 0x3333_3333) << 2;
    v ^= (v & 0x5555_5555) << 1;
    v
}

/// Point `index` of a scrambled, shuffled Sobol pair.
pub fn sobol2(index: u32, seed: u32) -> [f32; 2] {
    let shuffled = owen(index, seed);
    let seeds = pcg4d([seed, 1, 2, 3]);
    [unit(owen(shuffled.reverse_bits(), seeds[0])), unit(owen(sobol_second(shuffled), seeds[1]))]
}

/// Purposes of what is found out before the first pass, and of what both backends have on the host. The kernels' are in
/// shaders/sampling/rng.wgsl, the CPU backend's in src/backend/cpu/streams.rs: no two that meet in one render are alike.
pub mod purpose {
    /// Place in the image of a path that looks where the camera looks.
    pub const STREAM_SEEN: u32 = 0x200;
    /// Where paths that are counted start: from the camera, caustic, diffuse jotons.
    pub const STREAM_TRAFFIC: [u32; 3] = [0x203, 0x205, 0x207];
    /// Emitter and start place of a joton that is learned from, caustic and diffuse; one sequence a lamp.
    pub const STREAM_LEARN_PLACE: [u32; 2] = [0x210, 0x211];
    /// Its direction.
    pub const STREAM_LEARN_DIRECTION: [u32; 2] = [0x220, 0x221];
    /// Where jotons that look for small images of lamps start, and their directions; one sequence a lamp.
    pub const STREAM_LAMP_IMAGES_PLACE: u32 = 0x230;
    /// See [`STREAM_LAMP_IMAGES_PLACE`].
    pub const STREAM_LAMP_IMAGES_DIRECTION: u32 = 0x231;
    /// The device's area points, one scatter a group of passes.
    pub const STREAM_AREA: u32 = 0x100;
    /// Place in the pixel of a path that looks what the pixel shows.
    pub const STREAM_PATCH: u32 = 0x240;
    /// First direction of a path that tells how noisy paths are.
    pub const STREAM_TECHNIQUE: u32 = 0x250;
    /// The pass in which a pixel has its tree.
    pub const STREAM_TURN: u32 = 0x7475_726e;

    /// Events of a path that looks where the camera looks.
    pub const DIMENSION_SEEN: u32 = 0x10_0000;
    /// Events of a joton that is learned from, caustic and diffuse; by lamp.
    pub const DIMENSION_LEARN: [u32; 2] = [0x11_0000, 0x12_0000];
    /// Lamps that are tried at a place.
    pub const DIMENSION_PICKS: u32 = 0x13_0000;
    /// Events of a path that is counted, by its kind.
    pub const DIMENSION_TRAFFIC: u32 = 0x14_0000;
    /// Places of area points.
    pub const DIMENSION_AREA: u32 = 0x15_0000;
    /// Whether backs are the insides of bodies.
    pub const DIMENSION_TRUST: u32 = 0x16_0000;
    /// Whether an area point is inside of a body.
    pub const DIMENSION_BURIED: u32 = 0x17_0000;
    /// Events of a joton that looks for small images of lamps, by lamp.
    pub const DIMENSION_LAMP_IMAGES: u32 = 0x18_0000;
    /// How its start is changed.
    pub const DIMENSION_LAMP_CHANGES: u32 = 0x19_0000;
    /// Events of a path that looks what a pixel shows.
    pub const DIMENSION_PATCH: u32 = 0x1a_0000;
    /// Events of a path that tells how noisy paths are.
    pub const DIMENSION_TECHNIQUE: u32 = 0x1b_0000;

    /// All streams.
    pub const STREAMS: [u32; 14] = [
        STREAM_TECHNIQUE,
        STREAM_PATCH,
        STREAM_SEEN,
        STREAM_TRAFFIC[0],
        STREAM_TRAFFIC[1],
        STREAM_TRAFFIC[2],
        STREAM_LEARN_PLACE[0],
        STREAM_LEARN_PLACE[1],
        STREAM_LEARN_DIRECTION[0],
        STREAM_LEARN_DIRECTION[1],
        STREAM_LAMP_IMAGES_PLACE,
        STREAM_LAMP_IMAGES_DIRECTION,
        STREAM_AREA,
        STREAM_TURN,
    ];
    /// All first dimensions.
    pub const DIMENSIONS: [u32; 12] = [
        DIMENSION_TECHNIQUE,
        DIMENSION_PATCH,
        DIMENSION_SEEN,
        DIMENSION_LEARN[0],
        DIMENSION_LEARN[1],
        DIMENSION_PICKS,
        DIMENSION_TRAFFIC,
        DIMENSION_AREA,
        DIMENSION_TRUST,
        DIMENSION_BURIED,
        DIMENSION_LAMP_IMAGES,
        DIMENSION_LAMP_CHANGES,
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference: Sobol's second dimension by its direction numbers (primitive polynomial x + 1, all m = 1, 3, 5, 15 …).
    fn sobol_by_directions(index: u32) -> u32 {
        let mut v = [0u32; 32];
        v[0] = 1 << 31;
        for i in 1..32 {
            v[i] = v[i - 1] ^ (v[i - 1] >> 1);
        }
        (0..32).filter(|b| index >> b & 1 == 1).fold(0, |x, b| x ^ v[b as usize])
    }

    #[test]
    fn second_dimension_is_sobols() {
        for i in (0..5000).chain([u32::MAX, 1 << 31, 0xdead_beef]) {
            assert_eq!(sobol_second(i), sobol_by_directions(i), "index {i}");
        }
    }

    /// Every elementary interval of area 2^-10 holds exactly one of the first 1024 points, whatever the scrambling.
    #[test]
    fn scrambled_pairs_are_nets() {
        for seed in [0, 1, 77, 0xffff_ffff] {
            for start in [0u32, 1024, 7 * 1024] {
                for split in 0..=10 {
                    let mut seen = vec![false; 1024];
                    for i in start..start + 1024 {
                        let [x, y] = sobol2(i, seed);
                        let cell = ((x * (1 << split) as f32) as usize) << (10 - split)
                            | (y * (1 << (10 - split)) as f32) as usize;
                        assert!(!std::mem::replace(&mut seen[cell], true), "seed {seed} split {split}");
                    }
                }
            }
        }
    }

    #[test]
    fn unit_is_never_one() {
        assert!(unit(u32::MAX) < 1.0);
        assert_eq!(unit(0), 0.0);
    }

    #[test]
    fn neighbouring_addresses_do_not_correlate() {
        let n = 20_000;
        for (name, a, b) in [("pass", [0, 1, 0], [0, 0, 0]), ("path", [0, 0, 1], [0, 0, 0])] {
            let r: f64 = (0..n)
                .map(|i| {
                    let at = |o: [u32; 3]| f64::from(random4(7, o[1] + 5 * i, o[2] + 3 * i, 2)[0]) - 0.5;
                    at(a) * at(b) * 12.0
                })
                .sum::<f64>()
                / f64::from(n);
            assert!(r.abs() < 5.0 / f64::from(n).sqrt(), "{name}: correlation {r}");
        }
    }
}
