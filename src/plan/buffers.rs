//! Buffers: what a device holds for a render: names, bytes, and what for. The one place that tells how large a buffer is:
//! the GPU backend creates what is listed here, and `joton plan` prints it without a device.

use super::Plan;
use super::shape::{DIGIT_BITS, Kind, Machine, Shape, Shapes, Strips};
use super::traffic::Traffic;
use crate::film::LAYERS;
use crate::layout::{
    AreaPoint, Clip, Fit, GatherPoint, Joton, Lane, LaneTally, PathFilter, SMALL_EMITTERS, SMALL_MATERIALS,
    SMALL_NODE_WORDS, SMALL_TRIANGLES, status,
};
use crate::pack::{
    MAX_TARGETS, MAX_WARPS, PackedEmitter, PackedMaterial, PackedScene, PackedTriangle, Target, WARP_WORDS,
};

/// A buffer of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Buffer {
    /// The name that kernels know it by.
    pub name: &'static str,
    /// Its size.
    pub bytes: u64,
    /// What it holds.
    pub holds: &'static str,
}

/// Films of the layers, in the order of [`crate::film::Layer::ALL`].
pub const FILMS: [&str; LAYERS] = ["film_emission", "film_direct", "film_caustic", "film_diffuse"];
/// Bytes of a pixel of a film: a vector of four, of which three are used.
const FILM_PIXEL: u64 = 16;
/// Bytes of a word.
const WORD: u64 = 4;
/// Bytes that every buffer's size is a multiple of.
const GRAIN: u64 = 16;
/// Bytes of each uniform buffer of a small scene: WebGPU's least limit.
const SMALL_BYTES: u64 = 1 << 16;
/// Bytes of a node, and words of 16 bytes in it.
const NODE_BYTES: u64 = 80;
const NODE_WORDS: usize = 5;
/// Bytes of a triangle's shading normals.
const NORMALS_BYTES: u64 = 16;
/// Bytes of the ring of uniforms.
pub const RING_BYTES: u64 = 1 << 20;
/// Items that one invocation of a scan adds up.
pub const SCAN_BLOCK: u32 = 256;

/// Area points that fall into a whole disc.
const POINTS_PER_DISC: f64 = 150.0;
/// Most area points: memory and set-up time end somewhere; the fit only gets noisier.
const AREA_POINTS_MAX: usize = 1 << 21;
/// Bits of a bucket's number in the area points' grid.
pub const AREA_KEY_BITS: u32 = 17;
/// Entries of its bucket table.
pub const AREA_STARTS: usize = (1 << AREA_KEY_BITS) + 2;
/// Room for the area points of later passes, whose discs are smaller.
const AREA_SLACK: u64 = 2;

impl Buffer {
    fn new(name: &'static str, bytes: u64, holds: &'static str) -> Self {
        Self { name, bytes: bytes.next_multiple_of(GRAIN).max(GRAIN), holds }
    }
}

/// Everything that sizes follow from.
#[derive(Debug, Clone, Copy)]
pub struct Needs<'a> {
    /// The scene.
    pub scene: &'a PackedScene,
    /// What is done with it.
    pub plan: &'a Plan,
    /// The device.
    pub machine: Machine,
    /// How the maps are cut.
    pub shapes: Shapes,
    /// How the image is cut.
    pub strips: Strips,
}

impl<'a> Needs<'a> {
    /// What a device is expected to need, before its own pilot: how many jotons lanes store is an estimate.
    pub fn expected(scene: &'a PackedScene, plan: &'a Plan, machine: Machine, traffic: &Traffic) -> Self {
        let shape = |kind, emitted: u32| {
            let of = |n| Shape::expected(n, &traffic.of(kind), scene.triangles.len(), &machine);
            (emitted > 0).then_some(emitted).map(of)
        };
        let shapes = Shapes {
            caustic: shape(Kind::Caustic, plan.caustic_jotons),
            diffuse: shape(Kind::Diffuse, plan.diffuse_jotons),
        };
        Self { scene, plan, machine, shapes, strips: Strips::whole(scene.size) }
    }

    /// All buffers of a render. Area points are those of the first pass.
    pub fn buffers(&self) -> Vec<Buffer> {
        let mut all = scene_buffers(self.scene, self.plan, &self.machine);
        all.extend(self.pass_buffers());
        if self.shapes.diffuse.is_some() {
            let wanted = area_points_wanted(self.scene, self.plan.diffuse.radius(0));
            all.push(area_points(wanted));
        } else {
            all.push(area_points(0));
        }
        let read =
            |b: &&Buffer| b.name == "status" || b.name.starts_with("tallies") || FILMS.contains(&b.name);
        let bytes = all.iter().filter(read).map(|b| b.bytes).sum();
        all.push(Buffer::new("staging", bytes, "what is read back after a batch"));
        all
    }

    /// Those that depend on how the work is cut.
    pub fn pass_buffers(&self) -> Vec<Buffer> {
        let shapes: Vec<Shape> = self.shapes.each().collect();
        let mut all = map_buffers(&shapes, &self.machine);
        all.extend(pixel_buffers(self.strips.pixels_held()));
        all.push(Buffer::new("area_starts", AREA_STARTS as u64 * WORD, "first area point of each bucket"));
        all.push(Buffer::new("status", u64::from(status::SLOTS) * WORD, "alarms and counts of rays"));
        all
    }
}

