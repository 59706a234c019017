//! Constants that both sides share: written once, here, and rendered to WGSL by `wgsl.rs`.

/// Pixels across and down a workgroup's tile.
pub use crate::film::tile_schedule::TILE;

/// A value as WGSL writes it.
pub(super) enum Value {
    Unsigned(u32),
    Float(f32),
}

impl From<u32> for Value {
    fn from(value: u32) -> Self {
        Self::Unsigned(value)
    }
}

impl From<f32> for Value {
    fn from(value: f32) -> Self {
        Self::Float(value)
    }
}

/// Declare constants, and list them for the kernels.
macro_rules! shared_constants {
    ($($(#[$meta:meta])* pub const $name:ident: $ty:ty = $value:expr;)*) => {
        $($(#[$meta])* pub const $name: $ty = $value;)*

        /// Name and value of each constant that kernels may use.
        pub(super) fn shared() -> Vec<(&'static str, Value)> {
            vec![$((stringify!($name), Value::from($name)),)*]
        }
    };
}

/// Part of the light at cosine c that facets of GGX's α mask from each other: Σ c^(j/2) Σ K_ji α^(i/2), fitted from below to within .037
/// where both are at least .02 \[E41\].
pub const GGX_LOST: [[f32; 4]; 5] = [
    [0.8606, -6.4272, 12.0758, -6.6415],
    [-6.1439, 55.2063, -112.1168, 64.6598],
    [12.7017, -135.0473, 297.2886, -176.8362],
    [-9.7094, 124.7987, -294.3525, 181.0847],
    [2.3882, -39.6202, 99.6388, -63.1171],
];

/// Part of the light at cosine c that Charlie's sheen of roughness r sends on: Σ c^(j/2) Σ K_ji r^i, fitted from above to within
/// .018 where r is at least .3, by scripts/sheen.py \[E51\].
pub const SHEEN_ALBEDO: [[f32; 4]; 7] = [
    [1.6629, -4.7384, 7.0855, -3.2298],
    [6.6262, -16.1967, 29.0988, -15.4936],
    [-73.7440, 206.4262, -329.1683, 164.7613],
    [216.7446, -597.213, 959.9255, -486.0964],
    [-311.0897, 820.6258, -1342.7147, 692.2979],
    [224.7017, -568.9372, 944.8651, -494.7759],
    [-64.8189, 159.4272, -267.7914, 141.9232],
];

shared_constants! {
    /// A gather point's `glint_level` of pixels that have a tree in some passes only; 0 where they have none.
    pub const GLINT_TURNS: u32 = 1;
    /// Trees a pass of a pixel of the level above that; each further one has twice as many.
    pub const GLINT_TREES: u32 = 2;
    /// Lower bits of an entry in the list of glints: the pixel. Its level lies above.
    pub const GLINT_PIXEL_BITS: u32 = 28;
    /// Trees of a pixel in the pilot.
    pub const PILOT_TREES: u32 = 4;
    /// A tree takes both ways while the lesser keeps this part of what it began with.
    pub const SPLIT_MIN: f32 = 1.0 / 64.0;
    /// Ways of a tree that wait for others, at most: each is at least twice as much as all that is followed before it.
    pub const WAITING_MAX: u32 = 7;
    /// Bits of a gather point's `surface` that hold the index of the material …
    pub const MATERIAL_MASK: u32 = (1 << 24) - 1;
    /// … specular events from the eye, from this bit on, saturated at this number …
    pub const CHAIN_SHIFT: u32 = 24;
    /// See [`CHAIN_SHIFT`].
    pub const CHAIN_MAX: u32 = 63;
    /// … and whether the back of the triangle is seen.
    pub const BACK_SIDE: u32 = 1 << 30;
    /// … and whether light of the other side is scattered through to there \[E55\].
    pub const BOTH_SIDES: u32 = 1 << 31;
    /// A joton that meets what is there in part counts for those that went through, but for no more than one over this.
    pub const OPACITY_LEAST: f32 = 1.0 / 256.0;
    /// Width of what an eye path sees of a texture at once, in pixels: its passes lie all over the pixel, and blur what they see by one.
    pub const TEXTURE_PIXELS: f32 = 0.5;
    /// Words of 16 bytes of each section of a scene in uniform buffers: 64 KiB, WebGPU's least limit.
    pub const SMALL_WORDS: u32 = 4096;
    /// A joton is taken only where its normal and the gather point's agree this well …
    pub const GATHER_NORMAL_COS: f32 = 0.7;
    /// … and where it lies this near the tangent plane, in radii.
    pub const GATHER_PLANE_SHARE: f32 = 0.2;
    /// Area points of the opposite orientation count only this near the plane: two sheets of a thin board are not one.
    pub const GATHER_SHEET_SHARE: f32 = 0.01;
    /// A fit of a disc is solved where the determinant of its second moments is at least this part of a whole disc's …
    pub const FIT_DETERMINANT_MIN: f32 = 0.05;
    /// … which a quarter has .07 of, the corner of a plate; and raises the variance of a joton's weight by less than this factor.
    /// Elsewhere the area alone is corrected: a sliver has no slope.
    pub const FIT_AMPLIFICATION_MAX: f32 = 20.0;
    /// Determinant of the second moments of a whole disc of radius 1 over its area.
    pub const DISC_DETERMINANT: f32 = 1.0 / 16.0;
    /// Rays along the surface that look for walls about a gather point …
    pub const CLIP_RAYS: u32 = 8;
    /// … this part of the radius above it. What is lower than that is no wall.
    pub const CLIP_LIFT: f32 = 0.05;
    /// … and so much longer than the distance at which a wall is to be found: 1/cos of half the angle between two rays.
    pub const CLIP_REACH: f32 = 1.083;
    /// Cosine between view and normal below which a pixel is not taken to be any longer on the surface.
    pub const CLIP_GRAZING: f32 = 0.1;
    /// Cosine between a wall's normal and the surface's, at most; what is flatter is the surface itself, curved.
    pub const CLIP_STEEP: f32 = 0.5;
    /// Cosine between the normals of two hits above which they are of one wall, if they are equally far.
    pub const CLIP_SAME: f32 = 0.999;
    /// Triangles that a disc is measured with, at most, …
    pub const DISC_TRIANGLES: u32 = 64;
    /// … and least part of a circle that it may have: a joton's weight ends here. A disc that fails is halved, …
    pub const DISC_AREA_LEAST: f32 = 0.03;
    /// … as often as this.
    pub const DISC_HALVINGS: u32 = 4;
    /// Gather points whose normals' cosine is above this lie in one plane.
    pub const INTERIOR_COS: f32 = 0.9999;
    /// Walls that stand no further than this before another one, in radii, stand behind it.
    pub const DISC_WALL_SLACK: f32 = 0.01;
    /// A disc whose area is the circle's but for this part, and in which no wall stands, is whole.
    pub const DISC_WHOLE: f32 = 0.01;
    /// Surfaces of one orientation or the opposite one that lie nearer than this, internal units, are one: 32 units in the last place
    /// of the largest coordinates …
    pub const ONE_SURFACE: f32 = 1.0 / 512.0;
    /// … and whose normals have a cosine above this.
    pub const ONE_PLANE: f32 = 0.999;
    /// The pass whose random numbers are the pilot's, which is no part of the image: its jotons choose the caustic radii, its
    /// camera paths find edges, walls and glints.
    pub const PILOT_PASS: u32 = u32::MAX;
    /// Bits of the pilot's finding about a disc: it is not whole; other surfaces reach into its ball.
    pub const EDGE_CUT: u32 = 1;
    /// See [`EDGE_CUT`].
    pub const EDGE_OTHERS: u32 = 2;
    /// Rays leave a plane by this part of the coordinates that say how far off the origin it is: eight half units in the last
    /// place. Points of the plane are rounded so, and so is where another ray meets it \[E27\].
    pub const LIFT: f32 = 8.0 / (1 << 24) as f32;
    /// … and by no less than this, internal units: a plane through the origin of the scene is exact.
    pub const LIFT_LEAST: f32 = 1.0 / (1 << 20) as f32;
    /// Each of the two ways at a rough interface has at least this part: facets may send light where a flat one sends none.
    pub const ROUGH_SHARE_MIN: f32 = 0.05;
    /// Microfacets of an α up to this are followed as mirrors are: such a lobe is as wide as Phong's of exponent 300, α² = 2/(e + 2).
    pub const FOLLOWED_ALPHA: f32 = 0.081_4;
    /// Bits of the square of an anisotropy's strength …
    pub const BRUSH_STRENGTH_BITS: u32 = 10;
    /// … and of the angle of its way, over π.
    pub const BRUSH_ANGLE_BITS: u32 = 13;
    /// Microfacets of a smaller α are a smooth surface.
    pub const SMOOTH_ALPHA: f32 = 1e-4;
    /// What a clear coat of index 1.5 reflects head on.
    pub const CLEAR_COAT_HEAD_ON: f32 = 0.04;
    /// A normal of a relief that faces away from who sees it is turned to this cosine; it leaves the surface by no less.
    pub const RELIEF_COS_LEAST: f32 = 0.02;
    /// A picture of heights that comes this often in a unit of length, or less, has no width to measure them by.
    pub const RELIEF_SPAN_LEAST: f32 = 1e-12;
    /// All surfaces lie nearer than this to the internal origin, internal units.
    pub const SCENE_RADIUS: f32 = 1024.0;
    /// Discs of the caustic map at the later surfaces of a path are this part of the largest.
    pub const INDIRECT_DISC: f32 = 0.5;
    /// Events after which no path goes on for sure …
    pub const SURE_EVENTS: u32 = 64;
    /// … but with this probability at most, at each event \[E3\]: so paths end between perfect mirrors and inside bodies that
    /// reflect totally. No less than what the whitest walls keep of light: these end paths by their own absorption. No more,
    /// since a GPU waits for the longest path of a pass.
    pub const SURVIVAL_MAX: f32 = 0.99;
    /// Jotons of a cell that a path which goes on looks at: of more, every so many-th stands for those between. The noise of one
    /// path is larger by far.
    pub const CELL_JOTONS: u32 = 3;
    /// Of so many jotons where the camera does not look one is stored, with the flux of all \[E23\].
    pub const UNSEEN_STORED: u32 = 8;
    /// Most that shading normals may change a joton's flux at one event \[E11\]; Veach's factor is unbounded at grazing angles.
    pub const ADJOINT_MAX: f32 = 8.0;
    /// Emitters whose distance is worth a look, one by one; where there are more, any may be near.
    pub const NEAR_EMITTERS_MAX: u32 = 64;
    /// An emitter is near within this part of the width √(A/pick) that it stands for: 1/d² makes the weight of a shadow ray
    /// unbounded there, its variance infinite.
    pub const NEAR_WIDTH: f32 = 0.5;
    /// Loop iterations after which a lane puts its work away until the next dispatch. llvmpipe silently ends all loops of
    /// an invocation at 65,535 iterations, counted over the union of up to 16 lanes that run together.
    pub const STEP_BUDGET: u32 = 3600;
    /// Vectors of four words of the list of tiles that a dispatch sees: WebGPU's least uniform binding, 64 KiB.
    pub const TILES_VECTORS: u32 = 4096;
    /// Low bits of a word of that list: the number of a tile.
    pub const TILE_BITS: u32 = 24;
    /// Levels of the hierarchy that a traversal can keep in mind; obvhs' own limit.
    pub const TRAVERSAL_STACK: u32 = 32;
}

/// A map's cells are this many times narrower than its radius. Smaller cells follow the disc more closely, but visiting
/// a row costs as much as a few jotons: 2 was slower than 1.
pub const CELLS_PER_RADIUS: f32 = 1.0;

/// Factors of y and z in the number of a row's first bucket; see [`row_bucket`].
pub const ROW_FACTORS: [u32; 2] = [0x9e37_79b1, 0x85eb_ca6b];

/// First bucket of a row of cells. Twin: shaders/maps/grid.wgsl.
pub fn row_bucket(y: i32, z: i32, row_mask: u32) -> u32 {
    let [fy, fz] = ROW_FACTORS;
    (y as u32).wrapping_mul(fy).wrapping_add((z as u32).wrapping_mul(fz)) & row_mask
}

/// The same for a camera path where loops end when they should: it cannot be continued, so what it has not found by then
/// is left to the chances of a few.
pub const STEP_BUDGET_HARDWARE: u32 = 16 * STEP_BUDGET;

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows and columns that one gather visits (up to four by four, four columns wide) share no bucket, whatever the
    /// size of the table: no joton is counted twice.
    #[test]
    fn neighbouring_rows_share_no_bucket() {
        for bits in 12..=24 {
            let mask = (1u32 << bits) - 1;
            for dy in -3i32..=3 {
                for dz in -3i32..=3 {
                    if (dy, dz) == (0, 0) {
                        continue;
                    }
                    let apart = row_bucket(dy, dz, mask);
                    let apart = apart.min(mask + 1 - apart);
                    assert!(apart >= 4, "{bits} bits, rows {dy} {dz} apart: {apart} buckets");
                }
            }
        }
    }
}
