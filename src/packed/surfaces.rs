//! Triangles and materials as plain arrays.

use super::winding::corner;
use crate::packed::accel::Face;
use crate::packed::brush::Brush;
use crate::packed::constants::{FOLLOWED_ALPHA, SMOOTH_ALPHA};
use crate::packed::gpu_struct::gpu_struct;
use crate::packed::material_flags::MaterialFlags;
use crate::scene::texture::ReliefKind;
use crate::scene::{FacetKind, Facets, Inner, Layers, Material, Scene, Triangle};
use crate::spectrum::{BANDS, BLACK, Bands, is_black};
use glam::Vec3;
use half::f16;
use rustc_hash::{FxBuildHasher, FxHashMap};

/// [`PackedTriangle::emitter`] of a triangle that emits nothing.
pub const NO_EMITTER: u32 = u32::MAX;

/// Bit of [`PackedTriangle::flags`]: the triangle has shading normals.
pub const SMOOTH: u32 = 1;
/// Bit of [`PackedTriangle::flags`]: light passes through.
pub const CLEAR: u32 = 2;
/// Bit of [`PackedTriangle::flags`]: the front emits.
pub const LAMP: u32 = 4;
/// Bit of [`PackedTriangle::flags`]: a texture lies on it, or what has a way is brushed by its coordinates.
pub const TEXTURED: u32 = 8;
/// Bit of [`PackedTriangle::flags`]: some of it is not there \[E38\].
pub const CUT: u32 = 16;

/// Bit of [`PackedTriangle::flags`]: it bounds a body, and priorities decide what is in it \[E45\].
pub const NESTED: u32 = 32;

/// Ranks of faces in one place ([`Face::rank`]): opaque before clear, since glass that touches an opaque face is in optical
/// contact with it; of opaque faces those that look toward the ray, lamps first; of clear ones the way out before the way in, but where bodies have priorities: there each is left when
/// the next has been entered, so that no air is between them.
pub(crate) mod rank {
    pub(crate) const CLEAR_FRONT: u32 = 0;
    pub(crate) const CLEAR_BACK: u32 = 1;
    pub(crate) const BACK: u32 = 2;
    pub(crate) const FRONT: u32 = 3;
    pub(crate) const LAMP: u32 = 4;
}

