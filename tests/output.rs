//! Image files, display, comparison: what is written is what is read, and every comparator can say no.

use joton::film::{Image, LAYERS, Picture};
use joton::output::compare::{common_error, compare, region_ratios, relative_errors, write_heatmap};
use joton::output::display::{Display, Exposure, Transform, linear_from_srgb, srgb_from_linear};
use joton::output::{exr, png};
use std::fs;
use std::path::Path;

fn image(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let pixels = (0..width * height).map(|i| pixel(i % width, i / width)).collect();
    Image { width, height, pixels }
}

fn grey(width: u32, height: u32, level: f32) -> Image {
    image(width, height, |_, _| [level; 3])
}

/// Every pixel, band and layer different; values that half floats, clipping or a swap of axes would lose.
fn picture(width: u32, height: u32) -> Picture {
    let layer = |l: usize| {
        image(width, height, |x, y| {
            let base = 1000.0 * l as f32 + 10.0 * y as f32 + x as f32;
            [base + 1.0 / 3.0, -base * 1e-7, base * 1e9]
        })
    };
    Picture { whole: layer(LAYERS), layers: std::array::from_fn(layer), unresolved: Vec::new() }
}

fn files_in(folder: &Path) -> Vec<String> {
    let name = |entry: std::io::Result<fs::DirEntry>| {
        entry.expect("entry").file_name().into_string().expect("UTF-8")
    };
    let mut names: Vec<_> = fs::read_dir(folder).expect("folder").map(name).collect();
    names.sort();
    names
}

fn decode(path: &Path) -> (u32, u32, Vec<u8>) {
    let decoded = image::open(path).expect("a PNG").into_rgb8();
    (decoded.width(), decoded.height(), decoded.into_raw())
}

/// An EXR holds each value to the bit, whichever the size; 17 rows are more than one compressed block.
#[test]
fn exr_keeps_every_bit() {
    let folder = tempfile::tempdir().expect("folder");
    for (width, height) in [(1, 1), (7, 3), (5, 17), (64, 33)] {
        let path = folder.path().join("picture.exr");
        let written = picture(width, height);
        exr::write_picture(&path, &written, "seed 1, 16 passes").expect("written");
        assert_eq!(exr::read_image(&path).expect("read"), written.whole, "{width}x{height}");
    }
    let odd =
        image(
            2,
            1,
            |x, _| if x == 0 { [f32::INFINITY, f32::MIN_POSITIVE / 2.0, -0.0] } else { [f32::MAX; 3] },
        );
    let path = folder.path().join("odd.exr");
    exr::write_image(&path, &odd, "").expect("written");
    assert_eq!(exr::read_image(&path).expect("read"), odd);
}

/// Any reader finds the whole image as R G B of the first part, and each layer under its own name.
#[test]
fn exr_has_plain_rgb_and_named_layers_in_one_part() {
    use ::exr::prelude::*;
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("layers.exr");
    let written = picture(5, 4);
    joton::output::exr::write_picture(&path, &written, "how it was made").expect("written");
    let file = read_all_flat_layers_from_file(&path).expect("read");
    assert_eq!(file.layer_data.len(), 1, "one part");
    let part = &file.layer_data[0];
    assert_eq!(part.attributes.layer_name, None);
    assert_eq!(part.attributes.comments, Some(Text::from("how it was made")));
    assert!(part.attributes.software_name.as_ref().expect("software").to_string().starts_with("joton "));
    let channel = |name: &str| -> Vec<f32> {
        let found = part.channel_data.list.iter().find(|c| c.name.eq(name));
        let found = found.unwrap_or_else(|| panic!("no channel {name}"));
        assert!(matches!(found.sample_data, FlatSamples::F32(_)), "{name} is float32");
        found.sample_data.values_as_f32().collect()
    };
    assert_eq!(part.channel_data.list.len(), 3 * (1 + LAYERS));
    for (b, band) in ["R", "G", "B"].iter().enumerate() {
        let of = |image: &joton::film::Image| image.pixels.iter().map(|p| p[b]).collect::<Vec<_>>();
        assert_eq!(channel(band), of(&written.whole));
        for (layer, image) in joton::film::Layer::ALL.iter().zip(&written.layers) {
            assert_eq!(channel(&format!("{}.{band}", layer.name())), of(image));
        }
    }
}

