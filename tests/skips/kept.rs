//! Keeping what is skipped costs time and changes nothing.

use crate::common::twins::{self, Case, EVERYTHING, WIDE, file};
use crate::renders::{SCENES, Side, bits, both, is_alike, plan, run, unresolved};
use joton::film::{Layer, Picture};
use joton::packed::PackedScene;
use joton::plan::{Part, Plan, Reason};
use std::sync::Arc;

const SIZE: u32 = 24;

/// Parts whose skipping changes which random numbers are drawn for what: images are equal in the mean. Skipping any other
/// leaves out what adds nothing: images are equal bit by bit.
const STATISTICAL: [Part; 6] =
    [Part::OutOfReach, Part::FaintLight, Part::UnseenLight, Part::UnseenJotons, Part::Background, Part::Rest];

/// Whether skipping a part for this reason changes random numbers.
fn is_statistical(part: Part, why: Reason) -> bool {
    STATISTICAL.contains(&part) || why == Reason::PathsServe
}

/// The plans of a case as it is, and with a part kept.
fn plans(scene: &PackedScene, case: &Case, part: Part) -> [Plan; 2] {
    [&[][..], &[part]].map(|keep| plan(scene, case.paths, 1, &[case.keep, keep].concat()))
}

/// Of these scenes each part that is skipped is kept alone, too.
const ALONE: [&str; 2] = ["cornell", "pedestal"];

/// Every scene with everything that it does not need, on both sides; some on the host with each part of that alone, which on
/// the device the twins do.
#[test]
fn whatever_is_kept_renders() {
    for name in SCENES {
        let scene = Arc::new(PackedScene::new(&file(name, SIZE)));
        for side in both() {
            let all = plan(&scene, EVERYTHING, 1, &Part::ALL);
            assert!(all.skipped.is_empty(), "{name}: {:?}", all.skipped);
            run(side, &scene, all, 1);
        }
        if !ALONE.contains(&name) {
            continue;
        }
        for skip in &plan(&scene, EVERYTHING, 1, &[]).skipped {
            let kept = plan(&scene, EVERYTHING, 1, &[skip.what]);
            assert!(kept.skipped.iter().all(|s| s.what != skip.what), "{name}, {skip:?}: {:?}", kept.skipped);
            run(Side::Host, &scene, kept, 1);
        }
    }
}

/// Sums of f32 in another order: the host takes jotons one by one where it looks at their paths.
const ROUNDING: f32 = 1e-5;

