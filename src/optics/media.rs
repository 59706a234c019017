//! Media: which bodies light is in on its way, what they leave of it \[E44\], and which of them meet at a boundary \[E45\]. Twin: shaders/shading/media.wgsl.

use crate::packed::{Inside, Media, NESTED_MOST, PackedMaterial, PackedScene};
use crate::spectrum::{BANDS, Bands, is_black};

/// Where light is that meets a boundary, and where it would be beyond.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sides {
    /// Before it.
    pub(crate) here: Inside,
    /// Beyond it.
    pub(crate) beyond: Inside,
}

impl Sides {
    /// At a boundary, or any other surface, that is met from its front or its back by light in these bodies.
    pub(crate) fn at(media: &Media, boundary: &PackedMaterial, from_front: bool, inside: Inside) -> Self {
        let body = boundary.body() as u8;
        if body == 0 {
            return Self { here: inside, beyond: inside };
        }
        if from_front {
            return Self { here: inside, beyond: with(media, inside, body) };
        }
        // who meets the back of a boundary is in its body, whatever it took itself to be in; without priorities in nothing else there
        let here = match inside.bodies.contains(&body) {
            true => inside,
            false if media.has_priorities => with(media, inside, body),
            false => with(media, without(inside, inside.bodies[0]), body),
        };
        Self { here, beyond: without(here, body) }
    }

    /// On one of the two sides.
    pub(crate) fn toward(&self, is_across: bool) -> Inside {
        if is_across { self.beyond } else { self.here }
    }

    /// True where the medium stays: priorities say so.
    pub(crate) fn is_no_boundary(&self, media: &Media, boundary: &PackedMaterial) -> bool {
        media.has_priorities && boundary.body() > 0 && self.here.bodies[0] == self.beyond.bodies[0]
    }

    /// The boundary as it is between the media that meet at it; none where it says so itself.
    pub(crate) fn between(
        &self,
        scene: &PackedScene,
        boundary: &PackedMaterial,
        from_front: bool,
    ) -> Option<PackedMaterial> {
        let media = &scene.media;
        // what of a boundary is opaque is what it says
        if !media.has_priorities || boundary.body() == 0 || !boundary.flags().is_dielectric() {
            return None;
        }
        if self.is_no_boundary(media, boundary) {
            return Some(boundary.passed());
        }
        let [here, beyond] = [self.here.bodies[0], self.beyond.bodies[0]];
        let indices = |number: u8| match number {
            0 => (1.0, [1.0; BANDS], false),
            _ => {
                let m = &scene.materials[media.bodies[usize::from(number) - 1].material as usize];
                (m.ior, m.iors, m.flags().is_dispersive())
            }
        };
        let [before, behind] = if from_front { [here, beyond] } else { [beyond, here] }.map(indices);
        let iors = std::array::from_fn(|b| behind.1[b] / before.1[b]);
        Some(boundary.between(behind.0 / before.0, iors, behind.2 || before.2))
    }
}

/// What is left of light after a distance in these bodies, per band; none where it is all.
pub(crate) fn transmittance(scene: &PackedScene, inside: Inside, distance: f32) -> Option<Bands> {
    let body = usize::from(inside.bodies[0]).checked_sub(1)?;
    let absorption = &scene.materials[scene.media.bodies.get(body)?.material as usize].extinction;
    // no length makes up for what is not absorbed
    let left = |b: usize| if absorption[b] > 0.0 { (-absorption[b] * distance).exp() } else { 1.0 };
    (!is_black(absorption)).then(|| std::array::from_fn::<f32, BANDS, _>(left))
}

/// In one more body, before those that do not come before it by their priority; of too many the last is forgotten.
fn with(media: &Media, inside: Inside, body: u8) -> Inside {
    let rank = |number: u8| media.bodies[usize::from(number) - 1].rank;
    let is_after = |other: &u8| *other == 0 || rank(*other) >= rank(body);
    let Some(at) = inside.bodies.iter().position(is_after) else { return inside };
    let mut bodies = inside.bodies;
    bodies[at..].rotate_right(1);
    bodies[at] = body;
    Inside { bodies }
}

/// Out of a body, the first of its number.
fn without(inside: Inside, body: u8) -> Inside {
    let Some(at) = inside.bodies.iter().position(|b| *b == body) else { return inside };
    let mut bodies = inside.bodies;
    bodies[at..].rotate_left(1);
    bodies[NESTED_MOST - 1] = 0;
    Inside { bodies }
}