/// Half floats with alpha are read too, and a part without colour before the one with it is passed over.
#[test]
fn exr_of_other_programs_is_read() {
    use ::exr::prelude::*;
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("half.exr");
    let half = |v: f32| f16::from_f32(v);
    write_rgba_file(&path, 3, 2, |x, y| (half(x as f32), half(y as f32), half(0.5), half(1.0)))
        .expect("written");
    let read = joton::output::exr::read_image(&path).expect("read");
    assert_eq!(read, image(3, 2, |x, y| [x as f32, y as f32, 0.5]));
}

/// What is no EXR, has no colour, or is cut off is an error that names the file; never a panic, never an image.
#[test]
fn broken_exr_is_an_error() {
    use ::exr::prelude::*;
    let folder = tempfile::tempdir().expect("folder");
    let error_of = |path: &Path| {
        let error = joton::output::exr::read_image(path).expect_err("refused").to_string();
        assert!(error.contains(&path.display().to_string()), "{error}");
        error
    };
    error_of(&folder.path().join("missing.exr"));
    let text = folder.path().join("text.exr");
    fs::write(&text, "not an image").expect("written");
    assert!(error_of(&text).contains("not a readable OpenEXR file"));
    let luminance = folder.path().join("luminance.exr");
    let y = AnyChannel::new("Y", FlatSamples::F32(vec![1.0; 4]));
    Image::from_channels((2, 2), AnyChannels::sort(vec![y].into()))
        .write()
        .to_file(&luminance)
        .expect("written");
    let error = error_of(&luminance);
    assert!(error.contains("R, G and B") && error.contains("it has Y"), "{error}");
    let whole = folder.path().join("whole.exr");
    joton::output::exr::write_picture(&whole, &picture(33, 40), "").expect("written");
    let bytes = fs::read(&whole).expect("read");
    let cut = folder.path().join("cut.exr");
    for length in (0..bytes.len()).step_by(97) {
        fs::write(&cut, &bytes[..length]).expect("written");
        error_of(&cut);
    }
    // A damaged byte may change values, or be an error; it must not end the program.
    let header_end = bytes.len().min(1500);
    for at in (0..header_end).chain((header_end..bytes.len()).step_by(31)) {
        for damage in [0xff, 0x80, 0x01] {
            let mut damaged = bytes.clone();
            damaged[at] ^= damage;
            fs::write(&cut, damaged).expect("written");
            let _ = joton::output::exr::read_image(&cut);
        }
    }
    // A damaged size must not decide how much memory is asked for.
    let window = b"dataWindow\0box2i\0\x10\0\0\0";
    let at = bytes.windows(window.len()).position(|w| w == window).expect("a data window") + window.len();
    let mut huge = bytes.clone();
    huge[at + 8..at + 12].copy_from_slice(&1_000_000_i32.to_le_bytes());
    huge[at + 12..at + 16].copy_from_slice(&1_000_000_i32.to_le_bytes());
    fs::write(&cut, huge).expect("written");
    error_of(&cut);
}

