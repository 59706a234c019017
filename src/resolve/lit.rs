//! Lit: what the halves of the passes found of a layer.

use crate::film::Layer;
use crate::spectrum::Bands;

/// A layer as two halves of the passes have found it.
#[derive(Clone, Copy)]
pub(super) struct Lit<'a> {
    pub(super) layer: Layer,
    /// Mean radiance of each half in a pixel, W/(m² sr).
    pub(super) means: &'a (dyn Fn(usize) -> [Bands; 2] + Sync),
}

impl Lit<'_> {
    /// Mean radiance that each half found in a pixel.
    pub(super) fn halves(&self, pixel: usize) -> [Bands; 2] {
        (self.means)(pixel)
    }
}
