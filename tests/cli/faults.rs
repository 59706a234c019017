//! Faults from outside while the program runs: files that may not grow, devices that are lost or have no memory.

#[cfg(debug_assertions)]
use crate::folder::without_gpu;
use crate::folder::{Ended, Folder, QUICK, bits, names};
use std::fs;
use std::process::Command;

/// Bytes of a block of `ulimit -f`.
const BLOCK: u64 = 512;

/// A run whose files have at most so many blocks: what a disc is that is full at this place.
fn limited(folder: &Folder, blocks: u64, words: &str) -> Ended {
    let program = folder.command("").get_program().to_string_lossy().into_owned();
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("ulimit -f {blocks}; exec {program} {words}")]).current_dir(folder.path(""));
    Ended::of(shell.output().expect("a shell"))
}

fn size(folder: &Folder, name: &str) -> u64 {
    fs::metadata(folder.path(name)).expect("a file").len()
}

/// Files that may be no larger than so, at sizes around that of each: those that fit are written, those that do not are what they were, one
/// line names the first of these and says what to do, and the status is 2.
#[test]
fn what_fits_is_written() {
    let folder = Folder::new();
    let render = format!("{QUICK} --passes 2 --quiet -o a.png -o a.exr --report r.json --checkpoint c.joton");
    // in the order in which they are written
    let files = ["c.joton", "a.png", "a.exr", "r.json"];
    folder.done(&render);
    let whole = files.map(|name| fs::read(folder.path(name)).expect("a file"));
    let sizes = whole.each_ref().map(|bytes| bytes.len() as u64);
    // times are in two of them, whose digits may be more or fewer
    let slack = [64, 0, 0, 256];
    let around = |size: u64| [size / BLOCK - 1, size / BLOCK, size.div_ceil(BLOCK) + 1];
    let blocks = sizes.into_iter().flat_map(around).chain([0, 1, 17, 70]);
    for blocks in blocks {
        for name in ["a.png", "a.exr", "r.json"] {
            fs::write(folder.path(name), "precious").expect("a file");
        }
        fs::remove_file(folder.path("c.joton")).ok();
        let ended = limited(&folder, blocks, &render);
        let what = format!("{blocks} blocks: {}", ended.stderr);
        let mut first = None;
        for (i, name) in files.iter().enumerate() {
            let found = fs::read(folder.path(name)).unwrap_or_default();
            let is_old = found == if i == 0 { &b""[..] } else { b"precious" };
            if is_old {
                assert!(sizes[i] + slack[i] > blocks * BLOCK, "{name} fits; {what}");
                first = first.or(Some(*name));
            } else {
                assert!(sizes[i] <= blocks * BLOCK + slack[i], "{name} does not fit; {what}");
                let is_timed = slack[i] > 0;
                assert!(is_timed || found == whole[i], "{name} is whole; {what}");
                assert!(found.len() as u64 + slack[i] >= sizes[i], "{name} is whole; {what}");
            }
        }
        match first {
            Some(name) => {
                ended.is_refusal(&what, &[&format!("{name}: cannot write"), "too large", "ulimit -f"]);
            }
            None => assert_eq!((ended.code, &ended.stderr[..]), (Some(0), ""), "{what}"),
        }
        assert!(names(&folder).iter().all(|n| !n.ends_with(".part")), "{what}: {:?}", names(&folder));
    }
    // a device without room
    std::os::unix::fs::symlink("/dev/full", folder.path("full.png")).expect("a link");
    let words = format!("{QUICK} --passes 2 --quiet -o full.png -o after.png");
    folder.fails(&words, &["full.png: cannot write", "make room"]);
    assert!(fs::read(folder.path("after.png")).expect("a file") == whole[1]);
    // what is there is no checkpoint by half
    fs::write(folder.path("c.joton"), &whole[0]).expect("a file");
    let ended = limited(&folder, sizes[0] / BLOCK - 1, "resume c.joton --passes 4 --quiet -o b.png");
    ended.is_refusal("resume", &["c.joton: cannot write", "ulimit -f"]);
    assert!(fs::read(folder.path("c.joton")).expect("a file") == whole[0]);
    fs::write(folder.path("a.exr"), &whole[2]).expect("a file");
    folder.done("resume c.joton --passes 2 -o b.exr");
    assert!(bits(&folder, "b.exr") == bits(&folder, "a.exr"));
}

