//! Traffic: how many rays a camera path and a joton take, what these look at on their way, where camera paths end and jotons are
//! stored, by tracing a few thousand on the host. It changes nothing in the image: costs and sizes are estimated by it.

use super::Plan;
use super::discs::{Place, caustic_radius_most, is_cut};
use crate::estimators::maps::MapKind;
use crate::optics::lights::le;
use crate::optics::lights::pick::{aimed, by_law, sample_light};
use crate::optics::lights::samples::Start;
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::optics::shading::bsdf::Bsdf;
use crate::optics::shading::roulette::{EventProbabilities, SCATTERED};
use crate::packed::PackedScene;
use crate::packed::constants::{NEAR_EMITTERS_MAX, SURE_EVENTS, SURVIVAL_MAX, UNSEEN_STORED};
use crate::sampling::rng::purpose::{DIMENSION_TRAFFIC, STREAM_TRAFFIC};
use crate::sampling::rng::{random4, sequence_seed, sobol2};
use crate::spectrum::{BANDS, Bands, max, mul, scale};
use glam::Vec3;
use rayon::prelude::*;
use std::ops::AddAssign;

/// Paths from the camera and of each kind of jotons: their means are then good to a few per cent, which is better than the costs of
/// their rays are known.
const PATHS: [u32; 3] = [1 << 12, 1 << 14, 1 << 14];
/// Longest path that is followed.
const EVENTS_MAX: u32 = 64;

/// What paths of one kind do, in the mean.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Mean {
    /// Rays.
    pub rays: f64,
    /// Nodes and triangles that these look at.
    pub steps: f64,
    /// Jotons stored; of camera paths the part that ends in a gather point; surfaces where paths that go on look for light.
    pub stored: f64,
    /// Part of the camera paths that see a light through a mirror or glass.
    pub glints: f64,
}

impl AddAssign for Mean {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.steps += other.steps;
        self.stored += other.stored;
        self.glints += other.glints;
    }
}

/// What the paths of a pass do.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Traffic {
    /// Paths from the camera to the first diffuse surface.
    pub camera: Mean,
    /// Of a camera path, the rays of one light sample: a shadow ray, and one of the surface's lobes where these are asked, too.
    pub shadow: Mean,
    /// Of a camera path, what goes on from its gather point, shadow rays included.
    pub indirect: Mean,
    /// Jotons of the caustic map.
    pub caustic: Mean,
    /// Jotons of the diffuse map.
    pub diffuse: Mean,
    /// Where camera paths end; paths that end nowhere have none.
    pub places: Vec<Place>,
    /// Where paths that go on look for light.
    pub indirect_places: Vec<Place>,
    /// Camera paths.
    pub camera_paths: u32,
    /// Where the jotons of each map are stored.
    pub stored: [Vec<Vec3>; 2],
}

/// Which paths are followed.
#[derive(Clone, Copy, PartialEq)]
enum Path {
    Camera,
    Caustic,
    Diffuse,
}

/// What one path did.
#[derive(Default)]
struct Followed {
    mean: Mean,
    shadow: Mean,
    place: Option<Place>,
    indirect: Mean,
    indirect_places: Vec<Place>,
    stored: Vec<Vec3>,
}

impl Traffic {
    /// Trace a few paths of each kind that the plan has.
    pub fn look(scene: &PackedScene, plan: &Plan) -> Self {
        let all = |path: Path| -> (Vec<Followed>, Mean) {
            let paths = PATHS[path as usize];
            let all: Vec<Followed> =
                (0..paths).into_par_iter().map(|number| follow(scene, plan, path, number)).collect();
            let mean = mean(all.iter().map(|one| one.mean), paths);
            (all, mean)
        };
        let (seen, camera) = all(Path::Camera);
        let jotons = |kind, path| if plan.has_map(kind) { all(path) } else { Default::default() };
        let (caustic, diffuse) =
            (jotons(MapKind::Caustic, Path::Caustic), jotons(MapKind::Diffuse, Path::Diffuse));
        let places = |all: Vec<Followed>| all.into_iter().flat_map(|one| one.stored).collect();
        Self {
            camera,
            shadow: mean(seen.iter().map(|one| one.shadow), PATHS[0]),
            indirect: mean(seen.iter().map(|one| one.indirect), PATHS[0]),
            caustic: caustic.1,
            diffuse: diffuse.1,
            places: seen.iter().filter_map(|one| one.place).collect(),
            indirect_places: seen.iter().flat_map(|one| &one.indirect_places).copied().collect(),
            camera_paths: PATHS[0],
            stored: [places(caustic.0), places(diffuse.0)],
        }
    }

