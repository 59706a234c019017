//! What must hold of whatever bytes a reader meets: it is refused in one plain line, or what comes of it keeps its promises.
//!
//! One function for each target of `fuzz/`, which the fuzzers call and `cargo test --test corpus` calls of what they found.

#[path = "../common/promises.rs"]
mod promises;

use joton::backend::cpu::CpuBackend;
use joton::film::Image;
use joton::film::paths::{DEAD, Event, LIVE_STATES_MAX, LightPaths};
use joton::output::{checkpoint, compare, exr};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use joton::render::{PassRange, Reason, RenderState, Stop};
use joton::scene::{self, Scene};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// A target: its name, which is that of its corpus, and what it checks. Whether the bytes were taken.
pub type Target = (&'static str, fn(&[u8]) -> bool);

/// All of them.
pub const TARGETS: [Target; 7] = [
    ("obj", obj),
    ("mtl", mtl),
    ("scene", scene),
    ("pack", pack),
    ("paths", paths),
    ("checkpoint", checkpoint),
    ("exr", exr),
];

/// A mesh that uses what [`MTL`] defines, with a closed body for glass.
const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 3 0 0\nv 3 1 0\nv 3 0 1\nusemtl m\nf 5 6 7\nusemtl l\nf 7 6 5\n\
    o body\ng part\nusemtl g\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
/// A material library.
const MTL: &str = "newmtl m\nKd .5 .5 .5\nnewmtl l\nKe 1 2 3\nnewmtl g\nillum 7\nNi 1.5\nTf .9 .9 .9\n";

/// A folder of this process, which lies where TMPDIR says.
fn room() -> &'static Path {
    static ROOM: OnceLock<tempfile::TempDir> = OnceLock::new();
    ROOM.get_or_init(|| tempfile::tempdir().expect("a folder")).path()
}

/// A file of this thread in the room, which is written where it is not there already.
fn put(name: &str, bytes: &[u8]) -> PathBuf {
    thread_local! {
        static THERE: RefCell<HashMap<String, Vec<u8>>> = RefCell::default();
    }
    let folder = room().join(format!("{:?}", std::thread::current().id()));
    let path = folder.join(name);
    THERE.with_borrow_mut(|there| {
        if there.get(name).is_none_or(|before| before != bytes) {
            std::fs::create_dir_all(&folder).expect("a folder");
            std::fs::write(&path, bytes).expect("a file");
            there.insert(name.into(), bytes.into());
        }
    });
    path
}

/// Characters of a line, at most: file, fault and remedy.
const LINE_MAX: usize = 2500;

/// What is told the user is one line of plain text.
fn is_line(told: &str) {
    assert!(!told.is_empty() && !told.contains(char::is_control), "{told:?} is no line");
    assert!(told.chars().count() < LINE_MAX, "a line of {} bytes: {told:?}", told.len());
}

/// An error of a file says which, in a line, and never that joton is at fault.
fn is_refusal(e: &joton::Error, names: &[&str]) {
    let told = e.to_string();
    is_line(&told);
    assert!(names.iter().any(|name| told.contains(name)), "{told:?} names none of {names:?}");
    assert!(!told.contains("report this file"), "{told}");
}

/// Whatever is read of these files.
fn loaded(path: &Path, names: &[&str]) -> Option<Scene> {
    match scene::load(path) {
        Ok(scene) => {
            promises::check(&scene);
            scene.warnings.iter().for_each(|told| is_line(told));
            Some(scene)
        }
        Err(e) => {
            is_refusal(&e, names);
            None
        }
    }
}

/// A mesh alone, cleaned and parsed.
pub fn obj(bytes: &[u8]) -> bool {
    put("m.mtl", MTL.as_bytes());
    loaded(&put("a.obj", bytes), &["a.obj"]).is_some()
}

/// A material library of a mesh.
pub fn mtl(bytes: &[u8]) -> bool {
    put("m.mtl", bytes);
    loaded(&put("a.obj", OBJ.as_bytes()), &["m.mtl"]).is_some()
}