gpu_struct! {
    /// A triangle, 48 bytes; front where the vertices run counter-clockwise.
    pub struct PackedTriangle {
        /// First vertex.
        pub v0: Vec3,
        /// Index of the material.
        pub material: u32,
        /// Second vertex minus first.
        pub e1: Vec3,
        /// Bits: [`SMOOTH`], [`CLEAR`], [`LAMP`], [`TEXTURED`], [`CUT`], [`NESTED`].
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

impl Face for PackedTriangle {
    #[inline(always)]
    fn edges(&self) -> [Vec3; 3] {
        [self.v0, self.e1, self.e2]
    }

    // twin: shaders/accel/crossing.wgsl
    fn rank(&self, is_front: bool) -> u32 {
        let is_nested = self.flags & NESTED != 0;
        match (self.flags & CLEAR != 0, is_front) {
            (true, is_front) if is_nested == is_front => rank::CLEAR_BACK,
            (true, _) => rank::CLEAR_FRONT,
            (false, false) => rank::BACK,
            (false, true) if self.flags & LAMP == 0 => rank::FRONT,
            (false, true) => rank::LAMP,
        }
    }
}

/// Glossy lobes sharper than this Phong exponent are followed as mirrors are, never looked up in a map: none is dense enough.
/// Lights without area are never met so; shadow rays find them in such a lobe as in every other [E6].
const FOLLOWED_EXPONENT: f32 = 300.0;
/// Indices that differ by less are the same.
pub(crate) const SAME_INDEX: f32 = 1e-4;

/// Largest of 16 bits.
const SHEEN_STEPS: f32 = 65_535.0;

/// Two numbers as [`PackedMaterial::sheen`] has them: what is let through is never too much.
pub(super) fn sheen_bits(roughness: f32, most: f32) -> u32 {
    let steps = |x: f32| x.clamp(0.0, 1.0) * SHEEN_STEPS;
    (steps(most).ceil() as u32) << 16 | steps(roughness).round() as u32
}

/// Bits of [`PackedMaterial::flag_bits`] below the number of its body.
pub const BODY_SHIFT: u32 = 24;

gpu_struct! {
    /// A material, 144 bytes. For a dielectric `specular` and `transmission` are the tints; otherwise reflectances. Of microfacets
    /// `glossy` and `specular` are what Schlick's formula has head on, or the tint of what reflects by indices of refraction \[E40\].
    pub struct PackedMaterial {
        /// Lambertian reflectance; under a coat what leaves it over what enters it \[E42\].
        pub diffuse: Bands,
        /// Bits of [`MaterialFlags`]; above them the number of its body, where its inside matters.
        pub flag_bits: u32,
        /// Mirror reflectance, or the dielectric's reflection tint.
        pub specular: Bands,
        /// Index of refraction inside over outside, of a dielectric or of a coat; else 1.
        pub ior: f32,
        /// Glossy reflectance.
        pub glossy: Bands,
        /// Phong exponent of the glossy lobe; of anisotropic microfacets the bits of [`Brush`].
        pub glossy_exponent: f32,
        /// Transmission tint of a dielectric; of what is translucent the part that is scattered through \[E55\].
        pub transmission: Bands,
        /// Phong exponent about the mirror direction of what `specular` reflects, a lobe that is followed; 0 is a mirror.
        pub specular_exponent: f32,
        /// Radiance emitted from the front, W/(m² sr).
        pub emission: Bands,
        /// Numbers of its textures, from 1; 0 where there is none: that of `diffuse` in the low 16 bits, of its opacity above.
        pub textures: u32,
        /// `ior` in each band, where it differs between them; a metal's index, its real part; of layers what the dielectric part reflects
        /// head on.
        pub iors: Bands,
        /// GGX roughness α of the microfacets; 0 is smooth.
        pub alpha: f32,
        /// A metal's index, its imaginary part; of a body what it absorbs, per internal unit of length;
        /// of layers the colour of the sheen.
        pub extinction: Bands,
        /// Part of even light that a coat lets through.
        pub coat_transmittance: f32,
        /// Numbers of its textures, as in `textures`: of roughness in the low 16 bits, of the metallic part above.
        pub facet_textures: u32,
        /// Part that is metal, where that part's colour is settled at each place.
        pub metallic: f32,
        /// Numbers of its textures, as in `textures`: of its relief in the low 16 bits, of `emission` above.
        pub relief_texture: u32,
        /// Factor on slopes of normals, or height of white, internal units or widths of the picture.
        pub relief: f32,
        /// How much of a clear coat there is.
        pub clear_coat: f32,
        /// GGX roughness α of it; 0 is smooth.
        pub clear_coat_alpha: f32,
        /// Roughness of the sheen, and the most that its colour has anywhere, in 16 bits each from 0 to 1, the low ones first.
        pub sheen: u32,
        /// What the dielectric part of a layered material reflects at grazing angles.
        pub grazing: f32,
        /// Of what is glass in part the material of the rest; else 0, which is none's: it comes after the glass. `clear_coat` of such glass
        /// is what is transmitted of what is no metal, and `metallic` is that \[E57\].
        pub rest: u32,
        /// Number of the texture of the transmission, as in `textures`.
        pub transmission_texture: u32,
    }
    words 7 * BANDS + 17
}

impl PackedMaterial {
    /// How its microfacets are brushed.
    pub fn brush(&self) -> Option<Brush> {
        self.flags().is_anisotropic().then(|| Brush::unpacked(self.glossy_exponent))
    }

    /// Roughness of the sheen, and the most that its colour has in any band or at any wavelength.
    pub(crate) fn sheen_numbers(&self) -> [f32; 2] {
        [self.sheen & 0xffff, self.sheen >> 16].map(|x| x as f32 / SHEEN_STEPS)
    }

    /// Pack a material.
    pub fn new(m: &Material) -> Self {
        let mut bits = 0;
        let mut set = |on: bool, bit: u32| bits |= if on { bit } else { 0 };
        let opaque = m.dielectric.is_none();
        set(!opaque, MaterialFlags::DIELECTRIC);
        set(!opaque && m.thin, MaterialFlags::THIN);
        let is_varied = m.facets.is_some() && (m.roughness.is_some() || m.metallic.is_some());
        // what varies is rounded where it is looked up [E47], before it is asked whether it is followed
        let kept = |alpha: f32| if is_varied { f16::from_f32(alpha).to_f32() } else { alpha };
        let smooth = |alpha: f32| if kept(alpha) < SMOOTH_ALPHA { 0.0 } else { kept(alpha).min(1.0) };
        let alpha = m.facets.map_or(0.0, |f| smooth(f.alpha));
        let least_alpha = m.roughness.as_ref().map_or(alpha, |map| smooth(map.range()[0].powi(2)));
        let kind = m.facets.map(|f| f.kind).filter(|_| opaque);
        // a smooth interface needs no microfacets, and nothing is there where the index stays
        let is_interface =
            m.dielectric.is_some_and(|d| (d.ior - 1.0).abs() > SAME_INDEX || m.interior.priority.is_some());
        let has_facets = kind.is_some() || (is_interface && alpha > 0.0);
        set(has_facets, MaterialFlags::FACETS);
        // beside a mirror there is no room for a second lobe that is followed
        let narrow = |alpha: f32| {
            let alpha = m.anisotropy.map_or(alpha, |brush| Brush::of(brush).mean_alpha(alpha));
            if kind.is_some() { alpha <= FOLLOWED_ALPHA } else { m.glossy_exponent > FOLLOWED_EXPONENT }
        };
        let followed = narrow(least_alpha) && is_black(&m.specular);
        let (glossy, specular) = match followed {
            // at some places it is, at others not
            true if !narrow(alpha) => (m.glossy, m.glossy),
            true => (BLACK, m.glossy),
            false => (m.glossy, m.specular),
        };
        let is_all_metal = m.metallic.as_ref().is_some_and(|metal| metal.map.is_none() && metal.most >= 1.0);
        let has_base = !is_black(&m.diffuse) && !is_all_metal;
        let is_translucent = opaque && !is_black(&m.transmit);
        let has_base = has_base || is_translucent;
        set(is_translucent, MaterialFlags::TRANSLUCENT);
        set(opaque && has_base, MaterialFlags::DIFFUSE);
        set(opaque && !is_black(&glossy), MaterialFlags::GLOSSY);
        set(opaque && !is_black(&specular), MaterialFlags::SPECULAR);
        set(!is_black(&m.emission), MaterialFlags::EMISSIVE);
        let metal = match kind {
            Some(FacetKind::Conductor { eta, k }) => Some((eta, k)),
            _ => None,
        };
        let coat = kind.and_then(FacetKind::coat);
        set(metal.is_some(), MaterialFlags::CONDUCTOR);
        set(matches!(kind, Some(FacetKind::Schlick { .. })), MaterialFlags::SCHLICK);
        let layers = m.layers.filter(|_| matches!(kind, Some(FacetKind::Schlick { .. })));
        let clear_coat = layers.map_or(0.0, |l| l.clear_coat);
        let clear_coat_alpha = layers.map_or(0.0, |l| smooth(l.clear_coat_alpha));
        let follows_coat = clear_coat > 0.0 && clear_coat_alpha <= FOLLOWED_ALPHA;
        let has_sheen = layers.is_some_and(|l| !is_black(&l.sheen));
        let layers_scatter = has_sheen || (clear_coat > 0.0 && !follows_coat);
        set(layers.is_some(), MaterialFlags::LAYERED);
        set(follows_coat, MaterialFlags::CLEAR_COAT_FOLLOWED);
        set(layers_scatter, MaterialFlags::LAYERS_SCATTER);
        set(coat.is_some_and(|ior| ior > 1.0 || layers.is_some()) && has_base, MaterialFlags::COATED);
        set(opaque && (has_base || layers_scatter || !is_black(&glossy)), MaterialFlags::STORES);
        set(is_varied, MaterialFlags::VARIED);
        set(m.metallic.is_some(), MaterialFlags::MIXED);
        let relief = m.relief.as_ref().map(|relief| relief.kind);
        set(matches!(relief, Some(ReliefKind::Normals { .. })), MaterialFlags::NORMAL_MAP);
        set(matches!(relief, Some(ReliefKind::Heights { .. })), MaterialFlags::HEIGHT_MAP);
        let is_relative = matches!(relief, Some(ReliefKind::Heights { is_relative: true, .. }));
        set(is_relative, MaterialFlags::RELATIVE_HEIGHT);
        let brush = m.anisotropy.filter(|_| has_facets);
        set(brush.is_some(), MaterialFlags::ANISOTROPIC);
        set(brush.is_some_and(|brush| brush.is_around), MaterialFlags::AROUND);
        let d = m.dielectric;
        let mixture = m.mixture.as_ref();
        let ior = d.map(|d| d.ior).or(coat).unwrap_or(1.0);
        let is_phong = followed && m.facets.is_none() && !is_black(&m.glossy);
        let mut packed = Self {
            diffuse: if opaque { m.diffuse } else { BLACK },
            flag_bits: bits,
            specular: d.map_or(specular, |d| d.reflection_tint),
            ior,
            glossy: if opaque { glossy } else { BLACK },
            glossy_exponent: brush.map_or(m.glossy_exponent, |brush| Brush::of(brush).packed()),
            transmission: d.map_or(m.transmit, |d| d.transmission_tint),
            specular_exponent: if is_phong { m.glossy_exponent } else { 0.0 },
            emission: m.emission,
            textures: 0,
            iors: metal.map(|(eta, _)| eta).or(layers.map(|l| l.head_on)).unwrap_or([ior; BANDS]),
            alpha,
            extinction: metal.map(|(_, k)| k).or(layers.map(|l| l.sheen)).unwrap_or(BLACK),
            coat_transmittance: kind.map_or(1.0, |kind| coat_transmittance(kind, layers.as_ref()) as f32),
            facet_textures: 0,
            metallic: m
                .metallic
                .as_ref()
                .map(|metal| metal.most)
                .or(layers.map(|l| l.metallic))
                .or(mixture.map(|mixture| mixture.metallic))
                .unwrap_or(0.0),
            relief_texture: 0,
            relief: 0.0,
            clear_coat: mixture.map_or(clear_coat, |mixture| mixture.transmission),
            clear_coat_alpha,
            sheen: layers
                .map_or(0, |l| sheen_bits(l.sheen_roughness, l.sheen.into_iter().fold(0.0, f32::max))),
            grazing: layers.map_or(1.0, |l| l.grazing),
            rest: mixture.map_or(0, |mixture| mixture.number),
            transmission_texture: 0,
            pad: Default::default(),
        };
        packed.diffuse = packed.under_coat(m.facets, m.layers.as_ref(), packed.diffuse);
        packed
    }

    /// What leaves a diffuse base of this reflectance over what enters its coat: light is reflected to and fro between the two \[E42\].
    pub(super) fn under_coat(
        &self,
        facets: Option<Facets>,
        layers: Option<&Layers>,
        reflectance: Bands,
    ) -> Bands {
        let Some(kind) = facets.map(|f| f.kind).filter(|_| self.flags().is_coated()) else {
            return reflectance;
        };
        let (ior, inner) = match kind {
            FacetKind::Coat { ior, inner } => (f64::from(ior), inner),
            _ => (f64::from(self.ior), Inner::Even),
        };
        let outer = coat_transmittance(kind, layers);
        // of even light inside, which Fresnel's symmetry ties to that outside
        let inside = 1.0 - outer / (ior * ior);
        reflectance.map(|rho| {
            let rho = f64::from(rho);
            (match inner {
                Inner::Once => rho,
                Inner::Even => rho / outer,
                Inner::Coloured => rho / (ior * ior * (1.0 - rho * inside)),
            }) as f32
        })
    }

    /// Number of the body that it bounds among those whose inside matters, from 1; 0 where it is none.
    pub fn body(&self) -> u32 {
        self.flag_bits >> BODY_SHIFT
    }

    /// True for microfacets that are not smooth.
    pub(crate) fn is_rough(&self) -> bool {
        self.flags().has_facets() && self.alpha > 0.0
    }

    /// The material of what of it is no glass.
    pub fn rest(&self) -> Option<usize> {
        Some(self.rest as usize).filter(|number| *number > 0)
    }

    /// Texture of how much of it is glass, counted from 1.
    pub(crate) fn transmission_texture(&self) -> Option<u32> {
        Some(self.transmission_texture).filter(|number| *number > 0)
    }

    /// Texture of `diffuse`, counted from 1.
    pub(crate) fn colour_texture(&self) -> Option<u32> {
        Some(self.textures & 0xffff).filter(|number| *number > 0)
    }

    /// Texture of its opacity, counted from 1.
    pub(crate) fn opacity_texture(&self) -> Option<u32> {
        Some(self.textures >> 16).filter(|number| *number > 0)
    }

    /// Texture of the roughness, counted from 1.
    pub(crate) fn roughness_texture(&self) -> Option<u32> {
        Some(self.facet_textures & 0xffff).filter(|number| *number > 0)
    }

    /// Texture of the metallic part, counted from 1.
    pub(crate) fn metallic_texture(&self) -> Option<u32> {
        Some(self.facet_textures >> 16).filter(|number| *number > 0)
    }

    /// Texture of its relief, counted from 1.
    pub(crate) fn relief_texture(&self) -> Option<u32> {
        Some(self.relief_texture & 0xffff).filter(|number| *number > 0)
    }

    /// Texture of what it emits, counted from 1.
    pub(crate) fn emission_texture(&self) -> Option<u32> {
        Some(self.relief_texture >> 16).filter(|number| *number > 0)
    }

    /// True for a lobe of finite width that is followed as a mirror is, if only at some places: its α is the most that a texture makes it.
    pub fn has_narrow_lobe(&self) -> bool {
        let followed = MaterialFlags::SPECULAR | MaterialFlags::DIELECTRIC;
        self.specular_exponent > 0.0
            || (self.is_rough() && self.flags().0 & followed != 0)
            || (self.flags().follows_clear_coat() && self.clear_coat_alpha > 0.0)
    }

    /// True where what is stated as glossy is packed as `specular`: it is followed.
    pub(super) fn follows_glossy(&self, m: &Material) -> bool {
        !is_black(&m.glossy) && is_black(&m.specular) && !is_black(&self.specular)
    }

    /// The same where two other media meet at it: index of what is behind it over that of what is before, in all and in each band.
    pub(crate) fn between(&self, ior: f32, iors: Bands, is_dispersive: bool) -> Self {
        // nothing bends at facets where the index stays
        let same = if (ior - 1.0).abs() > SAME_INDEX { 0 } else { MaterialFlags::FACETS };
        let parts = is_dispersive && iors.iter().any(|other| (other - iors[0]).abs() > SAME_INDEX);
        let disperses = if parts { MaterialFlags::DISPERSIVE } else { 0 };
        let flag_bits = self.flag_bits & !(same | MaterialFlags::DISPERSIVE) | disperses;
        Self { ior, iors, flag_bits, ..*self }
    }

    /// The same where it is no boundary: light goes straight through, as through a pane of the index of air.
    pub(crate) fn passed(&self) -> Self {
        let none = MaterialFlags::FACETS | MaterialFlags::DISPERSIVE;
        let flag_bits = self.flag_bits & !none | MaterialFlags::THIN;
        let (specular, transmission) = (BLACK, [1.0; BANDS]);
        Self { ior: 1.0, iors: [1.0; BANDS], flag_bits, specular, transmission, ..*self }
    }

    /// Mark it as one whose index differs between the bands: `iors` says how \[E36\].
    pub(crate) fn set_dispersive(&mut self) {
        self.flag_bits |= MaterialFlags::DISPERSIVE;
    }

    /// True where light of different bands takes different ways on: what a thin pane transmits is not bent.
    pub fn parts_bands(&self) -> bool {
        self.flags().is_dispersive() && !self.flags().is_thin()
    }

    /// What the material can do.
    pub fn flags(&self) -> MaterialFlags {
        MaterialFlags(self.flag_bits)
    }
}

/// Glass keeps jotons where what of it is no glass does.
pub(super) fn join_rests(materials: &mut [PackedMaterial]) {
    for i in 0..materials.len() {
        let Some(rest) = materials[i].rest() else { continue };
        materials[i].flag_bits |= materials[rest].flag_bits & MaterialFlags::STORES;
    }
}

/// Part of even light from outside that a smooth coat lets through: ∫ T(c) 2c dc; of Schlick's formula in closed form \[E42\].
fn coat_transmittance(kind: FacetKind, layers: Option<&Layers>) -> f64 {
    const STEPS: u32 = 1000;
    let ior = match kind {
        FacetKind::Schlick { ior } => {
            let root = (f64::from(ior) - 1.0) / (f64::from(ior) + 1.0);
            if let Some(layers) = layers {
                return 1.0 - (20.0 * root * root + f64::from(layers.grazing)) / 21.0;
            }
            return (1.0 - root * root) * 20.0 / 21.0;
        }
        FacetKind::Coat { ior, .. } => f64::from(ior),
        FacetKind::Conductor { .. } | FacetKind::Interface => return 1.0,
    };
    // even places of the square of the sine are even light
    let passes = |i: u32| {
        let sin2 = (f64::from(i) + 0.5) / f64::from(STEPS);
        let (cos, inner) = ((1.0 - sin2).sqrt(), (1.0 - sin2 / (ior * ior)).max(0.0).sqrt());
        let [s, p] = [[cos, ior * inner], [ior * cos, inner]].map(|[a, b]| ((a - b) / (a + b)).powi(2));
        1.0 - 0.5 * (s + p)
    };
    (0..STEPS).map(passes).sum::<f64>() / f64::from(STEPS)
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

/// Index in the scene of corner `k` of a packed triangle, which starts from corner `first` of what may have been turned.
pub(super) fn corner_of(is_turned: bool, first: usize, k: usize) -> usize {
    corner(is_turned, (first + k) % 3)
}

/// Indices of the triangles without copies: same corners in the same turn. One of them is what a ray meets; the others
/// would only shine once more and make the hierarchy deep. What shines is kept before what does not, what is opaque before
/// glass (flush with an opaque face, glass is in optical contact), and the first of the file before the others.
pub(crate) fn without_copies(scene: &Scene, vertices: &[[Vec3; 3]]) -> Vec<u32> {
    let mut kept: FxHashMap<[[u32; 3]; 3], u32> =
        FxHashMap::with_capacity_and_hasher(vertices.len(), FxBuildHasher);
    let rank = |i: u32| {
        let material = &scene.materials[scene.mesh.triangles[i as usize].material as usize];
        (is_black(&material.emission), material.dielectric.is_some(), i)
    };
    let key = |i: u32| -> [[u32; 3]; 3] {
        // one zero for both
        let corners = vertices[i as usize].map(|v| (v + Vec3::ZERO).to_array().map(f32::to_bits));
        let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
        std::array::from_fn(|k| corners[(first + k) % 3])
    };
    for i in 0..vertices.len() as u32 {
        let best = kept.entry(key(i)).or_insert(i);
        if rank(i) < rank(*best) {
            *best = i;
        }
    }
    (0..vertices.len() as u32).filter(|&i| kept[&key(i)] == i).collect()
}

/// Bits of [`PackedTriangle::flags`].
fn flags(is_smooth: bool, material: &Material) -> u32 {
    let bit = |on: bool, bit: u32| if on { bit } else { 0 };
    let is_clear = material.dielectric.is_some();
    bit(is_smooth, SMOOTH)
        | bit(is_clear, CLEAR)
        | bit(!is_black(&material.emission), LAMP)
        | bit(material.surface_textures().next().is_some() || material.anisotropy.is_some(), TEXTURED)
        | bit(material.opacity.is_some(), CUT)
}

/// Triangles in leaf order with their shading normals (empty where all are flat). Emitters are not yet numbered:
/// `emitter` holds 0 where the material emits. `vertices` are turned already where a triangle is.
pub(super) fn pack(
    scene: &Scene,
    vertices: &[[Vec3; 3]],
    turned: &[bool],
    order: &[u32],
) -> (Vec<PackedTriangle>, Vec<[Vec3; 3]>) {
    let has_relief = |t: &Triangle| scene.materials[t.material as usize].relief.is_some();
    let any_smooth = scene.mesh.triangles.iter().any(|t| t.normal.is_some() || has_relief(t));
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
            // what has a relief has normals of its own
            flags: flags(t.normal.is_some() || has_relief(t), &scene.materials[t.material as usize]),
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
                    [0, 1, 2].map(|k| sign * scene.mesh.normals[n[corner_of(is_turned, first, k)] as usize])
                }
                None => [packed.normal(); 3],
            });
        }
    }
    (triangles, normals)
}
