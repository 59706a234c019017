//! Whatever bytes come: an error, or a scene that keeps its promises; never a panic.

#[path = "common/promises.rs"]
mod promises;

use joton::scene;
use promises::check;

/// Mutated files per kind: a second or two on a quiet machine.
const CASES: u64 = 1000;

const OBJ: &str = "# ü\nmtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5 1 0 0\nv .5 .2 0\nvn 0 .6 .8\nvn 1 0 0\nusemtl m\n\
    f 1//1 2//1 3//2\nf -1 -2 -3\nf 1 2 4 3\nf 1/1/1 2/2/2 \\\n4/3/1 3/1/1 5\nusemtl l\nf 3 2 1\nl 1 2\np 1\n";
const MTL: &str = "newmtl m\nKd .5 .5 .5\nKs .3 .3 .3 # x\nNs 20\nd 0.9\nmap_Kd -s 1 a.png\nnewmtl l\nillum 7\nNi 1.5\n\
    Tf .9 .9 .9\nKe 1 2 3\nPr .2\n";
const TOML: &str = "[[mesh]]\nfile = \"a.obj\"\nscale = 2\n[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_x = 40\n\
    [film]\nwidth = 9\nheight = 0x9\n[[light]]\nkind = \"spot\"\nposition = [0, 2, 0]\ntarget = [0, 0, 0]\n\
    intensity = [1, 2, 3]\nangle_outer = 60\n[[material]]\nname = \"m\"\ntype = \"glossy\"\nkd = 0.75\n";

/// Bytes that are wrong anywhere in a mesh, a material library or a scene file make no panic.
#[test]
fn no_input_panics() {
    let folder = tempfile::tempdir().unwrap();
    let sources = [("a.obj", OBJ), ("m.mtl", MTL), ("s.toml", TOML)];
    for (name, text) in sources {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    for root in ["a.obj", "s.toml"] {
        scene::load(&folder.path().join(root)).expect("the originals are sound");
    }
    let (mut accepted, mut refused) = (0, 0);
    for (name, text) in sources {
        for case in 0..CASES {
            let mut random = Random(case);
            std::fs::write(folder.path().join(name), mutated(text.as_bytes(), &mut random)).unwrap();
            for root in ["a.obj", "s.toml"] {
                match scene::load(&folder.path().join(root)) {
                    Ok(scene) => {
                        accepted += 1;
                        check(&scene);
                    }
                    Err(error) => {
                        refused += 1;
                        assert!(!error.to_string().contains("report this file"), "{error}");
                    }
                }
            }
        }
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    assert!(accepted > CASES && refused > CASES, "mutations reach both ends: {accepted} and {refused}");
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % end as u64) as usize
    }
}

/// Up to four places changed, doubled, removed, cut off or replaced by something awkward.
fn mutated(original: &[u8], random: &mut Random) -> Vec<u8> {
    const AWKWARD: [&[u8]; 16] = [
        b"nan",
        b"inf",
        b"-1",
        b"0",
        b"1e308",
        b"-1e-320",
        b"99999999999",
        b"/",
        b"\\\n",
        b"\xFF\xFE",
        b"\0",
        b"\r",
        b"\nf 1 1 1 1 2 1\n",
        b"[",
        b"\"",
        "\u{2028}é".as_bytes(),
    ];
    let mut bytes = original.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len() + 1);
        let end = (at + random.below(12)).min(bytes.len());
        match random.below(6) {
            0 if at < bytes.len() => bytes[at] = random.below(256) as u8,
            1 => drop(bytes.drain(at..end)),
            2 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            3 if random.below(8) == 0 => bytes.truncate(at),
            _ => {
                let awkward = AWKWARD[random.below(AWKWARD.len())];
                bytes.splice(at..end.min(at + 3), awkward.iter().copied());
            }
        }
    }
    bytes
}