/// A write that fails leaves the old file as it was and nothing beside it; one that works leaves only itself.
#[test]
fn files_are_replaced_whole_or_not_at_all() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("a.exr");
    fs::write(&path, "precious").expect("written");
    exr::write_image(&path, &Image::new(0, 0), "").expect_err("nothing to write");
    png::write_image(&path, &Image::new(0, 0), &Display::default()).expect_err("nothing to write");
    // A failure half way, after the scratch file was opened: more pixels than the encoder was promised.
    let mut wrong = grey(3, 3, 1.0);
    wrong.width = 2;
    png::write_image(&path, &wrong, &Display::default()).expect_err("sizes do not fit");
    assert_eq!(fs::read_to_string(&path).expect("read"), "precious");
    assert_eq!(files_in(folder.path()), ["a.exr"]);
    exr::write_image(&path, &grey(2, 2, 1.0), "").expect("written");
    assert_eq!(exr::read_image(&path).expect("read"), grey(2, 2, 1.0));
    assert_eq!(files_in(folder.path()), ["a.exr"]);
    #[cfg(unix)]
    {
        let link = folder.path().join("link.exr");
        std::os::unix::fs::symlink(&path, &link).expect("linked");
        exr::write_image(&link, &grey(3, 1, 2.0), "").expect("written");
        assert!(link.is_symlink(), "a link stays a link, and its target is replaced");
        assert_eq!(exr::read_image(&path).expect("read"), grey(3, 1, 2.0));
    }
    let nowhere = folder.path().join("no/such/folder.png");
    let error = png::write_image(&nowhere, &grey(2, 2, 1.0), &Display::default()).expect_err("no folder");
    assert!(error.to_string().contains("no/such/folder.png"), "{error}");
    exr::write_image(folder.path(), &grey(2, 2, 1.0), "").expect_err("a folder is no file");
}

/// Values of IEC 61966-2-1, and its inverse.
#[test]
fn srgb_transfer_is_the_standard_one() {
    for (linear, encoded) in
        [(0.0, 0.0), (0.0031308, 0.04045), (0.18, 0.46135), (0.5, 0.735_36), (1.0, 1.0), (7.0, 1.0)]
    {
        assert!((srgb_from_linear(linear) - encoded).abs() < 2e-5, "{linear}");
    }
    for i in 0..=255 {
        let v = i as f32 / 255.0;
        assert!((srgb_from_linear(linear_from_srgb(v)) - v).abs() < 1e-5, "{v}");
    }
}

/// Zero stops show 1 as white, and each stop doubles; black and white are exact in spite of the dither.
#[test]
fn png_shows_exposed_srgb() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("a.png");
    let levels = image(16, 16, |x, _| match x {
        0..4 => [0.0; 3],
        4..8 => [0.5; 3],
        8..12 => [1.0, 0.0, 0.0],
        _ => [-1.0; 3],
    });
    let display = Display { exposure: Exposure::Stops(1.0), transform: Transform::Srgb };
    png::write_image(&path, &levels, &display).expect("written");
    let (width, height, bytes) = decode(&path);
    assert_eq!((width, height), (16, 16));
    for (i, pixel) in bytes.chunks(3).enumerate() {
        let expected = match i % 16 {
            0..4 => [0, 0, 0],
            4..8 => [255, 255, 255],
            8..12 => [255, 0, 0],
            _ => [0, 0, 0],
        };
        assert_eq!(pixel, expected, "pixel {i}");
    }
}

/// Dither keeps the mean of a flat area within 1/20 of a level, uses only the two neighbouring levels, and is
/// the same each time. Plain rounding would miss by up to half a level.
#[test]
fn dither_is_fair_and_fixed() {
    for level in [10.25, 127.5, 200.9] {
        let flat = vec![[level / 255.0; 3]; 64 * 64];
        let rows = png::quantise(64, &flat);
        let mean = rows.iter().map(|p| f64::from(p[0])).sum::<f64>() / rows.len() as f64;
        assert!((mean - f64::from(level)).abs() < 0.05, "{level}: {mean}");
        assert!(rows.iter().flatten().all(|&v| (f32::from(v) - level).abs() < 1.0), "{level}");
        assert_eq!(rows, png::quantise(64, &flat));
    }
    for level in 0..=255_u8 {
        let exact = png::quantise(8, &[[f32::from(level) / 255.0; 3]; 64]);
        let off = exact.iter().filter(|p| p[0] != level).count();
        assert!(off <= 1, "{level}: v/255·255 misses by rounding only, not by dither: {off} pixels");
    }
}

