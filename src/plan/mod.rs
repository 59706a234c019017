//! Plan: what a scene needs and what is skipped and why; decided once, before the first pass, without a device.

pub mod buffers;
pub mod kernels;
mod learn;
mod pilot;
mod radius;
mod seen;
pub mod shape;
pub mod traffic;

pub use pilot::Pilot;
pub use radius::{Schedule, area_group, shrink};

use crate::film::{LAYERS, Layer};
use crate::pack::{EmitterKind, Guide, PackedScene};
use crate::paths::LightPaths;
use std::sync::Arc;

/// What the user asked for, as far as it changes the plan.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Seed of every random number.
    pub seed: u32,
    /// The light paths to render.
    pub paths: LightPaths,
    /// Shadow rays per gather point and pass.
    pub shadow_rays: u32,
    /// Bytes that a device's buffers may take together; none for as much as it allows.
    pub memory: Option<u64>,
}

/// Shadow rays that pay: where light is soft they halve the noise of direct light for a tenth of a pass.
pub const SHADOW_RAYS: u32 = 2;

impl Default for Settings {
    fn default() -> Self {
        Self { seed: 0, paths: LightPaths::everything(), shadow_rays: SHADOW_RAYS, memory: None }
    }
}

/// What is done in each pass, and how large everything is. Lengths are in internal units.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What was asked for.
    pub settings: Settings,
    /// What was found by looking at the scene through the camera.
    pub pilot: Pilot,
    /// What was learned of where the light of caustics comes from.
    pub guide: Arc<Guide>,
    /// Which of [`Layer::ALL`] is traced.
    pub layers: [bool; LAYERS],
    /// What the kernels must be able to do.
    pub features: Features,
    /// Jotons emitted a pass for the caustic map; 0 where it is skipped.
    pub caustic_jotons: u32,
    /// Jotons emitted a pass for the diffuse map; 0 where it is skipped.
    pub diffuse_jotons: u32,
    /// Jotons that the disc of a gather point of the caustic map shall hold in the first pass.
    pub caustic_wanted: f32,
    /// Radius of the caustic map: the largest that a gather point may use in the first pass.
    pub caustic: Schedule,
    /// Radius of the diffuse map; whether it is traced or not, since walls are looked for within it.
    pub diffuse: Schedule,
    /// What is not done, and why.
    pub skipped: Vec<Skip>,
}

/// What the kernels must be able to do for this scene; the rest is compiled out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Features {
    /// Some triangle has shading normals.
    pub smooth_normals: bool,
    /// Some surface mirrors.
    pub specular: bool,
    /// Some surface is a dielectric.
    pub dielectric: bool,
    /// Some surface has a glossy lobe.
    pub glossy: bool,
    /// Some emitter is not a triangle.
    pub delta_lights: bool,
    /// Only some light paths are wanted.
    pub path_filter: bool,
}

/// Something that is not done.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Skip {
    /// What is left out.
    pub what: &'static str,
    /// Why that changes nothing in the image.
    pub why: &'static str,
}

/// A gather point's caustic radius lies between these multiples of its pixel's footprint …
pub const CAUSTIC_FOOTPRINTS: [f32; 2] = [0.7, 4.0];
/// … and is chosen so that about this many jotons are found in the pilot pass where emission is not steered. Where it is,
/// more are found in the same disc: the radius that serves best then falls, but not so far that as few are left [E14].
const CAUSTIC_WANTED: f64 = 15.0;
/// Exponent of the gain in that number: error is least where squared radii go with jotons^(−1/3).
const WANTED_GAIN: f64 = 2.0 / 3.0;
/// α of both radii. Squared bias and variance then fall alike, with passes^(−2/3) (Knaus & Zwicker 2011); and radii
/// differ enough between passes to tell the bias from them [E18].
const ALPHA: f64 = 2.0 / 3.0;
/// Base radius of the diffuse map over the square root of the diffuse area, at [`DIFFUSE_REFERENCE_JOTONS`] a pass. It
/// falls with the square root of the jotons, so that a disc holds as many (about 190) whatever their number: more jotons
/// buy sharpness and more passes less noise, and a pass costs the same for each pixel.
const DIFFUSE_RADIUS: f64 = 0.0344;
/// See [`DIFFUSE_RADIUS`].
const DIFFUSE_REFERENCE_JOTONS: f64 = 49_152.0;
/// The diffuse radius is at most this part of the image's width, and at least this many footprints.
const DIFFUSE_LIMITS: [f64; 2] = [2.0, 0.08];
/// Jotons a pass for the diffuse map: between these, and about as many as pixels.
const DIFFUSE_JOTONS: [u32; 2] = [1 << 14, 1 << 18];
/// Jotons a pass for the caustic map, likewise: its radius follows the pixels.
const CAUSTIC_JOTONS: [u32; 2] = [1 << 14, 1 << 19];