/// A scene file, beside a mesh and its library.
pub fn scene(bytes: &[u8]) -> bool {
    put("a.obj", OBJ.as_bytes());
    put("m.mtl", MTL.as_bytes());
    loaded(&put("s.toml", bytes), &["s.toml", "a.obj", "m.mtl"]).is_some()
}

/// Triangles of a scene that is packed: round shapes have many more.
const TRIANGLES_MAX: usize = 300;
/// Between the mesh and the scene file of [`pack`].
const CUT: &[u8] = b"%%\n";

/// Triangles of a scene that is rendered.
const RENDERED_MAX: usize = 40;

/// A mesh and a scene file that are read, packed and looked through as `joton check` does; if small, planned, and rendered for a pass.
pub fn pack(bytes: &[u8]) -> bool {
    let cut = bytes.windows(CUT.len()).position(|window| window == CUT);
    let (mesh, file) = cut.map_or((bytes, None), |at| (&bytes[..at], Some(&bytes[at + CUT.len()..])));
    put("m.mtl", MTL.as_bytes());
    let mesh = put("a.obj", mesh);
    let root = file.map_or(mesh, |file| put("s.toml", file));
    let Some(mut scene) = loaded(&root, &["s.toml", "a.obj", "m.mtl"]) else { return false };
    if scene.mesh.triangles.len() > TRIANGLES_MAX {
        return false;
    }
    scene.resize([4, 4]);
    let packed = PackedScene::new(&scene);
    assert!(packed.bounds.iter().all(|corner| corner.is_finite()), "{:?}", packed.bounds);
    for t in packed.triangles.iter() {
        assert!([t.v0, t.e1, t.e2].iter().all(|v| v.is_finite()), "{t:?}");
        assert!((t.material as usize) < packed.materials.len(), "{t:?}");
    }
    assert_eq!(packed.emitters.last().map(|e| e.cumulative), Some(1.0));
    assert!(packed.total_flux.iter().all(|flux| flux.is_finite()), "{:?}", packed.total_flux);
    joton::packed::doubts(&scene, &packed).iter().for_each(|told| is_line(told));
    if scene.mesh.triangles.len() <= RENDERED_MAX {
        let packed = Arc::new(packed);
        let plan = Plan::new(&packed, Settings::default());
        let mut backend = CpuBackend::new(Arc::clone(&packed), plan);
        let stop = Stop { passes: Some(1), ..Stop::default() };
        let rendered = joton::render::render(&mut backend, packed.size, stop, |_| true).expect("it renders");
        let whole = &rendered.picture.whole;
        assert!(whole.pixels.iter().flatten().all(|x| x.is_finite()), "{:?}", whole.pixels);
    }
    true
}

/// Longest words of [`Words`].
const LETTERS_MAX: u32 = 5;

/// A set of words over D (0) and S (1) of at most [`LETTERS_MAX`] letters: bit `1 << letters | word`.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Words(u64);

impl Words {
    const EMPTY_WORD: Self = Self(1 << 1);

    fn all(self) -> impl Iterator<Item = u64> {
        (1..64).filter(move |word| self.0 >> word & 1 == 1)
    }

    fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    fn then(self, other: Self) -> Self {
        let both = |a: u64, b: u64| {
            let letters = b.ilog2();
            let fits = a.ilog2() + letters <= LETTERS_MAX;
            if fits { 1 << (a << letters | b ^ 1 << letters) } else { 0 }
        };
        Self(self.all().flat_map(|a| other.all().map(move |b| both(a, b))).fold(0, |set, word| set | word))
    }

    fn looped(self) -> Self {
        let mut found = self;
        loop {
            let more = found.or(found.then(self));
            if more == found {
                return found;
            }
            found = more;
        }
    }

    fn reversed(self) -> Self {
        let reverse = |word: u64| {
            let letters = word.ilog2();
            (0..letters).fold(1, |reversed, i| reversed << 1 | word >> i & 1)
        };
        Self(self.all().fold(0, |set, word| set | 1 << reverse(word)))
    }

