//! The GPU backend: passes as WGSL compute kernels through wgpu.

mod area_samples;
mod batches;
mod compiled;
mod context;
mod device_buffers;
#[doc(hidden)]
pub mod faults;
mod films;
mod glints;
#[doc(hidden)]
pub mod harness;
mod kernel;
mod map;
mod pilot;
mod pipelines;
mod precompile;
mod recorder;
mod ring;
mod scene_buffers;
mod shaders;
mod strips;
mod tiles;

pub use context::{Context, adapters};
pub use device_buffers::Buffers;
pub use kernel::{BoundKernel, Kernel};
pub use shaders::{SOURCES, Variant, link, link_source};

use crate::backend::{BATCH_PASSES_MAX, Backend, Batch, HostSeconds, HostWork, Spare};
use crate::error::{Error, Result};
use crate::estimators::maps::MapKind;
use crate::estimators::split_paths::SplitPaths;
use crate::film::tile_schedule::TileSchedule;
use crate::film::{LAYERS, Layer};
use crate::host::memory;
use crate::packed::PackedScene;
use crate::packed::constants::{TILE, TRAVERSAL_STACK};
use crate::packed::layout::{MapInfo, PassInfo, status};
use crate::plan::buffers::{self, Buffer, BufferPlan};
use crate::plan::map_layout::{MapLayout, MapLayouts};
use crate::plan::strips::{Strip, Strips};
use crate::plan::{InBands, Part, Plan};
use crate::resolve::Resolver;
use crate::spectrum::{BLACK, Bands, from_rgb};
use area_samples::AreaState;
use batches::Begun;
use films::four;
use glints::SplitPathLists;
use pipelines::{Kernels, PassGraph};
use precompile::Precompiler;
use recorder::{Recorder, Timer};
use ring::Ring;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;
use strips::Kept;
use tiles::Tiles;

/// Times that a batch is rendered with more room or smaller loops before the device is taken for broken.
const BATCH_TRIES: u32 = 12;
/// Dispatches of the trace kernel that are tried before the device is taken for broken.
const DISPATCHES_MAX: u32 = 1 << 16;

/// The GPU backend.
pub struct GpuBackend {
    context: Context,
    scene: Arc<PackedScene>,
    plan: Plan,
    buffers: Buffers,
    kernels: Kernels,
    steps: Option<PassGraph>,
    shapes: MapLayouts,
    /// Linear red, green and blue of the bands of a pass: rows.
    to_rgb: [Bands; 3],
    /// What a texel of red, green or blue alone reflects in them: columns.
    of_texel: [Bands; 3],
    strips: Strips,
    kept: Vec<Kept>,
    /// Sums of a batch so far, where the image is in strips; none before the first strip.
    strip_films: Option<[Vec<Bands>; LAYERS]>,
    area: Option<AreaState>,
    /// The batch that is rendered, and the next one, where it was begun.
    begun: VecDeque<Begun>,
    tiles: Tiles,
    glints: SplitPathLists,
    ring: Ring,
    timer: Option<Timer>,
    staging: Option<wgpu::Buffer>,
    spare: Spare,
    host: HostSeconds,
}

