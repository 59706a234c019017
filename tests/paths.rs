//! Light path expressions, against a matcher that shares nothing with the library but the notation.

use joton::film::paths::{DEAD, Event, LIVE_STATES_MAX, LightPaths, STATES_MAX};
use joton::film::{LAYERS, Layer};
use std::collections::BTreeSet;

/// Longest event string that is tried: 511 strings tell apart everything that these expressions can say.
const LENGTH_MAX: usize = 8;

/// Tried in light order as they stand, and in eye order as [`from_the_eye`] writes them.
const EXPRESSIONS: [&str; 22] = [
    "LE",
    "LDE",
    "LSE",
    "LS+DE",
    "L(S|D)E",
    "LD+E",
    "L(D|S)+SE",
    "L.*E",
    "L.E",
    "LD?S?E",
    "L(DS)*E",
    "L(D|SS)*E",
    "L.*D.E",
    "LS*DS*E",
    "L((D|S)S)+E",
    "L(D?S)*DE",
    "L(D*|S*)E",
    "L(D*S*)*E",
    "L(D+)?E",
    "L(S|D).*SD.SE",
    "LDE|LSSE",
    " L ( S | D ) + E ",
];

/// Every string over D and S up to the given length.
fn strings(length: usize) -> Vec<String> {
    let mut all = vec![String::new()];
    let mut from = 0;
    for _ in 0..length {
        let to = all.len();
        for i in from..to {
            all.extend(["D", "S"].map(|letter| all[i].clone() + letter));
        }
        from = to;
    }
    all
}

/// The ends of all matches of the alternatives at `*at` in the pattern, each begun at one of `starts` of the text.
/// Leaves `*at` at ")" or at the end.
fn ends(pattern: &[u8], at: &mut usize, text: &[u8], starts: &BTreeSet<usize>) -> BTreeSet<usize> {
    let mut all = BTreeSet::new();
    loop {
        let mut now = starts.clone();
        while *at < pattern.len() && !b"|)".contains(&pattern[*at]) {
            let atom = *at;
            let once = |starts: &BTreeSet<usize>, at: &mut usize| -> BTreeSet<usize> {
                *at = atom + 1;
                if pattern[atom] == b'(' {
                    let found = ends(pattern, at, text, starts);
                    *at += 1;
                    return found;
                }
                let fits = |i: &&usize| {
                    text.get(**i)
                        .is_some_and(|c| *c == pattern[atom] || pattern[atom] == b'.' && b"DS".contains(c))
                };
                starts.iter().filter(fits).map(|i| i + 1).collect()
            };
            let mut reached = once(&now, at);
            if let Some(&quantifier @ (b'*' | b'+' | b'?')) = pattern.get(*at) {
                let after = *at + 1;
                let mut fresh = reached.clone();
                while quantifier != b'?' && !fresh.is_empty() {
                    fresh = &once(&fresh, at) - &reached;
                    reached.extend(&fresh);
                }
                if quantifier != b'+' {
                    reached.extend(&now);
                }
                *at = after;
            }
            now = reached;
        }
        all.extend(now);
        if pattern.get(*at) != Some(&b'|') {
            return all;
        }
        *at += 1;
    }
}

/// Whether the whole of `text` ("LDSE") matches.
fn matches_plainly(pattern: &str, text: &str) -> bool {
    let pattern = pattern.replace(' ', "");
    ends(pattern.as_bytes(), &mut 0, text.as_bytes(), &BTreeSet::from([0])).contains(&text.len())
}

fn parse(expression: &str) -> LightPaths {
    LightPaths::parse(expression).unwrap_or_else(|e| panic!("{e}"))
}

/// The expression written from the eye: atoms in reverse order, each with its quantifier behind it.
fn from_the_eye(expression: &str) -> String {
    fn alternatives(p: &[u8], at: &mut usize) -> String {
        let (mut done, mut sequence) = (Vec::new(), String::new());
        while *at < p.len() && p[*at] != b')' {
            let mut atom = (p[*at] as char).to_string();
            *at += 1;
            if atom == "|" {
                done.push(std::mem::take(&mut sequence));
                continue;
            }
            if atom == "(" {
                atom = format!("({})", alternatives(p, at));
                *at += 1;
            }
            while *at < p.len() && b"*+?".contains(&p[*at]) {
                atom.push(p[*at] as char);
                *at += 1;
            }
            sequence = atom + &sequence;
        }
        done.push(sequence);
        done.join("|")
    }
    alternatives(expression.replace(' ', "").as_bytes(), &mut 0)
}

