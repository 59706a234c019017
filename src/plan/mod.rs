//! Plan: what a scene needs and what is skipped and why; decided once, before the first pass, without a device.

pub mod buffers;
mod discs;
mod facts;
mod features;
pub mod grid;
mod guiding;
mod in_bands;
pub mod kernels;
mod lamps_seen;
pub mod map_layout;
pub mod model;
mod pilot;
pub mod process_memory;
mod skip;
pub mod strips;
mod technique;
pub mod traffic;

pub use features::Features;
pub use in_bands::InBands;
pub use pilot::Pilot;
use skip::Skips;
pub use skip::{Part, Reason, Skip};

use crate::estimators::maps::MapKind;
use crate::estimators::radii::{Schedule, shrink};
use crate::film::paths::LightPaths;
use crate::film::{LAYERS, Layer};
use crate::packed::{Guide, PackedScene, VisibleCells};
use guiding::visible_points::VisiblePoints;
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
    /// Light on surfaces is shared with neighbours when a picture is made \[E29\].
    pub resolve: bool,
    /// Bytes that a device's buffers may take together, or after [`Plan::bound_process`] the whole process; none for as much as
    /// there is.
    pub memory: Option<u64>,
    /// What is not skipped, whether the scene needs it or not.
    pub keep: Vec<Part>,
    /// Only some of the passes are rendered, to be merged with others: the host keeps their sums exact.
    pub is_part: bool,
    /// Bands for who measures, beside red, green and blue \[E53\]: they take memory.
    pub measured: usize,
}

impl Settings {
    /// True for what is done whether the scene needs it or not.
    pub fn keeps(&self, part: Part) -> bool {
        self.keep.contains(&part)
    }
}

/// Shadow rays that pay: where light is soft they halve the noise of direct light for a tenth of a pass.
pub const SHADOW_RAYS: u32 = 2;

impl Default for Settings {
    fn default() -> Self {
        let (paths, shadow_rays) = (LightPaths::everything(), SHADOW_RAYS);
        let (memory, keep) = (None, Vec::new());
        Self { seed: 0, paths, shadow_rays, resolve: true, memory, keep, is_part: false, measured: 0 }
    }
}

/// What is done in each pass, and how large everything is. Lengths are in internal units.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What was asked for.
    pub settings: Settings,
    /// What was found by looking at the scene through the camera.
    pub pilot: Pilot,
    /// What was learned of where the light in view comes from.
    pub guides: Arc<Guides>,
    /// Light samples of which one gets a shadow ray.
    pub light_candidates: u32,
    /// Where the camera looks; none where jotons are stored wherever they are.
    pub visible_cells: Option<Arc<VisibleCells>>,
    /// Pixels, in ascending order, that show an image of a lamp too small for camera rays to find \[E25\].
    pub lamp_images: Arc<[u32]>,
    /// Which of [`Layer::ALL`] is traced.
    pub layers: [bool; LAYERS],
    /// What the kernels must be able to do.
    pub features: Features,
    /// How light that was diffusely reflected before is found.
    pub indirect: Indirect,
    /// Light on surfaces is shared with neighbours when a picture is made; see [`Plan::resolved_layers`].
    pub resolves: bool,
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
    /// Bytes of [`Settings::memory`] that are not for the buffers of a device.
    pub beside: u64,
}

/// How light that was diffusely reflected before (the diffuse layer) is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Indirect {
    /// By jotons: the diffuse map.
    Map,
    /// By eye paths that go on from their gather points \[E28\], smoothed over neighbours \[E29\].
    Paths,
}

impl Indirect {
    /// Name, lower case.
    pub fn name(self) -> &'static str {
        match self {
            Indirect::Map => "map",
            Indirect::Paths => "paths",
        }
    }
}

/// How lights are picked and jotons steered, by what was learned \[E20\].
#[derive(Debug, Clone, Default)]
pub struct Guides {
    /// For the jotons of the caustic map.
    pub caustic: Guide,
    /// For the jotons of the diffuse map.
    pub diffuse: Guide,
    /// For shadow rays.
    pub direct: Guide,
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
/// Jotons are traced for the pixels that see a surface alone where these are less than this part: what is learned of a few
/// thousand paths is not exact, and scenes without a background shall not differ by it.
const BACKGROUND: f64 = 0.7;
/// Jotons are stored everywhere where at least this part of them lies where the camera looks.
const STORED_IN_VIEW: f64 = 0.6;
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
        let seen = VisiblePoints::look(scene, settings.seed);
        let mut skips = Skips { keep: settings.keep.clone(), skipped: Vec::new() };
        if !scene.out_of_reach.is_empty() {
            // `PackedScene::whole` keeps it
            skips.must_skip(Part::OutOfReach, Reason::ClosedRoom);
        }
        let layers = layers(scene, &settings, &mut skips);
        let indirect = indirect(scene, &layers, &settings, &seen, &mut skips);
        let features = Features::of(scene, &settings, &mut skips);
        if let [light] = &scene.emitters[..]
            && !light.has_area()
            && settings.shadow_rays > 1
            && skips.skip(Part::FurtherShadowRays, Reason::OneDirection)
        {
            settings.shadow_rays = 1;
        }
        let traces = |layer: Layer| layers[layer as usize];
        let has_diffuse_map = traces(Layer::Diffuse) && indirect == Indirect::Map;
        let has_map_or_light = |layer: Layer| traces(layer) && (layer != Layer::Diffuse || has_diffuse_map);
        let Learned { guides, in_view, light_candidates } =
            learned(scene, settings.seed, &seen, has_map_or_light, &mut skips);

