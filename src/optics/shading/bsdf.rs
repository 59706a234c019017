//! The BSDF at a hit: what is asked of all its lobes together. Twin: shaders/shading/bsdf.wgsl.
//!
//! Lobes that scatter (event D) are sampled as one mixture; of the delta lobes (event S), which light follows in one direction or
//! nearly so, each is a way of its own.

use crate::optics::shading::dielectric::in_one_band;
use crate::optics::shading::frame::Frame;
use crate::optics::shading::relief;
use crate::optics::shading::{DELTA_MOST, DeltaLobe, SCATTER_MOST, ScatterLobe, delta_lobes, scatter_lobes};
use crate::packed::PackedMaterial;
use crate::packed::constants::ADJOINT_MAX;
use crate::sampling::distributions::{cosine_hemisphere, to_world};
use crate::spectrum::{BANDS, BLACK, Bands, add, max, mul, scale};
use arrayvec::ArrayVec;
use glam::Vec3;
use std::f32::consts::PI;

/// Throughput below this counts as none: one over it is still finite.
const LEAST_CARRIED: f32 = 1e-37;

/// The lobes of a material that scatter. Directions are unit vectors that leave the surface.
#[derive(Debug, Clone)]
pub struct Scatter {
    /// Of all of them.
    albedo: Bands,
    lobes: ArrayVec<ScatterLobe, SCATTER_MOST>,
}

impl Scatter {
    /// Of a material seen from `wo`, about `n`.
    pub fn of(m: &PackedMaterial, wo: Vec3, n: Vec3) -> Self {
        let lobes = scatter_lobes(m, wo.dot(n));
        let albedo = lobes.iter().fold(BLACK, |sum, lobe| add(&sum, &lobe.albedo()));
        Self { albedo, lobes }
    }

    /// Reflectance, per band.
    pub(crate) fn albedo(&self) -> Bands {
        self.albedo
    }

    /// True where f_r depends on directions.
    pub(crate) fn varies(&self) -> bool {
        self.lobes.iter().any(ScatterLobe::varies)
    }

    /// True where light goes to the other side, too.
    pub(crate) fn crosses(&self) -> bool {
        self.lobes.last().is_some_and(ScatterLobe::crosses)
    }

    /// f, 1/sr: of light from the other side, where some crosses, that of the lobe which does.
    #[inline]
    pub fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        self.eval_from(self.crosses() && wi.dot(n) < 0.0, wi, wo, n)
    }

    /// The same of light from beyond the surface, or from this side.
    #[inline]
    pub(crate) fn eval_from(&self, is_beyond: bool, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        match &self.lobes[..] {
            [lobe] => lobe.eval(wi, wo, n),
            lobes => lobes
                .iter()
                .filter(|lobe| lobe.crosses() == is_beyond)
                .fold(BLACK, |sum, lobe| add(&sum, &lobe.eval(wi, wo, n))),
        }
    }

    /// Each lobe, and the probability of sampling it.
    fn shares(&self) -> impl Iterator<Item = (&ScatterLobe, f32)> {
        let total: f32 = self.lobes.iter().map(|lobe| max(&lobe.albedo())).sum();
        self.lobes.iter().map(move |lobe| (lobe, max(&lobe.albedo()) / total.max(f32::MIN_POSITIVE)))
    }

    /// pdf_solid_angle of [`Scatter::sample`].
    pub fn pdf(&self, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
        if let [lobe] = &self.lobes[..] {
            return lobe.pdf(wi, wo, n);
        }
        self.shares().map(|(lobe, share)| share * lobe.pdf(wi, wo, n)).sum()
    }

    /// A direction given the other, `wo`, both about `n`. None where it falls below the surface.
    pub fn sample(&self, wo: Vec3, n: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<Vec3> {
        let mut below = 0.0;
        let is_chosen = |&(_, share): &(_, f32)| {
            below += share;
            u_lobe < below
        };
        let lobe = match &self.lobes[..] {
            [lobe] => lobe,
            // rounding may leave a sum below one
            _ => self.shares().find(is_chosen).map(|(lobe, _)| lobe).or(self.lobes.last())?,
        };
        Some(lobe.sample(wo, n, u))
            .filter(|wi| if lobe.crosses() { wi.dot(n) < 0.0 } else { wi.dot(n) > 0.0 })
    }

    /// f_r cosθ / pdf_solid_angle of a direction that was sampled.
    pub(crate) fn weight(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        match &self.lobes[..] {
            [ScatterLobe::Lambert(l)] => l.albedo,
            _ => scale(&self.eval(wi, wo, n), wi.dot(n).abs() / self.pdf(wi, wo, n)),
        }
    }
}

