//! Spectra: a scene by wavelength, and what its materials and lights are in the three bands of a pass \[E34\].
//!
//! The bands of a pass are three wavelengths. Everything that does not depend on them (hierarchy, probabilities, flags) is that of
//! the packed scene, whose own bands are red, green and blue: they decide what is learned and planned before the first pass.

use super::PackedScene;
use super::emitters::{PackedEmitter, Source};
use super::media::ABSORPTION_MOST;
use super::surfaces::{PackedMaterial, sheen_bits};
use crate::film::{half, place_in_half};
use crate::scene::{FacetKind, Facets, Layers, Light, Material, MaterialSpectra, Scene};
use crate::spectrum::cie::Matrix;
use crate::spectrum::glass::Index;
use crate::spectrum::lamp::Emission;
use crate::spectrum::metal::Metal;
use crate::spectrum::pick::{Pick, rgb_matrix};
use crate::spectrum::texel::bases_at;
use crate::spectrum::wavelengths::Distribution;
use crate::spectrum::{BANDS, BLACK, Bands, LAMBDA_MAX, LAMBDA_MIN, Spectrum, is_black, max, sum, to_rgb};
use std::sync::Arc;

/// A scene by wavelength.
#[derive(Debug, Clone)]
pub struct Spectra {
    distribution: Arc<Distribution>,
    /// Wavelengths of all passes, nm, where they are not drawn.
    listed: Option<[f64; BANDS]>,
    materials: Arc<Vec<Curves>>,
    /// Of each material, then of each light; none where it emits nothing.
    emissions: Arc<Vec<Option<Emission>>>,
    /// Of each emitter.
    sources: Arc<Vec<Source>>,
}

/// What a material is by wavelength. Where a lobe is black in red, green and blue, it is black.
#[derive(Debug, Clone)]
struct Curves {
    diffuse: Spectrum,
    specular: Spectrum,
    glossy: Spectrum,
    transmission: Spectrum,
    index: Option<Index>,
    /// What its body absorbs, per internal unit of length.
    absorption: Option<Spectrum>,
    /// The most that a texture leaves of `diffuse`: 1 where there is none.
    most: f32,
    /// Where it is one.
    metal: Option<Metal>,
    facets: Option<Facets>,
    /// What lies over its base, by wavelength what the dielectric part reflects head on, and the sheen, and the numbers of that for all
    /// wavelengths: what it leaves to the base does not depend on which are rendered together.
    layers: Option<(Layers, [Spectrum; 2], u32)>,
}

/// What the bands of a pass are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassBands {
    /// The wavelength of each.
    pub picks: [Pick; BANDS],
    /// Linear red, green and blue of the bands: rows. Where wavelengths are listed the film has the bands themselves.
    pub to_rgb: [Bands; 3],
    /// What a texel of red, green or blue alone reflects in the bands \[E37\].
    pub of_texel: [Bands; 3],
}

impl PassBands {
    /// Linear red, green and blue of what was seen in the bands.
    pub fn rgb(&self, seen: &Bands) -> [f32; 3] {
        self.to_rgb.map(|row| row.iter().zip(seen).map(|(m, x)| m * x).sum())
    }
}

impl Curves {
    fn new(m: &Material, packed: &PackedMaterial, world_scale: f64) -> Self {
        let stated = m.spectra.as_deref().cloned().unwrap_or_default();
        let MaterialSpectra { diffuse, glossy, specular, transmission, absorption, index, emission: _ } =
            stated;
        let curve = |rgb: Bands, stated: Option<Spectrum>| {
            stated.unwrap_or_else(|| Spectrum::reflectance_of_rgb(rgb.map(f64::from)))
        };
        // what is followed as a mirror lies there
        let specular = if packed.follows_glossy(m) { glossy.clone() } else { specular };
        let metal = match m.facets.map(|f| f.kind) {
            Some(FacetKind::Conductor { eta, k }) => {
                m.metal.as_deref().cloned().or_else(|| Metal::of_rgb(to_rgb(&eta), to_rgb(&k)))
            }
            _ => None,
        };
        Self {
            // what it reflects itself, under whatever coat
            diffuse: curve(m.diffuse, diffuse),
            specular: curve(packed.specular, specular),
            glossy: curve(packed.glossy, glossy),
            transmission: curve(packed.transmission, transmission),
            index,
            absorption: (packed.flags().is_dielectric()
                && packed.body() > 0
                && !is_black(&packed.extinction))
            .then(|| {
                absorption.unwrap_or_else(|| absorption_of_rgb(&m.interior.absorption)).scaled(world_scale)
            }),
            most: m.diffuse_texture.as_ref().map_or(1.0, |t| t.most().into_iter().fold(0.0, f32::max)),
            metal,
            facets: m.facets,
            layers: m.layers.filter(|_| packed.flags().is_layered()).map(|layers| {
                let [head_on, sheen] = [layers.head_on, layers.sheen].map(|rgb| curve(rgb, None));
                let most =
                    (LAMBDA_MIN as u32..=LAMBDA_MAX as u32).map(|nm| sheen.at(nm.into())).fold(0.0, f64::max);
                let most = if is_black(&layers.sheen) { 0.0 } else { most as f32 };
                (layers, [head_on, sheen], sheen_bits(layers.sheen_roughness, most))
            }),
        }
    }