        let few = (traces(Layer::Caustic) || has_diffuse_map)
            && seen.share() < BACKGROUND
            && skips.skip(Part::Background, Reason::MuchBackground);
        let pixels = (scene.pixels() as f64 * if few { seen.share() } else { 1.0 }) as u32;
        let jotons = |is_traced: bool, n: u32, [least, most]: [u32; 2]| {
            if is_traced { n.clamp(least, most) } else { 0 }
        };
        let diffuse_wanted = (pixels / 4 * 3).clamp(DIFFUSE_JOTONS[0], DIFFUSE_JOTONS[1]);
        let diffuse_jotons = jotons(has_diffuse_map, diffuse_wanted, DIFFUSE_JOTONS);
        let caustic_share = if pilot::aimed(scene, &guides.caustic) { pixels / 2 } else { pixels };
        let caustic_jotons = jotons(traces(Layer::Caustic), caustic_share, CAUSTIC_JOTONS);
        let per_joton = (DIFFUSE_REFERENCE_JOTONS / f64::from(diffuse_wanted)).sqrt();
        let footprint = f64::from(pilot.footprint_median);
        let image_width = footprint * f64::from(scene.size[0]);
        let diffuse = (DIFFUSE_RADIUS * scene.diffuse_area.sqrt() * per_joton)
            .min(DIFFUSE_LIMITS[1] * image_width)
            .max(DIFFUSE_LIMITS[0] * footprint);
        let caustic = f64::from(CAUSTIC_FOOTPRINTS[1] * pilot.footprint_large);
        if seen.share() < 1.0 {
            skips.skip(Part::Rest, Reason::NothingChanges);
        }
        let stores_all = in_view > STORED_IN_VIEW || !skips.skip(Part::UnseenJotons, Reason::JotonsElsewhere);
        let visible_cells = (!stores_all).then(|| Arc::new(seen.cells(scene, diffuse as f32)));
        let lamp_images: Arc<[u32]> = if traces(Layer::Emission) {
            guiding::lamp_images(scene, settings.seed).into()
        } else {
            Arc::default()
        };
        Self {
            // the maps end at thin walls, and sharing does not: where they give indirect light they are left alone
            resolves: indirect == Indirect::Paths && settings.resolve,
            settings,
            caustic_wanted: (CAUSTIC_WANTED * guides.caustic.gain.powf(WANTED_GAIN)) as f32,
            guides: Arc::new(guides),
            light_candidates,
            visible_cells,
            lamp_images,
            layers,
            features,
            indirect,
            caustic_jotons,
            diffuse_jotons,
            caustic: Schedule { base: caustic, alpha: ALPHA },
            diffuse: Schedule { base: diffuse, alpha: ALPHA },
            skipped: skips.skipped,
            beside: 0,
            pilot,
        }
    }

    /// Jotons emitted a pass for a map.
    pub fn jotons(&self, kind: MapKind) -> u32 {
        match kind {
            MapKind::Caustic => self.caustic_jotons,
            MapKind::Diffuse => self.diffuse_jotons,
        }
    }

    /// True where a map is traced.
    pub fn has_map(&self, kind: MapKind) -> bool {
        self.jotons(kind) > 0
    }

    /// Layers that are shared with neighbours when a picture is made.
    pub fn resolved_layers(&self) -> Vec<Layer> {
        let is_shared = |layer: &Layer| self.resolves && self.traces(*layer);
        Layer::ON_SURFACES.into_iter().filter(is_shared).collect()
    }

    /// True where eye paths go on from their gather points.
    pub fn has_indirect_paths(&self) -> bool {
        self.indirect == Indirect::Paths && self.traces(Layer::Diffuse)
    }

    /// Emit half as many jotons for a map, with the radius that goes with them: a disc holds as many.
    pub fn halve_jotons(&mut self, scene: &PackedScene, kind: MapKind) {
        match kind {
            // its radii are chosen by counting
            MapKind::Caustic => self.caustic_jotons = self.caustic_jotons.div_ceil(2),
            MapKind::Diffuse => {
                let image_width = f64::from(self.pilot.footprint_median) * f64::from(scene.size[0]);
                let largest = (DIFFUSE_LIMITS[1] * image_width).max(self.diffuse.base);
                self.diffuse_jotons = self.diffuse_jotons.div_ceil(2);
                self.diffuse.base = (self.diffuse.base * std::f64::consts::SQRT_2).min(largest);
            }
        }
    }

    /// How much the radii blur the maps in a pass: the radius, relative to the first pass; 0 without a map.
    pub fn blur(&self, pass: u64) -> f64 {
        // both shrink alike
        let has_map = MapKind::ALL.into_iter().any(|kind| self.has_map(kind));
        if has_map { shrink(ALPHA, pass).sqrt() } else { 0.0 }
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

/// Which layers are traced.
fn layers(scene: &PackedScene, settings: &Settings, skips: &mut Skips) -> [bool; LAYERS] {
    let wanted = settings.paths.layers();
    // in the order of the layers, the reasons of each in order of weight
    let reasons = [
        [
            (!facts::has_emissive_surface(scene) && !facts::shows_delta_lights(scene))
                .then_some(Reason::NoEmissiveSurface),
            None,
            None,
        ],
        [(!facts::has_diffuse_surface(scene)).then_some(Reason::NoDiffuseSurface), None, None],
        [
            (!facts::has(scene, |m| m.has_delta())).then_some(Reason::NoSpecularSurface),
            (!facts::has_diffuse_surface(scene)).then_some(Reason::NoDiffuseSurface),
            (!facts::lights_reach_targets(scene)).then_some(Reason::SpecularInTheDark),
        ],
        [
            (!facts::has_diffuse_surface(scene)).then_some(Reason::NoDiffuseSurface),
            facts::reflects_in_one_plane(scene).then_some(Reason::OnePlane),
            None,
        ],
    ];
    let parts = [Part::Emission, Part::DirectLight, Part::CausticMap, Part::DiffuseMap];
    std::array::from_fn(|layer| {
        if scene.emitters.is_empty() && layer != Layer::Emission as usize {
            // there is nothing to pick from
            skips.must_skip(parts[layer], Reason::NoLight);
            return false;
        }
        let unwanted = (!wanted[layer]).then_some(Reason::ExcludedByPaths);
        match reasons[layer].into_iter().flatten().chain(unwanted).next() {
            Some(reason) => !skips.skip(parts[layer], reason),
            None => true,
        }
    })
}

/// How indirect light is found.
fn indirect(
    scene: &PackedScene,
    layers: &[bool; LAYERS],
    settings: &Settings,
    seen: &VisiblePoints,
    skips: &mut Skips,
) -> Indirect {
    let [_, _, caustic, diffuse] = *layers;
    // paths need the caustic map, unless no light can be in it
    let is_dark = |s: &Skip| s.what == Part::CausticMap && s.why != Reason::ExcludedByPaths;
    let can_go_on = diffuse && (caustic || skips.skipped.iter().any(is_dark));
    if can_go_on
        && technique::choose(scene, settings.seed, seen, caustic) == Indirect::Paths
        && skips.skip(Part::DiffuseMap, Reason::PathsServe)
    {
        Indirect::Paths
    } else {
        Indirect::Map
    }
}

/// What is learned of a scene.
struct Learned {
    guides: Guides,
    /// Part of the diffuse map's jotons that lie where the camera looks.
    in_view: f64,
    light_candidates: u32,
}

/// What is learned, of the scene and the seed alone: --paths must not change it.
fn learned(
    scene: &PackedScene,
    seed: u32,
    seen: &VisiblePoints,
    traces: impl Fn(Layer) -> bool,
    skips: &mut Skips,
) -> Learned {
    let mut guides = Guides::default();
    let (mut in_view, mut light_candidates) = (1.0, 1);
    if traces(Layer::Caustic) {
        guides.caustic = guiding::jotons(scene, seed, seen, MapKind::Caustic).guide;
    }
    if traces(Layer::Diffuse) {
        let learned = guiding::jotons(scene, seed, seen, MapKind::Diffuse);
        (guides.diffuse, in_view) = (learned.guide, learned.in_view);
    }
    if traces(Layer::Direct) {
        let picks = guiding::direct(scene, seed, seen);
        guides.direct = picks.guide;
        if picks.candidates > 1 && skips.skip(Part::FaintLight, Reason::FaintAmongStrong) {
            light_candidates = picks.candidates;
        }
    }
    let all = [&guides.caustic, &guides.diffuse, &guides.direct];
    if all.iter().any(|g| !g.is_empty()) && !skips.skip(Part::UnseenLight, Reason::LightElsewhere) {
        guides = Guides::default();
    }
    let has_map = traces(Layer::Caustic) || traces(Layer::Diffuse);
    if has_map && [&guides.caustic, &guides.diffuse].iter().all(|g| g.warps().is_empty()) {
        skips.skip(Part::Warps, Reason::NothingLearned);
    }
    Learned { guides, in_view, light_candidates }
}
