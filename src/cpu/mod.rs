//! The CPU backend: the estimators of the GPU's kernels on native threads, written apart from them so that each can
//! catch the other's mistakes; and the plain path tracer, ground truth for what path tracing can see.
//!
//! A pass: jotons → kd-trees → eye paths, direct light and gather, pixel by pixel. Every sum is taken in a fixed
//! order: the same image whatever the number of threads.

mod boundary;
mod clip;
mod direct;
mod eye;
mod gather;
mod glint;
#[doc(hidden)]
pub mod harness;
mod kd_tree;
mod maps;
mod path_tracer;
mod pixels;
mod streams;
mod trace;

pub use path_tracer::PathTracer;

use crate::backend::{Backend, Batch, Tally};
use crate::bands::{BLACK, Bands};
use crate::error::Result;
use crate::film::{LAYERS, Layer};
use crate::pack::{PackedScene, scatter_area_points};
use crate::plan::{Plan, shrink};
use crate::rng::sequence_seed;
use boundary::Interior;
use clip::Clip;
use maps::{AreaMap, JotonMap};
use std::f64::consts::PI;
use std::sync::Arc;

/// Passes that share one scatter of area points: its error must average out, its cost must not show.
const PASSES_PER_SCATTER: u64 = 16;
/// Area points wanted in a disc of the diffuse radius; 150 are the least that pay.
const AREA_POINTS_PER_DISC: f64 = 250.0;
/// Most area points.
const AREA_POINTS_MAX: f64 = 2e6;
/// The pass whose jotons choose the caustic radii and whose chains mark glints; not part of the image.
const PILOT_PASS: u32 = u32::MAX;

/// Renders passes of a plan on this machine's threads.
pub struct CpuBackend {
    scene: Arc<PackedScene>,
    plan: Plan,
    /// Squared caustic radius of each pixel in the first pass; empty until it is needed.
    caustic_base: Vec<f32>,
    /// Whether each pixel's emission is left to glint chains; empty until it is needed.
    glints: Vec<bool>,
    /// Walls about each pixel's gather point; empty until they are needed.
    clips: Vec<Clip>,
    area: Option<Area>,
}

/// What is known of the diffuse surfaces' area, for a group of passes.
struct Area {
    /// The group's number.
    group: u64,
    map: AreaMap,
    /// For each pixel; empty in the first pass of a group, which may be the only one that is rendered.
    interiors: Vec<Interior>,
}

/// Everything that the pixels of one pass read.
struct Pass<'a> {
    scene: &'a PackedScene,
    plan: &'a Plan,
    index: u32,
    caustic: JotonMap,
    diffuse: JotonMap,
    area: Option<&'a AreaMap>,
    caustic_base: &'a [f32],
    /// Whether each pixel's emission is left to glint chains; empty where no emission is traced.
    glints: &'a [bool],
    /// Factor on the squared caustic radius.
    caustic_shrink: f32,
    /// Radius of the diffuse map.
    diffuse_radius: f32,
    /// Where each pixel's disc is known to be whole; empty where nothing is known.
    interiors: &'a [Interior],
    /// Walls about each pixel's gather point; empty where no map is traced.
    clips: &'a [Clip],
}

impl CpuBackend {
    /// A backend for a scene and its plan, on the threads of rayon's current pool.
    pub fn new(scene: Arc<PackedScene>, plan: Plan) -> Self {
        Self { scene, plan, caustic_base: Vec::new(), glints: Vec::new(), clips: Vec::new(), area: None }
    }

    /// Scatter new area points where `pass` belongs to another group than the last; survey them once they are used
    /// a second time. What is done depends on the pass alone, not on those rendered before.
    fn refresh_area(&mut self, pass: u64) {
        if !self.plan.traces(Layer::Diffuse) {
            return;
        }
        let group = pass / PASSES_PER_SCATTER;
        let first = group * PASSES_PER_SCATTER;
        let (scene, plan) = (&self.scene, &self.plan);
        if self.area.as_ref().is_none_or(|a| a.group != group) {
            // dense enough for the smallest radius of the group
            let radius = plan.diffuse.radius(first + PASSES_PER_SCATTER - 1);
            let count = AREA_POINTS_PER_DISC * scene.diffuse_area / (PI * radius * radius);
            let seed = sequence_seed(plan.settings.seed, group as u32, streams::STREAM_AREA);
            let (points, area_each) =
                scatter_area_points(scene, count.min(AREA_POINTS_MAX).ceil() as usize, seed);
            self.area = Some(Area { group, map: AreaMap::new(&points, area_each), interiors: Vec::new() });
        }
        if let Some(area) = &mut self.area
            && pass != first
            && area.interiors.is_empty()
        {
            let radius = plan.diffuse.radius(first) as f32;
            area.interiors = pixels::interiors(scene, plan, first as u32, &area.map, radius);
        }
    }

    fn pass(&mut self, pass: u64, layers: &mut [Vec<Bands>; LAYERS], tally: &mut Tally) {
        self.refresh_area(pass);
        let (scene, plan) = (&*self.scene, &self.plan);
        let index = pass as u32;
        let mut map = |layer: Layer| {
            if !plan.traces(layer) {
                return JotonMap::default();
            }
            JotonMap::new(trace::jotons(scene, plan, index, layer == Layer::Caustic, tally))
        };
        let (caustic, diffuse) = (map(Layer::Caustic), map(Layer::Diffuse));
        let diffuse_radius = plan.diffuse.radius(pass) as f32;
        // pass by pass the same, whatever was rendered before: the first pass of a group knows nothing
        let area = self.area.as_ref();
        let known = !pass.is_multiple_of(PASSES_PER_SCATTER);
        let pass = Pass {
            scene,
            plan,
            index,
            caustic,
            diffuse,
            area: area.map(|a| &a.map),
            caustic_base: &self.caustic_base,
            glints: &self.glints,
            caustic_shrink: shrink(plan.caustic.alpha, pass) as f32,
            diffuse_radius,
            clips: &self.clips,
            interiors: area.filter(|_| known).map_or(&[][..], |a| &a.interiors[..]),
        };
        *tally += pixels::render(&pass, layers);
    }
}

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("CPU, {} threads", rayon::current_num_threads())
    }

    fn blur(&self, pass: u64) -> [f64; LAYERS] {
        self.plan.blur(pass)
    }

    fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
        let mut tally = Tally::default();
        if self.plan.traces(Layer::Caustic) && self.caustic_base.is_empty() {
            let jotons = trace::jotons(&self.scene, &self.plan, PILOT_PASS, true, &mut Tally::default());
            self.caustic_base =
                pixels::caustic_base(&self.scene, &self.plan, PILOT_PASS, &JotonMap::new(jotons));
        }
        if self.plan.traces(Layer::Emission) && self.glints.is_empty() {
            self.glints = glint::mark(&self.scene, self.plan.settings.seed, PILOT_PASS);
        }
        if self.clips.is_empty() && (self.plan.traces(Layer::Caustic) || self.plan.traces(Layer::Diffuse)) {
            // with the area points of the first passes, whatever is rendered first
            self.refresh_area(0);
            // mirrors have no area points; and --paths must not change what is found
            let area = self.area.as_ref().filter(|_| !self.plan.has_specular_bodies()).map(|a| &a.map);
            self.clips = pixels::clips(&self.scene, &self.plan, PILOT_PASS, area);
        }
        let mut layers = std::array::from_fn(|_| vec![BLACK; self.scene.pixels()]);
        for pass in first..first + u64::from(count) {
            self.pass(pass, &mut layers, &mut tally);
        }
        Ok(Batch { layers, tally })
    }
}
