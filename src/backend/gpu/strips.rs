//! Strips: images that do not fit the device as a whole are rendered in strips of rows, one after the other. The maps of a
//! pass are traced and sorted once, then each strip gathers from them. What the pilot found out of a strip's pixels, the trees
//! that look for emission there, and its films wait on the host. Strips leave no trace in the image, not in a bit.

use super::films::{four, put};
use super::recorder::Recorder;
use super::{GpuBackend, unbound};
use crate::error::Result;
use crate::estimators::maps::MapKind;
use crate::film::Layer;
use crate::plan::buffers::{FILM_PIXEL, FILMS, known};
use crate::plan::strips::Strip;
use std::ops::Range;

/// What the host keeps of a strip: contents of [`known`].
pub(super) struct Kept(Vec<Runs>);

/// Words of pixels, equal neighbours once: most of what is known is alike over whole surfaces.
struct Runs {
    /// Words of a pixel, and those of them that are kept; the rest are zero.
    words: [usize; 2],
    /// Pixels of each run.
    lengths: Vec<u32>,
    values: Vec<u32>,
}

impl Runs {
    fn new(words: [usize; 2], bytes: &[u8]) -> Self {
        let [each, kept] = words;
        let (mut lengths, mut values): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
        for pixel in bytes.chunks_exact(4 * each) {
            let word = |i: usize| u32::from_ne_bytes([0, 1, 2, 3].map(|b| pixel[4 * i + b]));
            let last = values.len().saturating_sub(kept);
            match lengths.last_mut() {
                Some(length) if (0..kept).all(|i| values[last + i] == word(i)) => *length += 1,
                _ => {
                    lengths.push(1);
                    values.extend((0..kept).map(word));
                }
            }
        }
        Self { words, lengths, values }
    }

    fn bytes(&self) -> Vec<u8> {
        let [each, kept] = self.words;
        let mut bytes = Vec::new();
        for (length, value) in self.lengths.iter().zip(self.values.chunks_exact(kept)) {
            let mut pixel = vec![0; each];
            pixel[..kept].copy_from_slice(value);
            (0..*length).for_each(|_| bytes.extend_from_slice(bytemuck::cast_slice(&pixel)));
        }
        bytes
    }
}

impl GpuBackend {
    /// Keep what the pilot found out of the strip that is on the device.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where reading back fails.
    pub(super) fn keep_strip(&mut self, strip: Strip) -> Result<()> {
        let pixels = u64::from(strip.held_rows) * u64::from(self.scene.size[0]);
        let known: Vec<_> = known(&self.plan).collect();
        let sources: Vec<_> =
            known.iter().map(|k| (&self.buffers[k.name], 0..pixels * 4 * k.words[0] as u64)).collect();
        let mut kept = Vec::new();
        self.context.look_at(&mut self.staging, &sources, |i, bytes| {
            kept.push(Runs::new(known[i].words, bytes));
        })?;
        self.kept.push(Kept(kept));
        Ok(())
    }