    /// A material at wavelengths, nm.
    fn at(&self, base: &PackedMaterial, lambdas: [f64; BANDS]) -> PackedMaterial {
        let value = |rgb: &Bands, curve: &Spectrum| {
            if is_black(rgb) { BLACK } else { lambdas.map(|lambda| curve.at(lambda).clamp(0.0, 1.0) as f32) }
        };
        let mut m = *base;
        let layers = self.layers.as_ref().map(|(layers, ..)| layers);
        m.diffuse = base.under_coat(self.facets, layers, value(&base.diffuse, &self.diffuse));
        m.specular = value(&base.specular, &self.specular);
        m.glossy = value(&base.glossy, &self.glossy);
        m.transmission = value(&base.transmission, &self.transmission);
        if let Some(metal) = &self.metal {
            for (band, lambda) in lambdas.into_iter().enumerate() {
                [m.iors[band], m.extinction[band]] = metal.at(lambda).map(|x| x as f32);
            }
        }
        if let Some((_, [head_on, sheen], numbers)) = &self.layers {
            (m.iors, m.extinction) = (value(&base.iors, head_on), value(&base.extinction, sheen));
            m.sheen = *numbers;
        }
        if let Some(absorption) = &self.absorption {
            m.extinction = lambdas.map(|lambda| absorption.at(lambda).clamp(0.0, ABSORPTION_MOST) as f32);
        }
        if !base.flags().is_dielectric() && !base.flags().has_facets() {
            // lobes that reflect no more than arrives as colours may do so at a wavelength
            for band in 0..BANDS {
                let matte = m.diffuse[band] + m.transmission[band];
                let total = matte * self.most + m.specular[band] + m.glossy[band];
                for lobe in [&mut m.diffuse, &mut m.transmission, &mut m.specular, &mut m.glossy] {
                    lobe[band] /= total.max(1.0);
                }
            }
        }
        if let Some(index) = self.dispersion() {
            m.iors = lambdas.map(|lambda| index.at(lambda) as f32);
            m.set_dispersive();
        }
        m
    }

    /// The index, where it depends on the wavelength.
    fn dispersion(&self) -> Option<&Index> {
        self.index.as_ref().filter(|index| index.is_dispersive())
    }
}

impl Spectra {
    /// A scene whose emitters have these sources; all is packed. How much a wavelength is looked at follows from what the lights emit.
    pub(super) fn new(
        scene: &Scene,
        materials: &[PackedMaterial],
        emitters: &[PackedEmitter],
        sources: Vec<Source>,
        world_scale: f64,
    ) -> Self {
        let of_rgb = |rgb: Bands| Emission::continuous(Spectrum::emission_of_rgb(rgb.map(f64::from)));
        let of_material = |m: &Material| {
            let stated = m.spectra.as_ref().and_then(|s| s.emission.clone());
            m.emits().then(|| stated.unwrap_or_else(|| of_rgb(m.emission)))
        };
        let of_light = |(i, light): (usize, &Light)| {
            Some(scene.spectrum_of_light(i).cloned().unwrap_or_else(|| of_rgb(light.power())))
        };
        let lights = scene.lights.iter().enumerate().map(of_light);
        let emissions: Vec<Option<Emission>> =
            scene.materials.iter().map(of_material).chain(lights).collect();
        let mut shares = vec![0.0; emissions.len()];
        for (e, source) in emitters.iter().zip(&sources) {
            shares[source.emission as usize] += flux_of_strength(e) * f64::from(source.scale);
        }
        let lit = shares.iter().zip(&emissions).filter_map(|(share, e)| Some((*share, e.as_ref()?)));
        let distribution = Distribution::new(lit.filter(|(share, _)| *share > 0.0));
        let of_packed = |(m, packed)| Curves::new(m, packed, world_scale);
        let curves: Vec<Curves> = scene.materials.iter().zip(materials).map(of_packed).collect();
        Self {
            distribution: Arc::new(distribution),
            listed: None,
            materials: Arc::new(curves),
            emissions: Arc::new(emissions),
            sources: Arc::new(sources),
        }
    }

    /// The same at these wavelengths, nm, in every pass: the film has the radiance at each, W/(m² sr nm), in place of red, green and blue.
    /// Lines have none: they are nowhere \[E53\].
    fn listed(&self, lambdas: [f64; BANDS]) -> Self {
        Self { listed: Some(lambdas), ..self.clone() }
    }

