//! The CPU backend: the estimators of the GPU's kernels on native threads, written apart from them so that each can
//! catch the other's mistakes; and the plain path tracer, ground truth for what path tracing can see.
//!
//! A pass: jotons → kd-trees → eye paths, direct light and gather, pixel by pixel. Every sum is taken in a fixed
//! order: the same image whatever the number of threads.

mod candidates;
mod clip_planes;
mod direct;
mod disc;
mod eye;
mod followed_light;
mod gather;
mod glint;
#[doc(hidden)]
pub mod harness;
mod indirect;
mod interior;
mod kd_tree;
mod kernel_correction;
mod maps;
mod path_tracer;
mod pixels;
mod splits;
mod streams;
mod trace;
mod window;

pub use path_tracer::PathTracer;

use crate::backend::{Backend, Batch, Spare, Tally};
use crate::error::Result;
use crate::estimators::maps::MapKind;
use crate::estimators::radii::{area_group, shrink};
use crate::estimators::split_paths::SplitPaths;
use crate::film::tile_schedule::TileSchedule;
use crate::film::{LAYERS, Layer};
use crate::packed::constants::PILOT_PASS;
use crate::packed::{PackedScene, PassBands, scatter_area_points};
use crate::plan::{InBands, Part, Plan};
use crate::resolve::Resolver;
use crate::sampling::rng::sequence_seed;
use crate::spectrum::Bands;
use clip_planes::Clip;
use interior::Interior;
use maps::{AreaMap, JotonMap};
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// Area points wanted in a disc of the diffuse radius; 150 are the least that pay.
const AREA_POINTS_PER_DISC: f64 = 250.0;
/// Most area points.
const AREA_POINTS_MAX: f64 = 2e6;

/// Renders passes of a plan on this machine's threads.
pub struct CpuBackend {
    scene: Arc<PackedScene>,
    plan: Plan,
    /// Squared caustic radius of each pixel in the first pass; empty until it is needed.
    caustic_base: Vec<f32>,
    /// In which pixels trees look for emission; none until it is needed, or where no emission is traced.
    glints: Option<SplitPaths>,
    /// Where caustic discs are known to be whole, for each pixel; empty until it is needed.
    caustic_interiors: Vec<Interior>,
    /// Walls about each pixel's gather point; empty until they are needed, or where there is no diffuse map.
    clips: Vec<Clip>,
    area: Option<Area>,
    survey: Option<Survey>,
    schedule: TileSchedule,
    spare: Spare,
}

/// What is known of the diffuse surfaces' area, for a group of passes.
struct Area {
    /// The passes that it is for.
    group: Range<u64>,
    map: AreaMap,
}

/// Where discs were found to be whole.
struct Survey {
    /// The first pass that it is for.
    pass: u64,
    /// For each pixel.
    interiors: Vec<Interior>,
}

/// The pass whose survey `pass` uses: 2, 8, 32, … The first two passes know nothing; they may be all that is rendered.
fn survey_pass(pass: u64) -> Option<u64> {
    (pass >= 2).then(|| 2 << ((pass / 2).ilog2() / 2 * 2))
}

/// Everything that the pixels of one pass read.
struct Pass<'a> {
    scene: &'a PackedScene,
    plan: &'a Plan,
    /// What the bands are, where they are not red, green and blue.
    bands: Option<&'a PassBands>,
    index: u32,
    caustic: JotonMap,
    diffuse: JotonMap,
    area: Option<&'a AreaMap>,
    caustic_base: &'a [f32],
    /// In which pixels trees look for emission; none where no emission is traced.
    glints: Option<&'a SplitPaths>,
    /// Factor on the squared caustic radius.
    caustic_shrink: f32,
    /// Radius of the diffuse map.
    diffuse_radius: f32,
    /// Where each pixel's disc is known to be whole; empty where nothing is known.
    interiors: &'a [Interior],
    /// Where each pixel's caustic disc is known to be whole.
    caustic_interiors: &'a [Interior],
    /// Walls about each pixel's gather point; empty where there is no diffuse map.
    clips: &'a [Clip],
    /// Who rests.
    schedule: &'a TileSchedule,
}

impl CpuBackend {
    /// A backend for a scene and its plan, on the threads of rayon's current pool.
    pub fn new(scene: Arc<PackedScene>, plan: Plan) -> Self {
        Self {
            schedule: TileSchedule::none(scene.size),
            scene,
            plan,
            caustic_base: Vec::new(),
            glints: None,
            caustic_interiors: Vec::new(),
            clips: Vec::new(),
            area: None,
            survey: None,
            spare: Spare::default(),
        }
    }

    /// Area points for the group of passes that `pass` belongs to. They depend on the group alone, not on what was
    /// rendered before.
    fn refresh_area(&mut self, pass: u64) {
        let group = area_group(pass);
        if !self.plan.has_map(MapKind::Diffuse) || self.area.as_ref().is_some_and(|a| a.group == group) {
            return;
        }
        let (scene, plan) = (&self.scene, &self.plan);
        // dense enough for the smallest radius of the group
        let radius = plan.diffuse.radius(group.end - 1);
        let count = AREA_POINTS_PER_DISC * scene.diffuse_area / (PI * radius * radius);
        let seed = sequence_seed(plan.settings.seed, group.start as u32, streams::STREAM_AREA);
        let (points, area_each) =
            scatter_area_points(scene, count.min(AREA_POINTS_MAX).ceil() as usize, seed);
        self.area = Some(Area { group, map: AreaMap::new(&points, area_each) });
    }

