//! Eye: a camera ray through specular surfaces to its gather point, and the emission met on the way (E S* L).

use super::followed_light::{FollowedLight, Vertex};
use super::splits::Splits;
use super::streams::{DIMENSION_EYE, EVENTS_MAX, STREAM_CHOICE, STREAM_EYE_BAND, STREAM_JITTER};
use crate::backend::Tally;
use crate::film::paths::LightPaths;
use crate::optics::lights::{le_seen, on_miss};
use crate::optics::ray::{Ray, SurfaceInteraction, toward};
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::constants::{CLIP_GRAZING, SURE_EVENTS, SURVIVAL_MAX};
use crate::packed::{CameraRay, Inside, PackedScene, PackedTriangle};
use crate::plan::Plan;
use crate::sampling::rng::{golden, random4, sequence_seed, sobol2};
use crate::spectrum::{BANDS, BLACK, Bands, add, mul, scale};
use glam::Vec3;

/// The first D vertex of an eye path; normals turned toward the eye.
#[derive(Debug, Clone)]
pub(super) struct GatherPoint<'a> {
    pub(super) position: Vec3,
    /// Unit geometric normal.
    pub(super) ng: Vec3,
    /// `ng` is the triangle's front normal, not its back's.
    pub(super) front: bool,
    /// Unit shading normal.
    pub(super) ns: Vec3,
    /// Unit vector toward the eye, back along the chain.
    pub(super) wo: Vec3,
    /// Radiance at the eye per radiance that leaves the point through its D lobes.
    pub(super) throughput: Bands,
    pub(super) bsdf: Bsdf,
    pub(super) triangle: &'a PackedTriangle,
    /// The bodies that the point is in.
    pub(super) inside: Inside,
    /// Specular events between the eye and the point.
    pub(super) chain: u32,
    /// Length of the path from the eye, internal units.
    pub(super) length: f32,
}

impl GatherPoint<'_> {
    /// A ray that leaves it, on whichever side that is.
    pub(super) fn ray(&self, direction: Vec3) -> Ray {
        Ray::new(toward(self.position, self.ng, self.triangle, direction), direction).within(self.inside)
    }

    /// Width of the pixel on the surface, where it is longest, internal units.
    pub(super) fn pixel_width(&self, scene: &PackedScene) -> f32 {
        self.length * scene.pixel_angle() / self.ng.dot(self.wo).abs().max(CLIP_GRAZING)
    }
}

/// What an eye path found.
#[derive(Debug, Clone)]
pub(super) struct EyePath<'a> {
    /// Radiance of the emitters on the chain, weighed beside the trees'.
    pub(super) emission: Bands,
    pub(super) gather_point: Option<GatherPoint<'a>>,
}

/// The camera's ray of a pixel in a pass; box filter one pixel wide.
pub(super) fn camera_ray(scene: &PackedScene, seed: u32, pixel: u32, pass: u32) -> CameraRay {
    scene.sample_camera(pixel, pass.into(), seed, STREAM_JITTER)
}

/// True where emission is wanted that is seen through `chain` specular events (E S* L).
pub(super) fn wants_emission(plan: &Plan, chain: u32) -> bool {
    !plan.features.path_filter
        || plan.settings.paths.accept_mask_after_specular(chain) >> LightPaths::START & 1 == 1
}

/// Follow a pixel's ray to the first D event. So many trees a pass see its emission, too.
pub(super) fn follow<'a>(
    scene: &'a PackedScene,
    plan: &Plan,
    pixel: u32,
    pass: u32,
    trees: f32,
    tally: &mut Tally,
) -> EyePath<'a> {
    let settings = &plan.settings;
    let CameraRay { origin, direction, travelled: mut length } =
        camera_ray(scene, settings.seed, pixel, pass);
    let mut ray = Ray::new(origin, direction).within(scene.media.camera);
    // the first choices of way cover their square evenly over the passes: most of a glass ball's noise is theirs
    let choices = sobol2(pass, sequence_seed(settings.seed, pixel, STREAM_CHOICE));
    let lights = FollowedLight::new(scene, plan);
    let (mut throughput, mut splits) = ([1.0; BANDS], Splits::start());
    let mut path = EyePath { emission: BLACK, gather_point: None };
    for chain in 0..EVENTS_MAX {
        tally.rays += 1;
        let sees = |throughput: &Bands, le: &Bands, pdf_light| {
            scale(&mul(throughput, le), splits.weight_of_eye(trees, pdf_light))
        };
        let is_wanted = wants_emission(plan, chain);
        let Some(s) = SurfaceInteraction::hit(scene, &ray) else {
            if is_wanted {
                let light = ray.brings_from_afar(scene, &on_miss(ray.direction));
                path.emission = add(&path.emission, &sees(&throughput, &light, 0.0));
            }
            return path;
        };
        length += s.distance;
        throughput = s.through(&throughput);
        if let Some(le) = le_seen(scene, &s, length).filter(|_| is_wanted) {
            path.emission = add(&path.emission, &sees(&throughput, &le, lights.pdf(&s)));
        }
        let [u_way, u0, u1, u_survive] = random4(settings.seed, pass, pixel, DIMENSION_EYE + chain);
        let u_way = choices.get(chain as usize).copied().unwrap_or(u_way);
        let mut bsdf = Bsdf::seen(scene, &s, length);
        let shares = bsdf.shares(&throughput);
        if shares.kept() <= 0.0 {
            return path;
        }
        bsdf.part_bands(s.between(), &throughput, || {
            golden(pass, sequence_seed(settings.seed, pixel, STREAM_EYE_BAND))
        });
        if bsdf.has_width() && wants_emission(plan, chain + 1) {
            let vertex = Vertex { surface: &s, bsdf: &bsdf, shares: &shares, splits: &splits, trees };
            let light = lights.in_lobes(&vertex, [pixel, pass, chain], tally);
            path.emission = add(&path.emission, &mul(&throughput, &light));
        }
        // one lobe only: probability 1, no noise
        let ways = shares.kept();
        let choice = u_way * ways;
        if choice < shares.scatter {
            path.gather_point = Some(GatherPoint {
                position: s.position,
                ng: s.ng,
                front: s.front,
                ns: bsdf.shading_normal(),
                wo: s.back,
                throughput: scale(&throughput, ways / shares.scatter),
                bsdf,
                triangle: s.triangle,
                inside: s.sides.here,
                chain,
                length,
            });
            return path;
        }
        let lobe = shares.pick_delta(choice - shares.scatter);
        let Some(direction) = bsdf.sample_delta(lobe, [u0, u1]) else { return path };
        splits = splits.after(&shares, lobe, bsdf.pdf_delta(lobe, direction));
        let survival = survival(chain, shares.kept());
        if u_survive >= survival {
            return path;
        }
        let chance = shares.delta[lobe] / ways * survival;
        throughput = scale(&bsdf.through_delta(lobe, direction, &throughput), 1.0 / chance);
        ray = s.leave(direction);
    }
    tally.truncated += 1;
    path
}

/// Probability that a camera path goes on after event `event`, which keeps the share `kept` of what it carries: nothing
/// is left to chance but late in a path, where it ends as a joton's does [E3].
pub(super) fn survival(event: u32, kept: f32) -> f32 {
    if event < SURE_EVENTS { 1.0 } else { kept.min(SURVIVAL_MAX) }
}
