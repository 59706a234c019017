//! The pilot: what is found out on the device before the first pass, with random numbers of no pass that is rendered.

use super::glints;
use super::pipelines::{Glint, PassGraph};
use super::recorder::Recorder;
use super::{DISPATCHES_MAX, GpuBackend, check_traversal};
use crate::error::{Error, Result};
use crate::estimators::maps::MapKind;
use crate::estimators::split_paths::{Look, SplitPaths};
use crate::host::memory;
use crate::packed::constants::PILOT_PASS;
use crate::packed::layout::{MapInfo, PassInfo, status};
use crate::plan::buffers::fit;
use crate::plan::map_layout::{dispatches_kept, roomy};
use crate::plan::strips::Strip;

/// Lanes that are tried before the first pass.
const PROBE_LANES: u32 = 512;

impl GpuBackend {
    /// Everything that the pilot finds out.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails or a path does not end, [`Error::Capacity`] where a map does not fit.
    pub(super) fn run_pilot(&mut self) -> Result<()> {
        self.shape_lanes()?;
        self.cut_image()?;
        if self.shapes.caustic.is_some() {
            self.pilot_map(MapKind::Caustic)?;
        }
        if self.shapes.diffuse.is_some() {
            self.renew_area_points(0)?;
        }
        let mut looks = Vec::new();
        for strip in self.strips.each() {
            let all = strip.with_overlap();
            looks.extend(self.look_for_glints(strip)?);
            self.choose_caustic_radii(all)?;
            self.find_edges(all)?;
            if self.strips.count() > 1 {
                self.keep_strip(strip)?;
            }
        }
        if !looks.is_empty() {
            self.upload_glints(SplitPaths::mark(self.scene.size, &looks, &self.plan.lamp_images))?;
        }
        // of glints and walls, too, nothing was missed
        check_traversal(&self.status_words()?)?;
        self.warm_up()
    }

    /// Choose strips and jotons that fit, and make room for them.
    fn cut_image(&mut self) -> Result<()> {
        let machine = self.context.machine();
        self.strips = fit(&self.scene, &mut self.plan, &mut self.shapes, machine)?;
        if machine.is_software {
            // its memory is the host's
            self.needs().check_free(memory::available())?;
        }
        self.bind()
    }

    /// Find out how often the trace kernel must be dispatched and how much a lane stores, by tracing the pilot pass.
    fn shape_lanes(&mut self) -> Result<()> {
        // a part of the lanes tells as much as all of them
        let whole = self.shapes;
        for kind in [MapKind::Caustic, MapKind::Diffuse] {
            if let Some(shape) = self.shapes.of_mut(kind) {
                let part = f64::from(PROBE_LANES.min(shape.lanes)) / f64::from(shape.lanes);
                shape.lanes = PROBE_LANES.min(shape.lanes);
                shape.emitted = (f64::from(shape.emitted) * part).ceil() as u32;
            }
        }
        loop {
            self.bind()?;
            let mut settled = true;
            for kind in [MapKind::Caustic, MapKind::Diffuse] {
                let Some(shape) = self.shapes.of(kind) else { continue };
                let found = self.pilot_map(kind)?;
                let stored = found[status::LANE_STORED_MAX as usize];
                let mut wanted = shape;
                if found[status::UNFINISHED as usize] > 0 {
                    wanted.dispatches = shape.dispatches * 2;
                    settled = false;
                    if wanted.dispatches > DISPATCHES_MAX {
                        return Err(Error::device(
                            "a joton's path does not end",
                            "report this as a bug of joton",
                        ));
                    }
                } else if stored > shape.lane_capacity {
                    wanted.lane_capacity = roomy(stored);
                    settled = false;
                }
                *self.shapes.of_mut(kind) = Some(wanted);
            }
            if settled {
                for kind in [MapKind::Caustic, MapKind::Diffuse] {
                    if let (Some(shape), Some(whole)) = (self.shapes.of_mut(kind), whole.of(kind)) {
                        shape.dispatches = dispatches_kept(shape.dispatches);
                        (shape.lanes, shape.emitted) = (whole.lanes, whole.emitted);
                    }
                }
                return Ok(());
            }
        }
    }

    /// Fill one map from the pilot pass; the status words.
    fn pilot_map(&mut self, kind: MapKind) -> Result<Vec<u32>> {
        let Some(steps) = &self.steps else { return Ok(vec![0; status::SLOTS as usize]) };
        let Some((map, _)) = steps.maps.iter().find(|(m, _)| m.kind == kind) else {
            return Ok(vec![0; status::SLOTS as usize]);
        };
        let pass = self.pass_info(PILOT_PASS, self.strips.strip(0));
        let info = self.map_info(kind, 0, PILOT_PASS);
        let mut recorder = Recorder::new(&self.context, &mut self.ring, None);
        let pass_info = recorder.ring.push(&pass);
        recorder.clear(&self.buffers["lanes"]);
        recorder.clear(&self.buffers["status"]);
        map.record(&mut recorder, pass_info, &info);
        recorder.submit(&self.context, &self.buffers["ring"]);
        let words = self.status_words()?;
        check_traversal(&words)?;
        Ok(words)
    }

