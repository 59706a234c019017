//! Candidates: of some light samples one gets the shadow ray [E24].

use crate::backend::Tally;
use crate::optics::lights::pick::sample_light;
use crate::optics::lights::reservoir::Reservoir;
use crate::optics::lights::samples::LightSample;
use crate::packed::{PackedEmitter, PackedScene};
use crate::spectrum::{Bands, max, scale};
use glam::Vec3;

/// One of some light samples, picked by what each gives to `position` if nothing shades it, and what it gives for all of them [E24].
pub(super) fn brightest(
    scene: &PackedScene,
    lights: &[PackedEmitter],
    position: Vec3,
    candidates: impl ExactSizeIterator<Item = [f32; 2]>,
    choice: f32,
    given: impl Fn(&LightSample) -> Bands,
    tally: &mut Tally,
) -> Option<(LightSample, Bands)> {
    let number = candidates.len() as f32;
    let mut picked: Option<(LightSample, Bands)> = None;
    let mut reservoir = Reservoir::new(choice);
    for u in candidates {
        let Some(l) = sample_light(scene, lights, position, u) else { continue };
        let given = given(&l);
        let size = max(&given);
        if size <= 0.0 {
            continue;
        }
        if reservoir.takes(size) {
            picked = Some((l, given));
        }
        tally.shadow_rays_saved += 1;
    }
    let (l, given) = picked?;
    tally.shadow_rays_saved -= 1;
    let of_all = reservoir.total / (number * max(&given));
    Some((l, scale(&given, of_all)))
}
