//! Layout: what the kernels of a pass read and write, as both sides see it.

use crate::packed::camera::CameraInfo;
use crate::packed::gpu_struct::{Table, gpu_struct};
use crate::spectrum::{BANDS, Bands};
use glam::{Vec3, Vec4};

gpu_struct! {
    /// What is the same for all kernels of a pass; a uniform, one slot for each pass of a submission.
    pub struct PassInfo {
        /// The camera.
        pub camera: CameraInfo,
        /// Image width, pixels.
        pub width: u32,
        /// Image height, pixels.
        pub height: u32,
        /// The user's seed.
        pub seed: u32,
        /// Index of the pass, from 0.
        pub pass_index: u32,
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
        /// Passes of which one has a tree, in pixels of level `GLINT_TURNS`.
        pub glint_turns: u32,
        /// Padding.
        pub pad0: u32,
        /// Red of each band, the bands in the first components, where they differ from pass to pass \[E34\] …
        pub red: Vec4,
        /// … green …
        pub green: Vec4,
        /// … and blue.
        pub blue: Vec4,
        /// What a texel of red alone reflects in each band, likewise \[E37\] …
        pub texel_red: Vec4,
        /// … of green …
        pub texel_green: Vec4,
        /// … and of blue.
        pub texel_blue: Vec4,
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
    /// Where a camera path met its first diffuse surface; 64 bytes, one for each pixel.
    pub struct GatherPoint {
        /// Position, lifted off the surface toward the eye \[E27\]: where rays from it start.
        pub position: Vec3,
        /// Index of the material in the low 24 bits, number of specular events (saturated at 63) above, `BACK_SIDE` where the back of the
        /// triangle is seen, and `BOTH_SIDES` where light of the other side is, too.
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
        /// Diffuse reflectance where a texture makes it, half floats: the first two bands …
        pub albedo_low: u32,
        /// … and the next.
        pub albedo_high: u32,
        /// The bodies that it is in: [`crate::packed::Inside`].
        pub inside: u32,
        /// α of its microfacets and how much of it is metal where these vary, half floats; of what is translucent, how far it is lifted.
        pub facets: u32,
    }
    words 4 + BANDS + 9
}

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
    words 4 + BANDS + 1
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
        /// The bodies that the joton is in: [`crate::packed::Inside`].
        pub inside: u32,
    }
    words 8 + BANDS + 3
}

gpu_struct! {
    /// What a lane has counted over the passes of a batch.
    pub struct LaneTally {
        /// Flux that started; the bands in the first components, as in all of these.
        pub emitted: Vec4,
        /// Flux that surfaces absorbed (expected value).
        pub absorbed: Vec4,
        /// Flux that left.
        pub escaped: Vec4,
        /// Rays.
        pub rays: u32,
        /// Jotons stored.
        pub stored: u32,
        /// Jotons that were not stored, since the camera does not look there.
        pub not_stored: u32,
        /// Padding.
        pub pad0: u32,
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
    /// What jotons count for in a disc: one at (x, y) counts c.x + c.y x + c.z y.
    pub struct Fit {
        /// The weights, per area; x and y in the tangent frame in units of the radius. In `w` the radius of a caustic disc.
        pub c: Vec4,
    }
}

gpu_struct! {
    /// Planes of walls that cut the disc of a pixel's gather point: unit normal, and its product with a point of the plane, which
    /// counts from the disc's middle in a caustic disc; zeros where there is none.
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