/// A box whose white walls reflect 0.3 … 0.6 in half of the picture, with a small lamp at 20 and black around.
fn room(lamp: u32, border: u32) -> Image {
    image(64, 64, |x, y| match (x, y) {
        _ if x < border || y < border => [0.0; 3],
        _ if x >= 64 - lamp && y >= 64 - lamp => [20.0; 3],
        _ if x % 2 == 0 => [0.3 + 0.3 * y as f32 / 63.0; 3],
        _ => [0.2, 0.02, 0.02],
    })
}

/// Automatic exposure makes walls bright but not blown, and neither lamp nor black background changes that.
#[test]
fn auto_exposure_is_for_the_walls() {
    let display = Display::default();
    let reference = display.scale(&room(0, 0));
    assert!((0.8..1.0).contains(&(0.6 * reference)), "brightest wall at {}", 0.6 * reference);
    for (lamp, border) in [(4, 0), (12, 0), (0, 20), (8, 32)] {
        let ratio = display.scale(&room(lamp, border)) / reference;
        assert!((0.9..1.1).contains(&ratio), "lamp {lamp}, border {border}: {ratio}");
    }
    // Twice the light, half the factor: the picture does not depend on the unit.
    let mut doubled = room(4, 4);
    doubled.pixels.iter_mut().flatten().for_each(|x| *x *= 2.0);
    assert!((display.scale(&doubled) * 2.0 / display.scale(&room(4, 4)) - 1.0).abs() < 1e-5);
    for nothing in [grey(4, 4, 0.0), grey(4, 4, f32::NAN), Image::new(0, 0)] {
        assert_eq!(display.scale(&nothing), 1.0);
    }
}

/// Each transform maps black to black, grows with radiance, stays in 0 … 1; what is not finite is magenta.
#[test]
fn transforms_are_monotonic_and_bounded() {
    for transform in [Transform::Srgb, Transform::Filmic, Transform::Perception] {
        let ramp = image(200, 1, |x, _| [if x == 0 { 0.0 } else { 10f32.powf(x as f32 / 20.0 - 5.0) }; 3]);
        let shown = Display { exposure: Exposure::Stops(0.0), transform }.apply(&ramp);
        assert_eq!(shown[0], [0.0; 3], "{transform:?}");
        assert!(shown.windows(2).all(|w| w[1][0] >= w[0][0]), "{transform:?}");
        assert!(shown.iter().flatten().all(|v| (0.0..=1.0).contains(v)), "{transform:?}");
        assert!(shown[199][0] > 0.99, "{transform:?}");
        let odd = image(2, 1, |x, _| if x == 0 { [0.5, f32::NAN, 0.5] } else { [f32::INFINITY; 3] });
        let shown = Display { exposure: Exposure::Auto, transform }.apply(&odd);
        assert_eq!(shown, [[1.0, 0.0, 1.0]; 2], "{transform:?}");
    }
}

