//! Kernels: what a pass dispatches, how much work that is, and what it costs, told without a device.
//!
//! **Work** is counted, not guessed: a few thousand paths tell how many nodes and triangles rays look at, and how many jotons and
//! area points lie in the buckets that discs look through ([`super::traffic`], `discs.rs`). A test holds it to what is there.
//!
//! **Costs** are milliseconds of a reference machine: two idle cores, lavapipe of Mesa 22.3.6 (LLVM 15, 8 lanes). Unit costs
//! were fitted by hand to `--timings` of 15 scenes at 192 × 192 and 512 × 512 (docs/BENCHMARKS.md, "What a plan tells"). Other
//! machines differ in all of it.

use super::buffers::{AREA_KEY_BITS, BufferPlan, SCAN_BLOCK, area_points_most, area_points_wanted, is_small};
use super::discs::{Looked, Place, caustic_radius, caustic_radius_most};
use super::grid::Grid;
use super::map_layout::{DIGIT_BITS, MapLayout};
use super::strips::Strip;
use super::traffic::Traffic;
use crate::estimators::maps::MapKind;
use crate::estimators::radii::Schedule;
use crate::film::Layer;
use crate::packed::constants::{CELL_JOTONS, TILE};
use crate::packed::layout::{GatherPoint, Joton, PathState};
use crate::packed::scatter_area_points;
use glam::Vec3;
use std::f64::consts::PI;

/// A kernel in a pass: all its dispatches together.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Kernel {
    /// File and entry point, as the report of a render names it.
    pub name: &'static str,
    /// The map that it works for, of those that work for both.
    pub map: Option<&'static str>,
    /// Dispatches.
    pub dispatches: u64,
    /// Invocations of all of them.
    pub invocations: u64,
    /// Rays; estimated.
    pub rays: u64,
    /// Nodes and triangles that the rays look at; estimated.
    pub steps: u64,
    /// Jotons or area points that are tested against a disc; estimated.
    pub tests: u64,
    /// Bytes read and written, but for the scene; estimated.
    pub bytes: u64,
    /// Whether neighbouring invocations trace rays that go anywhere.
    pub is_scattered: bool,
    /// Estimated cost on the reference machine, milliseconds.
    pub milliseconds: f64,
}

/// Nanoseconds of a ray from the eye or to a light, and of a node or triangle that it looks at: neighbours look at the same.
const RAY_COHERENT: f64 = 30.0;
const STEP_COHERENT: f64 = 18.0;
/// The same of a joton's ray: the invocations that run in step wait for each other.
const RAY_SCATTERED: f64 = 30.0;
const STEP_SCATTERED: f64 = 36.0;
/// Part of what a node or triangle costs in a scene that lies in uniform buffers.
const SMALL_SHARE: f64 = 0.3;
/// Nanoseconds of a joton or area point that is tested.
const TEST: f64 = 1.5;
/// … and more of a joton that may be weighed by a glossy lobe.
const TEST_GLOSSY: f64 = 6.0;
/// Nanoseconds of an invocation, over its rays, tests and bytes.
const INVOCATION: f64 = 5.0;
/// Nanoseconds of what is done with a ray from the eye where it ends, with one to a light, and to start a joton.
const EYE: f64 = 40.0;
const DIRECT: f64 = 175.0;
const EMISSION: f64 = 60.0;
/// Nanoseconds of a gather point: its row of cells, its walls.
const GATHER: f64 = 200.0;
/// Nanoseconds of a disc whose area is measured.
const DISC: f64 = 1500.0;
/// Bytes of what is known and found of a caustic disc: radius, interior, area, walls.
const DISC_BYTES: f64 = 80.0;
/// Nanoseconds of a byte.
const BYTE: f64 = 0.12;
/// Nanoseconds of a dispatch.
const DISPATCH: f64 = 6000.0;

/// Area points that a plan looks at to tell how they lie.
const AREA_SAMPLES: usize = 1 << 14;
/// Area points in a disc below which it never looks whole: chance moves their centroid.
const POINTS_FEW: f64 = 100.0;
/// Rays of a pixel's trees for each of its eye path, where there are trees.
const GLINT_RAYS: f64 = 4.0;
/// Part of the pixels on the edges of lamps.
const GLINT_EDGES: f64 = 0.03;
/// Pixels that the pilot marks for each whose one path sees a light so: it looks eight times, and at neighbours.
const GLINT_NEAR: f64 = 4.0;
/// Bytes of a word, and of a pixel of a film that is read and written.
const WORD: f64 = 4.0;
const FILM: f64 = 32.0;

