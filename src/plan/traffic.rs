//! Traffic: how many rays a camera path and a joton take, and how many jotons are stored, by tracing a few thousand on the
//! host. It changes nothing in the image: costs and sizes are estimated by it.

use super::Plan;
use super::shape::Kind;
use crate::bands::{BANDS, Bands, mul, scale};
use crate::film::Layer;
use crate::optics::bsdf::{Boundary, sample_d, specular_direction};
use crate::optics::emit::{Start, aimed, by_law};
use crate::optics::odds::Odds;
use crate::optics::ray::{Ray, Surface};
use crate::pack::PackedScene;
use crate::rng::purpose::{DIMENSION_TRAFFIC, STREAM_TRAFFIC};
use crate::rng::{random4, sequence_seed, sobol2};
use rayon::prelude::*;
use std::ops::AddAssign;

/// Paths of each kind: their means are then good to a few per cent, which is better than the costs of their rays are known.
const PATHS: u32 = 1 << 12;
/// Longest path that is followed.
const EVENTS_MAX: u32 = 64;

/// What paths of one kind do, in the mean.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Mean {
    /// Rays.
    pub rays: f64,
    /// Jotons stored; of camera paths the part that ends in a gather point.
    pub stored: f64,
    /// Part of the camera paths that see a light through a mirror or glass.
    pub glints: f64,
}

impl AddAssign for Mean {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.stored += other.stored;
        self.glints += other.glints;
    }
}

/// What the paths of a pass do.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Traffic {
    /// Paths from the camera to the first diffuse surface.
    pub camera: Mean,
    /// Jotons of the caustic map.
    pub caustic: Mean,
    /// Jotons of the diffuse map.
    pub diffuse: Mean,
}

/// Which paths are followed.
#[derive(Clone, Copy, PartialEq)]
enum Path {
    Camera,
    Caustic,
    Diffuse,
}

impl Traffic {
    /// Trace a few paths of each kind that the plan has.
    pub fn look(scene: &PackedScene, plan: &Plan) -> Self {
        let mean = |path: Path| {
            let all: Vec<Mean> =
                (0..PATHS).into_par_iter().map(|number| follow(scene, plan, path, number)).collect();
            let mut sum = Mean::default();
            all.into_iter().for_each(|one| sum += one);
            let n = f64::from(PATHS);
            Mean { rays: sum.rays / n, stored: sum.stored / n, glints: sum.glints / n }
        };
        let jotons = |layer, path| if plan.traces(layer) { mean(path) } else { Mean::default() };
        Self {
            camera: mean(Path::Camera),
            caustic: jotons(Layer::Caustic, Path::Caustic),
            diffuse: jotons(Layer::Diffuse, Path::Diffuse),
        }
    }
}

impl Traffic {
    /// Of a map's jotons.
    pub fn of(&self, kind: Kind) -> Mean {
        match kind {
            Kind::Caustic => self.caustic,
            Kind::Diffuse => self.diffuse,
        }
    }
}

/// Where a path starts; none where nothing is emitted.
fn start(scene: &PackedScene, plan: &Plan, path: Path, number: u32) -> Option<(Ray, Bands)> {
    let seed = plan.settings.seed;
    let draw = |k: u32| sobol2(number, sequence_seed(seed, k, STREAM_TRAFFIC[path as usize]));
    let of = |s: Start| (Ray { origin: s.origin, direction: s.direction }, s.flux);
    match path {
        Path::Camera => {
            let c = &scene.camera;
            Some((Ray { origin: c.eye, direction: c.direction(draw(0)) }, [1.0; BANDS]))
        }
        _ if scene.emitters.is_empty() => None,
        Path::Caustic => aimed(scene, &plan.guides.caustic, draw(0), draw(1), 1.0).map(of),
        Path::Diffuse => Some(of(by_law(scene, &plan.guides.diffuse, draw(0), draw(1), 1.0))),
    }
}

fn follow(scene: &PackedScene, plan: &Plan, path: Path, number: u32) -> Mean {
    let mut found = Mean::default();
    let Some((mut ray, mut flux)) = start(scene, plan, path, number) else { return found };
    let (mut met_diffuse, mut met_specular) = (false, false);
    for event in 0..EVENTS_MAX {
        if flux.iter().all(|x| *x <= 0.0) {
            break;
        }
        found.rays += 1.0;
        let Some(s) = Surface::hit(scene, &ray) else { break };
        if path == Path::Camera && met_specular && s.flags().is_emissive() && s.front {
            found.glints = 1.0;
        }
        let is_met = match path {
            Path::Camera => false,
            Path::Caustic => met_specular,
            Path::Diffuse => met_diffuse,
        };
        if is_met && s.flags().has_diffuse() {
            found.stored += 1.0;
        }
        let [u_way, u0, u1, u_lobe] =
            random4(plan.settings.seed, path as u32, number, DIMENSION_TRAFFIC + event);
        let boundary = s.flags().is_dielectric().then(|| Boundary::at(&s));
        let odds = Odds::new(&s, boundary.as_ref(), &flux, event);
        // nothing is absorbed by chance on the way from the eye
        let kept = if path == Path::Camera { odds.ways.iter().map(|w| w.1).sum() } else { 1.0 };
        let Some(way) = odds.choose(u_way * kept) else { break };
        if way == 0 && path != Path::Diffuse {
            found.stored += if path == Path::Camera { 1.0 } else { 0.0 };
            break;
        }
        let leaving = match way {
            0 => sample_d(s.material, s.back, s.ns, u_lobe, [u0, u1]),
            _ => specular_direction(&s, boundary.as_ref(), way == 2, [u0, u1]),
        };
        let Some(w) = leaving else { break };
        let (reflectance, probability) = odds.ways[way];
        flux = scale(&mul(&flux, &reflectance), 1.0 / probability);
        met_diffuse |= way == 0;
        met_specular |= way > 0;
        ray = s.leave(w);
    }
    found
}