    /// Of a map's jotons.
    pub fn of(&self, kind: MapKind) -> Mean {
        match kind {
            MapKind::Caustic => self.caustic,
            MapKind::Diffuse => self.diffuse,
        }
    }

    /// Mean over the pixels of what each place comes to.
    pub(super) fn mean_of_places(&self, of: impl Fn(&Place) -> f64) -> f64 {
        self.mean_of(&self.places, of)
    }

    /// The same of the places of paths that go on.
    pub(super) fn mean_of_indirect_places(&self, of: impl Fn(&Place) -> f64) -> f64 {
        self.mean_of(&self.indirect_places, of)
    }

    fn mean_of(&self, places: &[Place], of: impl Fn(&Place) -> f64) -> f64 {
        places.iter().map(of).sum::<f64>() / f64::from(self.camera_paths.max(1))
    }
}

fn mean(all: impl Iterator<Item = Mean>, paths: u32) -> Mean {
    let mut sum = Mean::default();
    all.for_each(|one| sum += one);
    let [rays, steps, stored, glints] =
        [sum.rays, sum.steps, sum.stored, sum.glints].map(|x| x / f64::from(paths));
    Mean { rays, steps, stored, glints }
}

/// Where a path starts; none where nothing is emitted.
fn start(scene: &PackedScene, plan: &Plan, path: Path, number: u32) -> Option<(Ray, Bands)> {
    let seed = plan.settings.seed;
    let draw = |k: u32| sobol2(number, sequence_seed(seed, k, STREAM_TRAFFIC[path as usize]));
    let of = |s: Start| (s.ray(), s.flux);
    match path {
        Path::Camera => {
            let camera = scene.camera.ray(draw(0));
            let ray = Ray::new(camera.origin, camera.direction).within(scene.media.camera);
            Some((ray, [1.0; BANDS]))
        }
        _ if scene.emitters.is_empty() => None,
        Path::Caustic => aimed(scene, &plan.guides.caustic, draw(0), draw(1), 1.0).map(of),
        Path::Diffuse => Some(of(by_law(scene, &plan.guides.diffuse, draw(0), draw(1), 1.0))),
    }
}

/// Nodes and triangles that a ray looks at.
fn steps(scene: &PackedScene, ray: &Ray, reach: f32, any: bool) -> f64 {
    f64::from(scene.bvh.steps(&scene.triangles, ray.origin, ray.direction, reach, any))
}

fn follow(scene: &PackedScene, plan: &Plan, path: Path, number: u32) -> Followed {
    let mut found = Followed::default();
    let Some((mut ray, mut flux)) = start(scene, plan, path, number) else { return found };
    let (mut met_diffuse, mut met_specular) = (false, false);
    let mut length = 0.0;
    for event in 0..EVENTS_MAX {
        if flux.iter().all(|x| *x <= 0.0) {
            break;
        }
        found.mean.rays += 1.0;
        found.mean.steps += steps(scene, &ray, f32::INFINITY, false);
        let Some(s) = SurfaceInteraction::hit(scene, &ray) else { break };
        length += s.distance;
        if path == Path::Camera && met_specular && le(&s).is_some() {
            found.mean.glints = 1.0;
        }
        let is_met = match path {
            Path::Camera => false,
            Path::Caustic => met_specular,
            Path::Diffuse => met_diffuse,
        };
        let [u_way, u0, u1, u_lobe] =
            random4(plan.settings.seed, path as u32, number, DIMENSION_TRAFFIC + event);
        if is_met && s.flags().stores() {
            let is_marked = plan.visible_cells.as_ref().is_none_or(|cells| cells.holds(s.position));
            // as many of the others as are stored, by any number that decides about nothing else
            let share = if is_marked || path == Path::Caustic { 1 } else { UNSEEN_STORED };
            found.mean.stored += 1.0 / f64::from(share);
            if (number + event).is_multiple_of(share) {
                found.stored.push(s.position);
            }
        }
        let probabilities = EventProbabilities::new(&s, &flux, event);
        // nothing is absorbed by chance on the way from the eye
        let kept = if path == Path::Camera { probabilities.ways.iter().sum() } else { 1.0 };
        let Some(way) = probabilities.choose(u_way * kept) else { break };
        if way == SCATTERED && path != Path::Diffuse {
            if path == Path::Camera {
                found.mean.stored += 1.0;
                let mut place = Place {
                    position: s.position,
                    footprint: length * scene.pixel_angle(),
                    is_glossy: probabilities.bsdf.scatter.varies(),
                    is_cut: event > 0,
                };
                if plan.has_map(MapKind::Diffuse) {
                    place.is_cut |= is_cut(scene, &s, plan.diffuse.radius(0) as f32);
                } else if plan.has_map(MapKind::Caustic) {
                    place.is_cut |= is_cut(scene, &s, caustic_radius_most(plan, &place));
                }
                found.place = Some(place);
                found.shadow = shadow(scene, plan, &s, &probabilities.bsdf, [u0, u1, u_lobe]);
                if plan.has_indirect_paths() {
                    let from = (s, probabilities.bsdf);
                    (found.indirect, found.indirect_places) = indirect(scene, plan, from, length, number);
                }
            }
            break;
        }
        let Some(w) = probabilities.direction(way, u_lobe, [u0, u1]) else { break };
        flux = probabilities.carried(way, &flux);
        met_diffuse |= way == SCATTERED;
        met_specular |= way != SCATTERED;
        ray = s.leave(w);
    }
    found
}

