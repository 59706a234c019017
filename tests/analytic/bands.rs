//! Bands for who measures: the radiance at each wavelength of a list, W/(m² sr nm)  [E53].

use crate::build::{Build, Look, v};
use crate::harness::{EVERYTHING, Renderer, Shot, everyone, render, render_packed};
use crate::spectral::{FLINT, by_wavelength, flint, paint};
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::scene::{Dielectric, FacetKind, Facets, Layers, Light, Material, MaterialSpectra, Scene};
use joton::spectrum::glass::Index;
use joton::spectrum::lamp::Emission;
use joton::spectrum::list::List;
use joton::spectrum::{BANDS, Bands, Spectrum};
use std::f64::consts::PI;
use std::sync::Arc;

/// Where spectra of these tests have their values, nm.
const KNOTS: [f64; 4] = [400.0, 480.0, 590.0, 700.0];

/// Straight between the knots.
fn at(values: [f64; 4], lambda: f64) -> f64 {
    let i = (1..3).find(|&i| lambda < KNOTS[i]).unwrap_or(3);
    let t = (lambda - KNOTS[i - 1]) / (KNOTS[i] - KNOTS[i - 1]);
    values[i - 1] + t * (values[i] - values[i - 1])
}

fn reflectance(values: [f64; 4]) -> Spectrum {
    Spectrum::reflectance_table(KNOTS.to_vec(), values.to_vec()).expect("reflectances")
}

fn emission(values: [f64; 4]) -> Emission {
    Emission::continuous(Spectrum::emission_table(KNOTS.to_vec(), values.to_vec()).expect("an emission"))
}

/// What shines by a spectrum, and reflects by one.
fn wall(values: [f64; 4], shines: [f64; 4]) -> Material {
    let light = emission(shines);
    let rgb = light.to_rgb().map(|c| c.max(0.01) as f32);
    let mut material = Material { emission: rgb, ..paint(reflectance(values)) };
    let stated =
        MaterialSpectra { diffuse: Some(reflectance(values)), emission: Some(light), ..Default::default() };
    material.spectra = Some(Arc::new(stated));
    material
}

/// A render of each three of a list.
fn measure(who: Renderer, scene: &Scene, list: &List, passes: u64) -> Vec<([f64; BANDS], Shot)> {
    let packed = PackedScene::whole(scene);
    let at = |lambdas| (lambdas, render_packed(who, packed.at_wavelengths(lambdas), EVERYTHING, passes, &[]));
    list.threes().map(at).collect()
}

/// A paint under a sun: E(λ) ρ(λ)/π at each wavelength. Without noise, and where the last three are filled up, too.
#[test]
fn paint_under_a_sun_by_wavelength() {
    let (sun, rho) = ([3.0, 1.0, 2.0, 0.5], [0.1, 0.7, 0.2, 0.9]);
    let mut b = Build::new(v(0., 0., 4.), v(0., 0., 0.), 0.2, 8);
    b.floor(v(0., 0., 0.), 2.0, &paint(reflectance(rho)));
    let light = emission(sun);
    b.sun(v(0., 0., -1.), light.to_rgb().map(|c| c as f32));
    let scene = by_wavelength(b, light);
    let list = List::new(vec![620.0, 430.0, 505.5, 400.0]).expect("wavelengths");
    for who in everyone() {
        for (lambdas, shot) in measure(who, &scene, &list, 1) {
            let want = lambdas.map(|lambda| at(sun, lambda) * at(rho, lambda) / PI);
            shot.claim(&format!("paint at {lambdas:?} nm"), shot.layer(Layer::Direct), want, 1e-4);
        }
    }
}

