//! paths/paths.wgsl against the automata of src/film/paths/mod.rs.

use crate::common::{Row, Snippet, path_filter};
use crate::device_or_return;
use joton::backend::gpu::harness::Harness;
use joton::film::paths::{Event, LightPaths};

const FILTER: &str = "@group(0) @binding(0) var<uniform> path_filter: PathFilter;\n";

#[test]
fn steps_and_answers_are_those_of_the_automaton() {
    let context = device_or_return!();
    let inputs: Vec<[Row; 1]> = (0..32u32).flat_map(|q| (0..80u32).map(move |k| [[q, k, 0, 0]])).collect();
    for expression in [
        "L.*E",
        "LE",
        "LS*E",
        "LDE",
        "LS+DE",
        "L.*D.*DE",
        "L(D|S)+SE",
        "LDSD?S*E|LSSE",
        "ES*D(S*D)+S*L",
        "LSSSSDDDDE",
    ] {
        let paths = LightPaths::parse(expression).unwrap_or_else(|e| panic!("{e}"));
        let mut harness = Harness::new(context);
        harness.uniform("path_filter", &path_filter(expression));
        let snippet = Snippet {
            imports: &["paths/paths.wgsl"],
            declarations: FILTER,
            code: "let i = in_u(0u);
                out_u(0u, vec4(path_step(i.x, EVENT_D), path_step(i.x, EVENT_S),
                    select(0u, 1u, path_wanted(i.x, i.y)), PATH_START));",
            overrides: &[],
        };
        let out: Vec<[Row; 1]> = snippet.run_in(context, &mut harness, &[], &inputs);
        for ([i], [o]) in inputs.iter().zip(out) {
            // chains are counted up to 63 on the device
            let wanted = paths.accept_mask_after_specular(i[1].min(63)) >> i[0] & 1;
            let expected =
                [paths.step(i[0], Event::D), paths.step(i[0], Event::S), wanted, LightPaths::START];
            assert_eq!(o, expected, "{expression}: state {}, {} specular events", i[0], i[1]);
        }
    }
}

/// Whole words walked on the device are in the image where the expression says so, by an independent matcher.
#[test]
fn walks_end_where_the_expression_says() {
    let context = device_or_return!();
    // words of up to 8 letters: bit i of x is S
    let inputs: Vec<[Row; 1]> =
        (0..=8u32).flat_map(|n| (0..1u32 << n).map(move |x| [[n, x, 0, 0]])).collect();
    type Rule = fn(&str) -> bool;
    let rules: [(&str, Rule); 5] = [
        ("LE", |w| w.is_empty()),
        ("LS*E", |w| !w.contains('D')),
        ("LS+DE", |w| w.len() > 1 && w.ends_with('D') && w.find('D') == Some(w.len() - 1)),
        ("L.*D.*D.*E", |w| w.matches('D').count() >= 2),
        ("L(D|S)+SE", |w| w.len() >= 2 && w.ends_with('S')),
    ];
    for (expression, rule) in rules {
        let mut harness = Harness::new(context);
        harness.uniform("path_filter", &path_filter(expression));
        let snippet = Snippet {
            imports: &["paths/paths.wgsl"],
            declarations: FILTER,
            code: "let i = in_u(0u); var q = PATH_START; var last_d = 0u;
                for (var k = 0u; k < i.x; k += 1u) {
                    let s = (i.y >> k) & 1u;
                    q = path_step(q, select(EVENT_D, EVENT_S, s == 1u));
                }
                out_u(0u, vec4(q, select(0u, 1u, path_wanted(q, 0u)), 0u, 0u));",
            overrides: &[],
        };
        let out: Vec<[Row; 1]> = snippet.run_in(context, &mut harness, &[], &inputs);
        for ([i], [o]) in inputs.iter().zip(out) {
            let word: String = (0..i[0]).map(|k| if i[1] >> k & 1 == 1 { 'S' } else { 'D' }).collect();
            assert_eq!(o[1] == 1, rule(&word), "{expression}: L{word}E");
        }
    }
}