/// The BSDF where a ray met a surface.
#[derive(Debug, Clone)]
pub(crate) struct Bsdf {
    frame: Frame,
    pub(crate) scatter: Scatter,
    pub(crate) delta: ArrayVec<DeltaLobe, DELTA_MOST>,
}

impl Bsdf {
    /// Of a material, in a frame.
    pub(crate) fn new(m: &PackedMaterial, frame: Frame) -> Self {
        Self { frame, scatter: Scatter::of(m, frame.back, frame.ns), delta: delta_lobes(m, &frame) }
    }

    /// The shading normal that its lobes turn about.
    pub(crate) fn shading_normal(&self) -> Vec3 {
        self.frame.ns
    }

    /// Where bands part, let one go on: `u` in [0, 1), one number for a path, since from then on there is one to pick \[E36\].
    pub(crate) fn part_bands(&mut self, m: &PackedMaterial, carried: &Bands, u: impl FnOnce() -> f32) {
        if !m.parts_bands() {
            return;
        }
        match self.delta.last_mut() {
            Some(DeltaLobe::Interface(way)) => *way = in_one_band(m, &self.frame, way, carried, u()),
            Some(DeltaLobe::RoughInterface(way)) => *way = way.in_one_band(carried, u()),
            _ => {}
        }
    }

    /// Part of the flux that takes each lobe, as max over bands of (albedo × carried) over that of carried.
    pub(crate) fn shares(&self, carried: &Bands) -> Shares {
        // where nothing is carried the shares are 0
        let scale = 1.0 / max(carried).max(LEAST_CARRIED);
        let share = |albedo: &Bands| max(&mul(albedo, carried)) * scale;
        let mut delta = [0.0; DELTA_MOST];
        for (share_of, lobe) in delta.iter_mut().zip(&self.delta) {
            *share_of = share(&lobe.albedo());
        }
        Shares { scatter: share(&self.scatter.albedo()), delta }
    }

    /// f_r of the lobes that scatter, 1/sr, of light from `wi` toward where the ray came from.
    #[inline]
    pub(crate) fn eval_scatter(&self, wi: Vec3) -> Bands {
        self.scatter.eval(wi, self.frame.back, self.frame.ns)
    }

    /// The same of light from beyond the surface, or from this side.
    #[inline]
    pub(crate) fn eval_scatter_from(&self, is_beyond: bool, wi: Vec3) -> Bands {
        self.scatter.eval_from(is_beyond, wi, self.frame.back, self.frame.ns)
    }

    /// pdf_solid_angle of [`Bsdf::sample_scatter`].
    pub(crate) fn pdf_scatter(&self, wi: Vec3) -> f32 {
        self.scatter.pdf(wi, self.frame.back, self.frame.ns)
    }

    /// A direction of the lobes that scatter; none below the surface.
    pub(crate) fn sample_scatter(&self, u_lobe: f32, u: [f32; 2]) -> Option<Vec3> {
        self.scatter.sample(self.frame.back, self.frame.ns, u_lobe, u)
    }

    /// f_r cosθ / pdf_solid_angle of a direction that was sampled so.
    pub(crate) fn weight_scatter(&self, wi: Vec3) -> Bands {
        self.scatter.weight(wi, self.frame.back, self.frame.ns)
    }

