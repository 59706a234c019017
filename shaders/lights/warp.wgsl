// Warps: learned densities that steer where jotons go [E20]. Twin: src/packed/guide.rs.
// reads  warps

// Of each warp the steps below each row, then below each bin of each row, in 16 bits.
@group(1) @binding(15) var<uniform> warps: array<vec4<u32>, WARPS_VECTORS>;

// Steps of a whole row.
const WARP_STEPS: f32 = 65536.0;
// Numbers in a vector of four words.
const WARP_PACKED: u32 = 8u;

struct Drawn {
    bin: u32,
    // In the unit interval, and the density there.
    place: f32,
    density: f32,
}

struct Warped {
    // In the unit square, and the density there.
    place: vec2<f32>,
    density: f32,
}

// Steps below bin `bin` of list `list` of warp `number` (from 0).
fn warp_below(number: u32, list: u32, bin: u32) -> f32 {
    let i = list * WARP_BINS + bin;
    let word = warps[number * WARP_VECTORS + i / WARP_PACKED][(i % WARP_PACKED) / 2u];
    return f32(select(word & 0xffffu, word >> 16u, (i & 1u) == 1u));
}

fn warp_draw(number: u32, list: u32, u: f32) -> Drawn {
    let x = u * WARP_STEPS;
    // the last bin that begins at or below x
    var bin = 0u;
    for (var half = WARP_BINS / 2u; half > 0u; half /= 2u) {
        bin += select(0u, half, warp_below(number, list, bin + half) <= x);
    }
    let below = warp_below(number, list, bin);
    var upto = WARP_STEPS;
    if bin + 1u < WARP_BINS {
        upto = warp_below(number, list, bin + 1u);
    }
    let width = upto - below;
    let place = min((f32(bin) + (x - below) / width) / f32(WARP_BINS), 0.99999994);
    return Drawn(bin, place, width * (f32(WARP_BINS) / WARP_STEPS));
}

// A place drawn by warp `number`, u uniform.
fn warped(number: u32, u: vec2<f32>) -> Warped {
    let row = warp_draw(number, 0u, u.x);
    let column = warp_draw(number, 1u + row.bin, u.y);
    return Warped(vec2(row.place, column.place), row.density * column.density);
}
