//! Images: which files there are and what is in them.

use crate::folder::{Folder, QUICK, names};
use joton::film::{Image, Layer};
use std::fs;

/// A render without -o leaves NAME.png and NAME.exr of the asked size in the current folder, and nothing else.
#[test]
fn render_writes_its_default_files() {
    let folder = Folder::new();
    let before = names(&folder);
    folder.done("render cornell.toml --size 24x16 --device cpu --passes 2");
    let after = names(&folder);
    let new: Vec<&String> = after.iter().filter(|n| !before.contains(n)).collect();
    assert_eq!(new, ["cornell.exr", "cornell.png"]);
    let image = folder.image("cornell.exr");
    assert_eq!((image.width, image.height), (24, 16));
    assert!(image.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
    assert!(image.pixels.iter().flatten().any(|x| *x > 0.0));
    let png = fs::read(folder.path("cornell.png")).expect("a PNG");
    assert_eq!(png[16..24], [0, 0, 0, 24, 0, 0, 0, 16], "the size in the PNG's header");
}

/// The layers of the EXR sum to its R G B; float32 rounding of five numbers is all that differs.
#[test]
fn layers_sum_to_the_image() {
    use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
    let folder = Folder::new();
    folder.done("render ring.toml --size 32x32 --device cpu --passes 4 -o a.exr");
    let image = read_all_flat_layers_from_file(folder.path("a.exr")).expect("an EXR");
    let channels = &image.layer_data[0].channel_data.list;
    let values = |name: &str| -> Vec<f32> {
        let channel =
            channels.iter().find(|c| c.name.eq(name)).unwrap_or_else(|| panic!("no channel {name}"));
        match &channel.sample_data {
            FlatSamples::F32(values) => values.clone(),
            other => panic!("{name} is no float32: {other:?}"),
        }
    };
    for band in ["R", "G", "B"] {
        let layers = Layer::ALL.map(|l| values(&format!("{}.{band}", l.name())));
        for (pixel, whole) in values(band).into_iter().enumerate() {
            let sum: f32 = layers.iter().map(|l| l[pixel]).sum();
            assert!((sum - whole).abs() <= 1e-5 * whole.abs().max(1e-3), "{band} of {pixel}: {sum}, {whole}");
        }
        assert!(layers[Layer::Caustic as usize].iter().any(|x| *x > 0.0), "the ring makes a caustic");
    }
}

/// One seed is one image, byte by byte; another seed is another image.
#[test]
fn a_seed_is_an_image() {
    let folder = Folder::new();
    for (name, seed) in [("a", 7), ("b", 7), ("c", 8)] {
        folder.done(&format!("{QUICK} --passes 3 --seed {seed} -o {name}.exr"));
    }
    let bytes = |name: &str| fs::read(folder.path(name)).expect("an EXR");
    assert_eq!(bytes("a.exr"), bytes("b.exr"));
    // the images, not the files: a file also says its seed
    assert_ne!(folder.image("a.exr"), folder.image("c.exr"));
}

/// Expressions that share no path and leave none out give images that sum to the whole.
#[test]
fn paths_partition_the_image() {
    let folder = Folder::new();
    let render = |name: &str, paths: &str| {
        folder.done(&format!("render ring.toml --size 16x16 --device cpu --passes 64 -o {name}.exr {paths}"));
        folder.image(&format!("{name}.exr"))
    };
    let whole = render("whole", "");
    let parts = ["LS*E", "LDS*E", "LS+DS*E", "L.*D.*DS*E"].map(|p| render("part", &format!("--paths {p}")));
    let mean = |image: &Image| image.pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>();
    let sum: f64 = parts.iter().map(mean).sum();
    for (part, what) in parts.iter().zip(["emission", "direct", "caustic", "diffuse"]) {
        assert!(mean(part) < mean(&whole), "{what} is not all there is");
    }
    // the same random numbers throughout, but the maps may be cut differently: noise of the mean of 16,384 samples
    assert!((sum / mean(&whole) - 1.0).abs() < 0.01, "{sum} against {}", mean(&whole));
}

/// A picture that exists is replaced by a render that succeeds.
#[test]
fn success_replaces_files() {
    let folder = Folder::new();
    fs::write(folder.path("a.exr"), b"old").expect("a file");
    fs::write(folder.path("r.json"), b"old").expect("a file");
    folder.done(&format!("{QUICK} --passes 1 -o a.exr --report r.json"));
    assert_eq!(folder.image("a.exr").width, 32);
    assert_eq!(folder.report("r.json")["passes"], 1);
}