    /// Cosine of light from a direction to the shading normal, or of light that leaves; 0 on a side of the surface where none does.
    pub(crate) fn cosine(&self, w: Vec3) -> f32 {
        let [shading, geometric] = [self.frame.ns, self.frame.ng].map(|n| w.dot(n));
        match self.scatter.crosses() {
            true if shading < 0.0 && geometric < 0.0 => -shading,
            _ if shading > 0.0 && geometric > 0.0 => shading,
            _ => 0.0,
        }
    }

    /// A direction in which a joton leaves a relief by the lobes that scatter, and f_r |w·Ng| / pdf_solid_angle with what limits the
    /// adjoint of shading normals: what is diffuse is drawn about the geometric normal, since eyes see it from all sides \[E48\].
    pub(crate) fn scatter_off_relief(&self, u_lobe: f32, u: [f32; 2]) -> Option<(Vec3, Bands)> {
        let Frame { back, ng, ns, .. } = self.frame;
        let mut below = 0.0;
        let is_chosen = |&(_, share): &(_, f32)| {
            below += share;
            u_lobe < below
        };
        let (lobe, share) = self.scatter.shares().find(is_chosen)?;
        let (w, weight) = if lobe.is_diffuse() {
            let w = to_world(cosine_hemisphere(u), if lobe.crosses() { -ng } else { ng });
            (w, scale(&lobe.eval(w, back, relief::turned(ns, w)), PI))
        } else {
            let w = Some(lobe.sample(back, ns, u)).filter(|w| w.dot(ns) > 0.0 && w.dot(ng) > 0.0)?;
            let adjoint = (w.dot(ng) / w.dot(ns)).min(ADJOINT_MAX);
            (w, scale(&lobe.eval(w, back, ns), w.dot(ns) / lobe.pdf(w, back, ns) * adjoint))
        };
        Some((w, scale(&weight, 1.0 / share)))
    }

    /// A direction of a delta lobe; none below the surface.
    pub(crate) fn sample_delta(&self, lobe: usize, u: [f32; 2]) -> Option<Vec3> {
        self.delta[lobe].sample(&self.frame, u)
    }

    /// What of a path's throughput goes on by a delta lobe in a direction that was sampled, as radiance.
    pub(crate) fn through_delta(&self, lobe: usize, w: Vec3, throughput: &Bands) -> Bands {
        let lobe = &self.delta[lobe];
        scale(&mul(throughput, &lobe.through(&self.frame, w)), lobe.radiance_scale(&self.frame))
    }

    /// pdf_solid_angle of [`Bsdf::sample_delta`]; none of a lobe without a width.
    pub(crate) fn pdf_delta(&self, lobe: usize, w: Vec3) -> Option<f32> {
        self.delta[lobe].pdf(&self.frame, w)
    }

    /// True where a lobe that is followed has a width: a light sample may lie in it.
    pub(crate) fn has_width(&self) -> bool {
        self.delta.iter().any(DeltaLobe::has_width)
    }

    /// What each lobe that is followed, with a width, sends back along the ray from the direction `w`.
    pub(crate) fn followed_from(&self, w: Vec3) -> impl Iterator<Item = Followed> {
        let crosses = w.dot(self.frame.ng) < 0.0;
        let lobes = self.delta.iter().enumerate().filter(move |(_, lobe)| lobe.crosses() == crosses);
        lobes.filter_map(move |(lobe, _)| {
            let pdf = self.pdf_delta(lobe, w).filter(|pdf| *pdf > 0.0)?;
            Some(Followed { lobe, f_cos: self.through_delta(lobe, w, &[pdf; BANDS]), pdf })
        })
    }

    /// By how much radiance scales by a delta lobe \[E9\].
    pub(crate) fn radiance_scale(&self, lobe: usize) -> f32 {
        self.delta[lobe].radiance_scale(&self.frame)
    }