impl GpuBackend {
    /// Compile the kernels, upload the scene and run the pilot pass.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails, [`Error::Capacity`] where the scene does not fit.
    pub fn new(context: Context, scene: Arc<PackedScene>, plan: Plan) -> Result<Self> {
        let depth = scene.bvh.depth();
        if depth > TRAVERSAL_STACK {
            let what = format!(
                "the hierarchy over the triangles is {depth} levels deep, {TRAVERSAL_STACK} can be followed"
            );
            return Err(Error::device(what, "remove triangles that lie in one place, or use --device cpu"));
        }
        let kernels = Kernels::new(&context, &scene, &plan)?;
        let precompiler = Precompiler::start(&context, &kernels);
        let buffers = scene_buffers::upload(&context, &scene, &plan)?;
        let (tiles, words) = Tiles::new(TileSchedule::none(scene.size));
        context.queue.write_buffer(&buffers["tiles"], 0, bytemuck::cast_slice(&words));
        let machine = context.machine();
        let lanes = |emitted: u32| (emitted > 0).then(|| MapLayout::new(emitted, &machine));
        let shapes = MapLayouts { caustic: lanes(plan.caustic_jotons), diffuse: lanes(plan.diffuse_jotons) };
        // the pilot decides; its search for the lanes' shape needs no pixels
        let strips = Strips::whole([scene.size[0], scene.size[1].min(TILE)]);
        let ring = Ring::new(&context);
        let mut backend = Self {
            context,
            scene,
            plan,
            buffers,
            kernels,
            steps: None,
            shapes,
            to_rgb: [BLACK; 3],
            of_texel: [from_rgb([1.0, 0.0, 0.0]), from_rgb([0.0, 1.0, 0.0]), from_rgb([0.0, 0.0, 1.0])],
            strips,
            kept: Vec::new(),
            strip_films: None,
            area: None,
            begun: VecDeque::new(),
            tiles,
            glints: SplitPathLists::none(),
            ring,
            timer: None,
            staging: None,
            spare: Spare::default(),
            host: HostSeconds::default(),
        };
        backend.run_pilot()?;
        drop(precompiler);
        memory::give_back();
        Ok(backend)
    }

    /// Name and bytes of every buffer that is on the device, but for those of timers and what drivers keep for themselves.
    pub fn memory(&self) -> Vec<(&'static str, u64)> {
        let own = |(name, buffer): &(&&'static str, &wgpu::Buffer)| {
            // where nothing was learned there is one list of lights
            let same =
                |of: &str| name.starts_with(of) && name.len() > of.len() && **buffer == self.buffers[of];
            !same("emitters") && !same("scene_info")
        };
        let mut all: Vec<_> =
            self.buffers.iter().filter(own).map(|(name, buffer)| (*name, buffer.size())).collect();
        let read =
            self.staging.iter().map(wgpu::Buffer::size).chain(self.begun.iter().map(Begun::staging_bytes));
        all.push(("staging", read.sum()));
        all.sort_unstable();
        all
    }

    /// (Re)create the buffers that depend on the shapes, and bind every step.
    fn bind(&mut self) -> Result<()> {
        // what fails half-way is not gone on with
        self.steps = None;
        let wanted = self.needs().pass_buffers();
        let context = &self.context;
        scene_buffers::check_capacity(context, &wanted)?;
        for Buffer { name, bytes, .. } in wanted {
            if self.buffers.get(name).is_none_or(|b| b.size() != bytes) {
                self.buffers.insert(name, device_buffers::storage(context, name, bytes)?);
            }
        }
        if self.shapes.diffuse.is_some() && !self.buffers.contains_key("area_points") {
            let size = buffers::area_points(0, 1).bytes;
            self.buffers.insert("area_points", device_buffers::storage(context, "area_points", size)?);
        }
        context.check()?;
        let apart = self.needs().maps_apart();
        self.steps = Some(PassGraph::new(context, &self.kernels, &self.shapes, apart, &self.buffers)?);
        Ok(())
    }

