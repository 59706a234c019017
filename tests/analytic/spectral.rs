//! Light by wavelength: a prism, lamps of one line, paints that look alike under one light only, and white that stays white.

use crate::build::{Build, reflectance, v};
use crate::harness::{EVERYTHING, Renderer, everyone, mappers, render};
use glam::{DVec2, DVec3};
use joton::film::Layer;
use joton::scene::{Dielectric, Light, Material, MaterialSpectra, Scene};
use joton::spectrum::Spectrum;
use joton::spectrum::glass::Index;
use joton::spectrum::lamp::{Emission, Lamp, Line};
use std::f64::consts::PI;
use std::sync::Arc;

/// Linear sRGB of XYZ, by the matrix of IEC 61966-2-1 as it is printed: five digits that share nothing with the renderer's.
const XYZ_TO_SRGB: [[f64; 3]; 3] =
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
/// x̄, ȳ, z̄ at 590 nm, as the CIE prints them.
const OBSERVER_AT_590: [f64; 3] = [1.0263, 0.7570, 0.0011];
/// ∫ ȳ dλ, nm.
const OBSERVER_AREA: f64 = 106.857;

/// Linear sRGB of a line at 590 nm of power 1.
fn srgb_of_590() -> [f64; 3] {
    XYZ_TO_SRGB.map(|row| (0..3).map(|c| row[c] * OBSERVER_AT_590[c]).sum::<f64>() / OBSERVER_AREA)
}

/// Lines of these wavelengths, each of this power.
fn lines(lambdas: &[f64], power: f64) -> Emission {
    let line = |&lambda: &f64| Line { lambda, power };
    Emission::of_lines(lambdas.iter().map(line).collect()).expect("lines that can be seen")
}

/// A matte paint.
pub fn paint(spectrum: Spectrum) -> Material {
    let rgb = spectrum.reflectance_to_rgb().map(|c| c.clamp(0.0, 1.0) as f32);
    let spectra = MaterialSpectra { diffuse: Some(spectrum), ..MaterialSpectra::default() };
    Material { spectra: Some(Arc::new(spectra)), ..Material::matte("paint", rgb) }
}

pub fn by_wavelength(build: Build, light: Emission) -> Scene {
    let mut scene = build.0;
    scene.wavelengths.lights = vec![Some(light)];
    scene.wavelengths.are_rendered = true;
    scene
}

/// Two paints side by side, left and right, under a sun of this spectrum that stands in the zenith.
fn two_paints(paints: [Spectrum; 2], light: Emission) -> Scene {
    let mut b = Build::new(v(0., 0., 4.), v(0., 0., 0.), 0.2, 16);
    let [left, right] = paints.map(paint);
    b.quad(v(-2., -2., 0.), v(2., 0., 0.), v(0., 4., 0.), &left);
    b.quad(v(0., -2., 0.), v(2., 0., 0.), v(0., 4., 0.), &right);
    b.sun(v(0., 0., -1.), light.to_rgb().map(|c| c.max(0.01) as f32));
    by_wavelength(b, light)
}

/// Under a lamp of one line every paint has the line's colour, as bright as it reflects there: E ρ/π of it. No three fixed bands
/// can say so. It has no noise in colour: after two passes it is there.
#[test]
fn one_line_makes_all_paints_one_colour() {
    let table = |values: [f64; 3]| {
        Spectrum::reflectance_table(vec![500.0, 590.0, 650.0], values.to_vec()).expect("reflectances")
    };
    // as colours they are green and red
    let scene = two_paints([table([0.9, 0.2, 0.0]), table([0.0, 0.5, 0.9])], lines(&[590.0], 100.0));
    for who in everyone() {
        let shot = render(who, &scene, EVERYTHING, 2);
        for (side, rho) in [(0, 0.2), (1, 0.5)] {
            let seen = shot.mean(&[Layer::Direct], |x, _| (x > 0.5) == (side == 1));
            let want = srgb_of_590().map(|c| 100.0 * c * rho / PI);
            shot.claim(&format!("paint of {rho} at 590 nm"), seen, want, 2e-3);
        }
    }
}

