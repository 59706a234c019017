//! maps/grid.wgsl and dispatch/index.wgsl against Rust.

use crate::common::{Row, Snippet, floats, random, row3};
use crate::device_or_return;
use glam::Vec3;
use joton::packed::constants::row_bucket;

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
    let out: Vec<[Row; 2]> = Snippet::new(&["maps/grid.wgsl"], code).run(context, &inputs);
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
            "// import: dispatch/index.wgsl\n\
             @group(0) @binding(0) var<storage, read_write> marks: array<u32>;\n\
             @compute @workgroup_size(64)\n\
             fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{\n\
             let i = linear_index(id, groups); if i >= {count}u {{ return; }} marks[i] += i + 1u; }}\n"
        );
        let linked = joton::backend::gpu::link_source(&text, joton::backend::gpu::Variant::default())
            .unwrap_or_else(|e| panic!("{e}"));
        let kernel = joton::backend::gpu::Kernel::from_source(context, "marks", &linked, "main", &[])
            .unwrap_or_else(|e| panic!("{e}"));
        let mut harness = joton::backend::gpu::harness::Harness::new(context);
        harness.storage("marks", &vec![0u32; count as usize]);
        harness
            .run(&kernel, &[], &[], joton::backend::gpu::harness::Work::Invocations(count))
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
    let out: Vec<[Row; 1]> = Snippet::new(&["maps/grid.wgsl"], code).run(context, &inputs);
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

/// Each pixel of an image comes up once, in the tile of its workgroup, neighbours beside each other; none beyond it.
#[test]
fn tiles_cover_an_image_once() {
    let context = device_or_return!();
    for size in [[1u32, 1], [8, 8], [17, 5], [40, 23], [7, 64]] {
        let [width, height] = size;
        let count = (width.div_ceil(8) * height.div_ceil(8) * 64) as usize;
        let code = format!("out_u(0u, vec4(tiled_pixel(number, {width}u, {height}u), 0u, 0u, 0u));");
        let out: Vec<[Row; 1]> = Snippet::new(&[], &code).run(context, &vec![[[0; 4]]; count]);
        let mut seen = vec![0; (width * height) as usize];
        for (i, [o]) in out.iter().enumerate().filter(|(_, [o])| o[0] != u32::MAX) {
            seen[o[0] as usize] += 1;
            let ([x, y], tile) = ([o[0] % width, o[0] / width], i as u32 / 64);
            assert_eq!(x / 8 + y / 8 * width.div_ceil(8), tile, "{x} {y}");
            // two lanes are two pixels across, four a square
            let first = out[i / 4 * 4][0][0];
            assert!(x - first % width < 2 && y - first / width < 2, "{x} {y} is with {first}");
        }
        assert!(seen.iter().all(|&n| n == 1), "{size:?}: {seen:?}");
    }
}

/// The runs of buckets of the rows that a sphere touches hold every cell that it reaches, once, and no cell twice; a row has
/// the same bit for every sphere.
#[test]
fn runs_are_the_rows_that_a_sphere_reaches() {
    let context = device_or_return!();
    let origin = Vec3::new(-512.0, -300.25, 17.0);
    const MASK: u32 = (1 << 14) - 1;
    const COLUMNS: u32 = 100;
    let mut inputs: Vec<[Row; 1]> = Vec::new();
    for i in 0..3000 {
        let [x, y, z, s] = random(22, i);
        // rounded to cells now and then: a sphere that just touches the next
        let p = Vec3::new(x, y, z) * 90.0;
        let p = if i % 5 == 0 { p.round() } else { p };
        inputs.push([row3(origin + p, [1.0, 0.999, 0.3 + 0.7 * s][i % 3])]);
    }
    let runs = (0..16).map(|k| format!("if ((rows >> {k}u) & 1u) == 1u {{ let r = row_run(g, p.xyz, p.w, {k}u); out_u({k}u, vec4(r, 1u, rows)); }} else {{ out_u({k}u, vec4(0u, 0u, 0u, rows)); }}"));
    let code = format!(
        "let p = in_f(0u); let g = Grid(vec3(-512.0, -300.25, 17.0), 1.0, {MASK}u, {COLUMNS}u);
         let rows = rows_touched(g, p.xyz, p.w); {}",
        runs.collect::<String>()
    );
    let out: Vec<[Row; 16]> = Snippet::new(&["maps/grid.wgsl"], &code).run(context, &inputs);
    let mut most = 0;
    for ([input], runs) in inputs.iter().zip(&out) {
        let [x, y, z, r] = floats(*input);
        let p = Vec3::new(x, y, z) - origin;
        let (lowest, highest) = ((p - r).floor().as_ivec3(), (p + r).floor().as_ivec3());
        let mut wanted: Vec<u32> = Vec::new();
        for (cy, cz) in (lowest.y..=highest.y).flat_map(|y| (lowest.z..=highest.z).map(move |z| (y, z))) {
            let off = |v: f32, c: i32| (c as f32 - v).max(v - c as f32 - 1.0).max(0.0);
            let left = r * r - off(p.y, cy).powi(2) - off(p.z, cz).powi(2);
            let bit = (cy & 3) + 4 * (cz & 3);
            let [start, end, visited, _] = runs[bit as usize];
            assert_eq!(visited, 1, "row {cy} {cz} of {p} {r} has no bit");
            // cells that the sphere reaches by more than rounding
            if left > 1e-3 {
                let reach = left.sqrt() - 1e-3;
                let row = row_bucket(cy, cz, MASK);
                for c in ((p.x - reach).floor() as i32)..=((p.x + reach).floor() as i32) {
                    let bucket = row + c.clamp(0, COLUMNS as i32 - 1) as u32;
                    assert!((start..end).contains(&bucket), "{bucket} not in {start}..{end} of {p} {r}");
                }
            }
            wanted.extend(start..end);
        }
        let visited: Vec<u32> = runs.iter().flat_map(|r| r[0]..r[1]).collect();
        assert_eq!(visited.len(), wanted.len(), "rows that are not its own at {p} {r}");
        let distinct: std::collections::BTreeSet<u32> = visited.iter().copied().collect();
        assert_eq!(distinct.len(), visited.len(), "a bucket twice at {p} {r}");
        most = most.max(runs.iter().filter(|r| r[2] == 1).count());
    }
    assert!(most >= 9, "{most} rows at most");
}