    /// Of the alternatives at the begin of `rest`, which is cut behind them.
    fn of(rest: &mut &[u8]) -> Self {
        let mut all = Self(0);
        loop {
            let mut sequence = Self::EMPTY_WORD;
            while let [symbol @ (b'D' | b'S' | b'.' | b'('), after @ ..] = *rest {
                *rest = after;
                let mut atom = match symbol {
                    b'D' => Self(1 << 0b10),
                    b'S' => Self(1 << 0b11),
                    b'.' => Self(1 << 0b10 | 1 << 0b11),
                    _ => {
                        let group = Self::of(rest);
                        *rest = &rest[1..];
                        group
                    }
                };
                while let [quantifier @ (b'*' | b'+' | b'?'), after @ ..] = *rest {
                    *rest = after;
                    atom = if *quantifier == b'?' { atom } else { atom.looped() };
                    atom = if *quantifier == b'+' { atom } else { atom.or(Self::EMPTY_WORD) };
                }
                sequence = sequence.then(atom);
            }
            all = all.or(sequence);
            match *rest {
                [b'|', after @ ..] if !matches!(after, [b'L' | b'E', ..]) => *rest = after,
                _ => return all,
            }
        }
    }

    /// Of a whole expression that is known to be one.
    fn of_expression(text: &str) -> Self {
        let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let (mut rest, mut all) = (text.as_bytes(), Self(0));
        while let [first @ (b'L' | b'E'), after @ ..] = rest {
            rest = after;
            let words = Self::of(&mut rest);
            all = all.or(if *first == b'L' { words } else { words.reversed() });
            rest = rest.get(2..).unwrap_or_default();
        }
        all
    }
}

/// A light path expression: its automaton takes the words that the text says, and what it prints is the same again.
pub fn paths(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let parsed = match LightPaths::parse(text) {
        Ok(parsed) => parsed,
        Err(e) => {
            is_line(&e.to_string());
            return false;
        }
    };
    assert_eq!(LightPaths::parse(&parsed.to_string()).expect("what it prints"), parsed);
    let states = parsed.states();
    assert!((1..=LIVE_STATES_MAX as u32).contains(&states), "{states} states");
    for state in 0..states {
        for event in Event::ALL {
            let next = parsed.step(state, event);
            assert!(next < states || next == DEAD, "{state} leads to {next} of {states}");
        }
    }
    let words = Words::of_expression(text);
    for word in 1u64..64 {
        let letters = word.ilog2();
        let events: String = (0..letters).rev().map(|i| if word >> i & 1 == 1 { 'S' } else { 'D' }).collect();
        assert_eq!(parsed.matches(&events), words.0 >> word & 1 == 1, "{events:?} by {text:?}");
    }
    // an expression that takes no word at all cannot be written
    assert!(parsed.layers().contains(&true), "{text:?} holds no light");
    true
}

/// First line of a checkpoint.
const MAGIC: &[u8] = b"joton checkpoint 3\n";
/// Image of the checkpoints that are changed.
const SIZE: [u32; 2] = [5, 3];
/// Bytes of a change: where, and what is there then.
const CHANGE: usize = 3;

/// Real checkpoints: of a render that has not begun, of one with some passes, of a part of one.
fn checkpoints() -> &'static [Vec<u8>] {
    static WRITTEN: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    WRITTEN.get_or_init(|| {
        put("m.mtl", MTL.as_bytes());
        let mut scene = scene::load(&put("a.obj", OBJ.as_bytes())).expect("a scene");
        scene.resize(SIZE);
        let packed = Arc::new(PackedScene::new(&scene));
        let part = PassRange::new(16, 20).expect("a range");
        let is_part = |is_part| Settings { is_part, ..Settings::default() };
        let states = [
            (RenderState::new(SIZE), false, None),
            (RenderState::new(SIZE), false, Some(6)),
            (RenderState::of_part(SIZE, part), true, Some(20)),
        ];
        let written = states.map(|(mut state, settings, passes)| {
            if let Some(passes) = passes {
                let plan = Plan::new(&packed, is_part(settings));
                let mut backend = CpuBackend::new(Arc::clone(&packed), plan);
                let stop = Stop { passes: Some(passes), ..Stop::default() };
                state.go_on(&mut backend, stop, |_| true).expect("it renders");
            }
            let path = put("whole.joton", b"").with_file_name("real.joton");
            checkpoint::write(&path, &"header", &state).expect("written");
            std::fs::read(path).expect("read")
        });
        written.into()
    })
}