/// x̄, ȳ, z̄ at 585 nm, as the CIE prints them.
const OBSERVER_AT_585: [f64; 3] = [0.9786, 0.8163, 0.0014];
/// Lines of sodium, nm, and their relative power: D2 is twice D1 where the vapour is thin [NIST].
const SODIUM: [(f64, f64); 2] = [(588.995, 2.0), (589.592, 1.0)];

/// Under a sodium lamp coloured paints are greys of its one yellow: what each has of the light is what it reflects at 589 nm, and the
/// yellow that of the CIE's observer, within 1 %.
#[test]
fn sodium_makes_greys_of_paints() {
    let table = |values: [f64; 3]| {
        Spectrum::reflectance_table(vec![500.0, 590.0, 650.0], values.to_vec()).expect("reflectances")
    };
    // a green and a red, at 589 nm straight between their values
    let ends = [[0.9, 0.2, 0.0], [0.0, 0.5, 0.9]];
    let lamp = Lamp::named("sodium").expect("a lamp").emission().scaled(PI);
    let scene = two_paints(ends.map(table), lamp);
    // the lamp's luminance is 1
    let total: f64 = SODIUM.iter().map(|(_, power)| power).sum();
    let seen = |k: usize, rho: &dyn Fn(f64) -> f64| -> f64 {
        let of = |&(lambda, power): &(f64, f64)| {
            let t = (lambda - 585.0) / 5.0;
            power / total * rho(lambda) * (OBSERVER_AT_585[k] * (1.0 - t) + OBSERVER_AT_590[k] * t)
        };
        SODIUM.iter().map(of).sum()
    };
    let luminance = seen(1, &|_| 1.0);
    for who in everyone() {
        let shot = render(who, &scene, EVERYTHING, 4);
        for (side, [first, last, _]) in ends.into_iter().enumerate() {
            let rho = |lambda: f64| first + (last - first) * (lambda - 500.0) / 90.0;
            let mean = shot.mean(&[Layer::Direct], |x, _| (x > 0.5) == (side == 1));
            let want = XYZ_TO_SRGB.map(|row| (0..3).map(|k| row[k] * seen(k, &rho)).sum::<f64>() / luminance);
            // red and green; blue is next to nothing, and negative
            for band in [0, 1] {
                shot.claim_band(&format!("paint {side} under sodium"), mean, band, want[band], 1e-2);
            }
        }
    }
}

/// Two paints that look alike in daylight and differ by half under a line.
#[test]
fn paints_that_look_alike_in_daylight_differ_under_a_line() {
    // grey, and grey with waves that daylight does not show: of four bumps three take away what the first one does
    let centres = [590.0, 450.0, 540.0, 640.0];
    let bump = |k: usize, lambda: f64| (-((lambda - centres[k]) / 25.0).powi(2)).exp();
    let lambdas: Vec<f64> = (0..=470).map(|i| 360.0 + f64::from(i)).collect();
    let of = |values: Vec<f64>| Spectrum::reflectance_table(lambdas.clone(), values).expect("reflectances");
    let rgb = |k: usize| {
        let daylit: Vec<f64> = lambdas.iter().map(|&x| bump(k, x)).collect();
        DVec3::from(of(daylit).reflectance_to_rgb())
    };
    let others = glam::DMat3::from_cols(rgb(1), rgb(2), rgb(3));
    let less = others.inverse() * rgb(0);
    let wavy: Vec<f64> = lambdas
        .iter()
        .map(|&x| 0.4 + 0.2 * (bump(0, x) - (0..3).map(|k| less[k] * bump(k + 1, x)).sum::<f64>()))
        .collect();
    let at_590 = wavy[230];
    assert!((0.05..0.95).contains(&at_590) && (at_590 - 0.4).abs() > 0.1, "{at_590}");
    let paints = [Spectrum::Constant(0.4), of(wavy)];

    let daylight = Emission::continuous(Spectrum::emission_of_rgb([PI; 3]));
    let scene = two_paints(paints.clone(), daylight);
    for who in everyone() {
        let shot = render(who, &scene, EVERYTHING, 256);
        for side in [0, 1] {
            let seen = shot.mean(&[Layer::Direct], |x, _| (x > 0.5) == (side == 1));
            shot.claim(&format!("paint {side} in daylight"), seen, [0.4; 3], 8e-3);
        }
    }
    let scene = two_paints(paints, lines(&[590.0], 100.0));
    for who in everyone() {
        let shot = render(who, &scene, EVERYTHING, 2);
        for (side, rho) in [(0, 0.4), (1, at_590)] {
            let seen = shot.mean(&[Layer::Direct], |x, _| (x > 0.5) == (side == 1));
            shot.claim("paint under a line", seen, srgb_of_590().map(|c| 100.0 * c * rho / PI), 2e-3);
        }
    }
}

