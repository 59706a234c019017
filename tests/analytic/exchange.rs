//! Light that one matte surface sends to another.

use crate::build::{Build, matte, v, wide};
use crate::factors::parallel_rectangles;
use crate::harness::{everyone, render};
use joton::film::Layer;
use std::f64::consts::PI;

/// [A13] Two opposite unit squares: the mean irradiance of the upper is ρ E F, from a lower one that the sun lights aslant.
#[test]
fn parallel_plates_exchange_by_their_form_factor() {
    let (lower, upper, sun) = ([0.8f32, 0.5, 0.2], [0.3f32, 0.6, 0.9], [1.0f32, 2.0, 3.0]);
    for distance in [1.0, 0.6] {
        // the image is the upper plate
        let eye = 0.2;
        let mut b = Build::new(v(0., 0., eye), v(0., 0., distance), 0.5 / (distance - eye), 24);
        b.floor(v(0., 0., 0.), 0.5, &matte(lower));
        b.ceiling(v(0., 0., distance), 0.5, &matte(upper));
        // so low that the upper plate's shadow misses the lower one
        let low = 65f64.to_radians();
        b.sun(v(low.sin(), 0., -low.cos()), sun);
        let factor = low.cos() * parallel_rectangles(1.0 / distance, 1.0 / distance) / PI;
        let want = std::array::from_fn(|i| wide(upper)[i] * wide(lower)[i] * wide(sun)[i] * factor);
        for who in everyone() {
            let shot = render(who, &b.0, "LDDE", 64);
            // noise, and the correction at the plate's edges
            shot.claim(&format!("plates {distance} apart"), shot.layer(Layer::Diffuse), want, 0.025);
        }
    }
}