/// Perception: screen values are log(1 + L/L0)/log(1 + Lmax/L0), and the ratio of the bands stays (hue).
#[test]
fn perception_is_logarithmic_and_keeps_hue() {
    let (threshold, brightest) = (0.01_f32, 50.0_f32);
    let levels = [0.001, 0.01, 0.3, 2.0, brightest];
    let grey_levels = image(5, 1, |x, _| [levels[x as usize]; 3]);
    let display = Display { exposure: Exposure::Stops(0.0), transform: Transform::Perception };
    for (l, shown) in levels.iter().zip(display.apply(&grey_levels)) {
        let expected = (l / threshold).ln_1p() / (brightest / threshold).ln_1p();
        assert!((shown[1] - expected).abs() < 1e-4, "{l}: {shown:?} {expected}");
    }
    let coloured = image(2, 1, |x, _| if x == 0 { [0.2, 0.1, 0.05] } else { [50.0; 3] });
    let shown = display.apply(&coloured)[0].map(linear_from_srgb);
    assert!(
        (shown[0] / shown[1] - 2.0).abs() < 1e-3 && (shown[1] / shown[2] - 2.0).abs() < 1e-3,
        "{shown:?}"
    );
    // A blue as bright as white does not fit: it fades toward white rather than turning cyan or clipping.
    let blue = image(2, 1, |x, _| if x == 0 { [0.0, 0.0, 600.0] } else { [50.0; 3] });
    let shown = display.apply(&blue)[0];
    assert!(shown[2] > 0.99 && (shown[0] - shown[1]).abs() < 1e-5 && shown[0] > 0.5, "{shown:?}");
}

/// The error measures of an image worked out by hand: one band of one pixel in 2050 is off by 0.5.
#[test]
fn comparison_follows_its_definition() {
    let reference = grey(50, 41, 1.0);
    let mut off = reference.clone();
    off.pixels[7][1] = 1.5;
    let found = compare(&off, &reference).expect("compared");
    let pixel = 0.25 / 1.01 / 3.0;
    assert!((found.rel_mse - pixel / 2050.0).abs() < 1e-12, "{found:?}");
    assert!((found.mse - 0.25 / 6150.0).abs() < 1e-12, "{found:?}");
    assert_eq!(found.rel_mse_trimmed, 0.0, "the three worst of 2050 pixels, 2.05 rounded up, are left out");
    assert!((found.mean_ratio[1] - (1.0 + 0.5 / 2050.0)).abs() < 1e-12 && found.mean_ratio[0] == 1.0);
    for p in [100, 200, 300] {
        off.pixels[p][1] = 1.5;
    }
    let found = compare(&off, &reference).expect("compared");
    assert!(
        (found.rel_mse_trimmed - pixel / 2047.0).abs() < 1e-12,
        "of four bad pixels one stays: {found:?}"
    );
}

/// Two images of 1 with opposite noise of 0.1 against a reference of 0.8: alone each is off by noise and reference, in
/// common they have what the reference is off by, (1 − 0.8)² less 0.1² that the noise takes from it.
#[test]
fn twins_tell_the_error_of_their_reference() {
    let noisy = |sign: f32| image(16, 16, |x, y| [1.0 + if (x + y) % 2 == 0 { 0.1 * sign } else { 0.0 }; 3]);
    let (a, b, reference) = (noisy(1.0), noisy(-1.0), grey(16, 16, 0.8));
    let scale = 1.0 / (0.64 + 0.01);
    let common = common_error(&a, &b, &reference).expect("compared");
    // half of the pixels have noise: (0.2 + 0.1)(0.2 − 0.1) = 0.03, the others 0.2²
    assert!((common.rel_mse - scale * (0.03 + 0.04) / 2.0).abs() < 1e-7, "{common:?}");
    assert!((common.deviation - scale * 0.005 / 16.0).abs() < 1e-7, "{common:?}");
    let same = common_error(&a, &a, &reference).expect("compared");
    assert!((same.rel_mse - compare(&a, &reference).expect("compared").rel_mse).abs() < 1e-12, "{same:?}");
    // unlike noise of both is in neither
    let off = |which: u32| image(16, 16, |x, _| [if x % 2 == which { 1.3 } else { 1.0 }; 3]);
    let found = common_error(&off(0), &off(1), &grey(16, 16, 1.0)).expect("compared");
    assert!(found.rel_mse.abs() < 1e-12 && found.deviation < 1e-12, "{found:?}");
    common_error(&a, &grey(8, 16, 1.0), &reference).expect_err("sizes");
}