/// A closed box that emits half of what it reflects the other half of is white: light that is reflected without end has lost no colour.
#[test]
fn a_white_furnace_stays_white() {
    let mut b = Build::new(v(0., 0., 0.), v(1., 0.3, 0.2), 0.5, 8);
    let wall = Material { emission: [0.5; 3], ..Material::matte("wall", [0.5; 3]) };
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &wall);
    b.0.wavelengths.are_rendered = true;
    for who in everyone() {
        let shot = render(who, &b.0, EVERYTHING, 64);
        shot.claim("furnace", shot.mean(&Layer::ALL, |_, _| true), [1.0; 3], 6e-3);
    }
}

/// Equal sides of the prism, m.
const SIDE: f64 = 0.1;
/// From the prism to the screen, m.
const THROW: f64 = 1.5;

/// Sellmeier's coefficients of N-SF11 [Schott 2017]: B, and C in µm².
pub const FLINT: [[f64; 2]; 3] =
    [[1.737_596_95, 0.013_188_707], [0.313_747_346, 0.062_306_814_2], [1.898_781_01, 155.236_29]];

/// Its index.
pub fn flint(lambda: f64) -> f64 {
    let x = (lambda / 1000.0).powi(2);
    (1.0 + FLINT.iter().map(|[b, c]| b * x / (x - c)).sum::<f64>()).sqrt()
}

/// Half the deviation at a wavelength where the ray goes through the prism symmetrically, rad: sin((60° + D)/2) = n sin 30°.
fn half_deviation(lambda: f64) -> f64 {
    (0.5 * flint(lambda)).asin() - PI / 6.0
}

/// Where light of `lambda` meets the screen, m from where that of 550 nm does: angles only. It enters by the middle of the left side.
fn place(lambda: f64) -> f64 {
    let n = flint(lambda);
    let i1 = (0.5 * flint(550.0)).asin();
    let inside = (i1.sin() / n).asin();
    let i2 = PI / 3.0 - inside;
    let out = (n * i2.sin()).asin();
    let deviation = i1 + out - PI / 3.0 - 2.0 * half_deviation(550.0);
    // the triangle of the apex: from the middle of a side to where the ray leaves the other, measured from the apex
    let from_apex = SIDE / 2.0 * (PI / 2.0 - inside).sin() / (PI / 6.0 + inside).sin();
    // along the right side, down from its middle, seen from the screen
    let shift = (from_apex - SIDE / 2.0) * i1.cos();
    shift + (THROW - (from_apex - SIDE / 2.0) * i1.sin()) * deviation.tan()
}

/// Glass of this index.
fn glass(index: Index) -> Material {
    let ior = index.at(550.0) as f32;
    let dielectric = Dielectric { ior, reflection_tint: [1.0; 3], transmission_tint: [1.0; 3] };
    let spectra = MaterialSpectra { index: Some(index), ..MaterialSpectra::default() };
    Material {
        dielectric: Some(dielectric),
        spectra: Some(Arc::new(spectra)),
        ..Material::matte("glass", [0.0; 3])
    }
}

