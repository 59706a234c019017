//! Lists the shader files, so that the program carries them.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

/// Every .wgsl file below a folder, sorted.
fn shaders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(shaders(&path)?);
        } else if path.extension().is_some_and(|e| e == "wgsl") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=shaders");
    let variable = |name: &str| env::var_os(name).map(PathBuf::from).ok_or(io::ErrorKind::NotFound);
    let root = variable("CARGO_MANIFEST_DIR")?.join("shaders");
    let mut list = String::from("&[\n");
    for path in shaders(&root)? {
        let parts = path.strip_prefix(&root).map_err(io::Error::other)?.components();
        let name: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
        writeln!(list, "({:?}, include_str!({path:?})),", name.join("/")).map_err(io::Error::other)?;
    }
    list.push(']');
    fs::write(variable("OUT_DIR")?.join("shaders.rs"), list)
}
