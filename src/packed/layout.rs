//! Layout: structs and constants that Rust and WGSL share, written once, here, and rendered to WGSL.
//!
//! A test holds every struct against naga's offsets and reads a pattern back on the device.

use crate::sampling::distributions::{CIRCLE_COSINE, CIRCLE_SINE};
use crate::spectrum::Bands;
use glam::{Vec3, Vec4};

/// A struct that exists on both sides.
pub trait GpuStruct: bytemuck::Pod {
    /// Its name, the same in WGSL.
    const NAME: &'static str;
    /// Its declaration in WGSL.
    const WGSL: &'static str;
    /// WGSL type of every field.
    const TYPES: &'static [&'static str];
    /// Name and offset of every field on the Rust side.
    fn offsets() -> Vec<(&'static str, usize)>;
}

/// Declare a struct once for both sides. Field types are f32, u32, Vec3, Vec4, UVec4, Bands and arrays of these by an
/// alias; a Vec3 or Bands is followed by a scalar, so that both sides agree on the padding.
macro_rules! gpu_struct {
    ($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $ty:ident,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub struct $name { $($(#[$field_meta])* pub $field: $ty,)* }

        impl $crate::packed::layout::GpuStruct for $name {
            const NAME: &'static str = stringify!($name);
            const WGSL: &'static str = concat!(
                "struct ", stringify!($name), " {\n",
                $("    ", stringify!($field), ": ", stringify!($ty), ",\n",)*
                "}\n"
            );
            const TYPES: &'static [&'static str] = &[$(stringify!($ty),)*];
            fn offsets() -> Vec<(&'static str, usize)> {
                vec![$((stringify!($field), std::mem::offset_of!($name, $field)),)*]
            }
        }
    };
}
pub(crate) use gpu_struct;

/// The WGSL names of the Rust types that fields have.
pub const ALIASES: &str = "alias Vec3 = vec3<f32>;\nalias Vec4 = vec4<f32>;\nalias Bands = vec3<f32>;\n\
    alias Table = array<vec4<u32>, 16>;\n";

/// Sixty-four words in a uniform buffer.
pub type Table = [[u32; 4]; 16];

gpu_struct! {
    /// What is the same for all kernels of a pass; a uniform, one slot for each pass of a submission.
    pub struct PassInfo {
        /// Where the camera's middle ray starts: the eye, or a place before the scene where that is far away.
        pub eye: Vec3,
        /// Image width, pixels.
        pub width: u32,
        /// Right, scaled by the tangent of half the field of view.
        pub right: Vec3,
        /// Image height, pixels.
        pub height: u32,
        /// Up, scaled likewise.
        pub up: Vec3,
        /// The user's seed.
        pub seed: u32,
        /// Unit view direction.
        pub forward: Vec3,
        /// Index of the pass, from 0.
        pub pass_index: u32,
        /// Width of a pixel at unit distance.
        pub pixel_angle: f32,
        /// Shadow rays for each gather point.
        pub shadow_rays: u32,
        /// Number of emitters.
        pub emitters: u32,
        /// Number of targets of aimed emission.
        pub targets: u32,
        /// Light samples of which one gets a shadow ray.
        pub light_candidates: u32,
        /// First row that is rendered.
        pub first_row: u32,
        /// Rows that are rendered.
        pub rows: u32,
        /// First row that the buffers hold.
        pub held_first: u32,
        /// Rows that the buffers hold.
        pub held_rows: u32,
        /// First tree of the dispatch in the list of glints.
        pub glint_first: u32,
        /// Trees of the dispatch.
        pub glint_count: u32,
        /// Passes of which one has a tree, in pixels of level [`GLINT_TURNS`].
        pub glint_turns: u32,
        /// Distance from the eye to `eye`, in units of a ray's `forward`, `right` and `up`.
        pub eye_ahead: f32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

impl PassInfo {
    /// All of an image of this size, in one strip.
    pub fn set_image(&mut self, [width, height]: [u32; 2]) {
        (self.width, self.height) = (width, height);
        (self.first_row, self.rows) = (0, height);
        (self.held_first, self.held_rows) = (0, height);
    }
}

gpu_struct! {
    /// One map in one pass: how it is filled, sorted and read; a uniform, one slot for each map and pass.
    pub struct MapInfo {
        /// Lower corner of the grid.
        pub grid_origin: Vec3,
        /// One over the width of a cell.
        pub cells_per_unit: f32,
        /// Gather radius; of the caustic map the largest one.
        pub radius: f32,
        /// Factor on the squared base radius of each gather point (caustic map).
        pub shrink: f32,
        /// Rows (y, z) are hashed to this many less one (a mask of ones).
        pub row_mask: u32,
        /// Cells along x.
        pub columns: u32,
        /// Jotons emitted a pass.
        pub emitted: u32,
        /// Invocations that trace them.
        pub lanes: u32,
        /// Jotons that a lane can store.
        pub lane_capacity: u32,
        /// First index of this pass in the low-discrepancy sequence, the low word.
        pub first_joton: u32,
        /// The pass whose random numbers are used.
        pub pass_index: u32,
        /// Seed of the sequences of this pass …
        pub seed: u32,
        /// Area that each area point stands for; 0 where there are none.
        pub area_each: f32,
        /// One over the width of a cell of the area points' grid.
        pub area_cells_per_unit: f32,
        /// Hash mask of the area points' rows.
        pub area_row_mask: u32,
        /// Columns of the area points' grid.
        pub area_columns: u32,
        /// One over the width of a marked cell.
        pub cells_marked_per_unit: f32,
        /// … and of those indices from the next multiple of 2^32 on.
        pub seed_wrapped: u32,
    }
}

gpu_struct! {
    /// Where a camera path met its first diffuse surface; 48 bytes, one for each pixel.
    pub struct GatherPoint {
        /// Position, lifted off the surface toward the eye \[E27\]: where rays from it start.
        pub position: Vec3,
        /// Index of the material in the low 24 bits, number of specular events (saturated at 63) above, and
        /// [`BACK_SIDE`] where the back of the triangle is seen.
        pub surface: u32,
        /// What the path carries, per band, without the BRDF; zero where there is no gather point.
        pub throughput: Bands,
        /// Length of the path from the eye.
        pub path_length: f32,
        /// Geometric normal toward the eye, octahedral.
        pub normal: u32,
        /// Shading normal toward the eye, octahedral.
        pub shading_normal: u32,
        /// Direction toward the eye, octahedral.
        pub wo: u32,
        /// How many trees look for emission besides the eye path \[E25\]; stays from pass to pass.
        pub glint_level: u32,
    }
}

/// Pixels across and down a workgroup's tile.
pub use crate::film::tile_schedule::TILE;

/// [`GatherPoint::glint_level`] of pixels that have a tree in some passes only; 0 where they have none.
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

/// Bits of [`GatherPoint::surface`] that hold the index of the material.
pub const MATERIAL_MASK: u32 = (1 << 24) - 1;
/// Bit of [`GatherPoint::surface`].
pub const BACK_SIDE: u32 = 1 << 30;

gpu_struct! {
    /// A stored joton, 32 bytes.
    pub struct Joton {
        /// Position.
        pub position: Vec3,
        /// Geometric normal of the side that it met, signed 8 bits a component; in the top 8 bits the state of the
        /// path automaton.
        pub normal_state: u32,
        /// Flux, internal W per band; already divided by the number of emitted jotons.
        pub flux: Bands,
        /// Direction it came from (wi, toward the light), octahedral.
        pub wi: u32,
    }
}

gpu_struct! {
    /// A lane: one invocation that traces its jotons one after the other, over several dispatches.
    pub struct PathState {
        /// Origin of the next ray.
        pub origin: Vec3,
        /// Jotons that this lane has started.
        pub started: u32,
        /// Direction of the next ray.
        pub direction: Vec3,
        /// Jotons that this lane has stored.
        pub stored: u32,
        /// Flux of the joton on its way.
        pub flux: Bands,
        /// Low 5 bits: state of the path automaton; then LANE_ bits; above bit 16 the number of events.
        pub status: u32,
        /// Back faces nearer than this are not met by the next ray \[E27\].
        pub t_back: f32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

gpu_struct! {
    /// What a lane has counted over the passes of a batch.
    pub struct LaneTally {
        /// Flux that started.
        pub emitted: Bands,
        /// Rays.
        pub rays: u32,
        /// Flux that surfaces absorbed (expected value).
        pub absorbed: Bands,
        /// Jotons stored.
        pub stored: u32,
        /// Flux that left.
        pub escaped: Bands,
        /// Jotons that were not stored, since the camera does not look there.
        pub not_stored: u32,
    }
}

gpu_struct! {
    /// A prefix sum: so many numbers, in blocks of so many, and how many blocks these are.
    pub struct ScanInfo {
        /// Numbers.
        pub count: u32,
        /// Numbers in a block.
        pub block: u32,
        /// Blocks.
        pub blocks: u32,
        /// Nothing.
        pub pad: u32,
    }
}

gpu_struct! {
    /// A digit of a radix sort.
    pub struct SortInfo {
        /// Lowest bit of the digit.
        pub shift: u32,
        /// Items that an invocation takes.
        pub chunk: u32,
        /// Invocations.
        pub chunks: u32,
        /// Where the number of items stands in `total`.
        pub total_at: u32,
    }
}

gpu_struct! {
    /// A sample of the diffuse surfaces, standing for MapInfo.area_each.
    pub struct AreaPoint {
        /// Position.
        pub position: Vec3,
        /// Front normal, signed 8 bits a component.
        pub normal: u32,
    }
}

gpu_struct! {
    /// Weights of the local linear fit: a joton at (x, y) counts c.x + c.y x + c.z y.
    pub struct Fit {
        /// The weights, per area; x and y in the tangent frame in units of the radius.
        pub c: Vec4,
    }
}

gpu_struct! {
    /// Planes of walls that cut the disc of a pixel's gather point: unit normal, and its product with a point of the plane;
    /// zeros where there is none.
    pub struct Clip {
        /// The nearest.
        pub first: Vec4,
        /// The next.
        pub second: Vec4,
    }
}

gpu_struct! {
    /// The automaton of --paths.
    pub struct PathFilter {
        /// Next state for events D and S: word 2 * state + event.
        pub transitions: Table,
        /// Bit q: a path in state q, then k specular events and the eye, is wanted; word k.
        pub accept: Table,
    }
}

/// Slots of the status buffer, which the kernels raise and the host reads after a batch.
pub mod status {
    /// Lanes whose jotons were not all traced.
    pub const UNFINISHED: u32 = 0;
    /// Most jotons that a lane wanted to store.
    pub const LANE_STORED_MAX: u32 = 1;
    /// Loops that the driver ended early.
    pub const LOOP_CUT: u32 = 2;
    /// Camera and shadow rays, the low word.
    pub const RAYS: u32 = 3;
    /// Camera paths cut at their hard limit.
    pub const TRUNCATED: u32 = 4;
    /// Camera and shadow rays, the high word.
    pub const RAYS_HIGH: u32 = 5;
    /// Invocations with a traversal that the driver ended early.
    pub const TRAVERSAL_CUT: u32 = 6;
    /// Light samples that got no shadow ray, since another one stood for them; the low word.
    pub const SHADOW_RAYS_SAVED: u32 = 7;
    /// … and the high word.
    pub const SHADOW_RAYS_SAVED_HIGH: u32 = 8;
    /// Number of slots.
    pub const SLOTS: u32 = 9;

    /// Light samples without a shadow ray in the words of the status buffer.
    pub fn shadow_rays_saved(words: &[u32]) -> u64 {
        counted(words, SHADOW_RAYS_SAVED, SHADOW_RAYS_SAVED_HIGH)
    }

    /// Camera and shadow rays in the words of the status buffer.
    pub fn rays(words: &[u32]) -> u64 {
        counted(words, RAYS, RAYS_HIGH)
    }

    /// A number of 64 bits in two slots. Twin: shaders/dispatch/count.wgsl.
    fn counted(words: &[u32], low: u32, high: u32) -> u64 {
        u64::from(words[high as usize]) << 32 | u64::from(words[low as usize])
    }
}

/// Most of each that a scene in uniform buffers has: 64 KiB, WebGPU's least limit.
pub const SMALL_NODES: u32 = 819;
/// See [`SMALL_NODES`].
pub const SMALL_TRIANGLES: u32 = 1365;
/// See [`SMALL_NODES`].
pub const SMALL_MATERIALS: u32 = 819;
/// See [`SMALL_NODES`].
pub const SMALL_EMITTERS: u32 = 819;

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
/// Least part of a caustic disc that two walls may leave: the product of their shares is exact for right angles only.
pub const CLIP_KEPT_MIN: f32 = 0.1;
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
/// Where there are lights without area, eye paths stop at a narrow lobe to look for them this many times as often as they
/// follow it, at least.
pub const NARROW_STOPS: f32 = 1.0;

/// All surfaces lie nearer than this to the internal origin, internal units.
pub const SCENE_RADIUS: f32 = 1024.0;

/// Events after which no path goes on for sure …
pub const SURE_EVENTS: u32 = 64;
/// … but with this probability at most, at each event \[E3\]: so paths end between perfect mirrors and inside bodies that
/// reflect totally. No less than what the whitest walls keep of light: these end paths by their own absorption. No more,
/// since a GPU waits for the longest path of a pass.
pub const SURVIVAL_MAX: f32 = 0.99;

/// Of so many jotons where the camera does not look one is stored, with the flux of all \[E23\].
pub const UNSEEN_STORED: u32 = 8;

/// Most that shading normals may change a joton's flux at one event \[E11\]; Veach's factor is unbounded at grazing angles.
pub const ADJOINT_MAX: f32 = 8.0;

/// Emitters whose distance is worth a look, one by one; where there are more, any may be near.
pub const NEAR_EMITTERS_MAX: u32 = 64;

/// An emitter is near within this part of the width √(A/pick) that it stands for: 1/d² makes the weight of a shadow ray
/// unbounded there, its variance infinite.
pub const NEAR_WIDTH: f32 = 0.5;

/// Constants that the kernels use, as WGSL.
pub fn constants() -> String {
    use crate::packed::accel::{EDGE_ROUNDING, EDGE_SLACK, EDGE_SLACK_MAX, END_ROUNDING, ONE_PLACE};
    use crate::packed::{
        CLEAR, EmitterKind, FAR, LAMP, MAX_WARPS, MaterialFlags, NO_EMITTER, SMOOTH, VISIBLE_CELL_FACTORS,
        VISIBLE_CELL_WORDS, WARP_BINS, WARP_WORDS, rank,
    };
    use std::fmt::Write;
    let mut s = String::new();
    let mut u =
        |name: &str, value: u32| writeln!(s, "const {name}: u32 = {value}u;").expect("writing to a string");
    u("DIFFUSE", MaterialFlags::DIFFUSE);
    u("GLOSSY", MaterialFlags::GLOSSY);
    u("SPECULAR", MaterialFlags::SPECULAR);
    u("DIELECTRIC", MaterialFlags::DIELECTRIC);
    u("THIN", MaterialFlags::THIN);
    u("EMISSIVE", MaterialFlags::EMISSIVE);
    u("EMITTER_TRIANGLE", EmitterKind::Triangle as u32);
    u("EMITTER_POINT", EmitterKind::Point as u32);
    u("EMITTER_SPOT", EmitterKind::Spot as u32);
    u("EMITTER_SUN", EmitterKind::Sun as u32);
    u("NO_EMITTER", NO_EMITTER);
    u("SMOOTH", SMOOTH);
    u("CLEAR", CLEAR);
    u("LAMP", LAMP);
    u("RANK_CLEAR_FRONT", rank::CLEAR_FRONT);
    u("RANK_CLEAR_BACK", rank::CLEAR_BACK);
    u("RANK_BACK", rank::BACK);
    u("RANK_FRONT", rank::FRONT);
    u("RANK_LAMP", rank::LAMP);
    u("WARP_BINS", WARP_BINS as u32);
    u("WARP_VECTORS", (WARP_WORDS / 4) as u32);
    u("WARPS_VECTORS", (MAX_WARPS * WARP_WORDS / 4) as u32);
    u("VISIBLE_CELL_VECTORS", (VISIBLE_CELL_WORDS / 4) as u32);
    u("VISIBLE_CELL_FACTOR_X", VISIBLE_CELL_FACTORS[0]);
    u("VISIBLE_CELL_FACTOR_Y", VISIBLE_CELL_FACTORS[1]);
    u("VISIBLE_CELL_FACTOR_Z", VISIBLE_CELL_FACTORS[2]);
    u("UNSEEN_STORED", UNSEEN_STORED);
    u("NEAR_EMITTERS_MAX", NEAR_EMITTERS_MAX);
    u("MATERIAL_MASK", MATERIAL_MASK);
    u("BACK_SIDE", BACK_SIDE);
    u("GLINT_TURNS", GLINT_TURNS);
    u("GLINT_TREES", GLINT_TREES);
    u("GLINT_PIXEL_BITS", GLINT_PIXEL_BITS);
    u("PILOT_TREES", PILOT_TREES);
    u("WAITING_MAX", WAITING_MAX);
    u("TILE", TILE);
    u("STATUS_UNFINISHED", status::UNFINISHED);
    u("STATUS_LANE_STORED_MAX", status::LANE_STORED_MAX);
    u("STATUS_LOOP_CUT", status::LOOP_CUT);
    u("STATUS_RAYS", status::RAYS);
    u("STATUS_TRUNCATED", status::TRUNCATED);
    u("STATUS_RAYS_HIGH", status::RAYS_HIGH);
    u("STATUS_TRAVERSAL_CUT", status::TRAVERSAL_CUT);
    u("STATUS_SHADOW_RAYS_SAVED", status::SHADOW_RAYS_SAVED);
    u("STATUS_SHADOW_RAYS_SAVED_HIGH", status::SHADOW_RAYS_SAVED_HIGH);
    u("SURE_EVENTS", SURE_EVENTS);
    u("CLIP_RAYS", CLIP_RAYS);
    u("PILOT_PASS", PILOT_PASS);
    u("EDGE_CUT", EDGE_CUT);
    u("EDGE_OTHERS", EDGE_OTHERS);
    u("STEP_BUDGET", STEP_BUDGET);
    u("TRAVERSAL_STACK", TRAVERSAL_STACK);
    u("ROW_FACTOR_Y", ROW_FACTORS[0]);
    u("ROW_FACTOR_Z", ROW_FACTORS[1]);
    u("TILES_VECTORS", TILES_VECTORS);
    u("TILE_BITS", TILE_BITS);
    u("TILE_MASK", (1 << TILE_BITS) - 1);
    u("SMALL_NODES", SMALL_NODES);
    u("SMALL_TRIANGLES", SMALL_TRIANGLES);
    u("SMALL_MATERIALS", SMALL_MATERIALS);
    u("SMALL_EMITTERS", SMALL_EMITTERS);
    u("PATH_START", crate::film::paths::LightPaths::START);
    u("PATH_DEAD", crate::film::paths::DEAD);
    let mut f = |name: &str, value: f32| {
        writeln!(s, "const {name}: f32 = {value:?};").expect("writing to a string");
    };
    f("SURVIVAL_MAX", SURVIVAL_MAX);
    f("LIFT", LIFT);
    f("LIFT_LEAST", LIFT_LEAST);
    f("ONE_PLACE", ONE_PLACE);
    f("EDGE_SLACK", EDGE_SLACK);
    f("EDGE_ROUNDING", EDGE_ROUNDING);
    f("EDGE_SLACK_MAX", EDGE_SLACK_MAX);
    f("END_ROUNDING", END_ROUNDING);
    f("ADJOINT_MAX", ADJOINT_MAX);
    f("NEAR_WIDTH", NEAR_WIDTH);
    f("SCENE_RADIUS", SCENE_RADIUS);
    f("NARROW_STOPS", NARROW_STOPS);
    f("FAR", FAR);
    f("GATHER_NORMAL_COS", GATHER_NORMAL_COS);
    f("GATHER_PLANE_SHARE", GATHER_PLANE_SHARE);
    f("GATHER_SHEET_SHARE", GATHER_SHEET_SHARE);
    f("FIT_DETERMINANT_MIN", FIT_DETERMINANT_MIN);
    f("DISC_DETERMINANT", DISC_DETERMINANT);
    f("FIT_AMPLIFICATION_MAX", FIT_AMPLIFICATION_MAX);
    f("CLIP_LIFT", CLIP_LIFT);
    f("CLIP_STEEP", CLIP_STEEP);
    f("CLIP_REACH", CLIP_REACH);
    f("CLIP_GRAZING", CLIP_GRAZING);
    f("CLIP_SAME", CLIP_SAME);
    f("CLIP_KEPT_MIN", CLIP_KEPT_MIN);
    f("SPLIT_MIN", SPLIT_MIN);
    let mut v = |name: &str, [x, y, z, w]: [f32; 4]| {
        writeln!(s, "const {name} = Vec4({x:?}, {y:?}, {z:?}, {w:?});").expect("writing to a string");
    };
    v("CIRCLE_SINE", CIRCLE_SINE);
    v("CIRCLE_COSINE", CIRCLE_COSINE);
    s
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

/// Loop iterations after which a lane puts its work away until the next dispatch. llvmpipe silently ends all loops of
/// an invocation at 65,535 iterations, counted over the union of up to 16 lanes that run together.
pub const STEP_BUDGET: u32 = 3600;

/// The same for a camera path where loops end when they should: it cannot be continued, so what it has not found by then
/// is left to the chances of a few.
pub const STEP_BUDGET_HARDWARE: u32 = 16 * STEP_BUDGET;

/// Vectors of four words of the list of tiles that a dispatch sees: WebGPU's least uniform binding, 64 KiB.
pub const TILES_VECTORS: u32 = 4096;
/// Low bits of a word of that list: the number of a tile.
pub const TILE_BITS: u32 = 24;

/// Levels of the hierarchy that a traversal can keep in mind; obvhs' own limit.
pub const TRAVERSAL_STACK: u32 = 32;

/// Every struct that kernels may use, and the functions that read them from the heap, as WGSL.
pub fn declarations() -> String {
    use crate::packed::{PackedEmitter, PackedMaterial, PackedTriangle, SceneInfo, Target};
    let mut s = String::from(ALIASES);
    for declaration in [
        PassInfo::WGSL,
        MapInfo::WGSL,
        GatherPoint::WGSL,
        Joton::WGSL,
        PathState::WGSL,
        LaneTally::WGSL,
        ScanInfo::WGSL,
        SortInfo::WGSL,
        AreaPoint::WGSL,
        Fit::WGSL,
        Clip::WGSL,
        PathFilter::WGSL,
        PackedTriangle::WGSL,
        PackedMaterial::WGSL,
        PackedEmitter::WGSL,
        Target::WGSL,
        SceneInfo::WGSL,
    ] {
        s.push_str(declaration);
    }
    s + &crate::packed::heap::readers() + &constants()
}

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
