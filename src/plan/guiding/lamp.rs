//! Lamps: emitters in runs, as far as they are told apart when it is learned where their light goes.

use crate::packed::{PackedEmitter, PackedScene};
use crate::spectrum::sum;

/// Most lamps that are told apart; beyond, neighbours in the list are taken together.
const LAMPS: usize = 512;
/// Emissive triangles in a row are one lamp where the cosine between their normals is at least this.
const ONE_LAMP: f32 = 0.999;

/// A run of emitters.
pub(super) struct Lamp {
    /// Number of its first emitter.
    first: usize,
    /// Flux of its emitters up to and including each, internal W, all bands.
    flux_upto: Vec<f64>,
}

impl Lamp {
    /// Flux, internal W, all bands.
    pub(super) fn flux(&self) -> f64 {
        self.flux_upto.last().copied().unwrap_or(0.0)
    }

    /// Its emitters.
    pub(super) fn emitters<'a>(&self, scene: &'a PackedScene) -> &'a [PackedEmitter] {
        &scene.emitters[self.first..][..self.flux_upto.len()]
    }

    /// The emitter that `u` picks by flux, what is left of `u`, and the probability of picking it.
    pub(super) fn pick(&self, u: f32) -> (usize, f32, f32) {
        let wanted = f64::from(u) * self.flux();
        let i = self.flux_upto.partition_point(|&f| f <= wanted).min(self.flux_upto.len() - 1);
        let below = if i == 0 { 0.0 } else { self.flux_upto[i - 1] };
        let flux = self.flux_upto[i] - below;
        let rest = ((wanted - below) / flux.max(f64::MIN_POSITIVE)) as f32;
        (self.first + i, rest.clamp(0.0, 1.0 - f32::EPSILON), (flux / self.flux()) as f32)
    }
}

/// Triangles of one lamp together, and what must be taken together to be few enough.
pub(super) fn lamps(emitters: &[PackedEmitter]) -> Vec<Lamp> {
    let normal = |e: &PackedEmitter| e.e1.cross(e.e2).normalize_or_zero();
    let touch = |a: &PackedEmitter, b: &PackedEmitter| {
        let [(a, reach_a), (b, reach_b)] = [a.circle(), b.circle()];
        a.distance(b) <= reach_a + reach_b
    };
    let continues = |a: &PackedEmitter, b: &PackedEmitter| {
        a.kind == 0
            && b.kind == 0
            && a.strength == b.strength
            && normal(a).dot(normal(b)) > ONE_LAMP
            && touch(a, b)
    };
    let mut starts: Vec<usize> =
        (0..emitters.len()).filter(|&i| i == 0 || !continues(&emitters[i - 1], &emitters[i])).collect();
    let together = starts.len().div_ceil(LAMPS);
    starts = starts.into_iter().step_by(together.max(1)).collect();
    let ends: Vec<usize> = starts.iter().skip(1).copied().chain([emitters.len()]).collect();
    starts
        .into_iter()
        .zip(ends)
        .map(|(first, end)| {
            let mut upto = 0.0;
            let add = |e: &PackedEmitter| {
                upto += sum(&e.flux);
                upto
            };
            Lamp { first, flux_upto: emitters[first..end].iter().map(add).collect() }
        })
        .collect()
}