    /// Render one pass strip by strip. Area points are on the device.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails.
    pub(super) fn submit_pass_in_strips(&mut self, pass: u64) -> Result<()> {
        let infos = self.map_infos(pass);
        let whole = self.pass_info(pass as u32, self.strips.strip(0));
        let steps = self.steps.as_ref().ok_or_else(unbound)?;
        let mut recorder = Recorder::new(&self.context, &mut self.ring, self.timer.as_mut());
        let pass_info = recorder.ring.push(&whole);
        for (map, _) in &steps.maps {
            recorder.clear(&self.buffers["lanes"]);
            map.record(&mut recorder, pass_info, &infos[map.kind as usize]);
        }
        recorder.submit(&self.context, &self.buffers["ring"]);
        self.collect_times()?;
        for (i, strip) in self.strips.each().enumerate() {
            let info = self.pass_info(pass as u32, strip);
            let tiles = self.tiles_of(strip);
            for (known, runs) in known(&self.plan).zip(&self.kept[i].0) {
                self.context.queue.write_buffer(&self.buffers[known.name], 0, &runs.bytes());
            }
            self.send_films(strip);
            // where its list is longer than the buffer, its parts are used one after the other
            let parts = self.glints.parts(i, self.buffers.get("glints"));
            for (k, part) in parts.iter().enumerate() {
                self.send_glints(i, part);
                let steps = self.steps.as_ref().ok_or_else(unbound)?;
                let mut recorder = Recorder::new(&self.context, &mut self.ring, self.timer.as_mut());
                if k == 0 {
                    recorder.clear(&self.buffers["gather_points"]);
                }
                super::glints::record_marks(&mut recorder, steps, part.len() as u32, &info);
                if k + 1 == parts.len() {
                    let pass_info = recorder.ring.push(&info);
                    steps.record_eye(&mut recorder, pass_info, tiles);
                }
                recorder.submit(&self.context, &self.buffers["ring"]);
                self.collect_times()?;
            }
            for (k, part) in parts.iter().enumerate() {
                if parts.len() > 1 {
                    self.send_glints(i, part);
                }
                let steps = self.steps.as_ref().ok_or_else(unbound)?;
                let mut recorder = Recorder::new(&self.context, &mut self.ring, self.timer.as_mut());
                steps.record_glints(&mut recorder, self.glints.growths(i, part, &info));
                if k + 1 == parts.len() {
                    let pass_info = recorder.ring.push(&info);
                    steps.record_direct(&mut recorder, pass_info, tiles);
                    for (map, gather) in &steps.maps {
                        let map_info = recorder.ring.push(&infos[map.kind as usize]);
                        let at = [("pass_info", pass_info), ("map_info", map_info)];
                        steps.record_gather(&mut recorder, map.kind, gather, &at, tiles);
                    }
                    let map_info = recorder.ring.push(&infos[MapKind::Caustic as usize]);
                    let at = [("pass_info", pass_info), ("map_info", map_info)];
                    steps.record_indirect(&mut recorder, &at, tiles, &self.buffers);
                }
                recorder.submit(&self.context, &self.buffers["ring"]);
                self.collect_times()?;
            }
            self.fetch_films(strip)?;
        }
        Ok(())
    }

    /// Rows of a strip in its buffers.
    fn own_rows(strip: Strip) -> Range<usize> {
        let above = (strip.first - strip.held_first) as usize;
        above..above + strip.rows as usize
    }

    /// Pixels of a strip in the image.
    fn own_pixels(&self, strip: Strip) -> Range<usize> {
        let width = self.scene.size[0] as usize;
        strip.first as usize * width..(strip.first + strip.rows) as usize * width
    }

    /// Put on the device what the films of a strip hold of the batch's earlier passes.
    fn send_films(&mut self, strip: Strip) {
        let mut encoder = self.context.encoder();
        for (layer, name) in Layer::ALL.into_iter().zip(FILMS) {
            match &self.strip_films {
                Some(layers) if self.plan.traces(layer) => {
                    let pixels = &layers[layer as usize][self.own_pixels(strip)];
                    let four: Vec<[f32; 4]> = pixels.iter().map(four).collect();
                    let row = u64::from(self.scene.size[0]) * FILM_PIXEL;
                    let at = Self::own_rows(strip).start as u64 * row;
                    self.context.queue.write_buffer(&self.buffers[name], at, bytemuck::cast_slice(&four));
                }
                _ => encoder.clear_buffer(&self.buffers[name], 0, None),
            }
        }
        self.context.submit(encoder);
    }

    /// Read the films of a strip back.
    fn fetch_films(&mut self, strip: Strip) -> Result<()> {
        let pixels = self.own_pixels(strip);
        let mut layers =
            self.strip_films.take().unwrap_or_else(|| self.spare.black_but(self.scene.pixels(), 0..0));
        let traced: Vec<usize> = self.traced_films().map(|(layer, _)| layer as usize).collect();
        let mut staging = self.staging.take();
        let sources = self.parts_of_films(&Self::own_rows(strip));
        let read = self.context.look_at(&mut staging, &sources, |i, bytes| {
            put(&mut layers[traced[i]][pixels.clone()], bytes);
        });
        self.staging = staging;
        self.strip_films = Some(layers);
        read
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is kept comes back, but for words that are not kept.
    #[test]
    fn runs_come_back() {
        let words: Vec<u32> = [[7, 1], [7, 2], [7, 3], [9, 1], [7, 1]].concat();
        let runs = Runs::new([2, 2], bytemuck::cast_slice(&words));
        assert_eq!((runs.bytes(), runs.lengths.len()), (bytemuck::cast_slice(&words).to_vec(), 5));
        let runs = Runs::new([2, 1], bytemuck::cast_slice(&words));
        let firsts: Vec<u32> = [[7, 0], [7, 0], [7, 0], [9, 0], [7, 0]].concat();
        assert_eq!(runs.bytes(), bytemuck::cast_slice::<u32, u8>(&firsts));
        assert_eq!(runs.lengths, [3, 1, 1]);
        assert!(Runs::new([8, 8], &[]).bytes().is_empty());
    }
}
