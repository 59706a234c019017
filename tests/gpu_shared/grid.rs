//! shared/grid.wgsl and shared/index.wgsl against Rust.

use crate::common::{Row, Snippet, floats, random, row3};
use crate::device_or_return;
use glam::Vec3;
use joton::layout::row_bucket;

#[test]
fn cells_rows_and_columns_are_rusts() {
    let context = device_or_return!();
    let cells = [1.0f32, 0.125, 3.7, 1.0 / 7.0, 64.0];
    let origin = Vec3::new(-512.0, -300.25, 17.0);
    let mut inputs: Vec<[Row; 2]> = Vec::new();
    for (c, &per_unit) in cells.iter().enumerate() {
        for i in 0..800 {
            let [x, y, z, _] = random(20, i + 1000 * c);
            let mut p = origin + (Vec3::new(x, y, z) * 1.2 - 0.1) * 1000.0;
            if i % 4 == 0 {
                // corners of cells exactly, and on either side of the origin
                p = origin + ((p - origin) * per_unit).round() / per_unit;
            }
            inputs.push([row3(p, per_unit), [(1 << (10 + i % 14)) - 1, (i % 300 + 1) as u32, 0, 0]]);
        }
    }
    let code = "let p = in_f(0u); let c = cell_of(p.xyz, vec3(-512.0, -300.25, 17.0), p.w);
        out_u(0u, vec4(bitcast<vec3<u32>>(c), row_bucket(c.y, c.z, in_u(1u).x)));
        out_u(1u, vec4(column(c.x, in_u(1u).y), 0u, 0u, 0u));";
    let out: Vec<[Row; 2]> = Snippet::new(&["shared/grid.wgsl"], code).run(context, &inputs);
    let mut outside = 0;
    for ([p, t], [cell, column]) in inputs.iter().zip(out) {
        let [x, y, z, per_unit] = floats(*p);
        let wanted = ((Vec3::new(x, y, z) - origin) * per_unit).floor().as_ivec3();
        let got = [cell[0], cell[1], cell[2]].map(|c| c as i32);
        // one product more or less is rounded before floor where the compiler fuses: a neighbour at an exact corner
        let scaled = (Vec3::new(x, y, z) - origin) * per_unit;
        for (k, (g, w)) in got.iter().zip(wanted.to_array()).enumerate() {
            let s = scaled.to_array()[k];
            let at_corner = (s - s.round()).abs() < 4e-7 * s.abs().max(1.0);
            assert!(
                *g == w || (at_corner && (g - w).abs() == 1),
                "component {k} of {scaled}: {g} against {w}"
            );
        }
        assert_eq!(cell[3], row_bucket(got[1], got[2], t[0]), "row {got:?}, mask {:x}", t[0]);
        assert_eq!(column[0], got[0].clamp(0, t[1] as i32 - 1) as u32);
        outside += usize::from(got[0] < 0 || got[0] >= t[1] as i32);
    }
    assert!(outside > 100, "columns outside the row were met {outside} times");
}

/// Past 65,535 workgroups dispatches are folded into two dimensions: every number comes up exactly once, in its place.
#[test]
fn numbers_past_65535_workgroups_are_all_there() {
    let context = device_or_return!();
    for groups in [1u32, 65_535, 65_536, 131_072] {
        let count = groups * 64 - 13;
        let text = format!(
            "// import: shared/index.wgsl\n\
             @group(0) @binding(0) var<storage, read_write> marks: array<u32>;\n\
             @compute @workgroup_size(64)\n\
             fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{\n\
             let i = linear_index(id, groups); if i >= {count}u {{ return; }} marks[i] += i + 1u; }}\n"
        );
        let linked = joton::gpu::link_source(&text).unwrap_or_else(|e| panic!("{e}"));
        let kernel = joton::gpu::Kernel::from_source(context, "marks", &linked, "main", &[])
            .unwrap_or_else(|e| panic!("{e}"));
        let mut harness = joton::gpu::harness::Harness::new(context);
        harness.storage("marks", &vec![0u32; count as usize]);
        harness
            .run(&kernel, &[], &[], joton::gpu::harness::Work::Invocations(count))
            .unwrap_or_else(|e| panic!("{e}"));
        let marks: Vec<u32> = harness.read("marks").unwrap_or_else(|e| panic!("{e}"));
        let wrong = marks.iter().zip(1u32..).position(|(&m, i)| m != i);
        assert_eq!(wrong, None, "{groups} workgroups: {:?}", wrong.map(|w| marks[w]));
    }
}

/// Half the width of a sphere within a row of cells: against the geometry in f64, and never too small for any point of the
/// sphere in that row.
#[test]
fn a_sphere_reaches_no_further_than_said() {
    let context = device_or_return!();
    let origin = Vec3::new(-512.0, -300.25, 17.0);
    let mut inputs: Vec<[Row; 2]> = Vec::new();
    for i in 0..4000 {
        let [x, y, z, s] = random(21, i);
        let cell = 0.5 + 20.0 * s;
        let r = cell * [1.0, 0.3, 0.9][i % 3];
        let p = origin + Vec3::new(x, y, z) * 500.0;
        let at = ((p - origin) / cell).floor().as_ivec3();
        let (dy, dz) = ((i / 3 % 3) as i32 - 1, (i / 9 % 3) as i32 - 1);
        inputs.push([row3(p, r), [(at.y + dy) as u32, (at.z + dz) as u32, cell.to_bits(), 0]]);
    }
    let code = "let p = in_f(0u); let t = in_u(1u);
        out_f(0u, vec4(reach_in_row(p.xyz, p.w * p.w, bitcast<i32>(t.x), bitcast<i32>(t.y),
            vec3(-512.0, -300.25, 17.0), bitcast<f32>(t.z)), 0.0, 0.0, 0.0));";
    let out: Vec<[Row; 1]> = Snippet::new(&["shared/grid.wgsl"], code).run(context, &inputs);
    let (mut reached, mut missed) = (0, 0);
    for ([p, t], [o]) in inputs.iter().zip(out) {
        let [_, y, z, r] = floats(*p).map(f64::from);
        let cell = f64::from(f32::from_bits(t[2]));
        let off = |value: f64, index: u32, origin: f32| {
            let low = f64::from(origin) + f64::from(index as i32) * cell;
            (low - value).max(value - low - cell).max(0.0)
        };
        let (oy, oz) = (off(y, t[0], origin.y), off(z, t[1], origin.z));
        let left = r * r - oy * oy - oz * oz;
        let got = f64::from(floats(o)[0]);
        // coordinates up to 512 are rounded to 6e-5
        let slack = 4e-4 * r;
        if left < -slack {
            missed += 1;
            assert!(got < 0.0, "{left}: {got}");
        } else if left > slack {
            reached += 1;
            assert!((got * got - left).abs() < slack, "{} against {got}", left.sqrt());
        }
    }
    assert!(reached > 1000 && missed > 500, "{reached} rows reached, {missed} missed");
}
