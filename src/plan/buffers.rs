//! Buffers: what a device holds for a render: names, bytes, and what for. The one place that tells how large a buffer is:
//! the GPU backend creates what is listed here, and `joton plan` prints it without a device.

use super::Plan;
use super::map_layout::{DIGIT_BITS, DeviceLimits, MapLayout, MapLayouts};
use super::strips::Strips;
use super::traffic::Traffic;
use crate::error::{Error, Result};
use crate::estimators::maps::MapKind;
use crate::estimators::split_paths::{SplitPaths, TREES_MAX};
use crate::film::{LAYERS, Layer};
use crate::packed::accel::Node;
use crate::packed::constants::{SMALL_WORDS, TILE, TILES_VECTORS};
use crate::packed::layout::{
    AreaPoint, Clip, Fit, GatherPoint, Joton, LaneTally, PathFilter, PathState, status,
};
use crate::packed::{
    HEAP_WORD, HeapCounts, HeapLayout, MAX_TARGETS, MAX_WARPS, PackedEmitter, PackedMaterial, PackedScene,
    PackedTriangle, SceneInfo, Target, VISIBLE_CELL_WORDS, WARP_WORDS,
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
/// What the pilot finds out of each pixel and passes need: where there are several strips, it is kept on the host.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// The buffer.
    pub name: &'static str,
    /// Words of a pixel, and how many of them, the first, say anything.
    pub words: [usize; 2],
}

/// What is known of each pixel.
pub fn known(plan: &Plan) -> impl Iterator<Item = Known> {
    let [caustic, diffuse] = MapKind::ALL.map(|kind| plan.has_map(kind));
    let radius = Known { name: "radii", words: [4, 4] };
    let interiors = Known { name: "interiors", words: [4, 4] };
    let edges = Known { name: "edges", words: [1, 1] };
    let clips = Known { name: "clips", words: [8, 8] };
    let all = [(radius, caustic), (interiors, caustic), (edges, diffuse), (clips, diffuse)];
    all.into_iter().filter_map(|(known, is_read)| is_read.then_some(known))
}

/// Bytes of a pixel of a film: a vector of four, of which three are used.
pub const FILM_PIXEL: u64 = 16;
/// Bytes of a pixel of what is known of the surface about it: a vector of four.
const INTERIOR: u64 = 16;
/// Bytes of a word.
const WORD: u64 = 4;
/// Bytes that every buffer's size is a multiple of.
const GRAIN: u64 = 16;
/// Bytes of each uniform buffer of a small scene.
const SMALL_BYTES: u64 = SMALL_WORDS as u64 * HEAP_WORD;
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
const AREA_SLACK: usize = 2;
/// Area points may take one part of this many of the memory that is allowed.
const AREA_MEMORY_SHARE: u64 = 8;
/// Strips that are tried before a pass gets fewer jotons: thinner ones have too much overlap.
const STRIPS_GOOD: u32 = 32;
/// Jotons that a pass keeps in any case: the caustic map's and the diffuse map's.
const JOTONS_KEPT: u32 = 1 << 10;

impl Buffer {
    fn new(name: &'static str, bytes: u64, holds: &'static str) -> Self {
        Self { name, bytes: bytes.next_multiple_of(GRAIN).max(GRAIN), holds }
    }
}

/// Everything that sizes follow from.
#[derive(Debug, Clone, Copy)]
pub struct BufferPlan<'a> {
    /// The scene.
    pub scene: &'a PackedScene,
    /// What is done with it.
    pub plan: &'a Plan,
    /// The device.
    pub machine: DeviceLimits,
    /// How the maps are cut.
    pub shapes: MapLayouts,
    /// How the image is cut.
    pub strips: Strips,
}