/// Likewise what the other commands write: an export all of it or nothing, the rest each file whole or as it was.
#[test]
fn what_other_commands_write_is_whole() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 1 -o a.exr"));
    folder.done(&format!("{QUICK} --pass-range 0..2 --checkpoint p.joton"));
    let bench = "bench cornell.toml --size 16x16 --device cpu --times 0.01 -o bench";
    let jobs = [
        ("export cornell.toml -o box.xml", &["box.0.ply", "box.1.ply", "box.2.ply", "box.xml"][..], true),
        (
            "merge p.joton -o m.exr --checkpoint m.joton --report m.json",
            &["m.joton", "m.exr", "m.json"],
            false,
        ),
        ("compare a.exr a.exr --heatmap h.png", &["h.png"], false),
        (
            "slurm cornell.toml --passes 64 --tasks 2 --folder jobs",
            &["jobs/render.sh", "jobs/merge.sh"],
            true,
        ),
        (bench, &["bench.csv", "bench.summary.csv", "bench.svg"], false),
    ];
    for (words, files, is_set) in jobs {
        folder.done(words);
        let largest = files.iter().map(|name| size(&folder, name)).max().expect("files");
        let (mut blocks, mut failed) = (0, 0);
        while blocks * BLOCK <= 2 * largest {
            for name in files {
                fs::write(folder.path(name), "precious").expect("a file");
            }
            let ended = limited(&folder, blocks, words);
            let what = format!("{blocks} blocks: joton {words}: {}", ended.stderr);
            let old = |name: &&&str| fs::read(folder.path(name)).expect("a file") == b"precious";
            let old: Vec<_> = files.iter().filter(old).collect();
            if old.is_empty() {
                assert_eq!(ended.code, Some(0), "{what}");
            } else {
                failed += 1;
                assert!(!is_set || old.len() == files.len(), "{old:?} are old; {what}");
                assert_eq!(ended.code, Some(2), "{what}");
                let last = ended.stderr.lines().last().expect("a line");
                assert!(old.iter().any(|name| last.contains(**name)) && last.contains("ulimit -f"), "{what}");
            }
            assert!(files.iter().all(|name| old.contains(&name) || size(&folder, name) > 8), "{what}");
            assert!(names(&folder).iter().all(|n| !n.ends_with(".part")), "{what}: {:?}", names(&folder));
            blocks = (blocks + 1).max(blocks * 3 / 2);
        }
        assert!(failed > 0, "joton {words}");
    }
}

/// A device that fails at a point, as the program's debug builds let tests ask for.
#[cfg(debug_assertions)]
fn faulty(folder: &Folder, fault: &str, words: &str) -> Ended {
    Ended::of(folder.command(words).env("JOTON_TEST_FAULT", fault).output().expect("joton runs"))
}

/// A device that was named and is lost: one line, status 2, the passes that came out are in picture and checkpoint, and `resume` goes on to
/// the bits of a render that was never disturbed. Lost before any pass is done, nothing is written.
#[cfg(debug_assertions)]
#[test]
fn a_lost_device_leaves_all_it_finished() {
    if without_gpu() {
        return;
    }
    let folder = Folder::new();
    let render = "render cornell.toml --size 16x16 --passes 4 --device gpu --quiet";
    folder.done(&format!("{render} -o whole.exr"));
    let (mut early, mut late) = (0, 0);
    for number in (0..).step_by(2) {
        for name in ["a.exr", "c.joton"] {
            fs::remove_file(folder.path(name)).ok();
        }
        let words = format!("{render} -o a.exr --checkpoint c.joton");
        let ended = faulty(&folder, &format!("Running {number}"), &words);
        if ended.code == Some(0) {
            break;
        }
        ended.is_refusal(&words, &["lost", "--device cpu"]);
        let is_saved = ended.stderr.contains(" are saved");
        assert_eq!([folder.path("a.exr").exists(), folder.path("c.joton").exists()], [is_saved; 2]);
        if is_saved {
            folder.done("resume c.joton -o a.exr --quiet");
            assert!(bits(&folder, "a.exr") == bits(&folder, "whole.exr"), "{}", ended.stderr);
        }
        *if is_saved { &mut late } else { &mut early } += 1;
    }
    assert!(early > 0 && late > 0, "{early}, {late}");
}

/// With `--device auto` the CPU goes on, whether a device is lost or has no memory, and a line says why.
#[cfg(debug_assertions)]
#[test]
fn another_device_goes_on() {
    if without_gpu() {
        return;
    }
    let folder = Folder::new();
    for (fault, why) in
        [("Buffer 5", "no memory is left for the buffer "), ("Submission 6", "the device is lost")]
    {
        let words = "render cornell.toml --size 16x16 --passes 4 -o a.exr --report r.json";
        let ended = faulty(&folder, fault, words);
        assert_eq!(ended.code, Some(0), "{fault}: {}", ended.stderr);
        let told = ended.stderr.lines().filter(|line| line.contains("CPU") && line.contains(why)).count();
        assert_eq!(told, 1, "{fault}: {}", ended.stderr);
        assert_eq!(folder.report("r.json")["passes"], 4);
    }
}
