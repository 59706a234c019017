//! Batches on the device: begun, copied out, read back, and rendered again where they did not come out whole. The device begins with
//! one batch while the host reads the one before.

use super::context::Copy;
use super::recorder::Timed;
use super::{BATCH_TRIES, DISPATCHES_MAX, GpuBackend, check_traversal, films};
use crate::backend::{Batch, HostWork, Tally};
use crate::error::{Error, Result};
use crate::estimators::maps::MapKind;
use crate::host::memory;
use crate::packed::layout::{LaneTally, status};
use crate::plan::map_layout::{MapLayout, roomy};
use crate::spectrum::BANDS;
use std::ops::Range;
use std::time::Instant;

/// Batches that are on the device at a time: one is rendered while the other one is read.
const BEGUN_MAX: usize = 2;

/// A batch that the device has begun: it ends with a copy of its sums to the host.
pub(super) struct Begun {
    first: u64,
    count: u32,
    /// Rows in which some pixel does not rest.
    rows: Range<usize>,
    copy: Copy,
    submission: wgpu::SubmissionIndex,
    /// Its kernels, where they are measured.
    timed: Option<Timed>,
}

impl Begun {
    /// Whether it is these passes.
    fn is(&self, first: u64, count: u32) -> bool {
        (self.first, self.count) == (first, count)
    }

    /// Bytes that wait for it to be read.
    pub(super) fn staging_bytes(&self) -> u64 {
        self.copy.staging.size()
    }
}

impl GpuBackend {
    /// Begin a batch ahead, where it is not begun. The device has two at most, and one where the image is in strips.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails.
    pub(super) fn begin_batch(&mut self, first: u64, count: u32) -> Result<()> {
        let most = if self.strips.count() > 1 { 1 } else { BEGUN_MAX };
        if self.begun.len() < most && !self.begun.iter().any(|b| b.is(first, count)) {
            let begun = self.start_batch(first, count)?;
            self.begun.push_back(begun);
        }
        Ok(())
    }

    /// Hand a batch to the device.
    fn start_batch(&mut self, first: u64, count: u32) -> Result<Begun> {
        // what lies above and below is at rest
        let rows = self.tiles.tile_schedule().rows(first, u64::from(count));
        // few submissions: old drivers take three at a time
        let mut encoder = self.context.encoder();
        self.clear_films(&mut encoder, &rows);
        self.strip_films = None;
        for pass in first..first + u64::from(count) {
            if pass > first {
                let before = std::mem::replace(&mut encoder, self.context.encoder());
                self.context.submit(before);
            }
            encoder = self.record_pass(pass, encoder)?;
        }
        let begin = Instant::now();
        let timed = match &mut self.timer {
            Some(timer) => timer.copy_out(&self.context, &mut encoder)?,
            None => None,
        };
        let staging = self.staging.take();
        let mut sources: Vec<_> =
            films::COUNTS.iter().map(|name| &self.buffers[*name]).map(|b| (b, 0..b.size())).collect();
        sources.extend(self.film_parts(&rows));
        let copy = self.context.copy_out(staging, &sources, &mut encoder)?;
        let submission = self.context.submit(encoder);
        self.host.add(HostWork::Recording, begin.elapsed());
        Ok(Begun { first, count, rows, copy, submission, timed })
    }

    /// Forget what has begun: it was begun for what is no longer so.
    pub(super) fn forget_begun(&mut self) {
        self.begun.clear();
    }

    /// Render a batch, or read back one that has begun.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails, [`Error::Capacity`] where a pass does not fit.
    pub(super) fn render_batch(&mut self, first: u64, count: u32) -> Result<Batch> {
        for _ in 0..BATCH_TRIES {
            let begun = match self.begun.pop_front().filter(|b| b.is(first, count)) {
                Some(begun) => begun,
                None => {
                    self.forget_begun();
                    self.start_batch(first, count)?
                }
            };
            let (batch, words) = self.read_batch(begun)?;
            if !self.must_repeat(&words)? {
                return Ok(batch);
            }
        }
        let what = format!("{}: passes {first} and on do not come out whole", self.context.info.name);
        Err(Error::device(what, "use --device cpu and report this as a bug of joton"))
    }

