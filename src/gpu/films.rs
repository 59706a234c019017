//! Films on the device: which of them and of their rows a batch clears, and what is read back of them.

use super::GpuBackend;
use crate::backend::{Cause, NonFinite};
use crate::bands::{BANDS, Bands};
use crate::film::{LAYERS, Layer};
use crate::plan::buffers::{FILM_PIXEL, FILMS};
use std::ops::Range;

impl GpuBackend {
    /// The films that are traced and their bytes of these rows; none where there are no rows. Strips keep theirs on
    /// the host.
    pub(super) fn film_parts(&self, rows: &Range<usize>) -> Vec<(&wgpu::Buffer, Range<u64>)> {
        if rows.is_empty() || self.strips.count() > 1 {
            return Vec::new();
        }
        let row_bytes = u64::from(self.scene.size[0]) * FILM_PIXEL;
        let bytes = rows.start as u64 * row_bytes..rows.end as u64 * row_bytes;
        self.traced_films().map(|(_, name)| (&self.buffers[name], bytes.clone())).collect()
    }

    /// The layers that are traced, and their films.
    pub(super) fn traced_films(&self) -> impl Iterator<Item = (Layer, &'static str)> {
        Layer::ALL.into_iter().zip(FILMS).filter(|(layer, _)| self.plan.traces(*layer))
    }

    /// Clear what a batch writes; of the films these rows.
    pub(super) fn clear_films(&mut self, rows: &Range<usize>) {
        let mut encoder =
            self.context.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for name in ["status", "tallies_caustic", "tallies_diffuse"] {
            encoder.clear_buffer(&self.buffers[name], 0, None);
        }
        for (film, bytes) in self.film_parts(rows) {
            encoder.clear_buffer(film, bytes.start, Some(bytes.end - bytes.start));
        }
        self.context.queue.submit([encoder.finish()]);
        self.kept.iter_mut().for_each(|strip| strip.films.clear());
    }

    /// The layers from what was read of the films that are traced; black where nothing was.
    pub(super) fn images(
        &self,
        rows: &Range<usize>,
        parts: &[Vec<u8>],
        non_finite: &mut NonFinite,
    ) -> [Vec<Bands>; LAYERS] {
        let width = self.scene.size[0] as usize;
        // zeros that are never touched take no time
        let mut layers = std::array::from_fn(|_| vec![[0.0; BANDS]; self.scene.pixels()]);
        for ((layer, _), bytes) in self.traced_films().zip(parts) {
            let pixels: &[[f32; 4]] = bytemuck::cast_slice(bytes);
            let image: &mut Vec<Bands> = &mut layers[layer as usize];
            for (bands, p) in image[rows.start * width..rows.end * width].iter_mut().zip(pixels) {
                *bands = keep_finite(p, non_finite);
            }
        }
        layers
    }
}

/// A pixel, or black and counted where a band is not finite (tested by bits).
fn keep_finite(p: &[f32; 4], non_finite: &mut NonFinite) -> Bands {
    let bands: Bands = std::array::from_fn(|b| p[b]);
    if bands.iter().all(|x| x.to_bits() & 0x7f80_0000 != 0x7f80_0000) {
        return bands;
    }
    non_finite.count(Cause::ReadBack);
    [0.0; BANDS]
}