/// A prism of these corners across z = 0.
fn add_prism(b: &mut Build, corners: [DVec2; 3], glass: &Material) {
    let [p, q, r] = corners.map(|p| p.extend(-0.05));
    let along = v(0., 0., 0.1);
    for [from, to] in [[p, q], [q, r], [r, p]] {
        b.quad(from, to - from, along, glass);
    }
    b.triangle([p, r, q], glass);
    b.triangle([p + along, q + along, r + along], glass);
}

/// A thin beam of some lines through the prism at the minimum of deviation of 550 nm, and the screen behind it, seen from the prism's side.
fn prism(lambdas: &[f64]) -> Scene {
    let height = SIDE * 3f64.sqrt() / 2.0;
    let [apex, left, right] = [(0.0, 2.0 / 3.0), (-0.5, -1.0 / 3.0), (0.5, -1.0 / 3.0)]
        .map(|(x, y): (f64, f64)| DVec2::new(x * SIDE, y * height));
    let (sin, cos) = half_deviation(550.0).sin_cos();
    let [into, out] = [v(cos, sin, 0.), v(cos, -sin, 0.)];
    let [enters, leaves] = [left, right].map(|corner| 0.5 * (apex + corner).extend(0.0));
    let middle = leaves + out * THROW;
    let mut b = Build::new(middle - out * 0.8, middle, 0.15, 160);
    let index = Index::Sellmeier(FLINT.to_vec());
    let glass = glass(index);
    add_prism(&mut b, [apex, left, right], &glass);
    let across = v(sin, cos, 0.);
    let corner = middle - across - v(0., 0., 1.);
    // looks back at the prism
    b.quad(corner, v(0., 0., 2.), across * 2.0, &Material::matte("screen", [0.8; 3]));
    let light = lines(lambdas, 1e4);
    b.light(Light::Spot {
        position: enters - into * 2.0,
        direction: into,
        intensity: light.to_rgb().map(|c| c.max(0.01) as f32),
        angle_inner: 0.0,
        angle_outer: 0.1f64.to_radians(),
    });
    by_wavelength(b, light)
}

/// Each line leaves the prism by its own angle, within 1e-4 rad of sin((A + D)/2) = n sin(A/2) and its neighbours: the middle of its
/// image on the screen lies where the formula says, on both devices.
#[test]
fn a_prism_bends_each_line_by_its_own_angle() {
    let lambdas = [470.0, 550.0, 650.0];
    let scene = prism(&lambdas);
    for who in mappers() {
        let shot = render(who, &scene, EVERYTHING, 48);
        for lambda in lambdas {
            // left in the image is up along the screen: less deviation
            let wanted = -place(lambda);
            let across = |x: f64| (0.5 - x) * 2.0 * 0.15 * 0.8;
            let here = |x: f64, y: f64| (across(x) - wanted).abs() < 0.016 && (y - 0.5).abs() < 0.1;
            let light = |w: &dyn Fn(f64) -> f64| {
                let seen =
                    shot.weighed(&[Layer::Caustic], |x, y| if here(x, y) { w(across(x)) } else { 0.0 });
                // luminance: no line's is zero
                (0..3).map(|b| [0.2126, 0.7152, 0.0722][b] * seen.mean[b]).sum::<f64>()
            };
            let total = light(&|_| 1.0);
            assert!(total > 0.0, "{who:?}: {lambda} nm is nowhere near {wanted}");
            let found = light(&|at| at) / total;
            let angle = (found - wanted) / THROW;
            println!("{lambda} nm, {who:?}: {found:.5} m, wanted {wanted:.5}: off by {angle:.2e} rad");
            assert!(angle.abs() < 1e-4, "{who:?}, {lambda} nm: off by {angle:.2e} rad");
        }
    }
    assert!(mappers().contains(&Renderer::Cpu));
}

/// A crown's index by Cauchy's formula, in µm: A, and B in µm².
const CROWN: [f64; 2] = [1.5046, 0.0042];

fn crown(lambda: f64) -> f64 {
    CROWN[0] + CROWN[1] / (lambda / 1000.0).powi(2)
}

