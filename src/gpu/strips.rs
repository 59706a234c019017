//! Strips: images that do not fit the device as a whole are rendered in strips of rows that take turns on it. The maps of a
//! pass are traced and sorted once, then each strip gathers from them. What the pilot found out of a strip's pixels, and
//! its films, wait on the host. Strips leave no trace in the image, not in a bit.

use super::GpuBackend;
use super::recorder::Recorder;
use crate::error::Result;
use crate::plan::buffers::{FILMS, KNOWN};

/// Bytes of a pixel that the host keeps where there are strips: a gather point, radius, edge and clip, four films.
pub(super) const KEPT_BYTES_PER_PIXEL: u64 = 48 + 16 + 4 + 32 + 4 * 16;

/// What the host keeps of a strip.
pub(super) struct Kept {
    /// Contents of [`KNOWN`].
    known: Vec<Vec<u8>>,
    /// Contents of [`FILMS`]; none before the first pass of a batch.
    pub(super) films: Vec<Vec<u8>>,
}

impl GpuBackend {
    /// Keep what the pilot found out of the strip that is on the device.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where reading back fails.
    pub(super) fn keep_strip(&mut self) -> Result<()> {
        let sources = KNOWN.map(|name| &self.buffers[name]);
        let known = self.context.read(&mut self.staging, &sources)?;
        self.kept.push(Kept { known, films: Vec::new() });
        Ok(())
    }

    /// Render one pass strip by strip. Area points are on the device.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails.
    pub(super) fn submit_pass_in_strips(&mut self, pass: u64) -> Result<()> {
        let infos = self.map_infos(pass);
        let whole = self.pass_info(pass as u32, self.strips.strip(0));
        let Some(steps) = &self.steps else { return Ok(()) };
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
            let Some(steps) = &self.steps else { return Ok(()) };
            for (name, bytes) in KNOWN.iter().zip(&self.kept[i].known) {
                self.context.queue.write_buffer(&self.buffers[name], 0, bytes);
            }
            for (name, bytes) in FILMS.iter().zip(&self.kept[i].films) {
                self.context.queue.write_buffer(&self.buffers[name], 0, bytes);
            }
            let mut recorder = Recorder::new(&self.context, &mut self.ring, self.timer.as_mut());
            if self.kept[i].films.is_empty() {
                FILMS.iter().for_each(|film| recorder.clear(&self.buffers[film]));
            }
            let pass_info = recorder.ring.push(&info);
            self.glints.record_marks(&mut recorder, steps, i, &info);
            steps.record_camera(&mut recorder, pass_info, tiles, self.glints.growths(i, &info));
            for (map, gather) in &steps.maps {
                let map_info = recorder.ring.push(&infos[map.kind as usize]);
                let at = [("pass_info", pass_info), ("map_info", map_info)];
                steps.record_gather(&mut recorder, map.kind, gather, &at, tiles);
            }
            recorder.submit(&self.context, &self.buffers["ring"]);
            self.collect_times()?;
            let sources = FILMS.map(|film| &self.buffers[film]);
            self.kept[i].films = self.context.read(&mut self.staging, &sources)?;
        }
        Ok(())
    }

    /// The films that are traced, of the whole image and all passes of a batch.
    pub(super) fn films_of_strips(&self) -> Vec<Vec<u8>> {
        let row = self.scene.size[0] as usize * size_of::<[f32; 4]>();
        let film = |film: usize| {
            let mut whole = Vec::with_capacity(row * self.scene.size[1] as usize);
            for (strip, kept) in self.strips.each().zip(&self.kept) {
                let above = (strip.first - strip.held_first) as usize;
                whole.extend_from_slice(&kept.films[film][above * row..][..strip.rows as usize * row]);
            }
            whole
        };
        self.traced_films().map(|(layer, _)| film(layer as usize)).collect()
    }
}
