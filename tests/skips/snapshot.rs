//! Which skips the plans of known scenes have, and why.

use crate::common::twins::{self, Case, EVERYTHING, file};
use crate::renders::{SCENES, plan};
use joton::packed::PackedScene;
use joton::plan::{Part, Reason, Skip};
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// Pixels across: as few as still show what a scene is.
const SIZE: u32 = 64;

/// The skips of all scenes, by name: those of the repository, and both of all twins.
fn skips() -> &'static [(&'static str, Vec<Skip>)] {
    static SKIPS: OnceLock<Vec<(&str, Vec<Skip>)>> = OnceLock::new();
    SKIPS.get_or_init(|| {
        let files = SCENES.map(|name| Case { name, scene: file(name, SIZE), paths: EVERYTHING, keep: &[] });
        let twins = twins::all(SIZE).into_iter().flat_map(|t| [t.without, t.with]);
        let mut names = BTreeSet::new();
        let cases = files.into_iter().chain(twins).filter(|c| names.insert(c.name));
        cases.map(|c| (c.name, plan(&PackedScene::new(&c.scene), c.paths, 0, c.keep).skipped)).collect()
    })
}

/// A scene as in snapshot.txt.
fn lines((name, skips): &(&str, Vec<Skip>)) -> String {
    let skips: String = skips.iter().map(|s| format!("    {}: {:?}\n", s.what.name(), s.why)).collect();
    format!("{name}\n{skips}")
}

/// The skips of known scenes are those of snapshot.txt, reason by reason.
#[test]
fn skips_are_those_of_the_snapshot() {
    let found: String = skips().iter().map(lines).collect();
    let wanted = include_str!("snapshot.txt");
    assert!(found == wanted, "snapshot.txt should be\n{found}");
}

/// All reasons of a plan.
const REASONS: [Reason; 34] = [
    Reason::ClosedRoom,
    Reason::NoSpecularSurface,
    Reason::SpecularInTheDark,
    Reason::NoEmissiveSurface,
    Reason::NoDiffuseSurface,
    Reason::OnePlane,
    Reason::ExcludedByPaths,
    Reason::NoMirror,
    Reason::NoDielectric,
    Reason::NoTexture,
    Reason::LightsAreEven,
    Reason::NoRelief,
    Reason::SameFacetsAllOver,
    Reason::NothingCut,
    Reason::PlainBodies,
    Reason::NothingDisperses,
    Reason::NoGlossySurface,
    Reason::NothingTranslucent,
    Reason::NoMicrofacets,
    Reason::NothingBrushed,
    Reason::NoLayers,
    Reason::NothingMixed,
    Reason::AllFlat,
    Reason::AllLightsAreSurfaces,
    Reason::NothingTouches,
    Reason::AllPathsWanted,
    Reason::NothingLearned,
    Reason::OneDirection,
    Reason::FaintAmongStrong,
    Reason::LightElsewhere,
    Reason::JotonsElsewhere,
    Reason::MuchBackground,
    Reason::NothingChanges,
    Reason::PathsServe,
];

/// Every part, and every reason, is met in some scene: none is there for nothing. But for no light at all: edges.rs.
#[test]
fn every_part_and_every_reason_occurs() {
    let all = || skips().iter().flat_map(|s| &s.1);
    for part in Part::ALL {
        assert!(all().any(|s| s.what == part), "{part:?} is never skipped");
    }
    for reason in REASONS {
        assert!(all().any(|s| s.why == reason), "nothing is skipped for {reason:?}");
    }
}

/// Of twins, one is without the part, for the reason that is said, and the other has it.
#[test]
fn twins_differ_in_their_part() {
    for t in twins::all(1) {
        let why = |case: &Case| -> Vec<Reason> {
            let (_, skips) = skips().iter().find(|s| s.0 == case.name).expect("a scene of that name");
            skips.iter().filter(|s| s.what == t.part).map(|s| s.why).collect()
        };
        assert_eq!(why(&t.without), [t.why], "{:?}: {}", t.part, t.without.name);
        assert_eq!(why(&t.with), [], "{:?}: {}", t.part, t.with.name);
    }
}
