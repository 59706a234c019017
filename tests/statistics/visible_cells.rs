//! Visible cells [E23]: whatever cells are marked, the image is the same; and few jotons are stored out of view.

use crate::chi_square::Claims;
use crate::renders::{EVERYTHING, Side, file, layer, pictures_of, plan_by_map, run};
use joton::film::Layer;
use joton::film::stats::{Estimate, test_equal};
use joton::packed::{PackedScene, VisibleCells};
use std::sync::Arc;

/// Cells on one half of the box only: jotons of the other half are stored one in eight, and count as eight.
#[test]
fn jotons_out_of_marks_count_for_all() {
    const SIZE: u32 = 24;
    let scene = Arc::new(PackedScene::new(&file("cornell.toml", SIZE)));
    let [low, high] = scene.bounds;
    let width = 0.1 * (high.x - low.x);
    // three cells about a column of points
    let points = (0..40)
        .map(|i| low + (high - low) * glam::Vec3::new(0.25, (i % 8) as f32 / 8.0, (i / 8) as f32 / 5.0));
    let visible_cells = Arc::new(VisibleCells::new(low, width, points));
    let mut claims = Claims::default();
    for side in [Side::Host, Side::Device] {
        if side == Side::Device && crate::common::device().is_none() {
            continue;
        }
        let renders = |visible_cells: Option<&Arc<VisibleCells>>, first: u32| {
            let p = pictures_of(plan_by_map, side, &scene, EVERYTHING, first..first + 8, 4, |plan| {
                plan.visible_cells = visible_cells.cloned()
            });
            layer(&p, Layer::Diffuse)
        };
        let (plain, marked) = (renders(None, 0), renders(Some(&visible_cells), 20));
        for block in [4, SIZE] {
            let [a, b] =
                [&plain, &marked].map(|i| Estimate::from_renders(i, block).unwrap_or_else(|e| panic!("{e}")));
            let outcome = test_equal(&a, &b).unwrap_or_else(|e| panic!("{e}"));
            claims.add(format!("{side:?}, blocks of {block}"), outcome.p_value);
        }
    }
    claims.hold();
}

/// Of ten rooms one is in view: more than half of the jotons are not stored, and both backends leave out as many.
#[test]
fn jotons_out_of_view_are_not_stored() {
    let scene = Arc::new(PackedScene::new(&file("rooms.toml", 32)));
    assert!(plan_by_map(&scene, EVERYTHING, 0).visible_cells.is_some());
    let share = |side| {
        let t = run(side, &scene, plan_by_map(&scene, EVERYTHING, 0), 4).tally;
        t.jotons_not_stored as f64 / (t.jotons_not_stored + t.jotons_stored) as f64
    };
    let host = share(Side::Host);
    assert!(host > 0.5 && host < 0.9, "{host}");
    if crate::common::device().is_some() {
        let device = share(Side::Device);
        // some 40,000 jotons: 0.005 is twice the spread of a part of them
        assert!((host - device).abs() < 0.01, "{host} {device}");
    }
}
