//! Lights beside emissive triangles: those that a surface cannot stand for.

use crate::spectrum::Bands;
use glam::DVec3;

/// A light without a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Shines the same in every direction.
    Point {
        /// World position.
        position: DVec3,
        /// Radiant intensity, W/sr per band. Flux is 4π times this.
        intensity: Bands,
    },
    /// Shines into a cone: full intensity inside `angle_inner`, smoothly (cubic in the cosine) to none at `angle_outer`.
    Spot {
        /// World position.
        position: DVec3,
        /// Unit axis, away from the light.
        direction: DVec3,
        /// Radiant intensity on the axis, W/sr per band.
        intensity: Bands,
        /// Angle from the axis up to which the intensity is full, rad. Not its cosine: that of a narrow cone has no digits.
        angle_inner: f64,
        /// Angle from the axis at which the intensity reaches zero, rad.
        angle_outer: f64,
    },
    /// Parallel light from far away.
    Sun {
        /// Unit direction in which the light travels.
        direction: DVec3,
        /// Irradiance on a surface that faces the sun, W/m² per band.
        irradiance: Bands,
    },
}