/// What one kernel does for one item.
#[derive(Clone, Copy, Default)]
struct Work {
    rays: f64,
    /// Nodes and triangles that the rays look at.
    steps: f64,
    tests: f64,
    bytes: f64,
    /// Nanoseconds of everything else.
    rest: f64,
}

impl BufferPlan<'_> {
    /// The kernels of the first pass, in their order.
    pub fn kernels(&self, traffic: &Traffic) -> Vec<Kernel> {
        let small = if is_small(self.scene, &self.machine) { SMALL_SHARE } else { 1.0 };
        let mut list = List { small, kernels: Vec::new() };
        let maps: Vec<(MapKind, MapLayout)> =
            MapKind::ALL.into_iter().filter_map(|k| Some((k, self.shapes.of(k)?))).collect();
        let strips: Vec<Strip> = self.strips.each().collect();
        self.camera_kernels(&mut list, traffic, &strips);
        for &(kind, shape) in &maps {
            self.map_kernels(&mut list, traffic, kind, shape);
            self.gather_kernels(&mut list, traffic, kind, &strips);
        }
        if self.plan.has_indirect_paths() {
            self.indirect_kernel(&mut list, traffic, &strips);
        }
        list.kernels
    }

    fn camera_kernels(&self, list: &mut List, traffic: &Traffic, strips: &[Strip]) {
        let rows = |s: &Strip| u64::from(s.rows) * u64::from(self.strips.size[0]);
        let pixels: Vec<u64> = strips.iter().map(rows).collect();
        let camera = &traffic.camera;
        let point = size_of::<GatherPoint>() as f64;
        let eye = Work {
            rays: camera.rays,
            steps: camera.steps,
            bytes: 2.0 * point + FILM,
            rest: INVOCATION + camera.rays * EYE,
            ..Work::default()
        };
        list.add("eye", None, &pixels, eye);
        if self.plan.traces(Layer::Emission) {
            let share = (GLINT_EDGES + GLINT_NEAR * camera.glints).min(1.0);
            let rays = share * GLINT_RAYS * camera.rays;
            let steps = share * GLINT_RAYS * camera.steps;
            let glint = Work { rays, steps, bytes: point, rest: INVOCATION + rays * EYE, ..Work::default() };
            list.add("glint", None, &pixels, glint);
            let sum = Work { bytes: share * FILM, rest: share * INVOCATION, ..Work::default() };
            list.add("glint_sum", None, &pixels, sum);
        }
        if self.plan.traces(Layer::Direct) {
            let samples = f64::from(self.plan.settings.shadow_rays);
            let rays = traffic.shadow.rays * samples;
            // a light is looked at for each candidate, and the lobes for each ray
            let looks = camera.stored * samples * f64::from(self.plan.light_candidates);
            let direct = Work {
                rays,
                steps: traffic.shadow.steps * samples,
                bytes: point + FILM,
                rest: INVOCATION + (rays + looks) * 0.5 * DIRECT,
                ..Work::default()
            };
            list.add("direct", None, &pixels, direct);
        }
    }

    /// Filling and sorting a map.
    fn map_kernels(&self, list: &mut List, traffic: &Traffic, kind: MapKind, shape: MapLayout) {
        let mean = traffic.of(kind);
        let map = Some(kind.name());
        let lanes = u64::from(shape.lanes);
        let emitted = f64::from(shape.emitted);
        let stored = emitted * mean.stored;
        let joton = size_of::<Joton>() as f64;
        // what a whole step does, shared out among its invocations
        let shared = |total: f64, by: u64| total / (by.max(1) as f64);
        let dispatches = u64::from(shape.dispatches);
        let trace = Work {
            rays: shared(emitted * mean.rays, lanes * dispatches),
            steps: shared(emitted * mean.steps, lanes * dispatches),
            bytes: 2.0 * size_of::<PathState>() as f64 + shared(stored * joton, lanes * dispatches),
            rest: INVOCATION + shared(emitted * EMISSION, lanes * dispatches),
            ..Work::default()
        };
        list.add_scattered("trace", map, &vec![lanes; dispatches as usize], trace);
        let moved = |bytes: f64| Work { bytes, rest: INVOCATION, ..Work::default() };
        list.add("lane_counts", map, &[lanes + 1], moved(2.0 * WORD));
        let mut scans = vec![lanes + 1];
        list.add("map_keys", map, &[lanes], moved(shared(stored * (joton + 2.0 * WORD), lanes)));
        let chunks = u64::from(shape.chunks(&self.machine));
        let digits = vec![chunks; shape.digits() as usize];
        let histogram = f64::from(1 << DIGIT_BITS) * WORD;
        list.add("radix count", map, &digits, moved(shared(stored * WORD, chunks) + histogram));
        list.add("radix scatter", map, &digits, moved(shared(stored * 4.0 * WORD, chunks) + histogram));
        scans.extend(digits.iter().map(|chunks| chunks << DIGIT_BITS));
        let block = f64::from(SCAN_BLOCK) * WORD;
        let blocks: Vec<u64> = scans.iter().map(|count| count.div_ceil(u64::from(SCAN_BLOCK))).collect();
        list.add("scan reduce", map, &blocks, moved(block));
        let sums = blocks.iter().sum::<u64>() as f64 / blocks.len() as f64 * 2.0 * WORD;
        list.add("scan spine", map, &vec![1; blocks.len()], moved(sums));
        list.add("scan apply", map, &blocks, moved(2.0 * block));
        let search = stored.max(2.0).log2() * WORD;
        list.add("map_starts", map, &[shape.buckets()], moved(search));
        let slots = shape.max_stored();
        list.add("map_reorder", map, &[slots], moved(shared(stored * (2.0 * joton + WORD), slots)));
    }

    /// Paths that go on from the gather points: rays, light at their surfaces, and the caustic map there.
    fn indirect_kernel(&self, list: &mut List, traffic: &Traffic, strips: &[Strip]) {
        let pixels: Vec<u64> = strips.iter().map(|s| self.pixels_of_tiles(s)).collect();
        let paths = &traffic.indirect;
        let most = f64::from(CELL_JOTONS);
        let jotons = self.jotons_looked_at(traffic, MapKind::Caustic);
        let tests = |place: &Place| {
            let radius = caustic_radius_most(self.plan, place);
            jotons.as_ref().map_or(0.0, |jotons| jotons.tests_at_most(place.position, radius, most))
        };
        let glossy = |place: &Place| if place.is_glossy { tests(place) } else { 0.0 };
        let looks = paths.stored * f64::from(self.plan.light_candidates);
        let gathers = if jotons.is_some() { paths.stored } else { 0.0 };
        let work = Work {
            rays: paths.rays,
            steps: paths.steps,
            tests: traffic.mean_of_indirect_places(tests),
            bytes: size_of::<GatherPoint>() as f64 + FILM,
            rest: INVOCATION
                + (paths.rays + looks) * 0.5 * DIRECT
                + gathers * (GATHER + DISC)
                + traffic.mean_of_indirect_places(glossy) * TEST_GLOSSY,
        };
        list.add_scattered("indirect", None, &pixels, work);
    }

    /// Pixels of whole tiles over a strip.
    fn pixels_of_tiles(&self, s: &Strip) -> u64 {
        let [across, down] = [self.strips.size[0], s.rows].map(|n| u64::from(n.div_ceil(TILE)));
        across * down * u64::from(TILE * TILE)
    }

    /// The jotons of a map by place; none where there is no such map.
    fn jotons_looked_at(&self, traffic: &Traffic, kind: MapKind) -> Option<Looked> {
        let shape = self.shapes.of(kind)?;
        let stored = f64::from(shape.emitted) * traffic.of(kind).stored;
        let radius = self.schedule(kind).radius(0) as f32;
        let grid = Grid::new(self.scene.bounds, radius, shape.key_bits());
        Some(Looked::new(grid, &traffic.stored[kind as usize], stored))
    }

    fn gather_kernels(&self, list: &mut List, traffic: &Traffic, kind: MapKind, strips: &[Strip]) {
        let map = Some(kind.name());
        let pixels: Vec<u64> = strips.iter().map(|s| self.pixels_of_tiles(s)).collect();
        let point = size_of::<GatherPoint>() as f64;
        let points = traffic.camera.stored;
        let work = |tests: f64, glossy: f64| Work {
            tests,
            bytes: point + FILM,
            rest: points * GATHER + glossy * TEST_GLOSSY,
            ..Work::default()
        };
        let over_places = |tests: &dyn Fn(&Place) -> f64| traffic.mean_of_places(tests);
        let glossy = |place: &Place, tests: f64| if place.is_glossy { tests } else { 0.0 };
        let Some(jotons) = self.jotons_looked_at(traffic, kind) else { return };
        let schedule = self.schedule(kind);
        let radius = schedule.radius(0) as f32;
        let tests = |place: &Place| {
            let caustic = || caustic_radius(self.plan, place, &jotons);
            jotons.tests(place.position, if kind == MapKind::Caustic { caustic() } else { radius })
        };
        let gather = work(over_places(&tests), over_places(&|place| glossy(place, tests(place))));
        if kind == MapKind::Caustic {
            let is_measured = |place: &Place| {
                let has_jotons =
                    jotons.tests(place.position, caustic_radius(self.plan, place, &jotons)) > 0.0;
                if place.is_cut && has_jotons { 1.0 } else { 0.0 }
            };
            let rest = INVOCATION + over_places(&is_measured) * DISC;
            let measure = Work { bytes: point + DISC_BYTES, rest, ..Work::default() };
            list.add("caustic_disc", map, &pixels, measure);
            list.add("gather", map, &pixels, gather);
            return;
        }
        let most = area_points_most(self.plan.buffer_limit());
        let wanted = area_points_wanted(self.scene, schedule.radius(0), most);
        let (sample, _) = scatter_area_points(self.scene, wanted.min(AREA_SAMPLES), 0);
        let sample: Vec<Vec3> = sample.iter().map(|p| p.position).collect();
        let all = wanted as f64 * sample.len() as f64 / wanted.min(AREA_SAMPLES) as f64;
        let area_points = Looked::new(Grid::new(self.scene.bounds, radius, AREA_KEY_BITS), &sample, all);
        let discs = self.scene.diffuse_area / (PI * schedule.radius(0).powi(2));
        let are_few = (wanted as f64) < POINTS_FEW * discs;
        let cut = |place: &Place| {
            if place.is_cut || are_few { area_points.tests(place.position, radius) } else { 0.0 }
        };
        list.add("kernel_correction", map, &pixels, work(over_places(&cut), 0.0));
        list.add("gather", map, &pixels, gather);
    }

    fn schedule(&self, kind: MapKind) -> &Schedule {
        if kind == MapKind::Caustic { &self.plan.caustic } else { &self.plan.diffuse }
    }
}