    /// What of a joton's flux goes on so.
    pub(crate) fn flux_through_delta(&self, lobe: usize, w: Vec3, flux: &Bands) -> Bands {
        mul(flux, &self.delta[lobe].through(&self.frame, w))
    }
}

/// Light of a direction in a lobe that is followed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Followed {
    pub(crate) lobe: usize,
    /// f |cosθ|, 1/sr, of radiance on the way to the eye.
    pub(crate) f_cos: Bands,
    /// pdf_solid_angle of the lobe.
    pub(crate) pdf: f32,
}

/// Part of the flux that takes each lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shares {
    /// Those that scatter, together.
    pub(crate) scatter: f32,
    /// Each delta lobe; 0 where there is none.
    pub(crate) delta: [f32; DELTA_MOST],
}

impl Shares {
    /// All delta lobes.
    pub(crate) fn followed(&self) -> f32 {
        self.delta.iter().sum()
    }

    /// All lobes.
    pub(crate) fn kept(&self) -> f32 {
        self.scatter + self.followed()
    }

    /// The delta lobe that `u` in [0, [`Shares::followed`]) falls on; never one without a share, whatever rounding says.
    pub(crate) fn pick_delta(&self, u: f32) -> usize {
        let second = self.delta[1] > 0.0 && u >= self.delta[0];
        usize::from(second)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::random4;
    use crate::scene::Material;
    use std::f32::consts::TAU;

    /// A path that carries nothing, or less than f32 can be divided by, ends: its shares are finite, and none where it is black.
    #[test]
    fn nothing_is_shared_out_where_nothing_is_carried() {
        let frame = Frame { back: Vec3::Z, ng: Vec3::Z, ns: Vec3::Z, front: true };
        let matte = PackedMaterial::new(&Material::matte("m", [0.3; 3]));
        for m in [matte, glossy(30.0)] {
            let bsdf = Bsdf::new(&m, frame);
            assert_eq!(bsdf.shares(&BLACK).kept(), 0.0);
            // 1/1e-40 is no f32
            let faint = bsdf.shares(&[1e-40; 3]).kept();
            assert!((0.0..=1.0).contains(&faint), "{faint}");
        }
    }

    fn glossy(exponent: f32) -> PackedMaterial {
        PackedMaterial::new(&Material {
            glossy: [0.5; 3],
            glossy_exponent: exponent,
            ..Material::matte("m", [0.3; 3])
        })
    }

    /// Sampling by its pdf gives the same albedo as uniform directions do; f is symmetric.
    #[test]
    fn glossy_sampling_matches_its_pdf() {
        let n = Vec3::Z;
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let m = Scatter::of(&glossy(30.0), wo, n);
        let count = 1 << 17;
        let (mut by_lobe, mut by_cone, mut total_pdf) = (0.0, 0.0, 0.0);
        for i in 0..count {
            let [a, b, c, _] = random4(1, 0, i, 0);
            if let Some(wi) = m.sample(wo, n, c, [a, b]) {
                by_lobe += f64::from(m.eval(wi, wo, n)[0] * wi.z / m.pdf(wi, wo, n));
            }
            let wi = crate::sampling::distributions::cone([a, b], 1.0);
            by_cone += f64::from(m.eval(wi, wo, n)[0] * wi.z * TAU);
            total_pdf += f64::from(m.pdf(wi, wo, n) * TAU);
            assert!((m.eval(wi, wo, n)[0] - m.eval(wo, wi, n)[0]).abs() < 1e-4);
        }
        let n = f64::from(count);
        assert!((by_lobe / by_cone - 1.0).abs() < 0.02, "{} {}", by_lobe / n, by_cone / n);
        // the part of the lobe below the surface is lost: a little less than one
        assert!(total_pdf / n > 0.97 && total_pdf / n < 1.01, "{}", total_pdf / n);
        assert!(by_lobe / n < 0.8);
    }
}