    /// Read back a batch, and what its kernels reported.
    fn read_batch(&mut self, begun: Begun) -> Result<(Batch, Vec<u32>)> {
        let Begun { first, count, rows, copy, submission, timed } = begun;
        let traced: Vec<usize> = self.traced_films().map(|(layer, _)| layer as usize).collect();
        let width = self.scene.size[0] as usize;
        // strips have been read before
        let in_strips = self.strip_films.take();
        let rows = if in_strips.is_some() { 0..0 } else { rows };
        let read = rows.start * width..rows.end * width;
        let mut layers = in_strips.unwrap_or_else(|| self.spare.black_but(self.scene.pixels(), read.clone()));
        let (mut counted, mut begin): (Vec<Vec<u8>>, Option<Instant>) = Default::default();
        let staging = self.context.see_copy(copy, submission.clone(), &mut |i, bytes| {
            // from here on the device is not waited for
            begin.get_or_insert_with(Instant::now);
            match i.checked_sub(films::COUNTS.len()) {
                None => counted.push(bytes.to_vec()),
                Some(film) => films::put(&mut layers[traced[film]][read.clone()], bytes),
            }
        })?;
        self.staging = Some(staging);
        let begin = begin.unwrap_or_else(Instant::now);
        if let (Some(timer), Some(timed)) = (&mut self.timer, timed) {
            timer.add(&self.context, timed, submission)?;
        }
        if first == 0 {
            // the last kernels are compiled
            memory::give_back();
        }
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&counted[0]);
        let mut tally = Tally::default();
        films::keep_finite(&mut layers, &mut tally.non_finite);
        self.host.add(HostWork::ReadingBack, begin.elapsed());
        let t = &mut tally;
        t.rays = status::rays(&words);
        t.shadow_rays_saved = status::shadow_rays_saved(&words);
        t.pixels_rested =
            (first..first + u64::from(count)).map(|p| self.tiles.tile_schedule().pixels_resting(p)).sum();
        t.truncated = u64::from(words[status::TRUNCATED as usize]);
        let emitted = |s: Option<MapLayout>| s.map_or(0, |s| u64::from(s.emitted)) * u64::from(count);
        t.jotons_emitted = emitted(self.shapes.caustic) + emitted(self.shapes.diffuse);
        for (i, bytes) in counted[1..].iter().enumerate() {
            let lanes: Vec<LaneTally> = bytemuck::pod_collect_to_vec(bytes);
            for lane in &lanes {
                t.rays += u64::from(lane.rays);
                t.jotons_stored += u64::from(lane.stored);
                t.jotons_not_stored += u64::from(lane.not_stored);
                if i == MapKind::Diffuse as usize {
                    for b in 0..BANDS {
                        t.emitted[b] += f64::from(lane.emitted[b]);
                        t.absorbed[b] += f64::from(lane.absorbed[b]);
                        t.escaped[b] += f64::from(lane.escaped[b]);
                    }
                }
            }
        }
        Ok((Batch { layers, tally }, words))
    }

    /// What the kernels reported of a batch: adapt and say so where it must be rendered again.
    fn must_repeat(&mut self, words: &[u32]) -> Result<bool> {
        check_traversal(words)?;
        let unfinished = words[status::UNFINISHED as usize] > 0;
        let stored = words[status::LANE_STORED_MAX as usize];
        let cut = words[status::LOOP_CUT as usize] > 0;
        if !unfinished && stored == 0 && !cut {
            return Ok(false);
        }
        for kind in [MapKind::Caustic, MapKind::Diffuse] {
            if let Some(shape) = self.shapes.of_mut(kind) {
                if unfinished {
                    shape.dispatches = (shape.dispatches * 2).min(DISPATCHES_MAX);
                }
                if stored > shape.lane_capacity {
                    shape.lane_capacity = roomy(stored);
                }
                if cut {
                    // the driver ended a loop early: fewer jotons a pass make shorter loops
                    shape.emitted = (shape.emitted / 2).max(1);
                    shape.lanes = shape.lanes.min(shape.emitted);
                }
            }
        }
        // where that is too much, the map has fewer jotons
        while let Err(e) = self.needs().fits() {
            let largest =
                MapKind::ALL.into_iter().max_by_key(|k| self.shapes.of(*k).map_or(0, |s| s.max_stored()));
            match largest.and_then(|kind| self.shapes.of_mut(kind).as_mut()) {
                Some(shape) if shape.emitted > 1 => *shape = shape.halved(),
                _ => return Err(e),
            }
        }
        self.bind()?;
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::Backend;
    use crate::backend::gpu::Context;
    use crate::film::LAYERS;
    use crate::film::tile_schedule::TileSchedule;
    use crate::packed::PackedScene;
    use crate::plan::{Part, Plan, Settings};
    use std::path::Path;
    use std::sync::Arc;

    const PASSES: u64 = 6;

    /// A small picture with both maps; none where tests of GPUs are left out, as was asked.
    fn open() -> Option<GpuBackend> {
        if std::env::var("JOTON_TEST_NO_GPU").is_ok_and(|v| v == "1") {
            return None;
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/spheres.toml");
        let mut scene = crate::scene::load(&path).expect("a scene");
        scene.resize([24; 2]);
        let scene = Arc::new(PackedScene::new(&scene));
        let settings = Settings { keep: vec![Part::DiffuseMap], ..Settings::default() };
        let plan = Plan::new(&scene, settings);
        Some(GpuBackend::new(Context::open(None).expect("a device"), scene, plan).expect("it opens"))
    }

    fn bits(batch: &Batch) -> [Vec<[u32; BANDS]>; LAYERS] {
        batch.layers.each_ref().map(|layer| layer.iter().map(|p| p.map(f32::to_bits)).collect())
    }

    /// Render pass after pass, with the next one begun where `ahead` says so.
    fn passes(backend: &mut GpuBackend, ahead: impl Fn(u64) -> bool) -> Vec<Batch> {
        let render = |pass| {
            if ahead(pass) {
                backend.begin(pass, 1).expect("it begins");
                backend.begin(pass + 1, 1).expect("and with the next");
                assert_eq!(backend.begun.len(), 2);
            }
            backend.render(pass, 1).expect("a pass")
        };
        (0..PASSES).map(render).collect()
    }

    /// A device that works ahead finds the same bits and counts: always ahead, at times, with times measured, where a pass does not
    /// come out whole, and where what was begun is for nothing.
    #[test]
    fn what_begins_ahead_is_the_same() {
        let Some(mut backend) = open() else { return };
        let wanted = passes(&mut backend, |_| false);
        let check = |found: Vec<Batch>, how: &str| {
            for (pass, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
                assert!(bits(found) == bits(wanted), "{how}: pass {pass}");
                assert_eq!(found.tally, wanted.tally, "{how}: pass {pass}");
            }
        };
        check(passes(&mut backend, |_| true), "always");
        check(passes(&mut backend, |pass| pass % 3 == 1), "at times");
        let none = TileSchedule::none(backend.scene.size);
        backend.begin(0, 1).expect("it begins");
        backend.begin(1, 1).expect("and with the next");
        backend.set_tile_schedule(&none);
        assert!(backend.begun.is_empty(), "who rests is told anew");
        backend.begin(4, 1).expect("for nothing");
        check(passes(&mut backend, |_| true), "for nothing");
        backend.measure_kernels().expect("room for times");
        check(passes(&mut backend, |_| true), "measured");
        let eye = backend.kernel_seconds().into_iter().find(|(name, ..)| name == "eye");
        assert_eq!(
            eye.map(|(_, _, dispatches)| dispatches),
            Some(PASSES),
            "what is not asked for does not count"
        );
        let mut backend = open().expect("the same device");
        for map in [&mut backend.shapes.caustic, &mut backend.shapes.diffuse] {
            map.as_mut().expect("both maps").lane_capacity = 1;
        }
        backend.bind().expect("smaller maps");
        check(passes(&mut backend, |_| true), "not whole");
        assert!(backend.shapes.caustic.is_some_and(|map| map.lane_capacity > 1));
    }

    /// A backend without memory for wider maps renders nothing, rather than what it has bound by half, until it is bound anew; a batch that
    /// began before the device was lost is not taken for whole.
    #[cfg(debug_assertions)]
    #[test]
    fn what_failed_is_not_gone_on_with() {
        use crate::backend::gpu::faults::Point;
        let Some(mut backend) = open() else { return };
        let wanted = bits(&backend.render(0, 1).expect("a pass"));
        for map in [&mut backend.shapes.caustic, &mut backend.shapes.diffuse] {
            map.as_mut().expect("both maps").lane_capacity *= 2;
        }
        let faults = Arc::clone(&backend.context.faults);
        faults.ask_for(Point::Buffer, faults.seen(Point::Buffer) + 1);
        let e = backend.bind().expect_err("there is no memory").to_string();
        assert!(e.contains("no memory is left for the buffer"), "{e}");
        let e = backend.render(0, 1).map(|_| ()).expect_err("it is not bound").to_string();
        assert!(e.contains("not set up"), "{e}");
        backend.bind().expect("there is memory again");
        assert!(bits(&backend.render(0, 1).expect("a pass")) == wanted);
        backend.begin(1, 1).expect("it begins");
        faults.ask_for(Point::Running, faults.seen(Point::Running));
        backend.begin(2, 1).ok();
        for pass in [1, 2] {
            let e = backend.render(pass, 1).map(|_| ()).expect_err("it is lost").to_string();
            assert!(e.contains("--device cpu"), "{e}");
        }
    }
}