impl Plan {
    /// Decide what a scene needs.
    pub fn new(scene: &PackedScene, mut settings: Settings) -> Self {
        let pilot = Pilot::look(scene);
        let has = |f: &dyn Fn(crate::pack::MaterialFlags) -> bool| {
            scene.triangles.iter().any(|t| f(scene.materials[t.material as usize].flags()))
        };
        let features = Features {
            smooth_normals: !scene.shading_normals.is_empty(),
            specular: has(&|m| m.has_delta() && !m.is_dielectric()),
            dielectric: has(&|m| m.is_dielectric()),
            glossy: has(&|m| m.has_glossy()),
            delta_lights: scene.emitters.iter().any(|e| e.kind != 0),
            path_filter: !settings.paths.is_everything(),
        };
        let wanted = settings.paths.layers();
        let mut skipped = Vec::new();
        let mut layers = [true; LAYERS];
        let mut skip = |layer: Layer, what, why| {
            if layers[layer as usize] {
                layers[layer as usize] = false;
                skipped.push(Skip { what, why });
            }
        };
        if !features.specular && !features.dielectric {
            skip(Layer::Caustic, "caustic map", "no surface mirrors or refracts");
        }
        if !scene.emitters.iter().any(|e| e.kind == 0) {
            skip(Layer::Emission, "emission", "no surface emits");
        }
        if scene.diffuse_area == 0.0 {
            let why = "no surface is diffuse";
            skip(Layer::Direct, "direct light", why);
            skip(Layer::Caustic, "caustic map", why);
            skip(Layer::Diffuse, "diffuse map", why);
        }
        let why = "--paths excludes it";
        for (layer, what) in
            Layer::ALL.into_iter().zip(["emission", "direct light", "caustic map", "diffuse map"])
        {
            if !wanted[layer as usize] {
                skip(layer, what, why);
            }
        }
        for (on, what, why) in [
            (features.specular, "mirrors", "no surface mirrors"),
            (features.dielectric, "refraction", "no surface refracts"),
            (features.glossy, "glossy lobes", "no surface is glossy"),
            (features.smooth_normals, "shading normals", "every triangle is flat"),
            (features.delta_lights, "point, spot and sun lights", "every light is a surface"),
            (features.path_filter, "light path filter", "all light paths are wanted"),
        ] {
            if !on {
                skipped.push(Skip { what, why });
            }
        }

        if let [light] = &scene.emitters[..]
            && light.kind != EmitterKind::Triangle as u32
            && settings.shadow_rays > 1
        {
            settings.shadow_rays = 1;
            skipped
                .push(Skip { what: "further shadow rays", why: "the only light is a point or a direction" });
        }

        // of the scene and the seed alone: --paths must not change what is learned
        let traced = layers[Layer::Caustic as usize];
        let guide = if traced { learn::guide(scene, settings.seed) } else { Guide::default() };

        let pixels = scene.pixels() as u32;
        let jotons = |layer: Layer, n: u32, [least, most]: [u32; 2]| {
            if layers[layer as usize] { n.clamp(least, most) } else { 0 }
        };
        let diffuse_wanted = (pixels / 4 * 3).clamp(DIFFUSE_JOTONS[0], DIFFUSE_JOTONS[1]);
        let diffuse_jotons = jotons(Layer::Diffuse, diffuse_wanted, DIFFUSE_JOTONS);
        let caustic_share = if pilot::aimed(scene, &guide) { pixels / 2 } else { pixels };
        let caustic_jotons = jotons(Layer::Caustic, caustic_share, CAUSTIC_JOTONS);
        let per_joton = (DIFFUSE_REFERENCE_JOTONS / f64::from(diffuse_wanted)).sqrt();
        let footprint = f64::from(pilot.footprint_median);
        let image_width = footprint * f64::from(scene.size[0]);
        let diffuse = (DIFFUSE_RADIUS * scene.diffuse_area.sqrt() * per_joton)
            .min(DIFFUSE_LIMITS[1] * image_width)
            .max(DIFFUSE_LIMITS[0] * footprint);
        let caustic = f64::from(CAUSTIC_FOOTPRINTS[1] * pilot.footprint_large);
        Self {
            settings,
            caustic_wanted: (CAUSTIC_WANTED * guide.gain.powf(WANTED_GAIN)) as f32,
            guide: Arc::new(guide),
            layers,
            features,
            caustic_jotons,
            diffuse_jotons,
            caustic: Schedule { base: caustic, alpha: ALPHA },
            diffuse: Schedule { base: diffuse, alpha: ALPHA },
            skipped,
            pilot,
        }
    }

    /// Emit half as many jotons for a map, with the radius that goes with them: a disc holds as many.
    pub fn halve_jotons(&mut self, scene: &PackedScene, kind: shape::Kind) {
        match kind {
            // its radii are chosen by counting
            shape::Kind::Caustic => self.caustic_jotons = self.caustic_jotons.div_ceil(2),
            shape::Kind::Diffuse => {
                let image_width = f64::from(self.pilot.footprint_median) * f64::from(scene.size[0]);
                let largest = (DIFFUSE_LIMITS[1] * image_width).max(self.diffuse.base);
                self.diffuse_jotons = self.diffuse_jotons.div_ceil(2);
                self.diffuse.base = (self.diffuse.base * std::f64::consts::SQRT_2).min(largest);
            }
        }
    }

    /// How much the radii blur the maps in a pass: the squared radius, relative to the first pass; 0 without a map.
    pub fn blur(&self, pass: u64) -> f64 {
        // both shrink alike
        let has_map = self.traces(Layer::Caustic) || self.traces(Layer::Diffuse);
        if has_map { shrink(ALPHA, pass) } else { 0.0 }
    }

    /// True where something mirrors or refracts.
    pub fn has_specular_bodies(&self) -> bool {
        self.features.specular || self.features.dielectric
    }

    /// True where a layer is traced.
    pub fn traces(&self, layer: Layer) -> bool {
        self.layers[layer as usize]
    }
}