    /// True where some index depends on the wavelength.
    pub fn disperses(&self) -> bool {
        self.materials.iter().any(|curves| curves.dispersion().is_some())
    }

    /// What the bands of a pass are; no pass of a seed has those of another.
    pub fn bands(&self, seed: u32, pass: u64) -> PassBands {
        let (picks, to_rgb) = match self.listed {
            Some(lambdas) => (lambdas.map(Pick::listed), IDENTITY),
            None => {
                let picks = self.distribution.of_pass(seed.into(), half(pass), place_in_half(pass));
                (picks, rgb_matrix(&picks))
            }
        };
        let to_rgb = to_rgb.map(|row| row.map(|x| x as f32));
        PassBands { picks, to_rgb, of_texel: bases_at(picks.map(|pick| pick.lambda)) }
    }

    /// What is emitted in the bands of a pass: by each material, then by each light.
    pub fn emitted(&self, bands: &PassBands) -> Vec<Bands> {
        let value = |e: &Emission| bands.picks.map(|pick| e.value(&pick) as f32);
        self.emissions.iter().map(|e| e.as_ref().map_or(BLACK, value)).collect()
    }

    /// Materials in the bands of a pass; `base` are those of the scene, `emitted` is what [`Spectra::emitted`] says.
    fn materials(
        &self,
        base: &[PackedMaterial],
        bands: &PassBands,
        emitted: &[Bands],
    ) -> Vec<PackedMaterial> {
        let lambdas = bands.picks.map(|pick| pick.lambda);
        let mut materials: Vec<PackedMaterial> =
            self.materials.iter().zip(base).map(|(curves, base)| curves.at(base, lambdas)).collect();
        materials.iter_mut().zip(emitted).for_each(|(m, emission)| m.emission = *emission);
        materials
    }

    /// A list of the scene's emitters in the bands of a pass; its probabilities stay.
    pub fn emitters(&self, base: &[PackedEmitter], emitted: &[Bands]) -> Vec<PackedEmitter> {
        let at = |(e, source): (&PackedEmitter, &Source)| {
            let flux = flux_of_strength(e);
            let strength = emitted[source.emission as usize].map(|x| x * source.scale);
            PackedEmitter { strength, flux: strength.map(|s| (f64::from(s) * flux) as f32), ..*e }
        };
        base.iter().zip(self.sources.iter()).map(at).collect()
    }

    /// The scene in the bands of a pass.
    pub fn scene(&self, base: &PackedScene, bands: &PassBands, emitted: &[Bands]) -> PackedScene {
        PackedScene {
            materials: self.materials(&base.materials, bands, emitted),
            emitters: self.emitters(&base.emitters, emitted),
            of_texel: Some(bands.of_texel),
            ..base.clone()
        }
    }
}

impl PackedScene {
    /// The same scene at three wavelengths, nm, where it is rendered by wavelength: films then have the radiance at these, W/(m² sr nm), in
    /// place of red, green and blue, of all that shines continuously \[E53\].
    pub fn at_wavelengths(&self, lambdas: [f64; BANDS]) -> Self {
        let spectra = self.spectra.as_deref().map(|spectra| Arc::new(spectra.listed(lambdas)));
        Self { spectra, ..self.clone() }
    }
}

/// Bands as they are.
const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Absorption of this in red, green and blue: what is left of white where the most is absorbed that is, e^-1, is a smooth spectrum of its
/// colour \[E44\].
fn absorption_of_rgb(rgb: &Bands) -> Spectrum {
    const LEAST_LEFT: f64 = 1e-6;
    const LAMBDAS: std::ops::RangeInclusive<u32> = 360..=830;
    let most = f64::from(max(rgb));
    let left = Spectrum::reflectance_of_rgb(rgb.map(|x| (-f64::from(x) / most).exp()));
    if left.is_constant() {
        return Spectrum::Constant(most);
    }
    let lambdas: Vec<f64> = LAMBDAS.step_by(5).map(f64::from).collect();
    let share = |lambda: &f64| left.at(*lambda).max(LEAST_LEFT).ln() / LEAST_LEFT.ln();
    let shares = lambdas.iter().map(share).collect();
    let table = Spectrum::reflectance_table(lambdas, shares);
    // ascending wavelengths and shares of at most one make a table
    table.map_or(Spectrum::Constant(most), |shares| shares.scaled(-LEAST_LEFT.ln() * most))
}

/// Flux of an emitter over its strength: the same in each band, and of one with a picture the mean over the bands.
fn flux_of_strength(e: &PackedEmitter) -> f64 {
    if e.texture > 0 {
        return sum(&e.flux) / sum(&e.strength);
    }
    let largest = (0..BANDS).max_by(|&a, &b| e.strength[a].total_cmp(&e.strength[b])).unwrap_or(0);
    f64::from(e.flux[largest]) / f64::from(e.strength[largest])
}
