//! Anisotropy: microfacets that are rougher one way of the surface than the other \[E56\] (Heitz 2014), and which way that is. Twins:
//! shaders/shading/{anisotropy,brushed_way}.wgsl.

use super::relief::Plain;
use super::texture::TexturePlace;
use crate::packed::{Brush, PackedMaterial};
use crate::sampling::distributions::basis;
use glam::{Mat3, Vec3};
use std::f32::consts::PI;

/// GGX normals with an α along a way of the surface and another one across it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Brushed {
    pub(super) alphas: [f32; 2],
    /// Cosine and sine of the angle of the way in the basis of the normal.
    way: [f32; 2],
}

impl Brushed {
    /// Of a material that has been met; none where it is as rough one way as the other.
    pub(super) fn of(m: &PackedMaterial) -> Option<Self> {
        let brush = m.brush()?;
        let (sin, cos) = brush.angle.sin_cos();
        Some(Self { alphas: brush.alphas(m.alpha), way: [cos, sin] })
    }

    /// α of even microfacets that mask as much from each other, of even light.
    pub(super) fn masking_alpha(&self) -> f32 {
        (0.5 * (self.alphas[0].powi(2) + self.alphas[1].powi(2))).sqrt()
    }

    /// Along, across, and the normal.
    pub(super) fn frame(&self, n: Vec3) -> Mat3 {
        let (x, y) = basis(n);
        let [cos, sin] = self.way;
        Mat3::from_cols(x * cos + y * sin, y * cos - x * sin, n)
    }

    /// Density of normals, 1/sr.
    pub(super) fn density(&self, h: Vec3, n: Vec3) -> f32 {
        let h = self.frame(n).transpose() * h;
        let [a, b] = self.alphas;
        let stretched = (h.x / a).powi(2) + (h.y / b).powi(2) + h.z * h.z;
        1.0 / (PI * a * b * stretched * stretched)
    }

    /// √(cos²θ + (α cosφ sinθ)² + (β sinφ sinθ)²): Smith's Λ is this over 2 cosθ, less a half.
    pub(super) fn slope(&self, w: Vec3, n: Vec3) -> f32 {
        let w = self.frame(n).transpose() * w;
        let [a, b] = self.alphas;
        Vec3::new(a * w.x, b * w.y, w.z).length()
    }
}

/// The material where a surface has been met: the way of its anisotropy in the basis of the shading normal.
pub(super) fn at(m: &PackedMaterial, place: &TexturePlace, plain: Plain, ns: Vec3) -> Option<PackedMaterial> {
    let brush = m.brush()?;
    let (way, across) = of_surface(m, place, plain);
    let (sin, cos) = brush.angle.sin_cos();
    let along = way * cos + across * sin;
    let (x, y) = basis(ns);
    let angle = along.dot(y).atan2(along.dot(x));
    Some(PackedMaterial { glossy_exponent: Brush { angle, ..brush }.packed(), ..*m })
}

/// The way of a surface, and the one at right angles to it, counter-clockwise as seen from the front; of no sense.
fn of_surface(m: &PackedMaterial, place: &TexturePlace, Plain { front, ns }: Plain) -> (Vec3, Vec3) {
    let [u, v] = place.gradients;
    let way = if m.flags().is_around() {
        v * place.uv[0] - u * place.uv[1]
    } else {
        // where the picture goes right and stays as high
        v.cross(front)
    };
    let level = Vec3::Y.cross(ns).normalize_or(Vec3::X);
    let way = (way - ns * ns.dot(way)).normalize_or(level);
    (way, ns.cross(way))
}