    /// What the sizes of the buffers follow from.
    pub fn needs(&self) -> BufferPlan<'_> {
        BufferPlan {
            scene: &self.scene,
            plan: &self.plan,
            machine: self.context.machine(),
            shapes: self.shapes,
            strips: self.strips,
        }
    }

    /// The uniform of a pass over a strip.
    fn pass_info(&self, pass: u32, strip: Strip) -> PassInfo {
        let [red, green, blue] = self.to_rgb.map(|row| four(&row).into());
        let [texel_red, texel_green, texel_blue] = self.of_texel.map(|column| four(&column).into());
        PassInfo {
            camera: self.scene.camera_info(),
            width: self.scene.size[0],
            height: self.scene.size[1],
            seed: self.plan.settings.seed,
            pass_index: pass,
            shadow_rays: self.plan.settings.shadow_rays,
            emitters: self.scene.emitters.len() as u32,
            targets: self.scene.targets.len() as u32,
            light_candidates: self.plan.light_candidates,
            first_row: strip.first,
            rows: strip.rows,
            held_first: strip.held_first,
            held_rows: strip.held_rows,
            glint_first: 0,
            glint_count: 0,
            glint_turns: self.glints.turns(),
            pad0: 0,
            red,
            green,
            blue,
            texel_red,
            texel_green,
            texel_blue,
        }
    }

    /// The uniform of a map in a pass; zeros where the map is skipped.
    fn map_info(&self, kind: MapKind, pass: u64, random_pass: u32) -> MapInfo {
        let found = self.steps.as_ref().and_then(|s| s.maps.iter().find(|(m, _)| m.kind == kind));
        let Some((map, _)) = found else { return bytemuck::Zeroable::zeroed() };
        let schedule = if kind == MapKind::Caustic { &self.plan.caustic } else { &self.plan.diffuse };
        let mut info = map.info(
            &self.scene,
            schedule,
            pass,
            random_pass,
            self.plan.jotons(kind),
            self.plan.settings.seed,
        );
        info.cells_marked_per_unit = self.plan.visible_cells.as_ref().map_or(0.0, |m| m.per_unit);
        if let (MapKind::Diffuse, Some(area)) = (kind, &self.area) {
            info.area_each = area.each;
            info.area_cells_per_unit = area.cells_per_unit;
            info.area_row_mask = area.row_mask;
            info.area_columns = area.columns;
        }
        info
    }

    /// Uniforms of both maps in a pass.
    fn map_infos(&self, pass: u64) -> [MapInfo; 2] {
        MapKind::ALL.map(|kind| self.map_info(kind, pass, pass as u32))
    }

    /// Tiles of a strip: the first so many of the list, where none rests.
    fn tiles_of(&self, strip: Strip) -> u32 {
        self.scene.size[0].div_ceil(TILE) * strip.rows.div_ceil(TILE)
    }

    /// Pixels of a strip.
    fn pixels_of(&self, strip: Strip) -> u32 {
        strip.rows * self.scene.size[0]
    }

    /// Put the bands of a pass on the device, where they differ from pass to pass. What was submitted before has its own.
    fn set_bands(&mut self, pass: u64) -> Result<()> {
        if let Some(in_bands) = InBands::of(&self.scene, &self.plan, pass) {
            scene_buffers::write_in_bands(&self.context, &self.buffers, &self.plan, &in_bands)?;
            self.to_rgb = in_bands.bands.to_rgb;
            self.of_texel = in_bands.bands.of_texel;
        }
        Ok(())
    }

    /// Record one pass after what was recorded; submit that and more where needed.
    fn record_pass(&mut self, pass: u64, before: wgpu::CommandEncoder) -> Result<wgpu::CommandEncoder> {
        if self.timer.as_ref().is_some_and(Timer::is_nearly_full) {
            self.collect_times()?;
        }
        if self.shapes.diffuse.is_some() {
            let begin = Instant::now();
            self.renew_area_points(pass)?;
            self.host.add(HostWork::Lists, begin.elapsed());
        }
        let begin = Instant::now();
        self.set_bands(pass)?;
        self.host.add(HostWork::Lists, begin.elapsed());
        if self.strips.count() > 1 {
            self.context.submit(before);
            self.submit_pass_in_strips(pass)?;
            return Ok(self.context.encoder());
        }
        let begin = Instant::now();
        let infos = self.map_infos(pass);
        let strip = self.strips.strip(0);
        let pass_info = self.pass_info(pass as u32, strip);
        let steps = self.steps.as_ref().ok_or_else(unbound)?;
        let live = self.tiles.live(pass);
        let mut recorder = Recorder::after(before, &mut self.ring, self.timer.as_mut());
        let at = recorder.ring.push(&pass_info);
        steps.record_eye(&mut recorder, at, live);
        steps.record_glints(&mut recorder, self.glints.growths(0, &(0..u32::MAX), &pass_info));
        steps.record_direct(&mut recorder, at, live);
        for (map, gather) in &steps.maps {
            let info = infos[map.kind as usize];
            recorder.clear(&self.buffers["lanes"]);
            map.record(&mut recorder, at, &info);
            let map_info = recorder.ring.push(&info);
            let at = [("pass_info", at), ("map_info", map_info)];
            steps.record_gather(&mut recorder, map.kind, gather, &at, live);
        }
        // where paths go on there is no other map than theirs
        let map_info = recorder.ring.push(&infos[MapKind::Caustic as usize]);
        let at = [("pass_info", at), ("map_info", map_info)];
        steps.record_indirect(&mut recorder, &at, live, &self.buffers);
        let recorded = recorder.finish(&self.context, &self.buffers["ring"]);
        self.host.add(HostWork::Recording, begin.elapsed());
        Ok(recorded)
    }

    /// Add up what the kernels of the last submission took.
    fn collect_times(&mut self) -> Result<()> {
        match &mut self.timer {
            Some(timer) => timer.collect(&self.context),
            None => Ok(()),
        }
    }
}