/// The scene, and the uniforms that never change.
pub fn scene_buffers(scene: &PackedScene, plan: &Plan, machine: &Machine) -> Vec<Buffer> {
    let small = is_small(scene, machine);
    let buffer = |name, count: usize, each: u64, holds| {
        // a uniform buffer is as long as the kernels say, whatever is in it
        let bytes = if small { SMALL_BYTES } else { count as u64 * each };
        Buffer::new(name, bytes, holds)
    };
    let emitter = size_of::<PackedEmitter>() as u64;
    let mut all = vec![
        buffer("nodes", scene.bvh.node_count(), NODE_BYTES, "hierarchy"),
        buffer("triangles", scene.triangles.len(), size_of::<PackedTriangle>() as u64, "triangles"),
        Buffer::new(
            "shading_normals",
            scene.shading_normals.len() as u64 * NORMALS_BYTES,
            "normals of smooth surfaces",
        ),
        buffer("materials", scene.materials.len(), size_of::<PackedMaterial>() as u64, "materials"),
        buffer("emitters", scene.emitters.len(), emitter, "lights"),
    ];
    if !plan.guide.is_empty() {
        let holds = "lights, picked as was learned for the caustic map";
        all.push(buffer("emitters_caustic", scene.emitters.len(), emitter, holds));
    }
    let warps = (MAX_WARPS * WARP_WORDS) as u64 * WORD;
    all.extend([
        Buffer::new("targets", (MAX_TARGETS * size_of::<Target>()) as u64, "spheres about specular bodies"),
        Buffer::new("path_filter", size_of::<PathFilter>() as u64, "the automaton of --paths"),
        Buffer::new("warps", warps, "learned directions of emission"),
        Buffer::new("ring", RING_BYTES, "uniforms of a submission"),
    ]);
    all
}

/// True for a scene that fits into uniform buffers.
pub fn is_small(scene: &PackedScene, machine: &Machine) -> bool {
    let fits = |count: usize, most: u32| count <= most as usize;
    machine.uniform_binding >= SMALL_BYTES
        && fits(scene.bvh.node_count() * NODE_WORDS, SMALL_NODE_WORDS)
        && fits(scene.triangles.len(), SMALL_TRIANGLES)
        && fits(scene.materials.len(), SMALL_MATERIALS)
        && fits(scene.emitters.len(), SMALL_EMITTERS)
}

/// What the maps need; they take turns on all but the tallies.
pub fn map_buffers(shapes: &[Shape], machine: &Machine) -> Vec<Buffer> {
    let most = |f: &dyn Fn(&Shape) -> u64| shapes.iter().map(f).max().unwrap_or(1).max(1);
    let lanes = most(&|s| u64::from(s.lanes));
    let stored = most(&|s| s.max_stored());
    let histogram = most(&|s| u64::from(s.chunks(machine)) << DIGIT_BITS);
    let scanned = histogram.max(lanes + 1);
    let tallies = lanes * size_of::<LaneTally>() as u64;
    let jotons = stored * size_of::<Joton>() as u64;
    vec![
        Buffer::new("lanes", lanes * size_of::<Lane>() as u64, "jotons on their way"),
        Buffer::new("tallies_caustic", tallies, "counts and energy, caustic map"),
        Buffer::new("tallies_diffuse", tallies, "counts and energy, diffuse map"),
        Buffer::new("lane_starts", (lanes + 1) * WORD, "first joton of each lane"),
        Buffer::new("jotons", jotons, "jotons as they were stored"),
        Buffer::new("sorted_jotons", jotons, "jotons in the order of the grid"),
        Buffer::new("keys_a", stored * WORD, "grid bucket of each joton"),
        Buffer::new("keys_b", stored * WORD, "the same, other half of a sort"),
        Buffer::new("places_a", stored * WORD, "place of each joton"),
        Buffer::new("places_b", stored * WORD, "the same, other half of a sort"),
        Buffer::new("histogram", histogram * WORD, "digits of a sort"),
        Buffer::new("block_sums", scanned.div_ceil(u64::from(SCAN_BLOCK)) * WORD, "sums of a scan"),
        Buffer::new("bucket_starts", most(&Shape::buckets) * WORD, "first joton of each bucket"),
    ]
}

/// What each pixel needs.
fn pixel_buffers(pixels: u64) -> Vec<Buffer> {
    let mut all = vec![
        Buffer::new("gather_points", pixels * size_of::<GatherPoint>() as u64, "where camera paths end"),
        Buffer::new("fits", pixels * size_of::<Fit>() as u64, "weights of the discs at boundaries"),
        Buffer::new("radii", pixels * size_of::<Fit>() as u64, "radius of the caustic map"),
        Buffer::new("counts", pixels * WORD, "jotons that the pilot found"),
        Buffer::new("edges", pixels * WORD, "whether a disc is whole"),
        Buffer::new("clips", pixels * size_of::<Clip>() as u64, "walls about a disc"),
    ];
    all.extend(FILMS.map(|film| Buffer::new(film, pixels * FILM_PIXEL, "sums of a layer")));
    all
}

/// The buffer for so many area points.
pub fn area_points(count: usize) -> Buffer {
    let each = size_of::<AreaPoint>() as u64;
    // rounding may add one
    let bytes = (count as u64 * AREA_SLACK).min(AREA_POINTS_MAX as u64) * each + each;
    Buffer::new("area_points", bytes, "sample of the diffuse surfaces")
}

/// How many area points discs of this radius want.
pub fn area_points_wanted(scene: &PackedScene, radius: f64) -> usize {
    let discs = scene.diffuse_area / (std::f64::consts::PI * radius * radius);
    ((POINTS_PER_DISC * discs) as usize).clamp(1, AREA_POINTS_MAX)
}