/// FNV-1a, 64 bits.
fn fnv(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}

/// A checkpoint. The first byte says what the others are: all of the file (0), what stands between the first line and the checksum, which
/// is put right (1), or changes to a real one, whose checksum is put right.
pub fn checkpoint(bytes: &[u8]) -> bool {
    let [kind, rest @ ..] = bytes else { return false };
    let summed = |mut file: Vec<u8>| {
        let hash = fnv(&file).to_le_bytes();
        file.extend(hash);
        file
    };
    let file = match kind {
        0 => rest.to_vec(),
        1 => summed([MAGIC, rest].concat()),
        kind => {
            let all = checkpoints();
            let whole = &all[usize::from(*kind) % all.len()];
            let mut body = whole[..whole.len() - 8].to_vec();
            for change in rest.chunks_exact(CHANGE) {
                let at = usize::from(u16::from_le_bytes([change[0], change[1]])) % body.len();
                body[at] = change[2];
            }
            summed(body)
        }
    };
    let path = put("a.joton", &file);
    let header = checkpoint::read_header::<serde_json::Value>(&path);
    if let Err(e) = &header {
        is_refusal(e, &["a.joton"]);
    }
    let (told, state) = match checkpoint::read::<serde_json::Value>(&path) {
        Ok(read) => read,
        Err(e) => {
            is_refusal(&e, &["a.joton"]);
            return false;
        }
    };
    assert_eq!(header.expect("the header of what opens"), told);
    // what is written of it is the same again
    let copy = path.with_file_name("copy.joton");
    let again = |state: &RenderState| {
        checkpoint::write(&copy, &told, state).expect("written");
        let bytes = std::fs::read(&copy).expect("read");
        (bytes, checkpoint::read::<serde_json::Value>(&copy).expect("what was written").1)
    };
    let (first, state) = again(&state);
    let (second, mut state) = again(&state);
    assert!(first == second);
    let size = state.size();
    assert!(state.passes() <= state.range().end);
    if let Some(part) = state.part() {
        let other = RenderState::of_part(
            size,
            PassRange::new(part.end().next_multiple_of(16), part.end() + 32).expect("a range"),
        );
        if let Err(e) = state.merge(&other) {
            is_line(&e.to_string());
        }
    }
    let rendered = state.finish(Reason::Passes);
    assert_eq!(rendered.picture.whole.pixels.len(), size[0] as usize * size[1] as usize);
    true
}

/// A picture as `joton compare` reads it: what is written of it has the same bits, and is compared without a fault.
pub fn exr(bytes: &[u8]) -> bool {
    let path = put("a.exr", bytes);
    let image = match exr::read_image(&path) {
        Ok(image) => image,
        Err(e) => {
            is_refusal(&e, &["a.exr"]);
            return false;
        }
    };
    assert!(image.width > 0 && image.height > 0, "{} × {}", image.width, image.height);
    assert_eq!(image.pixels.len(), image.width as usize * image.height as usize);
    let copy = path.with_file_name("b.exr");
    exr::write_image(&copy, &image, "").expect("written");
    let bits = |image: &Image| -> Vec<u32> { image.pixels.iter().flatten().map(|x| x.to_bits()).collect() };
    assert!(bits(&exr::read_image(&copy).expect("what was written")) == bits(&image));
    let found = compare::compare(&image, &image).expect("of one size");
    let expected = if found.non_finite > 0 { f64::INFINITY } else { 0.0 };
    assert_eq!(found.rel_mse, expected);
    compare::region_ratios(&image, &image, 7).expect("of one size");
    true
}