/// Where nothing of its own is drawn for a part, keeping it leaves every bit as it is: on the device all that is kept is more
/// code; on the host it is the order of a sum, too.
#[test]
fn what_adds_nothing_changes_no_bit() {
    for t in twins::all(SIZE).iter().filter(|t| !is_statistical(t.part, t.why)) {
        let scene = Arc::new(PackedScene::new(&t.without.scene));
        for side in both() {
            let plans = plans(&scene, &t.without, t.part);
            assert!(is_more(&plans), "{:?}: keeping it does nothing", t.part);
            let [skipped, kept] =
                plans.map(|plan| bits(&run(side, &scene, plan, 1).picture).into_flattened());
            let near = |a: u32, b: u32| {
                let [a, b] = [a, b].map(f32::from_bits);
                (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
            };
            let reordered = side == Side::Host && t.part == Part::PathFilter;
            let differ = |(a, b): &(&u32, &u32)| a != b && !(reordered && near(**a, **b));
            let different = skipped.iter().zip(&kept).filter(differ).count();
            assert_eq!(different, 0, "{:?}, {side:?}: {}", t.part, t.without.name);
        }
    }
}

/// True where the second plan does more than the first.
fn is_more([skipped, kept]: &[Plan; 2]) -> bool {
    // what is kept of learned directions is code alone, which the kernels' names of files do not tell
    kept.settings.keeps(Part::Warps)
        || (skipped.layers, skipped.features, skipped.settings.shadow_rays)
            != (kept.layers, kept.features, kept.settings.shadow_rays)
}

/// A plan without one of the parts that same bits are claimed of, though the scene may need it; none where there is no way.
fn deprived(mut plan: Plan, part: Part) -> Option<Plan> {
    let (layers, features) = (&mut plan.layers, &mut plan.features);
    let needed = match part {
        Part::Emission => &mut layers[Layer::Emission as usize],
        Part::DirectLight => &mut layers[Layer::Direct as usize],
        Part::CausticMap => &mut layers[Layer::Caustic as usize],
        Part::DiffuseMap => &mut layers[Layer::Diffuse as usize],
        Part::Mirrors => &mut features.specular,
        Part::Refraction => &mut features.dielectric,
        Part::Textures => &mut features.textures,
        Part::CutOuts => &mut features.cutouts,
        Part::Media => &mut features.media,
        Part::Dispersion => &mut features.dispersion,
        Part::GlossyLobes => &mut features.glossy,
        Part::Translucency => &mut features.translucent,
        Part::FacetTextures => &mut features.facet_textures,
        Part::Relief => &mut features.relief,
        Part::Glow => &mut features.glow,
        Part::Microfacets => &mut features.facets,
        Part::Anisotropy => &mut features.anisotropy,
        Part::Layers => &mut features.layers,
        Part::Mixtures => &mut features.mixtures,
        Part::ShadingNormals => &mut features.smooth_normals,
        Part::DeltaLights => &mut features.delta_lights,
        Part::Contacts => &mut features.contacts,
        Part::PathFilter => &mut features.path_filter,
        _ => return None,
    };
    assert!(std::mem::take(needed), "{part:?} is needed");
    Some(plan)
}

/// Same bits are a claim that can fail: where a scene needs a part, leaving it out changes the image. Layers on both sides, code
/// on the device, which alone leaves it out.
#[test]
fn leaving_out_what_is_needed_changes_the_image() {
    let mut done: Vec<Part> = Vec::new();
    for t in twins::all(SIZE) {
        let scene = Arc::new(PackedScene::new(&t.with.scene));
        let own = plan(&scene, t.with.paths, 1, t.with.keep);
        let Some(less) = deprived(own.clone(), t.part).filter(|_| !done.contains(&t.part)) else { continue };
        done.push(t.part);
        let is_layer = own.layers != less.layers;
        for side in both().into_iter().filter(|&side| is_layer || side == Side::Device) {
            let [own, less] = [&own, &less].map(|plan| bits(&run(side, &scene, plan.clone(), 1).picture));
            assert!(own != less, "{:?}, {side:?}: {}", t.part, t.with.name);
        }
    }
    assert_eq!(done.len(), 23, "{done:?}");
}

/// What is not skipped cannot be kept: where a scene needs a part, `--no-skip` leaves plan and image as they are.
#[test]
fn what_is_needed_costs_nothing() {
    for t in twins::all(SIZE) {
        let scene = Arc::new(PackedScene::new(&t.with.scene));
        let [own, kept] = plans(&scene, &t.with, t.part);
        assert_eq!(own.skipped, kept.skipped, "{:?}: {}", t.part, t.with.name);
        assert_eq!(own.features, kept.features, "{:?}: {}", t.part, t.with.name);
        let [own, kept] = [own, kept].map(|plan| {
            let rendered = run(Side::Host, &scene, plan, 1);
            (rendered.tally, bits(&rendered.picture))
        });
        assert!(own == kept, "{:?}: {}", t.part, t.with.name);
    }
}

/// Part of the plan's diffuse radius at which bias is below the noise, where skips change how many jotons there are, and so
/// the radius.
const NARROW: f64 = 0.3;

/// Skips that change random numbers or their number change nothing in the mean: eighths of the image and the whole, each
/// layer, seeds that are not the same. Of the others reach.rs and picks.rs, and elsewhere the tests of marks and of rest, say so.
#[test]
fn what_changes_numbers_keeps_the_mean() {
    // the diffuse map is what most of them are about
    let (by_map, by_paths) = (&[Part::DiffuseMap][..], &[][..]);
    // side, scene, pixels across, what is kept in both, parts, renders of each kind
    let cases = [
        (Side::Host, "rooms", SIZE, by_map, &[Part::UnseenLight][..], 12),
        (Side::Host, "pedestal", WIDE, by_map, &[Part::Background], 6),
        (Side::Device, "pedestal", SIZE, by_map, &[Part::UnseenLight], 4),
        (Side::Host, "pedestal", SIZE, by_paths, &[Part::DiffuseMap], 12),
        (Side::Device, "cornell", SIZE, by_paths, &[Part::DiffuseMap], 6),
    ];
    for (side, name, size, always, parts, seeds) in cases.into_iter().filter(|c| both().contains(&c.0)) {
        let scene = Arc::new(PackedScene::new(&file(name, size)));
        let plans =
            [&[][..], parts].map(|keep| unresolved(plan(&scene, EVERYTHING, 0, &[always, keep].concat())));
        let [own, kept] = plans.each_ref();
        assert!(
            parts.iter().all(|part| own.skipped.iter().any(|s| s.what == *part)),
            "{name}: {:?}",
            own.skipped
        );
        assert!(
            own.diffuse_jotons != kept.diffuse_jotons || own.guides.diffuse != kept.guides.diffuse,
            "{name}: nothing differs"
        );
        let narrow = if own.diffuse_jotons == kept.diffuse_jotons { 1.0 } else { NARROW };
        let mut first = 0;
        let [skipped, kept] = plans.map(|mut plan| {
            plan.diffuse.base *= narrow;
            first += seeds;
            // what was learned is the same for all seeds: it is no part of the noise
            let render = |seed| {
                let mut plan = plan.clone();
                plan.settings.seed = seed;
                run(side, &scene, plan, 1).picture
            };
            (first..first + seeds).map(render).collect::<Vec<Picture>>()
        });
        is_alike(&format!("{parts:?}, {side:?}, {name}"), &skipped, &kept, &[size / 8, size]);
    }
}