impl Backend for GpuBackend {
    fn measure_kernels(&mut self) -> Result<()> {
        self.timer = Timer::new(&self.context)?;
        Ok(())
    }

    fn kernel_seconds(&self) -> Vec<(String, f64, u64)> {
        let seconds = self.timer.as_ref().map(|t| t.seconds().clone()).unwrap_or_default();
        seconds.into_iter().map(|(name, (seconds, dispatches))| (name, seconds, dispatches)).collect()
    }

    fn take_host_seconds(&mut self) -> HostSeconds {
        std::mem::take(&mut self.host)
    }

    fn device_bytes(&self) -> Option<u64> {
        Some(self.memory().iter().map(|(_, bytes)| bytes).sum())
    }

    fn describe(&self) -> String {
        let i = &self.context.info;
        let kind = if self.context.is_software() { "software" } else { "GPU" };
        format!("{} ({kind}, {:?}, {} {})", i.name, i.backend, i.driver, i.driver_info)
    }

    fn batch_passes(&self, first: u64) -> u32 {
        // software devices take long for a pass and nothing for reading it back; on a GPU it is the other way round
        if self.context.is_software() {
            1
        } else {
            (first.next_power_of_two() / 2).clamp(1, BATCH_PASSES_MAX.into()) as u32
        }
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
        self.forget_begun();
        let (tiles, words) = Tiles::new(schedule.clone());
        self.tiles = tiles;
        self.context.queue.write_buffer(&self.buffers["tiles"], 0, bytemuck::cast_slice(&words));
        self.strips.count() == 1 && !self.plan.settings.keeps(Part::Rest)
    }

    fn split_paths(&self) -> Option<&SplitPaths> {
        self.glints.whose()
    }

    fn set_split_paths(&mut self, glints: SplitPaths) -> Result<()> {
        self.forget_begun();
        self.upload_glints(glints)
    }

    fn works_beside_host(&self) -> bool {
        !self.context.is_software()
    }

    fn begin(&mut self, first: u64, count: u32) -> Result<()> {
        self.begin_batch(first, count)
    }

    fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
        self.render_batch(first, count)
    }

    fn reuse(&mut self, batch: Batch) {
        self.spare = Spare(batch.layers);
    }
}

/// A backend whose buffers could not be made does not go on.
fn unbound() -> Error {
    Error::device("the device is not set up", "use --device cpu")
}

/// Refuse what rays found whose loops the driver ended.
///
/// # Errors
/// [`Error::Device`] where there are any.
fn check_traversal(words: &[u32]) -> Result<()> {
    if words[status::TRAVERSAL_CUT as usize] > 0 {
        let what = "a ray meets more triangles than the loops of this driver can follow";
        return Err(Error::device(what, "remove triangles that lie in one place, or use --device cpu"));
    }
    Ok(())
}
