//! Surfaces that are glass in part [E57], and rough panes [E58].

use crate::build::{Build, glowing, matte, pane, reflectance, v};
use crate::harness::{EVERYTHING, Values, everyone, everyone_both_ways, render, render_keeping};
use joton::film::Layer;
use joton::scene::texture::{Bitmap, Channel, Filter, NumberMap, Space, Texture};
use joton::scene::{FacetKind, Facets, Layers, Material, Metallic, Mixture, number_rests};
use std::sync::Arc;

/// A sheet in a box whose walls shine with radiance 1 and reflect nothing, seen head on.
fn sheet_in_even_light(sheet: &Material, slope: f64) -> Build {
    let eye = v(slope, 0., 1.).normalize() * 2.0;
    let mut b = Build::new(eye, v(0., 0., 0.), 0.05, 8);
    b.cuboid(v(-5., -5., -5.), v(5., 5., 5.), false, &glowing([1.0; 3], [0.0; 3]));
    b.floor(v(0., 0., 0.), 1.0, sheet);
    // 20 and 10 squares are seen in each unit of the sheet
    b.0.mesh.uvs = b.0.mesh.positions.iter().map(|p| [p.x as f32, p.y as f32]).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    number_rests(&mut b.0.materials);
    b
}

/// [E57] A pane in even light, of which t is glass and m metal, and t varies in squares: of a pixel t (1 − m) (R + (1 − R) τ) + m ρ is seen
/// by S events, and (1 − t) (1 − m) ρ is matte.
#[test]
fn a_mixture_in_even_light_has_its_parts() {
    const TRANSMISSION: [f64; 2] = [0.75, 0.25];
    const METALLIC: f64 = 0.25;
    let (tint, base) = ([0.5, 0.75, 1.0], [0.8, 0.5, 0.3]);
    let squares = Bitmap::board(TRANSMISSION.map(|t| [0.0, t as f32, 0.0]));
    let squares = Texture {
        filter: Filter::Nearest,
        scale: [10.0; 2],
        ..Texture::of(Arc::new(squares), Space::Linear)
    };
    let map = NumberMap { texture: squares, channel: Channel::Green, factor: 1.0 };
    let rest = Material {
        // smooth, so that metal is followed; nothing but it reflects
        facets: Some(Facets { alpha: 0.0, kind: FacetKind::Schlick { ior: 1.0 } }),
        layers: Some(Layers { head_on: [0.0; 3], grazing: 0.0, ..Layers::PLAIN }),
        metallic: Some(Metallic { most: METALLIC as f32, map: None }),
        glossy: base.map(|b| b as f32 * METALLIC as f32),
        ..matte(base.map(|b| b as f32))
    };
    let mut glass = pane(1.5);
    glass.dielectric.as_mut().expect("glass").transmission_tint = tint.map(|t| t as f32);
    glass.mixture = Some(Mixture {
        transmission: 1.0,
        transmission_map: Some(map),
        metallic: METALLIC as f32,
        metallic_map: None,
        rest: Box::new(rest),
        number: 0,
    });
    let scene = sheet_in_even_light(&glass, 0.0);
    let face = reflectance(0.0, 1.5);
    let reflected = 2.0 * face / (1.0 + face);
    let transmission = 0.5 * (TRANSMISSION[0] + TRANSMISSION[1]);
    let seen: Values = std::array::from_fn(|i| {
        transmission * (1.0 - METALLIC) * (reflected + (1.0 - reflected) * tint[i]) + METALLIC * base[i]
    });
    let matte: Values = std::array::from_fn(|i| (1.0 - transmission) * (1.0 - METALLIC) * base[i]);
    for who in everyone() {
        let shot = render(who, &scene.0, EVERYTHING, 128);
        shot.claim("seen through and in it", shot.layer(Layer::Emission), seen, 0.02);
        shot.claim("matte", shot.layer(Layer::Direct), matte, 0.04);
    }
}

/// [E57] Jotons meet the matte part of a mixture, and go through the rest: a sheet of matter and clear glass beside a lit wall
/// scatters what it is told to, whichever way diffuse light is found.
#[test]
fn jotons_meet_mixtures() {
    const GLASS: f64 = 0.4;
    let albedo = [0.9, 0.6, 0.3];
    let scene = |transmission: f32| {
        let mut b = Build::new(v(0.3, 0., 2.), v(0.3, 0., 0.), 0.1, 8);
        let mut sheet = pane(1.5);
        let rest = Box::new(matte(albedo));
        sheet.mixture = Some(Mixture {
            transmission,
            transmission_map: None,
            metallic: 0.0,
            metallic_map: None,
            rest,
            number: 0,
        });
        b.floor(
            v(0., 0., 0.),
            1.0,
            if transmission > 0.0 { &sheet } else { &sheet.mixture.as_ref().unwrap().rest },
        );
        // a wall that a sun lights, whose light falls on the sheet
        b.quad(v(1., -1., 0.), v(0., 0., 1.), v(0., 2., 0.), &matte([0.8; 3]));
        b.sun(v(1., 0., 0.), [2.0; 3]);
        number_rests(&mut b.0.materials);
        b
    };
    for (who, keep) in everyone_both_ways(&scene(0.0).0) {
        let whole = render_keeping(who, &scene(0.0).0, EVERYTHING, 48, keep).layer(Layer::Diffuse).mean;
        let part = render_keeping(who, &scene(GLASS as f32).0, EVERYTHING, 64, keep);
        part.claim("diffuse", part.layer(Layer::Diffuse), whole.map(|x| (1.0 - GLASS) * x), 0.09);
    }
}

/// [E58] A rough pane in even light gives back what facets do not mask: no more than all, and at α = .1 from above but little less; by a
/// tint it is darker where light goes through.
#[test]
fn a_rough_pane_in_even_light_loses_little() {
    for (alpha, least) in [(0.01, 0.995), (0.1, 0.98), (0.5, 0.6)] {
        let mut rough = pane(1.5);
        rough.facets = Some(Facets { alpha, kind: FacetKind::Interface });
        let scene = sheet_in_even_light(&rough, 0.3);
        for who in everyone() {
            let shot = render(who, &scene.0, EVERYTHING, 16);
            let seen = shot.layer(Layer::Emission);
            for band in 0..3 {
                assert!(
                    seen.mean[band] < 1.0 + 4.0 * seen.error[band] + 1e-5 && seen.mean[band] > least,
                    "{who:?}, α {alpha}: {seen:?}"
                );
            }
        }
    }
}
