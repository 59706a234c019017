//! What the fuzzers of `fuzz/` kept, once more on stable Rust: inputs that reach every part of the readers that was ever reached, and those
//! that found a fault. `sh scripts/fuzz.sh` looks for more.

mod checks;

use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What takes longer is a fault, however small the file: a hundred times what any of them takes.
const LONGEST: Duration = Duration::from_secs(10);

fn corpus(target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(target);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    files
}

/// Every file keeps what its target promises; some are taken, and some refused.
fn replay(target: &str) {
    let (name, check) = checks::TARGETS.into_iter().find(|(name, _)| *name == target).expect("a target");
    let (mut taken, mut refused, mut faults) = (0, 0, Vec::new());
    for path in corpus(name) {
        let bytes = std::fs::read(&path).expect("a file of the corpus");
        let begin = Instant::now();
        match catch_unwind(|| check(&bytes)) {
            Ok(true) => taken += 1,
            Ok(false) => refused += 1,
            Err(_) => faults.push(path.clone()),
        }
        assert!(begin.elapsed() < LONGEST, "{} takes {:?}", path.display(), begin.elapsed());
    }
    assert!(faults.is_empty(), "a fault is found by {faults:?}");
    assert!(taken > 0 && refused > 0, "{target}: {taken} taken, {refused} refused");
}

/// Each target has a test here.
macro_rules! replays {
    ($($target:ident)*) => {
        $(
            #[test]
            fn $target() {
                replay(stringify!($target));
            }
        )*

        /// No target is left out, and there is a folder for each.
        #[test]
        fn all_targets_are_replayed() {
            let names = [$(stringify!($target)),*];
            assert_eq!(checks::TARGETS.map(|(name, _)| name), names);
        }
    };
}

replays!(obj mtl scene pack paths checkpoint exr);