impl<'a> BufferPlan<'a> {
    /// All buffers of a render. Area points are those of the first pass.
    pub fn buffers(&self) -> Vec<Buffer> {
        let mut all = scene_buffers(self.scene, self.plan, &self.machine);
        all.extend(self.pass_buffers());
        if self.shapes.diffuse.is_some() {
            let most = area_points_most(self.plan.buffer_limit());
            all.push(area_points(area_points_wanted(self.scene, self.plan.diffuse.radius(0), most), most));
        }
        let bytes = |is_read: &dyn Fn(&str) -> bool| -> u64 {
            all.iter().filter(|b| is_read(b.name)).map(|b| b.bytes).sum()
        };
        let counts = bytes(&|name| name == "status" || name.starts_with("tallies"));
        let film = |name: &str| FILMS.iter().position(|film| *film == name);
        let whole = self.strips.count() == 1;
        let films = bytes(&|name| film(name).is_some_and(|layer| self.plan.layers[layer]));
        let known = bytes(&|name| known(self.plan).any(|k| k.name == name));
        // while a GPU renders the next batch, this one is read
        let batches = if self.machine.is_software { 1 } else { 2 };
        let together = if whole { batches * (counts + films) } else { counts.max(films).max(known) };
        all.push(Buffer::new("staging", together, "what is read back at a time"));
        all
    }

    /// Whether both sorted maps are kept: where there are several strips, each gathers from both.
    pub fn maps_apart(&self) -> bool {
        self.strips.count() > 1 && self.shapes.each().count() > 1
    }

    /// The image in as few strips as fit, at most so many: no buffer larger than a binding, all together within the budget.
    ///
    /// # Errors
    /// [`Error::Capacity`] that names what does not fit.
    fn cut(mut self, most: u32) -> Result<Strips> {
        for count in 1..=most {
            self.strips = Strips::cut(self.scene.size, count);
            if self.fits().is_ok() {
                break;
            }
        }
        self.fits().map(|()| self.strips)
    }

    /// Check that all buffers fit.
    ///
    /// # Errors
    /// [`Error::Capacity`] that names what does not.
    pub fn fits(&self) -> Result<()> {
        let buffers = self.buffers();
        // staging is bound by no kernel
        let bound = buffers.iter().filter(|b| b.name != "staging");
        if let Some(b) = bound.max_by_key(|b| b.bytes).filter(|b| b.bytes > self.machine.storage_binding) {
            let remedy = "use --device cpu".to_string();
            let limit = self.machine.storage_binding;
            return Err(Error::Capacity { buffer: b.name, need: b.bytes, limit, remedy });
        }
        let Some(limit) = self.plan.settings.memory else { return Ok(()) };
        let beside = self.plan.beside;
        let need =
            |limit: u64| most_bytes(&buffers, Some(limit.saturating_sub(beside))).saturating_add(beside);
        if need(limit) <= limit {
            return Ok(());
        }
        // area points take a part of what there is: of more there are more, but the sum converges
        let enough = std::iter::successors(Some(need(0)), |n| (need(*n) > *n).then(|| need(*n)));
        Err(self.plan.too_large(enough.last().unwrap_or(limit), limit))
    }

    /// Bytes on the device of a pixel that its buffers hold.
    pub fn bytes_per_pixel(&self) -> f64 {
        let pixels = self.strips.pixels_held();
        pixel_buffers(self.plan, pixels).iter().map(|b| b.bytes).sum::<u64>() as f64 / pixels as f64
    }

    /// Bytes of the films of the host, at most.
    pub fn host_bytes(&self) -> u64 {
        self.plan.films(self.scene).bytes()
    }

    /// Check that so many free bytes hold the buffers of a device whose memory is the host's, and what the host needs itself. How
    /// much is free never decides how a picture is made.
    ///
    /// # Errors
    /// [`Error::Memory`] with need, what is free, and what to do.
    pub fn check_free(&self, free: Option<u64>) -> Result<()> {
        let need = most_bytes(&self.buffers(), self.plan.buffer_limit()).saturating_add(self.host_bytes());
        match free {
            Some(free) if need > free => Err(Error::Memory { need, free }),
            _ => Ok(()),
        }
    }

