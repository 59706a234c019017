//! Values that are not finite: counted by their cause, in the report too, and kept out of the film.

use crate::renders::{EVERYTHING, Planner, Side, file, open, plan, plan_by_map};
use joton::backend::{Cause, NonFinite};
use joton::film::Layer;
use joton::output::report::{Circumstances, Report};
use joton::packed::PackedScene;
use joton::render::{Rendered, Stop, render};
use std::sync::Arc;

const PASSES: u64 = 3;
/// The band that is spoilt.
const BAND: usize = 1;

/// Render Cornell's box with something spoilt in it.
fn spoilt(side: Side, planner: Planner, spoil: impl Fn(&mut PackedScene)) -> (Rendered, Report) {
    let mut scene = PackedScene::new(&file("cornell.toml", 16));
    let plan = planner(&scene, EVERYTHING, 1);
    spoil(&mut scene);
    let scene = Arc::new(scene);
    let mut backend = open(side, &scene, plan.clone());
    let stop = Stop { passes: Some(PASSES), ..Stop::default() };
    let rendered = render(backend.as_mut(), scene.size, stop, |_| true).unwrap_or_else(|e| panic!("{e}"));
    let around = Circumstances {
        device: backend.describe(),
        setup_seconds: 0.0,
        setup: Vec::new(),
        kernels: Vec::new(),
        warnings: Vec::new(),
    };
    let report = Report::new(&rendered, &scene, &plan, around);
    (rendered, report)
}

/// The flux with which jotons start.
fn spoil_flux(value: f32) -> impl Fn(&mut PackedScene) {
    move |scene| scene.emitters.iter_mut().for_each(|e| e.flux[BAND] = value)
}

/// The radiance of the lamp where it is seen.
fn spoil_radiance(value: f32) -> impl Fn(&mut PackedScene) {
    move |scene| {
        let lamps = scene.materials.iter_mut().filter(|m| m.flags().is_emissive());
        lamps.for_each(|m| m.emission[BAND] = value);
    }
}

fn finite(rendered: &Rendered) -> bool {
    let layers = rendered.picture.layers.iter().chain([&rendered.picture.whole]);
    layers.flat_map(|l| &l.pixels).flatten().all(|x| x.to_bits() & 0x7f80_0000 != 0x7f80_0000)
}

/// Of all causes only this one was counted, in the tally and in the report.
fn check(name: &str, (rendered, report): &(Rendered, Report), cause: Cause) {
    let found = rendered.tally.non_finite;
    assert!(finite(rendered), "{name}: not finite in the film");
    assert!(found.of(cause) > 0, "{name}: {found:?}");
    assert_eq!(found.total(), found.of(cause), "{name}: {found:?}");
    let json = serde_json::to_value(report).expect("a report is JSON");
    let told = &json["non_finite"];
    assert_eq!(told["total"], found.total(), "{name}: {told}");
    for c in Cause::ALL {
        assert_eq!(told[c.name()], found.of(c), "{name}: {told}");
    }
    assert_eq!(told.as_object().map(|o| o.len()), Some(1 + Cause::ALL.len()), "{told}");
}

/// Jotons of infinite or undefined flux are not stored; the other layers are what they were.
#[test]
fn spoilt_jotons_are_left_out() {
    let whole = spoilt(Side::Host, plan_by_map, |_| ());
    assert_eq!(whole.0.tally.non_finite, NonFinite::default());
    let found = spoilt(Side::Host, plan_by_map, spoil_flux(f32::NAN));
    check("NaN", &found, Cause::Joton);
    let [was, is] = [&whole.0, &found.0].map(|r| &r.picture.layers);
    assert!(was[Layer::Diffuse as usize].pixels.iter().flatten().any(|x| *x > 0.0), "there was light");
    for layer in [Layer::Emission, Layer::Direct, Layer::Caustic] {
        assert_eq!(was[layer as usize], is[layer as usize], "{}", layer.name());
    }
}

/// A pixel that sees such light is black and counted; so is a path, and what a device hands back.
#[test]
fn spoilt_radiance_is_left_out() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let name = format!("{value}");
        check(&name, &spoilt(Side::PathTracer, plan, spoil_radiance(value)), Cause::Path);
        for planner in [plan_by_map as Planner, plan] {
            check(&name, &spoilt(Side::Host, planner, spoil_radiance(value)), Cause::Pixel);
            if crate::common::device().is_some() {
                check(&name, &spoilt(Side::Device, planner, spoil_radiance(value)), Cause::ReadBack);
            }
        }
    }
    if crate::common::device().is_some() {
        check(
            "jotons of the device",
            &spoilt(Side::Device, plan_by_map, spoil_flux(f32::NAN)),
            Cause::ReadBack,
        );
    }
}

/// Counts add up cause by cause.
#[test]
fn counts_add_up() {
    let mut sum = NonFinite::default();
    for (n, cause) in (1..).zip(Cause::ALL) {
        let mut one = NonFinite::default();
        (0..n).for_each(|_| one.count(cause));
        sum += one;
    }
    assert_eq!(Cause::ALL.map(|c| sum.of(c)), [1, 2, 3, 4]);
    assert_eq!(sum.total(), 10);
}