/// The automaton accepts exactly the strings that plain matching accepts, up to eight vertices, read from
/// either end.
#[test]
fn automaton_agrees_with_plain_matching() {
    for expression in EXPRESSIONS {
        let (light, eye) = (parse(expression), parse(&from_the_eye(expression)));
        assert_eq!(light, eye, "{expression} and {}", from_the_eye(expression));
        for events in strings(LENGTH_MAX) {
            let expected = matches_plainly(expression, &format!("L{events}E"));
            assert_eq!(light.matches(&events), expected, "{expression} on L{events}E");
        }
    }
}

/// The matcher of these tests can say no, and is right on known cases.
#[test]
fn plain_matcher_knows_right_from_wrong() {
    for (pattern, text, expected) in [
        ("LS+DE", "LSSDE", true),
        ("LS+DE", "LDE", false),
        ("L(DS)*E", "LDSDSE", true),
        ("L(DS)*E", "LDSDE", false),
        ("LDE|LSE", "LSE", true),
        ("L(S|D)?E", "LSDE", false),
    ] {
        assert_eq!(matches_plainly(pattern, text), expected, "{pattern} {text}");
    }
}

/// An asymmetric expression differs from its mirror image: eye order is not light order.
#[test]
fn eye_order_is_the_reverse() {
    let caustics = parse("LS+DE");
    assert!(caustics.matches("SD") && !caustics.matches("DS"));
    assert_eq!(caustics, parse("EDS+L"));
    assert_ne!(caustics, parse("ES+DL"));
    assert_eq!(parse("LDE|LSDE"), parse("EDL|EDSL"));
    assert_eq!(parse("LDE|EDSL"), parse("LS?DE"));
}

/// Automata are minimal: known counts of live states, and equal languages give equal automata.
#[test]
fn automata_are_minimal() {
    for (expression, states) in
        [("LE", 1), ("LDE", 2), ("L.*E", 1), ("LS*DS*E", 2), ("LS+DE", 3), ("L(D|SS)*E", 2), ("L.*D..E", 8)]
    {
        assert_eq!(parse(expression).states(), states, "{expression}");
    }
    assert_eq!(parse("L(D|S)*E"), parse("L(D*S*)*E"));
    assert_eq!(parse("LDD*E"), parse("LD+E"));
    assert_ne!(parse("LD*E"), parse("LD+E"));
}

/// Only what leaves nothing out is everything, however it is spelt.
#[test]
fn everything_is_recognised() {
    assert!(LightPaths::everything().is_everything());
    assert!(parse("E(D*S*)+L").is_everything());
    assert!(parse("LE|L.+E").is_everything());
    for partial in ["L.+E", "LE", "LD*E", "L.*DE", "L(..)*E"] {
        assert!(!parse(partial).is_everything(), "{partial}");
    }
}

/// The device's table is the automaton: rows beyond the live states, and the dead one, lead to the dead state.
#[test]
fn table_holds_the_automaton() {
    for expression in EXPRESSIONS {
        let paths = parse(expression);
        let table = paths.transitions();
        assert_eq!(table.len(), STATES_MAX);
        for (q, row) in table.iter().enumerate() {
            for event in Event::ALL {
                let target = row[event as usize];
                assert_eq!(target, paths.step(q as u32, event));
                assert!(target < paths.states() || target == DEAD, "{expression} {q} {event:?}");
                assert!((q as u32) < paths.states() || target == DEAD, "{expression} {q} {event:?}");
            }
        }
    }
}