    /// Those that depend on how the work is cut.
    pub fn pass_buffers(&self) -> Vec<Buffer> {
        let shapes: Vec<MapLayout> = self.shapes.each().collect();
        let mut all = map_buffers(&shapes, &self.machine);
        if let (true, Some(shape)) = (self.maps_apart(), self.shapes.caustic) {
            let [sorted, starts] = sorted_buffers(shape.max_stored(), shape.buckets());
            all.push(Buffer { name: "sorted_jotons_caustic", ..sorted });
            all.push(Buffer { name: "bucket_starts_caustic", ..starts });
        }
        all.extend(pixel_buffers(self.plan, self.strips.pixels_held()));
        if self.shapes.diffuse.is_some() {
            all.push(Buffer::new(
                "area_starts",
                AREA_STARTS as u64 * WORD,
                "first area point of each bucket",
            ));
        }
        if self.plan.has_indirect_paths() {
            all.push(Buffer::new("queue", WORD, "pixels whose paths have gone on"));
        }
        all.push(Buffer::new("status", u64::from(status::SLOTS) * WORD, "alarms and counts of rays"));
        all
    }
}

/// A plan as the reference machine would keep it, and what it would need: told without a device.
#[derive(Debug)]
pub struct Expected {
    /// The plan, with as many jotons as fit.
    pub plan: Plan,
    /// What a few thousand paths meet.
    pub traffic: Traffic,
    shapes: MapLayouts,
    strips: Strips,
}

impl Expected {
    /// Look at a scene.
    ///
    /// # Errors
    /// [`Error::Capacity`] with need and limit where the least does not fit.
    pub fn look(scene: &PackedScene, mut plan: Plan) -> Result<Self> {
        let machine = DeviceLimits::REFERENCE;
        let traffic = Traffic::look(scene, &plan);
        let mut shapes = expected_shapes(scene, &plan, machine, &traffic);
        let strips = fit(scene, &mut plan, &mut shapes, machine)?;
        Ok(Self { plan, traffic, shapes, strips })
    }

    /// What the sizes of the buffers follow from.
    pub fn needs<'a>(&'a self, scene: &'a PackedScene) -> BufferPlan<'a> {
        let Self { plan, shapes, strips, .. } = self;
        BufferPlan { scene, plan, machine: DeviceLimits::REFERENCE, shapes: *shapes, strips: *strips }
    }
}

/// How a device is expected to cut the maps, before its own pilot: how many jotons lanes store is an estimate.
pub fn expected_shapes(
    scene: &PackedScene,
    plan: &Plan,
    machine: DeviceLimits,
    traffic: &Traffic,
) -> MapLayouts {
    let shape = |kind, emitted: u32| {
        let of = |n| MapLayout::expected(n, &traffic.of(kind), scene.triangles.len(), &machine);
        (emitted > 0).then_some(emitted).map(of)
    };
    MapLayouts {
        caustic: shape(MapKind::Caustic, plan.caustic_jotons),
        diffuse: shape(MapKind::Diffuse, plan.diffuse_jotons),
    }
}

/// Make a render fit: first the image is cut into strips, which changes nothing in it, then passes get fewer jotons.
///
/// # Errors
/// [`Error::Capacity`] with need and limit where the least does not fit.
pub fn fit(
    scene: &PackedScene,
    plan: &mut Plan,
    shapes: &mut MapLayouts,
    machine: DeviceLimits,
) -> Result<Strips> {
    let thinnest = scene.size[1].div_ceil(TILE);
    loop {
        let strips = Strips::whole(scene.size);
        let needs = BufferPlan { scene, plan, machine, shapes: *shapes, strips };
        if let Ok(strips) = needs.cut(STRIPS_GOOD.min(thinnest)) {
            return Ok(strips);
        }
        let stored = |kind: &MapKind| shapes.of(*kind).map_or(0, |shape| shape.max_stored());
        let [caustic, diffuse] = MapKind::ALL;
        let larger = if stored(&caustic) > stored(&diffuse) { caustic } else { diffuse };
        match shapes.of_mut(larger) {
            Some(shape) if shape.emitted > JOTONS_KEPT => {
                plan.halve_jotons(scene, larger);
                *shape = shape.halved();
            }
            _ => return needs.cut(thinnest),
        }
    }
}

