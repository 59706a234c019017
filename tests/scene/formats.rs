//! Formats, encodings, ends of lines and of files.

use crate::folder::{TRIANGLE, load_obj, warned};
use joton::Error;
use joton::scene;
use std::path::Path;

/// A format without a reader is an error that names those with one.
#[test]
fn unknown_formats_are_refused() {
    let error = scene::load(Path::new("scene.blend")).unwrap_err().to_string();
    assert!(error.contains("scene.blend") && error.contains(".toml") && error.contains(".obj"), "{error}");
}

/// A file that does not exist is an error that names it.
#[test]
fn missing_files_are_named() {
    let error = scene::load(Path::new("nowhere/a.obj")).unwrap_err();
    assert!(matches!(error, Error::Io { .. }) && error.to_string().contains("nowhere"), "{error}");
}

/// The same text in UTF-8, Latin-1 and UTF-16, with LF, CRLF or CR, is the same scene.
#[test]
fn encodings_and_line_ends_do_not_matter() {
    let text = format!("# Würfel\n{TRIANGLE}usemtl grün\nf 1 2 \\\n 3\n");
    for end in ["\n", "\r\n", "\r"] {
        let text = text.replace('\n', end);
        let latin1: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let utf16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(bytes).collect()
        };
        let marked = [b"\xEF\xBB\xBF", text.as_bytes()].concat();
        let (little, big) = (utf16(u16::to_le_bytes), utf16(u16::to_be_bytes));
        for bytes in [text.as_bytes(), &latin1, &marked, &little, &big] {
            let scene = load_obj(bytes).unwrap();
            assert_eq!(scene.mesh.triangles.len(), 1);
            assert_eq!(scene.materials[0].name, "grün");
            warned(&scene, "a.obj:6", "\"grün\" is not defined");
        }
    }
}

/// NUL and Ctrl-Z after the end are passed over.
#[test]
fn trailing_garbage_is_survived() {
    assert_eq!(load_obj(format!("{TRIANGLE}f 1 2 3\n\0\0\x1a")).unwrap().mesh.triangles.len(), 1);
}