/// What is seen at a wavelength does not depend on which are rendered together: of a coloured sheen, too, whose most anywhere counts for
/// what it leaves to the base [E51].
#[test]
fn a_band_has_no_company() {
    let mut b = Build::new(v(0., 0., 4.), v(0., 0., 0.), 0.2, 4);
    let layers = Layers { sheen: [0.9, 0.5, 0.1], ..Layers::PLAIN };
    let facets = Facets { alpha: 0.25, kind: FacetKind::Schlick { ior: 1.5 } };
    let velvet = Material {
        glossy: [0.04; 3],
        facets: Some(facets),
        layers: Some(layers),
        ..Material::matte("velvet", [0.5; 3])
    };
    b.floor(v(0., 0., 0.), 2.0, &velvet);
    let light = emission([1.0; 4]);
    b.sun(v(0.3, 0., -1.).normalize(), light.to_rgb().map(|c| c as f32));
    let scene = by_wavelength(b, light);
    let lists = [vec![550.0], vec![450.0, 550.0, 650.0]].map(|list| List::new(list).expect("wavelengths"));
    for who in everyone() {
        let [alone, among] = lists.each_ref().map(|list| {
            let (lambdas, shot) = measure(who, &scene, list, 1).remove(0);
            let band = lambdas.iter().position(|lambda| *lambda == 550.0).expect("550 nm");
            shot.layer(Layer::Direct).mean[band]
        });
        assert!(alone > 0.01 && (among / alone - 1.0).abs() < 1e-5, "{who:?}: {among}, alone {alone}");
    }
}

/// Plates of flint before what shines.
const PLATES: u32 = 3;

/// Plates before what shines, seen straight: (1 − R)/(1 + (2m − 1) R) of it, R = ((n − 1)/(n + 1))², by the index of each wavelength
/// [Stokes 1862].
#[test]
fn flint_transmits_by_wavelength() {
    let shines = [1.0, 2.0, 0.5, 1.5];
    let mut b = Build::new(v(0., 0., 40.), v(0., 0., 0.), 0.01, 16);
    let stated = MaterialSpectra { index: Some(Index::Sellmeier(FLINT.to_vec())), ..Default::default() };
    let glass = Material {
        dielectric: Some(Dielectric { ior: 1.785, reflection_tint: [1.0; 3], transmission_tint: [1.0; 3] }),
        spectra: Some(Arc::new(stated)),
        ..Material::matte("glass", [0.0; 3])
    };
    b.floor(v(0., 0., 0.), 1.0, &wall([0.0; 4], shines));
    for plate in 1..=PLATES {
        b.cuboid(v(-1., -1., f64::from(plate)), v(1., 1., f64::from(plate) + 0.5), true, &glass);
    }
    b.0.wavelengths.are_rendered = true;
    let list = List::new(vec![420.0, 500.0, 690.0]).expect("wavelengths");
    for who in everyone() {
        for (lambdas, shot) in measure(who, &b.0, &list, 64) {
            let want = lambdas.map(|lambda| {
                let r = ((flint(lambda) - 1.0) / (flint(lambda) + 1.0)).powi(2);
                at(shines, lambda) * (1.0 - r) / (1.0 + f64::from(2 * PLATES - 1) * r)
            });
            shot.claim(&format!("flint at {lambdas:?} nm"), shot.layer(Layer::Emission), want, 2e-2);
        }
    }
}

/// A paint and a glass ball under two lamps, in bands that have these values.
fn twins(lamp: Bands, paint: Bands) -> Build {
    let mut b = Build::new(v(0., -4., 2.), v(0., 0., 0.5), 0.4, 16);
    let dielectric = Dielectric { ior: 1.5, reflection_tint: [1.0; 3], transmission_tint: paint };
    b.floor(v(0., 0., 0.), 2.0, &Material::matte("paint", paint));
    let glass = Material { dielectric: Some(dielectric), ..Material::matte("glass", [0.0; 3]) };
    b.sphere(v(0., 0., 0.7), 0.5, 2, Look::OutwardSmooth, &glass);
    b.ceiling(v(0., 0.5, 3.), 0.3, &Material { emission: lamp, ..Material::matte("lamp", [0.0; 3]) });
    b.light(Light::Point { position: v(1.5, 0., 2.), intensity: lamp });
    b
}