/// The uniforms that say where the heap has what a kernel reads. They differ in the list of emitters, which differ in their
/// probabilities: by flux, and as was learned for shadow rays, the caustic map and the diffuse map.
pub const SCENE_INFOS: [&str; 4] =
    ["scene_info", "scene_info_direct", "scene_info_caustic", "scene_info_diffuse"];
/// The lists themselves where they are small.
pub const SMALL_EMITTER_LISTS: [&str; 4] =
    ["emitters", "emitters_direct", "emitters_caustic", "emitters_diffuse"];

/// True for each list of emitters that differs from the first.
fn lists(plan: &Plan) -> [bool; 4] {
    let guides = &plan.guides;
    [true, !guides.direct.is_empty(), !guides.caustic.is_empty(), !guides.diffuse.is_empty()]
}

/// Number, in the heap, of the list that each of [`SCENE_INFOS`] points to.
pub fn list_numbers(plan: &Plan) -> [usize; 4] {
    let lists = lists(plan);
    std::array::from_fn(|i| if lists[i] { lists[..i].iter().filter(|own| **own).count() } else { 0 })
}

/// Where the scene lies in the heap.
pub fn heap_layout(scene: &PackedScene, plan: &Plan) -> HeapLayout {
    let lists = lists(plan).into_iter().filter(|own| *own).count();
    HeapLayout::new(&HeapCounts::of(scene, lists))
}

/// The scene, and the uniforms that never change.
pub fn scene_buffers(scene: &PackedScene, plan: &Plan, machine: &DeviceLimits) -> Vec<Buffer> {
    let bytes = heap_layout(scene, plan).bytes();
    let mut all = vec![Buffer::new(HEAP[0], bytes, "the scene")];
    if is_split(bytes, machine) {
        let part = heap_part_bytes(machine);
        all = (0..)
            .zip(HEAP)
            .map(|(i, name)| {
                // what does not fit into all parts is left to the last, and found to be too large
                let most = if i + 1 < HEAP.len() as u64 { part } else { bytes };
                Buffer::new(name, bytes.saturating_sub(i * part).min(most), "a part of the scene")
            })
            .collect();
    }
    if is_small(scene, machine) {
        // a uniform buffer is as long as the kernels say, whatever is in it
        let lists = SMALL_EMITTER_LISTS.into_iter().zip(lists(plan)).filter(|(_, own)| *own);
        let names = ["nodes", "triangles", "materials"].into_iter().chain(lists.map(|(name, _)| name));
        all.extend(names.map(|name| Buffer::new(name, SMALL_BYTES, "a copy of a part of a small scene")));
    }
    let infos = SCENE_INFOS.into_iter().zip(lists(plan)).filter(|(_, own)| *own);
    all.extend(infos.map(|(name, _)| {
        Buffer::new(name, size_of::<SceneInfo>() as u64, "where the scene lies in its buffer")
    }));
    let warps = (MAX_WARPS * WARP_WORDS) as u64 * WORD;
    all.extend([
        Buffer::new("targets", (MAX_TARGETS * size_of::<Target>()) as u64, "spheres about specular bodies"),
        Buffer::new("path_filter", size_of::<PathFilter>() as u64, "the automaton of --paths"),
        Buffer::new("warps_caustic", warps, "learned directions of emission, caustic map"),
        Buffer::new("warps_diffuse", warps, "learned directions of emission, diffuse map"),
        Buffer::new("visible_cells", VISIBLE_CELL_WORDS as u64 * WORD, "cells where the camera looks"),
        Buffer::new("tiles", tiles_bytes(scene.size), "tiles, those that rest last"),
        Buffer::new("ring", RING_BYTES, "uniforms of a submission"),
    ]);
    all
}