/// Collects kernels and what they cost.
struct List {
    /// Factor on the cost of a node or triangle.
    small: f64,
    kernels: Vec<Kernel>,
}

impl List {
    /// A kernel that is dispatched over these numbers of items.
    fn add(&mut self, name: &'static str, map: Option<&'static str>, items: &[u64], each: Work) {
        self.push(name, map, items, each, false);
    }

    /// One whose rays go anywhere.
    fn add_scattered(&mut self, name: &'static str, map: Option<&'static str>, items: &[u64], each: Work) {
        self.push(name, map, items, each, true);
    }

    fn push(
        &mut self,
        name: &'static str,
        map: Option<&'static str>,
        items: &[u64],
        each: Work,
        is_scattered: bool,
    ) {
        let [ray, step] =
            if is_scattered { [RAY_SCATTERED, STEP_SCATTERED] } else { [RAY_COHERENT, STEP_COHERENT] };
        let invocations: u64 = items.iter().sum();
        let n = invocations as f64;
        let nanoseconds = DISPATCH * items.len() as f64
            + n * (self.small * (each.rays * ray + each.steps * step)
                + each.tests * TEST
                + each.bytes * BYTE
                + each.rest);
        self.kernels.push(Kernel {
            name,
            map,
            dispatches: items.len() as u64,
            invocations,
            rays: (n * each.rays) as u64,
            steps: (n * each.steps) as u64,
            tests: (n * each.tests) as u64,
            bytes: (n * each.bytes) as u64,
            is_scattered,
            milliseconds: nanoseconds * 1e-6,
        });
    }
}