/// The mask after k mirrors says for each reachable state what the whole string with S^k appended says.
#[test]
fn mask_after_specular_is_the_string_with_s_appended() {
    for expression in EXPRESSIONS {
        let paths = parse(expression);
        for k in (0..70).chain([1000, 1001]) {
            let mask = paths.accept_mask_after_specular(k);
            assert_eq!(mask >> DEAD, 0, "nothing dead is accepted");
            for events in strings(5) {
                let state = events.chars().fold(LightPaths::START, |q, letter| {
                    paths.step(q, if letter == 'D' { Event::D } else { Event::S })
                });
                let whole = events.clone() + &"S".repeat(k as usize);
                assert_eq!((mask >> state) & 1 == 1, paths.matches(&whole), "{expression} {events} S^{k}");
            }
        }
    }
    // A counter modulo three stays exact where a cap would not.
    let thirds = parse("L(SSS)*E");
    assert_eq!(thirds.accept_mask_after_specular(u32::MAX) & 1, 1, "2^32 − 1 is a multiple of three");
    assert_eq!(thirds.accept_mask_after_specular(u32::MAX - 1) & 1, 0);
}

/// The layer of a path, told by counting letters.
fn layer_of(events: &str) -> Layer {
    match (events.matches('D').count(), events.starts_with('S')) {
        (0, _) => Layer::Emission,
        (1, false) => Layer::Direct,
        (1, true) => Layer::Caustic,
        _ => Layer::Diffuse,
    }
}

/// A layer is possible exactly where some string of it is accepted.
#[test]
fn layers_are_those_of_the_accepted_strings() {
    for expression in EXPRESSIONS {
        let paths = parse(expression);
        let mut expected = [false; LAYERS];
        for events in strings(LENGTH_MAX).iter().filter(|events| paths.matches(events)) {
            expected[layer_of(events) as usize] = true;
        }
        assert_eq!(paths.layers(), expected, "{expression}");
    }
    assert_eq!(parse("LS+DS*E").layers(), [false, false, true, false]);
    assert_eq!(parse("LD(SSSSSSSSSSSS)+DE").layers(), [false, false, false, true], "longer than any sample");
}

/// Text comes back as written.
#[test]
fn display_gives_the_expression() {
    assert_eq!(parse(" L(S|D)+E ").to_string(), "L(S|D)+E");
    assert_eq!(LightPaths::everything().to_string(), "L.*E");
}

/// Each wrong expression is refused with its column and with what to do.
#[test]
fn errors_name_column_and_remedy() {
    for (expression, column, remedy) in [
        ("", 1, "L … E"),
        ("   ", 4, "L … E"),
        ("DE", 1, "L … E"),
        ("LD", 3, "L … E"),
        ("L", 2, "L … E"),
        ("LDL", 3, "once each"),
        ("LDED", 4, "\"|\""),
        ("LDE+", 4, "\"|\""),
        ("L*DE", 2, "L and E occur once"),
        ("LD|SE", 3, "L … E"),
        ("LDE|", 5, "L … E"),
        ("L(DE", 4, "outside groups"),
        ("L(D", 2, "add \")\""),
        ("LD)E", 3, "open a group"),
        ("L()E", 3, "optional"),
        ("L(D|)E", 5, "optional"),
        ("L(*D)E", 3, "put D, S"),
        ("LXE", 2, "use L E D S"),
        ("lde", 1, "L … E"),
        ("L\u{e9}E", 2, "use L E D S"),
    ] {
        let error = LightPaths::parse(expression).expect_err(expression).to_string();
        assert!(error.contains(&format!("column {column}:")), "{expression:?}: {error}");
        assert!(error.contains(remedy), "{expression:?}: {error}");
    }
}

/// 31 live states fit, the 32nd is refused, and neither length, depth nor blow-up can hang or overflow.
#[test]
fn limits_are_errors() {
    let chain = |n: usize| format!("L{}E", "D".repeat(n));
    assert_eq!(parse(&chain(LIVE_STATES_MAX - 1)).states() as usize, LIVE_STATES_MAX);
    let large = LightPaths::parse(&chain(LIVE_STATES_MAX)).expect_err("32 states").to_string();
    assert!(large.contains("32 states") && large.contains("at most 31"), "{large}");
    let deep = format!("L{}D{}E", "(".repeat(400), ")".repeat(400));
    assert!(LightPaths::parse(&deep).expect_err("deep").to_string().contains("nested"));
    let long = LightPaths::parse(&chain(5000)).expect_err("long").to_string();
    assert!(long.contains("at most 1000"), "{long}");
    let exponential = format!("L.*D{}E", ".".repeat(40));
    assert!(LightPaths::parse(&exponential).expect_err("2^41 states").to_string().contains("simpler"));
}