/// The list of an image's tiles: whole bindings.
fn tiles_bytes([width, height]: [u32; 2]) -> u64 {
    let tiles = u64::from(width.div_ceil(TILE)) * u64::from(height.div_ceil(TILE));
    let binding = u64::from(TILES_VECTORS) * GRAIN;
    (tiles * WORD).next_multiple_of(binding).max(binding)
}

/// Names of the parts of the heap where it is more than a binding holds.
pub const HEAP: [&str; 8] = ["heap", "heap_1", "heap_2", "heap_3", "heap_4", "heap_5", "heap_6", "heap_7"];
/// Storage buffers of the kernel that has most of them, with all these parts.
const STORAGE_BUFFERS_SPLIT: u32 = 8 + HEAP.len() as u32 - 1;

/// Binary logarithm of the words in a part of the heap: as many as a binding holds.
pub fn heap_part(machine: &DeviceLimits) -> u32 {
    (machine.storage_binding / HEAP_WORD).max(1).ilog2()
}

/// Bytes of a part of the heap.
pub fn heap_part_bytes(machine: &DeviceLimits) -> u64 {
    HEAP_WORD << heap_part(machine)
}

/// True where the heap is more than a binding holds, and the device can bind its parts.
pub fn is_split(heap_bytes: u64, machine: &DeviceLimits) -> bool {
    heap_bytes > machine.storage_binding && machine.storage_buffers >= STORAGE_BUFFERS_SPLIT
}

/// True for a scene that fits into uniform buffers.
pub fn is_small(scene: &PackedScene, machine: &DeviceLimits) -> bool {
    let fits = |count: usize, each: usize| (count * each) as u64 <= SMALL_BYTES;
    machine.uniform_binding >= SMALL_BYTES
        && fits(scene.bvh.node_count(), size_of::<Node>())
        && fits(scene.triangles.len(), size_of::<PackedTriangle>())
        && fits(scene.materials.len(), size_of::<PackedMaterial>())
        && fits(scene.emitters.len(), size_of::<PackedEmitter>())
}

/// What the maps need. Both use the same buffers, one after the other; each has tallies of its own.
pub fn map_buffers(shapes: &[MapLayout], machine: &DeviceLimits) -> Vec<Buffer> {
    let most = |f: &dyn Fn(&MapLayout) -> u64| shapes.iter().map(f).max().unwrap_or(1).max(1);
    let lanes = most(&|s| u64::from(s.lanes));
    let stored = most(&|s| s.max_stored());
    let histogram = most(&|s| u64::from(s.chunks(machine)) << DIGIT_BITS);
    let scanned = histogram.max(lanes + 1);
    let tallies = lanes * size_of::<LaneTally>() as u64;
    let jotons = stored * size_of::<Joton>() as u64;
    let mut all = vec![
        Buffer::new("lanes", lanes * size_of::<PathState>() as u64, "jotons on their way"),
        Buffer::new("tallies_caustic", tallies, "counts and energy, caustic map"),
        Buffer::new("tallies_diffuse", tallies, "counts and energy, diffuse map"),
        Buffer::new("lane_starts", (lanes + 1) * WORD, "first joton of each lane"),
        Buffer::new("jotons", jotons, "jotons as they were stored"),
        Buffer::new("keys_a", stored * WORD, "grid bucket of each joton"),
        Buffer::new("keys_b", stored * WORD, "the same, other half of a sort"),
        Buffer::new("places_a", stored * WORD, "place of each joton"),
        Buffer::new("places_b", stored * WORD, "the same, other half of a sort"),
        Buffer::new("histogram", histogram * WORD, "digits of a sort"),
        Buffer::new("block_sums", scanned.div_ceil(u64::from(SCAN_BLOCK)) * WORD, "sums of a scan"),
    ];
    all.extend(sorted_buffers(stored, most(&MapLayout::buckets)));
    all
}