/// Equal images differ by nothing, swapped ones are not equal, and sizes must agree.
#[test]
fn comparison_can_say_no() {
    let a = image(8, 8, |x, y| [x as f32, y as f32, 1.0]);
    let b = image(8, 8, |x, y| [y as f32, x as f32, 1.0]);
    assert_eq!(compare(&a, &a).expect("compared").rel_mse, 0.0);
    assert!(compare(&a, &b).expect("compared").rel_mse > 1.0);
    let (ab, ba) = (compare(&a, &grey(8, 8, 2.0)), compare(&grey(8, 8, 2.0), &a));
    assert!(ab.expect("ab").rel_mse != ba.expect("ba").rel_mse, "the reference is in the denominator");
    let error = compare(&a, &grey(8, 9, 1.0)).expect_err("sizes").to_string();
    assert!(error.contains("8x8") && error.contains("8x9"), "{error}");
    compare(&Image::new(0, 0), &Image::new(0, 0)).expect_err("no pixels");
}

/// A reference's bad pixel is skipped but counted in the mean, as free of error; an image's own is never accepted.
#[test]
fn values_that_are_not_finite_are_told_apart() {
    let mut reference = grey(4, 4, 1.0);
    reference.pixels[3] = [f32::NAN, 1.0, 1.0];
    let found = compare(&grey(4, 4, 2.0), &reference).expect("compared");
    assert!((found.rel_mse - 15.0 / 16.0 / 1.01).abs() < 1e-9, "{found:?}");
    assert_eq!((found.mean_ratio, found.non_finite), ([2.0; 3], 0));
    for bad in [f32::NAN, f32::INFINITY] {
        let mut image = grey(4, 4, 1.0);
        image.pixels[3][2] = bad;
        // Also where the reference is not finite either.
        let found = compare(&image, &reference).expect("compared");
        assert_eq!((found.non_finite, found.rel_mse), (1, f64::INFINITY));
        assert!(found.rel_mse_trimmed.is_infinite() && found.mse.is_infinite());
    }
}

/// Regions tile the image and find the place of a bias.
#[test]
fn regions_show_where_the_bias_is() {
    let reference = grey(10, 7, 2.0);
    let mut biased = reference.clone();
    for y in 0..7 {
        for x in 5..10 {
            biased.pixels[y * 10 + x] = [3.0, 2.0, 2.0];
        }
    }
    let regions = region_ratios(&biased, &reference, 2).expect("regions");
    let ratios: Vec<f64> = regions.iter().map(|r| r.ratio[0]).collect();
    assert_eq!(ratios, [1.0, 1.5, 1.0, 1.5]);
    for n in [1, 3, 7, 100] {
        let regions = region_ratios(&biased, &reference, n).expect("regions");
        let pixels: u32 = regions.iter().map(|r| r.size[0] * r.size[1]).sum();
        assert_eq!(pixels, 70, "{n}");
        assert!(regions.iter().all(|r| r.size[0] > 0 && r.size[1] > 0), "{n}");
    }
}

/// The heat map is brighter where the error is larger, and has its scale below.
#[test]
fn heatmap_grows_with_the_error() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("heat.png");
    let reference = grey(40, 8, 1.0);
    let off = image(40, 8, |x, _| [1.0 + 0.003 * x as f32; 3]);
    let errors = relative_errors(&off, &reference).expect("errors");
    assert!(errors[0] == 0.0 && errors[39] > errors[1]);
    write_heatmap(&path, &off, &reference).expect("written");
    let (width, height, bytes) = decode(&path);
    assert!(width == 40 && height > 8);
    let brightness: Vec<u32> =
        bytes[..40 * 3].chunks(3).map(|p| p.iter().map(|&v| u32::from(v)).sum()).collect();
    assert!(
        brightness.windows(2).all(|w| w[1] >= w[0]) && brightness[39] > brightness[0] + 100,
        "{brightness:?}"
    );
}