/// A white beam through a prism of crown at the minimum of deviation of 550 nm and, where `is_joined`, through a second one that stands on
/// its head behind the first; the screen behind.
fn newton(is_joined: bool) -> Scene {
    let height = SIDE * 3f64.sqrt() / 2.0;
    let [apex, left, right] = [(0.0, 2.0 / 3.0), (-0.5, -1.0 / 3.0), (0.5, -1.0 / 3.0)]
        .map(|(x, y): (f64, f64)| DVec2::new(x * SIDE, y * height));
    let half = (0.5 * crown(550.0)).asin() - PI / 6.0;
    let (sin, cos) = half.sin_cos();
    let [into, out] = [DVec2::new(cos, sin), DVec2::new(cos, -sin)];
    let [enters, leaves] = [left, right].map(|corner| 0.5 * (apex + corner));
    // turned by half a turn about a place behind the first
    let turn = leaves + out * 0.0025;
    let (from, along, far) =
        if is_joined { (2.0 * turn - enters, into, 0.5) } else { (leaves, out, 2.0 * THROW) };
    let middle = (from + along * far).extend(0.0);
    let [into, along] = [into, along].map(|v| v.extend(0.0));
    let mut b = Build::new(middle - along * 0.4, middle, 0.15, 32);
    let [a, c] = CROWN;
    let glass = glass(Index::Cauchy { a, b: c });
    add_prism(&mut b, [apex, left, right], &glass);
    if is_joined {
        add_prism(&mut b, [apex, left, right].map(|p| 2.0 * turn - p), &glass);
    }
    let across = along.cross(v(0., 0., -1.));
    b.quad(
        middle - across - v(0., 0., 1.),
        v(0., 0., 2.),
        across * 2.0,
        &Material::matte("screen", [0.8; 3]),
    );
    let light = Emission::continuous(Spectrum::Constant(1e4));
    b.light(Light::Spot {
        position: enters.extend(0.0) - into * 2.0,
        direction: into,
        intensity: light.to_rgb().map(|c| c as f32),
        angle_inner: 0.3f64.to_radians(),
        angle_outer: 0.3f64.to_radians(),
    });
    by_wavelength(b, light)
}

/// Newton's experiment: one prism parts white light into colours, and a second one that stands on its head puts them together again: the
/// middle of the spot has the colour of what four faces let through of each wavelength.
#[test]
fn two_prisms_make_white_again() {
    use joton::spectrum::cie::{cmf, integral, xyz_to_rgb};
    let y = integral(|lambda| cmf(lambda)[1]);
    let let_through = |lambda: f64| {
        let (n, i1) = (crown(lambda), (0.5 * crown(550.0)).asin());
        let i2 = PI / 3.0 - (i1.sin() / n).asin();
        let out = (n * i2.sin()).asin();
        [i1, out].map(|angle| (1.0 - reflectance(angle, n)).powi(2)).iter().product::<f64>()
    };
    let want = xyz_to_rgb([0, 1, 2].map(|k| integral(|lambda| let_through(lambda) * cmf(lambda)[k]) / y));
    for who in mappers() {
        let shot = render(who, &newton(true), "LS+DE", 8);
        let spot = shot.mean(&[Layer::Caustic], |x, y| (x - 0.5).hypot(y - 0.5) < 0.07);
        let ratios = [0, 2].map(|k| spot.mean[k] / spot.mean[1] / (want[k] / want[1]));
        let shot = render(who, &newton(false), "LS+DE", 8);
        // red to one side, blue to the other
        let place = |k: usize| {
            let light = |w: &dyn Fn(f64) -> f64| shot.weighed(&[Layer::Caustic], |x, _| w(x)).mean;
            light(&|x| x)[k] / light(&|_| 1.0)[k]
        };
        let apart = (place(2) - place(0)) * 0.12;
        println!("{who:?}: red and blue over green {ratios:.4?} of what is right; apart by {apart:.4} m");
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.03), "{who:?}: {ratios:?}");
        // a degree or so, over the way to the screen
        assert!((0.01..0.1).contains(&apart.abs()), "{who:?}: {apart} m");
    }
}