/// A sorted map.
fn sorted_buffers(stored: u64, buckets: u64) -> [Buffer; 2] {
    let jotons = stored * size_of::<Joton>() as u64;
    [
        Buffer::new("sorted_jotons", jotons, "jotons in the order of the grid"),
        Buffer::new("bucket_starts", buckets * WORD, "first joton of each bucket"),
    ]
}

/// What each pixel needs.
fn pixel_buffers(plan: &Plan, pixels: u64) -> Vec<Buffer> {
    let [caustic, diffuse] = MapKind::ALL.map(|kind| plan.has_map(kind));
    let emission = plan.traces(Layer::Emission);
    let fit = size_of::<Fit>() as u64;
    // kernels that can do without still have a binding for it
    let edges = if diffuse { pixels } else { 0 };
    let clip = size_of::<Clip>() as u64;
    let trees = SplitPaths::most(pixels).max(TREES_MAX.into());
    let all = [
        (true, "gather_points", pixels * size_of::<GatherPoint>() as u64, "where camera paths end"),
        (true, "fits", pixels.max(TREES_MAX.into()) * fit, "what trees see, weights of discs"),
        (caustic || emission, "radii", pixels * fit, "radius of the caustic map, what the pilot's trees see"),
        (caustic, "counts", pixels * WORD, "jotons that the pilot found"),
        (emission, "glints", trees * WORD, "trees that look for emission"),
        (caustic || diffuse, "edges", edges * WORD, "whether a disc is whole"),
        (diffuse, "clips", pixels * clip, "walls about a disc"),
        (caustic, "walls", pixels * clip, "walls about a caustic disc"),
        (caustic, "interiors", pixels * INTERIOR, "where a caustic disc is whole"),
    ];
    let needed = all.into_iter().filter(|(is_needed, ..)| *is_needed);
    let mut all: Vec<Buffer> =
        needed.map(|(_, name, bytes, holds)| Buffer::new(name, bytes, holds)).collect();
    for (layer, film) in Layer::ALL.into_iter().zip(FILMS) {
        // the first kernel has a binding for emission, whether it is wanted or not
        let is_held = plan.traces(layer) || layer == Layer::Emission;
        let bytes = if is_held { pixels * FILM_PIXEL } else { 0 };
        all.push(Buffer::new(film, bytes, "sums of a layer"));
    }
    all
}

/// How many area points the discs of a pass want, with at most `most`.
pub fn area_points_wanted(scene: &PackedScene, radius: f64, most: usize) -> usize {
    let discs = scene.diffuse_area / (std::f64::consts::PI * radius * radius);
    ((POINTS_PER_DISC * discs) as usize).clamp(1, most)
}

/// Bytes of all of these buffers with a limit on them, at most: later passes have more area points.
fn most_bytes(buffers: &[Buffer], limit: Option<u64>) -> u64 {
    let most = area_points_most(limit);
    let area = |b: &Buffer| if b.name == "area_points" { area_points(most, most).bytes } else { b.bytes };
    buffers.iter().map(area).sum()
}

/// Most area points of a render that may take so much memory.
pub fn area_points_most(memory: Option<u64>) -> usize {
    let share = |bytes: u64| (bytes / AREA_MEMORY_SHARE) as usize / size_of::<AreaPoint>();
    memory.map_or(AREA_POINTS_MAX, share).clamp(1, AREA_POINTS_MAX)
}

/// The buffer for so many area points, of at most `most`.
pub fn area_points(count: usize, most: usize) -> Buffer {
    let each = size_of::<AreaPoint>() as u64;
    // rounding may add one
    let bytes = ((count * AREA_SLACK).min(most) as u64 + 1) * each;
    Buffer::new("area_points", bytes, "sample of the diffuse surfaces")
}