    /// Survey where discs are whole, for `pass` and those after it, where that pays: it costs as much as the fits of a
    /// pass. Radii only shrink: what is whole stays whole.
    fn refresh_survey(&mut self, pass: u64) {
        let wanted = survey_pass(pass);
        if !self.plan.has_map(MapKind::Diffuse) || self.survey.as_ref().map(|s| s.pass) == wanted {
            return;
        }
        self.survey = None;
        if let Some(first) = wanted {
            self.refresh_area(first);
            let radius = self.plan.diffuse.radius(first) as f32;
            self.survey = self.area.as_ref().map(|area| Survey {
                pass: first,
                interiors: pixels::interiors(&self.scene, &self.plan, first as u32, &area.map, radius),
            });
        }
    }

    /// Choose the caustic radii and find what surrounds each pixel's gather point of the pilot pass, once.
    fn look_around(&mut self) {
        if self.plan.traces(Layer::Caustic) && self.caustic_base.is_empty() {
            let (scene, plan) = (&self.scene, &self.plan);
            let map = JotonMap::new(trace::jotons(scene, plan, PILOT_PASS, true, &mut Tally::default()));
            let found = pixels::caustic_discs(scene, plan, PILOT_PASS, &map);
            self.caustic_base = pixels::caustic_base(scene, plan, &found);
            self.caustic_interiors = pixels::caustic_interiors(&found);
        }
        if self.plan.has_map(MapKind::Diffuse) && self.clips.is_empty() {
            // mirrors have no area points; and --paths must not change what is found
            let by_area = !self.plan.has_specular_bodies();
            if by_area {
                // with the area points of the first passes, whatever is rendered first
                self.refresh_area(0);
            }
            let area = self.area.as_ref().filter(|_| by_area).map(|a| &a.map);
            self.clips = pixels::clips(&self.scene, &self.plan, PILOT_PASS, area);
        }
    }

    fn pass(&mut self, pass: u64, layers: &mut [Vec<Bands>; LAYERS], tally: &mut Tally) {
        self.refresh_survey(pass);
        self.refresh_area(pass);
        let in_bands = InBands::of(&self.scene, &self.plan, pass).map(|b| (b.plan(&self.plan), b));
        let (scene, plan, bands) = match &in_bands {
            Some((plan, InBands { scene, bands, .. })) => (scene, plan, Some(bands)),
            None => (&*self.scene, &self.plan, None),
        };
        let index = pass as u32;
        let mut map = |kind: MapKind| {
            if !plan.has_map(kind) {
                return JotonMap::default();
            }
            JotonMap::new(trace::jotons(scene, plan, index, kind == MapKind::Caustic, tally))
        };
        let (caustic, diffuse) = (map(MapKind::Caustic), map(MapKind::Diffuse));
        let diffuse_radius = plan.diffuse.radius(pass) as f32;
        let pass = Pass {
            scene,
            plan,
            bands,
            index,
            caustic,
            diffuse,
            area: self.area.as_ref().map(|a| &a.map),
            caustic_base: &self.caustic_base,
            glints: self.glints.as_ref(),
            caustic_shrink: shrink(plan.caustic.alpha, pass) as f32,
            diffuse_radius,
            caustic_interiors: &self.caustic_interiors,
            clips: &self.clips,
            schedule: &self.schedule,
            interiors: self.survey.as_ref().map_or(&[][..], |s| &s.interiors[..]),
        };
        *tally += pixels::render(&pass, layers);
    }
}

impl Backend for CpuBackend {
    fn describe(&self) -> String {
        format!("CPU, {} threads", rayon::current_num_threads())
    }

    fn blur(&self, pass: u64) -> f64 {
        self.plan.blur(pass)
    }

    fn traces(&self, layer: Layer) -> bool {
        self.plan.traces(layer)
    }

    fn resolver(&self) -> Option<Arc<Resolver>> {
        Resolver::of_layers(self.scene.clone(), self.plan.settings.seed, self.plan.resolved_layers())
            .map(Arc::new)
    }

    fn set_tile_schedule(&mut self, schedule: &TileSchedule) -> bool {
        self.schedule = schedule.clone();
        !self.plan.settings.keeps(Part::Rest)
    }

    fn split_paths(&self) -> Option<&SplitPaths> {
        self.glints.as_ref()
    }

    fn set_split_paths(&mut self, glints: SplitPaths) -> Result<()> {
        self.glints = Some(glints);
        Ok(())
    }

    fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
        let mut tally = Tally::default();
        if self.plan.traces(Layer::Emission) && self.glints.is_none() {
            let looks = glint::look(&self.scene, self.plan.settings.seed, PILOT_PASS);
            self.glints = Some(SplitPaths::mark(self.scene.size, &looks, &self.plan.lamp_images));
        }
        self.look_around();
        let mut layers = self.spare.black_but(self.scene.pixels(), 0..0);
        for pass in first..first + u64::from(count) {
            self.pass(pass, &mut layers, &mut tally);
            tally.pixels_rested += self.schedule.pixels_resting(pass);
        }
        Ok(Batch { layers, tally })
    }

    fn reuse(&mut self, batch: Batch) {
        self.spare = Spare(batch.layers);
    }
}