    /// What the kernels have raised since it was cleared.
    fn status_words(&mut self) -> Result<Vec<u32>> {
        let words = self.context.read(&mut self.staging, &[&self.buffers["status"]])?;
        Ok(bytemuck::pod_collect_to_vec(&words[0]))
    }

    /// Choose the caustic radius of each pixel; the pilot pass's map is there.
    fn choose_caustic_radii(&mut self, strip: Strip) -> Result<()> {
        let pass = self.pass_info(PILOT_PASS, strip);
        let info = self.map_info(MapKind::Caustic, 0, PILOT_PASS);
        let (pixels, tiles) = (self.pixels_of(strip), self.tiles_of(strip));
        let Some(PassGraph { eye, pilot: Some([count, radius]), caustic_disc: Some(disc), .. }) = &self.steps
        else {
            return Ok(());
        };
        let mut recorder = Recorder::new(&self.context, &mut self.ring, None);
        let at = [("pass_info", recorder.ring.push(&pass)), ("map_info", recorder.ring.push(&info))];
        recorder.dispatch_tiles(eye, &at, tiles);
        recorder.dispatch(count, &at, pixels);
        recorder.dispatch(radius, &at, pixels);
        recorder.dispatch_tiles(disc, &at, tiles);
        recorder.submit(&self.context, &self.buffers["ring"]);
        self.context.wait()
    }

    /// What trees see of emission through the pixels of a strip; nothing where no emission is traced.
    fn look_for_glints(&mut self, strip: Strip) -> Result<Vec<Look>> {
        let pass = self.pass_info(PILOT_PASS, strip);
        let tiles = self.tiles_of(strip);
        let Some(PassGraph { glint: Some(Glint { pilot, .. }), .. }) = &self.steps else {
            return Ok(Vec::new());
        };
        let mut recorder = Recorder::new(&self.context, &mut self.ring, None);
        let at = [("pass_info", recorder.ring.push(&pass))];
        recorder.dispatch_tiles(pilot, &at, tiles);
        recorder.submit(&self.context, &self.buffers["ring"]);
        let read = self.context.read(&mut self.staging, &[&self.buffers["radii"]])?;
        let pixels: &[[f32; 4]] = bytemuck::cast_slice(&read[0]);
        let width = self.scene.size[0] as usize;
        let above = (strip.first - strip.held_first) as usize * width;
        let own = &pixels[above..above + strip.rows as usize * width];
        Ok(own.iter().map(glints::look).collect())
    }

    /// Run every kernel of a pass on nothing: drivers compile at the first dispatch, and that is set-up.
    fn warm_up(&mut self) -> Result<()> {
        let Some(steps) = &self.steps else { return Ok(()) };
        let mut recorder = Recorder::new(&self.context, &mut self.ring, None);
        let nothing: PassInfo = bytemuck::Zeroable::zeroed();
        let no_map: MapInfo = bytemuck::Zeroable::zeroed();
        let at = [("pass_info", recorder.ring.push(&nothing)), ("map_info", recorder.ring.push(&no_map))];
        let kernels = [&steps.eye]
            .into_iter()
            .chain(&steps.direct)
            .chain(&steps.indirect)
            .chain(steps.glint.iter().flat_map(|g| [&g.trees, &g.sum]));
        let maps = steps
            .maps
            .iter()
            .map(|(_, gather)| gather)
            .chain(&steps.kernel_correction)
            .chain(&steps.caustic_disc);
        for step in kernels.chain(maps) {
            recorder.dispatch(step, &at, 1);
        }
        recorder.submit(&self.context, &self.buffers["ring"]);
        self.context.wait()
    }

    /// Find the pixels whose discs are cut by edges and by walls, once, with the largest radius.
    fn find_edges(&mut self, strip: Strip) -> Result<()> {
        let pass = self.pass_info(PILOT_PASS, strip);
        let info = self.map_info(MapKind::Diffuse, 0, PILOT_PASS);
        let (pixels, tiles) = (self.pixels_of(strip), self.tiles_of(strip));
        let Some(PassGraph { eye, kernel_correction, clip_planes: Some(clip_planes), .. }) = &self.steps
        else {
            return Ok(());
        };
        let mut recorder = Recorder::new(&self.context, &mut self.ring, None);
        let at = [("pass_info", recorder.ring.push(&pass)), ("map_info", recorder.ring.push(&info))];
        recorder.dispatch_tiles(eye, &at, tiles);
        if let Some(kernel_correction) = kernel_correction {
            // pixels without a gather point keep what is there
            recorder.clear(&self.buffers["edges"]);
            recorder.dispatch_tiles(kernel_correction, &at, tiles);
        }
        recorder.dispatch(clip_planes, &at, pixels);
        recorder.submit(&self.context, &self.buffers["ring"]);
        self.context.wait()
    }
}