/// What a path does that goes on from its gather point, and where it looks for light.
fn indirect<'a>(
    scene: &'a PackedScene,
    plan: &Plan,
    mut from: (SurfaceInteraction<'a>, Bsdf),
    mut length: f32,
    number: u32,
) -> (Mean, Vec<Place>) {
    let (mut found, mut places) = (Mean::default(), Vec::new());
    // what the path carries at the surface that it leaves
    let mut carried = [1.0; BANDS];
    let mut draws = 0;
    let mut draw = || {
        draws += 1;
        // kinds of paths that start somewhere have the numbers below
        random4(plan.settings.seed, PATHS.len() as u32, number, DIMENSION_TRAFFIC + draws)
    };
    for vertex in 0..EVENTS_MAX {
        let (s, bsdf) = &from;
        let [u_lobe, u0, u1, u_survive] = draw();
        let leaving = bsdf.sample_scatter(u_lobe, [u0, u1]).filter(|wi| bsdf.cosine(*wi) > 0.0);
        let Some(wi) = leaving else { break };
        let left = mul(&carried, &bsdf.weight_scatter(wi));
        let limit = if vertex < SURE_EVENTS { 1.0 } else { SURVIVAL_MAX };
        let survives = if vertex == 0 { 1.0 } else { (max(&left) / max(&carried)).min(limit) };
        if max(&left) <= 0.0 || u_survive >= survives {
            break;
        }
        carried = scale(&left, 1.0 / survives);
        let mut ray = s.leave(wi);
        let next = (0..EVENTS_MAX).find_map(|event| {
            found.rays += 1.0;
            found.steps += steps(scene, &ray, f32::INFINITY, false);
            let Some(s) = SurfaceInteraction::hit(scene, &ray) else { return Some(None) };
            length += s.distance;
            let probabilities = EventProbabilities::new(&s, &carried, event);
            let kept: f32 = probabilities.ways.iter().sum();
            let [u_way, u0, u1, u_lobe] = draw();
            let Some(way) = probabilities.choose(u_way * kept) else { return Some(None) };
            if way == SCATTERED {
                return Some(Some((s, probabilities.bsdf)));
            }
            let Some(w) = probabilities.direction(way, u_lobe, [u0, u1]) else { return Some(None) };
            carried = probabilities.carried(way, &carried);
            ray = s.leave(w);
            None
        });
        let Some(Some(next)) = next else { break };
        let (s, bsdf) = &next;
        let [u0, u1, u_lobe, _] = draw();
        let light = shadow(scene, plan, s, bsdf, [u0, u1, u_lobe]);
        found.rays += light.rays;
        found.steps += light.steps;
        found.stored += 1.0;
        places.push(Place {
            position: s.position,
            footprint: length * scene.pixel_angle(),
            is_glossy: bsdf.scatter.varies(),
            is_cut: false,
        });
        from = next;
    }
    (found, places)
}

/// The rays of a light sample at a surface.
fn shadow(
    scene: &PackedScene,
    plan: &Plan,
    s: &SurfaceInteraction,
    bsdf: &Bsdf,
    [u, v, w]: [f32; 3],
) -> Mean {
    let mut found = Mean::default();
    let lights = plan.guides.direct.emitters(&scene.emitters);
    if let Some(light) = sample_light(scene, lights, s.position, [u, v])
        && bsdf.cosine(light.wi) > 0.0
    {
        found.rays += 1.0;
        found.steps += steps(scene, &s.leave(light.wi), (light.target - s.position).length(), true);
    }
    // every sample shares its weight with one of the lobes where either is much better
    if (bsdf.scatter.varies() || lights.len() > NEAR_EMITTERS_MAX as usize)
        && let Some(wi) = bsdf.sample_scatter(w, [u, v])
    {
        found.rays += 1.0;
        found.steps += steps(scene, &s.leave(wi), f32::INFINITY, false);
    }
    found
}
