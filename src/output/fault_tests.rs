//! A disc that fails at each call of each writer: what was there stays whole, nothing is left beside it, and the error names the file and
//! says what to do.

use super::disc::Call;
use super::disc::faults::{Fault, with};
use super::{Part, checkpoint, display, exr, png, write_set, write_text};
use crate::error::Result;
use crate::film::{Film, Image};
use crate::render::RenderState;
use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// What stood in a file before.
const OLD: &[u8] = b"precious";

/// Something that writes files of these names into a folder.
struct Writer {
    names: &'static [&'static str],
    write: fn(&Path) -> Result<()>,
}

/// A picture of several blocks, so that it takes several writes.
const SIZE: [u32; 2] = [64, 40];

/// What neither deflate nor a buffer of 8 KiB makes small.
fn noise(width: u32, height: u32) -> Image {
    let mut image = Image::new(width, height);
    let mut word = 1u32;
    for band in image.pixels.as_flattened_mut() {
        word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *band = f32::from_bits(0x3f80_0000 | word >> 9) - 1.0;
    }
    image
}

const WRITERS: [Writer; 5] = [
    Writer {
        names: &["a.png"],
        write: |folder| {
            png::write_image(&folder.join("a.png"), &noise(SIZE[0], SIZE[1]), &display::Display::default())
        },
    },
    Writer {
        names: &["a.exr"],
        write: |folder| {
            let mut picture = Film::new(SIZE[0], SIZE[1]).picture();
            picture.whole = noise(SIZE[0], SIZE[1]);
            exr::write_picture(&folder.join("a.exr"), &picture, "noise")
        },
    },
    Writer { names: &["a.json"], write: |folder| write_text(&folder.join("a.json"), &"word ".repeat(8000)) },
    Writer {
        names: &["a.joton"],
        write: |folder| checkpoint::write(&folder.join("a.joton"), &"header", &RenderState::new(SIZE)),
    },
    Writer {
        names: &["a.0.ply", "a.1.ply", "a.xml"],
        write: |folder| {
            let part = |name: &str| -> Part<'_> { (folder.join(name), Box::new(|| vec![b'x'; 20_000])) };
            write_set(["a.0.ply", "a.1.ply", "a.xml"].map(part).into())
        },
    },
];

/// Names and bytes of all files in a folder.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry"));
    let file =
        |e: fs::DirEntry| (e.file_name().into_string().expect("UTF-8"), fs::read(e.path()).expect("a file"));
    let mut all: Vec<_> = entries.map(file).collect();
    all.sort();
    all
}

/// A folder in which the files of a writer are, or are not.
fn folder_with(writer: &Writer, is_there: bool) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    if is_there {
        for name in writer.names {
            fs::write(folder.path().join(name), OLD).expect("written");
        }
    }
    folder
}

/// Let each call of each writer fail, one after the other: how many did, and of which kinds.
fn fail_each(fault_at: impl Fn(usize) -> Fault, remedy: &str) -> (usize, BTreeSet<Call>) {
    let (mut count, mut kinds) = (0, BTreeSet::new());
    for writer in &WRITERS {
        for is_there in [false, true] {
            let folder = folder_with(writer, is_there);
            let (done, calls) = with(Fault::None, || (writer.write)(folder.path()));
            done.expect("it is written");
            let whole = contents(folder.path());
            for k in 0..calls.len() {
                let folder = folder_with(writer, is_there);
                let before = contents(folder.path());
                let (done, calls) = with(fault_at(k), || (writer.write)(folder.path()));
                let what = format!("{:?} at call {k}, there before: {is_there}", writer.names);
                match done {
                    Err(e) => {
                        let e = e.to_string();
                        assert_eq!(contents(folder.path()), before, "{what}: {e}");
                        let is_named = writer.names.iter().any(|name| e.contains(name));
                        assert!(is_named && e.contains("cannot write") && e.contains(remedy), "{what}: {e}");
                        assert_eq!(e.lines().count(), 1, "{e}");
                        count += 1;
                    }
                    // where there is another way it is whole
                    Ok(()) => {
                        assert!(contents(folder.path()) == whole, "{what}");
                        assert!(matches!(calls[k], Call::Link | Call::Rename), "{what}: {:?}", calls[k]);
                    }
                }
                kinds.extend(calls.get(k));
            }
        }
    }
    (count, kinds)
}

/// One call fails: opening, each write, bringing it to the disc, a second name, the copy in its place, renaming.
#[test]
fn each_call_may_fail() {
    let every = BTreeSet::from([
        Call::Open,
        #[cfg(unix)]
        Call::Permissions,
        Call::Write,
        Call::Sync,
        Call::Link,
        Call::Copy,
        Call::Rename,
    ]);
    let (denied, of_one) =
        fail_each(|k| Fault::One(k, ErrorKind::PermissionDenied), "change its permissions");
    let (alone, without_links) =
        fail_each(|k| Fault::WithoutLinks(k, ErrorKind::ReadOnlyFilesystem), "another folder");
    assert_eq!(&of_one | &without_links, every);
    assert!(denied > 60 && alone > 60, "{denied}, {alone}");
}

/// From some call on the disc is full, whichever that is.
#[test]
fn the_disc_may_be_full_from_any_call_on() {
    let (count, _) = fail_each(Fault::Full, "make room or choose another disc");
    assert!(count > 60, "{count}");
}

/// A system that takes half of what it is given, and interrupts every other call, gets whole files in the end.
#[test]
fn short_writes_are_gone_on_with() {
    for writer in &WRITERS {
        let [wanted, found] = [Fault::None, Fault::Short].map(|fault| {
            let folder = folder_with(writer, true);
            with(fault, || (writer.write)(folder.path())).0.expect("it is written");
            contents(folder.path())
        });
        assert!(wanted == found, "{:?}", writer.names);
    }
}
