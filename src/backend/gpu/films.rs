//! Films on the device: which of them and of their rows a batch clears, and what is read back of them.

use super::GpuBackend;
use crate::backend::{Cause, NonFinite, PIXELS_AT_ONCE};
use crate::film::{LAYERS, Layer};
use crate::plan::buffers::{FILM_PIXEL, FILMS};
use crate::spectrum::{BANDS, Bands};
use rayon::prelude::*;
use std::ops::Range;

/// What a batch counts, beside its films.
pub(super) const COUNTS: [&str; 3] = ["status", "tallies_caustic", "tallies_diffuse"];

impl GpuBackend {
    /// The films that are traced and their bytes of these rows; none where there are no rows. Each strip uses them after the one before.
    pub(super) fn film_parts(&self, rows: &Range<usize>) -> Vec<(&wgpu::Buffer, Range<u64>)> {
        if rows.is_empty() || self.strips.count() > 1 {
            return Vec::new();
        }
        self.parts_of_films(rows)
    }

    /// The films that are traced and their bytes of these rows of the buffers.
    pub(super) fn parts_of_films(&self, rows: &Range<usize>) -> Vec<(&wgpu::Buffer, Range<u64>)> {
        let row_bytes = u64::from(self.scene.size[0]) * FILM_PIXEL;
        let bytes = rows.start as u64 * row_bytes..rows.end as u64 * row_bytes;
        self.traced_films().map(|(_, name)| (&self.buffers[name], bytes.clone())).collect()
    }

    /// The layers that are traced, and their films.
    pub(super) fn traced_films(&self) -> impl Iterator<Item = (Layer, &'static str)> {
        Layer::ALL.into_iter().zip(FILMS).filter(|(layer, _)| self.plan.traces(*layer))
    }

    /// Record that what a batch writes is cleared; of the films these rows.
    pub(super) fn clear_films(&self, encoder: &mut wgpu::CommandEncoder, rows: &Range<usize>) {
        for name in COUNTS {
            encoder.clear_buffer(&self.buffers[name], 0, None);
        }
        for (film, bytes) in self.film_parts(rows) {
            encoder.clear_buffer(film, bytes.start, Some(bytes.end - bytes.start));
        }
    }
}

/// A pixel as films hold it.
pub(super) fn four(pixel: &Bands) -> [f32; 4] {
    std::array::from_fn(|b| pixel.get(b).copied().unwrap_or(0.0))
}

/// Put into an image what was read of a film. Black pixels are left alone.
pub(super) fn put(pixels: &mut [Bands], bytes: &[u8]) {
    let found = bytes.par_chunks_exact(FILM_PIXEL as usize);
    pixels.par_iter_mut().zip(found).with_min_len(PIXELS_AT_ONCE).for_each(|(bands, p)| {
        let p: [f32; 4] = bytemuck::pod_read_unaligned(p);
        let found: Bands = std::array::from_fn(|b| p[b]);
        if found.map(f32::to_bits) != bands.map(f32::to_bits) {
            *bands = found;
        }
    });
}

/// Black and counted where a band of a pixel is not finite (tested by bits).
pub(super) fn keep_finite(layers: &mut [Vec<Bands>; LAYERS], non_finite: &mut NonFinite) {
    let is_finite = |x: &f32| x.to_bits() & 0x7f80_0000 != 0x7f80_0000;
    for layer in layers {
        let broken = |bands: &mut Bands| {
            let is_broken = !bands.iter().all(is_finite);
            if is_broken {
                *bands = [0.0; BANDS];
            }
            is_broken
        };
        let count = layer.par_iter_mut().with_min_len(PIXELS_AT_ONCE).map(broken).filter(|b| *b).count();
        non_finite.add(Cause::ReadBack, count as u64);
    }
}
