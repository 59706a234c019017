//! Triangles and materials as plain arrays.

use super::winding::corner;
use crate::bands::{BLACK, Bands, add, is_black};
use crate::bvh::Edges;
use crate::layout::gpu_struct;
use crate::scene::{Material, Scene};
use glam::Vec3;
use std::collections::HashSet;

/// [`PackedTriangle::emitter`] of a triangle that emits nothing.
pub const NO_EMITTER: u32 = u32::MAX;

/// Bit of [`PackedTriangle::flags`]: the triangle has shading normals.
pub const SMOOTH: u32 = 1;

gpu_struct! {
    /// A triangle, 48 bytes; front where the vertices run counter-clockwise.
    pub struct PackedTriangle {
        /// First vertex.
        pub v0: Vec3,
        /// Index of the material.
        pub material: u32,
        /// Second vertex minus first.
        pub e1: Vec3,
        /// [`SMOOTH`] or 0.
        pub flags: u32,
        /// Third vertex minus first.
        pub e2: Vec3,
        /// Index of the emitter, or [`NO_EMITTER`].
        pub emitter: u32,
    }
}

impl PackedTriangle {
    /// Area in internal units.
    pub fn area(&self) -> f32 {
        0.5 * self.e1.as_dvec3().cross(self.e2.as_dvec3()).length() as f32
    }

    /// Unit geometric normal of the front.
    pub fn normal(&self) -> Vec3 {
        self.e1.cross(self.e2).normalize_or_zero()
    }

    /// The triangle with all corners.
    pub fn vertices(&self) -> [Vec3; 3] {
        [self.v0, self.v0 + self.e1, self.v0 + self.e2]
    }
}

impl Edges for PackedTriangle {
    #[inline(always)]
    fn edges(&self) -> [Vec3; 3] {
        [self.v0, self.e1, self.e2]
    }
}

/// Glossy lobes sharper than this Phong exponent are S events: sampled like mirrors, never looked up in a map.
const SHARP_EXPONENT: f32 = 300.0;

/// What a material can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaterialFlags(u32);

impl MaterialFlags {
    pub(crate) const DIFFUSE: u32 = 1;
    pub(crate) const GLOSSY: u32 = 2;
    pub(crate) const SPECULAR: u32 = 4;
    pub(crate) const DIELECTRIC: u32 = 8;
    pub(crate) const EMISSIVE: u32 = 16;

    /// Light can be scattered into all directions here: a gather point, a place for jotons.
    pub fn has_diffuse(self) -> bool {
        self.0 & (Self::DIFFUSE | Self::GLOSSY) != 0
    }
    /// There is a glossy lobe.
    pub fn has_glossy(self) -> bool {
        self.0 & Self::GLOSSY != 0
    }
    /// A mirror or a dielectric: light can leave in a single direction.
    pub fn has_delta(self) -> bool {
        self.0 & (Self::SPECULAR | Self::DIELECTRIC) != 0
    }
    /// Light can pass through.
    pub fn is_dielectric(self) -> bool {
        self.0 & Self::DIELECTRIC != 0
    }
    /// The front emits.
    pub fn is_emissive(self) -> bool {
        self.0 & Self::EMISSIVE != 0
    }
}

gpu_struct! {
    /// A material, 80 bytes. For a dielectric `specular` and `transmission` are the tints; otherwise reflectances.
    pub struct PackedMaterial {
        /// Lambertian reflectance.
        pub diffuse: Bands,
        /// Bits of [`MaterialFlags`].
        pub flag_bits: u32,
        /// Mirror reflectance, or the dielectric's reflection tint.
        pub specular: Bands,
        /// Index of refraction inside over outside; 1 where opaque.
        pub ior: f32,
        /// Glossy reflectance.
        pub glossy: Bands,
        /// Phong exponent of the glossy lobe.
        pub glossy_exponent: f32,
        /// Transmission tint of a dielectric; black where opaque.
        pub transmission: Bands,
        /// Phong exponent about the mirror direction of what `specular` reflects; 0 is a perfect mirror.
        pub specular_exponent: f32,
        /// Radiance emitted from the front, W/(m² sr).
        pub emission: Bands,
        /// Padding.
        pub pad1: u32,
    }
}