/// Light of all orders: at three wavelengths a scene has the picture of one whose red, green and blue are what spectra are there: to the bit on the host, to
/// rounding on a device, whose kernels are others.
#[test]
fn bands_are_colours_of_that_value() {
    let lambdas = [450.0, 520.0, 650.0];
    let (lamp, paint) = ([2.0, 1.5, 3.0], [0.25, 0.75, 0.5]);
    let of = |values: Bands| -> Vec<f64> { values.map(f64::from).to_vec() };
    let light =
        || Emission::continuous(Spectrum::emission_table(lambdas.to_vec(), of(lamp)).expect("a lamp"));
    let tint = || Spectrum::reflectance_table(lambdas.to_vec(), of(paint)).ok();
    let colours = twins(lamp, paint).0;
    let mut spectra = twins(lamp, paint).0;
    for m in &mut spectra.materials {
        let (is_lamp, is_glass) = (m.emission != [0.0; 3], m.dielectric.is_some());
        m.spectra = Some(Arc::new(MaterialSpectra {
            diffuse: tint().filter(|_| !is_lamp && !is_glass),
            transmission: tint().filter(|_| is_glass),
            emission: Some(light()).filter(|_| is_lamp),
            ..Default::default()
        }));
    }
    spectra.wavelengths.lights = vec![Some(light())];
    spectra.wavelengths.are_rendered = true;
    for who in everyone() {
        let by_colour = render(who, &colours, EVERYTHING, 1);
        let packed = PackedScene::whole(&spectra).at_wavelengths(lambdas);
        let by_band = render_packed(who, packed, EVERYTHING, 1, &[]);
        let pixels = [&by_colour, &by_band].map(|shot| shot.pixels(&Layer::ALL));
        let total: f64 = pixels[0].as_flattened().iter().sum();
        let off: f64 =
            pixels[0].as_flattened().iter().zip(pixels[1].as_flattened()).map(|(a, b)| (a - b).abs()).sum();
        println!("{who:?}: {:.1e}", off / total);
        assert!(
            total > 0.0 && off <= if who == Renderer::Device { 1e-5 * total } else { 0.0 },
            "{who:?}: {off}"
        );
    }
}

/// The colour of many bands, by the integral over them, is the picture in red, green and blue that stands beside them.
#[test]
fn bands_add_up_to_the_colours_beside_them() {
    use joton::spectrum::cie::{cmf, integral, xyz_to_rgb};
    let (sun, rho) = ([1.0, 3.0, 2.0, 1.0], [0.3, 0.7, 0.4, 0.6]);
    let mut b = Build::new(v(0., 0., 4.), v(0., 0., 0.), 0.2, 8);
    b.floor(v(0., 0., 0.), 2.0, &paint(reflectance(rho)));
    let light = emission(sun);
    b.sun(v(0., 0., -1.), light.to_rgb().map(|c| c.max(0.01) as f32));
    let scene = by_wavelength(b, light);
    let list = List::even(31).expect("wavelengths");
    let mut xyz = [0.0; 3];
    for (lambdas, shot) in measure(Renderer::Cpu, &scene, &list, 1) {
        let seen = shot.layer(Layer::Direct).mean;
        for (band, lambda) in lambdas.into_iter().enumerate() {
            if lambdas[..band].contains(&lambda) {
                continue;
            }
            let width = 10.0 / integral(|lambda| cmf(lambda)[1]);
            xyz = std::array::from_fn(|k| xyz[k] + seen[band] * cmf(lambda)[k] * width);
        }
    }
    let shot = render(Renderer::Cpu, &scene, EVERYTHING, 64);
    shot.claim("bands", shot.layer(Layer::Direct), xyz_to_rgb(xyz), 1e-2);
}
