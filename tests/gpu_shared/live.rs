//! Live tiles: their pixels and the indices that they use, against the host's.

use crate::common::{Row, Snippet, pass_info};
use crate::device_or_return;
use joton::backend::gpu::harness::Harness;
use joton::film::tile_schedule::TileSchedule;

/// The list holds every pixel of the image once, those that rest least first; indices are those of the host.
#[test]
fn live_pixels_and_indices_are_the_hosts() {
    let context = device_or_return!();
    let size = [20, 12];
    let schedule = TileSchedule::new(size, vec![3, 0, 1, 4, 0, 2]);
    for pass_index in [0u32, 1, 5, 16, 32, 80, 1000, joton::packed::constants::PILOT_PASS] {
        let mut pass = pass_info();
        pass.set_image(size);
        pass.pass_index = pass_index;
        let mut harness = Harness::new(context);
        harness.set_tile_schedule(&schedule);
        let snippet = Snippet {
            imports: &["camera/live.wgsl"],
            declarations: "@group(0) @binding(0) var<uniform> pass_info: PassInfo;",
            code: "out_u(0u, vec4(live_pixel(number), sequence_index(number), 0u, 0u));",
            overrides: &[],
        };
        let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
        let lanes = schedule.exponents().len() * 64;
        let out: Vec<[Row; 1]> = snippet.run_in(context, &mut harness, &at, &vec![[[0; 4]]; lanes]);
        let mut seen = vec![0; 20 * 12];
        let mut exponents = Vec::new();
        for [o] in out.iter().filter(|[o]| o[0] != u32::MAX) {
            seen[o[0] as usize] += 1;
            let tile = (o[0] / 20 / 8 * 3 + o[0] % 20 / 8) as usize;
            exponents.push(schedule.exponents()[tile]);
            if schedule.is_live(tile, u64::from(pass_index)) {
                assert_eq!(
                    o[1],
                    schedule.sequence_index(tile, pass_index),
                    "tile {tile} in pass {pass_index}"
                );
            }
        }
        assert!(seen.iter().all(|n| *n == 1), "{seen:?}");
        assert!(exponents.is_sorted(), "{exponents:?}");
    }
}