impl PackedMaterial {
    /// Pack a material.
    pub fn new(m: &Material) -> Self {
        let mut bits = 0;
        let mut set = |on: bool, bit: u32| bits |= if on { bit } else { 0 };
        set(m.dielectric.is_some(), MaterialFlags::DIELECTRIC);
        let opaque = m.dielectric.is_none();
        let sharp = m.glossy_exponent > SHARP_EXPONENT;
        let (glossy, specular) =
            if sharp { (BLACK, add(&m.specular, &m.glossy)) } else { (m.glossy, m.specular) };
        set(opaque && !is_black(&m.diffuse), MaterialFlags::DIFFUSE);
        set(opaque && !is_black(&glossy), MaterialFlags::GLOSSY);
        set(opaque && !is_black(&specular), MaterialFlags::SPECULAR);
        set(!is_black(&m.emission), MaterialFlags::EMISSIVE);
        let d = m.dielectric;
        Self {
            diffuse: if opaque { m.diffuse } else { BLACK },
            flag_bits: bits,
            specular: d.map_or(specular, |d| d.reflection_tint),
            ior: d.map_or(1.0, |d| d.ior),
            glossy: if opaque { glossy } else { BLACK },
            glossy_exponent: m.glossy_exponent,
            transmission: d.map_or(BLACK, |d| d.transmission_tint),
            specular_exponent: if sharp && !is_black(&m.glossy) { m.glossy_exponent } else { 0.0 },
            emission: m.emission,
            pad1: 0,
        }
    }

    /// What the material can do.
    pub fn flags(&self) -> MaterialFlags {
        MaterialFlags(self.flag_bits)
    }
}

/// Triangles start at their first corner unless the sine of its angle is this many times smaller than another's.
const SLIVER: f32 = 4.0;

/// The corner that a triangle starts from: the first, but where that is the tip of a sliver the one whose angle has the
/// largest sine. One edge is short then, and what rounding does to the weights of a hit stays small along the long one.
pub fn first_corner(vertices: [Vec3; 3]) -> usize {
    // twice the area over the sine
    let product = |k: usize| {
        let [a, b, c] = [0, 1, 2].map(|i| vertices[(k + i) % 3]);
        (b - a).length() * (c - a).length()
    };
    let best = if product(1) < product(2) { 1 } else { 2 };
    if SLIVER * product(best) < product(0) { best } else { 0 }
}

/// Indices of the triangles without exact copies: same corners in the same turn, same material, no shading normals. One
/// of them is what a ray meets; the others would only shine once more and make the hierarchy deep.
pub(crate) fn without_copies(scene: &Scene, vertices: &[[Vec3; 3]]) -> Vec<u32> {
    let mut seen = HashSet::with_capacity(vertices.len());
    let is_new = |&i: &u32| {
        let t = &scene.mesh.triangles[i as usize];
        let corners = vertices[i as usize].map(|v| v.to_array().map(f32::to_bits));
        let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
        let turned: [[u32; 3]; 3] = std::array::from_fn(|k| corners[(first + k) % 3]);
        t.normal.is_some() || seen.insert((turned, t.material))
    };
    (0..vertices.len() as u32).filter(is_new).collect()
}

/// Triangles in leaf order with their shading normals (empty where all are flat). Emitters are not yet numbered:
/// `emitter` holds 0 where the material emits. `vertices` are turned already where a triangle is.
pub(super) fn pack(
    scene: &Scene,
    vertices: &[[Vec3; 3]],
    turned: &[bool],
    order: &[u32],
) -> (Vec<PackedTriangle>, Vec<[Vec3; 3]>) {
    let any_smooth = scene.mesh.triangles.iter().any(|t| t.normal.is_some());
    let mut triangles = Vec::with_capacity(order.len());
    let mut normals = Vec::with_capacity(if any_smooth { order.len() } else { 0 });
    for &i in order {
        let t = &scene.mesh.triangles[i as usize];
        let first = first_corner(vertices[i as usize]);
        let from_first = |k: usize| (first + k) % 3;
        let [a, b, c] = [0, 1, 2].map(|k| vertices[i as usize][from_first(k)]);
        let packed = PackedTriangle {
            v0: a,
            material: t.material,
            e1: b - a,
            flags: if t.normal.is_some() { SMOOTH } else { 0 },
            e2: c - a,
            emitter: NO_EMITTER,
        };
        triangles.push(packed);
        if any_smooth {
            normals.push(match t.normal {
                Some(n) => {
                    // they are of the front, which is the other one where a triangle is turned
                    let is_turned = turned[i as usize];
                    let sign = if is_turned { -1.0 } else { 1.0 };
                    [0, 1, 2].map(|k| sign * scene.mesh.normals[n[corner(is_turned, from_first(k))] as usize])
                }
                None => [packed.normal(); 3],
            });
        }
    }
    (triangles, normals)
}
