//! What scene files say of the inside of bodies: what it absorbs, and which of several bodies counts.

use crate::folder::{Folder, refused};
use joton::Error;
use joton::scene::{Material, Scene};

/// A cube of glass under the sun, with these keys from line 4 on.
fn scene(keys: &str) -> Result<Scene, Error> {
    let toml = format!(
        "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n\
         [[shape]]\nkind = \"cube\"\nmaterial = \"m\"\n[[material]]\nname = \"m\"\n{keys}\n"
    );
    let spd = "400 1\n500 2\n700 8\n";
    Folder::new(&[("s.toml", toml.as_bytes()), ("wine.spd", spd.as_bytes())]).load("s.toml")
}

fn glass(keys: &str) -> Material {
    scene(&format!("type = \"glass\"\n{keys}")).unwrap_or_else(|e| panic!("{e}")).materials.remove(0)
}

fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs())
}

/// Per unit of length, as bands or one number, or as what is left after a length.
#[test]
fn absorption_is_stated_per_length() {
    assert_eq!(glass("").interior, Default::default());
    assert_eq!(glass("absorption = [1, 0, 2.5]").interior.absorption, [1.0, 0.0, 2.5]);
    assert_eq!(glass("absorption = 3").interior.absorption, [3.0; 3]);
    let pair = glass("attenuation_color = [0.4, 1, 0.16]\nattenuation_distance = 2").interior.absorption;
    // e^(−2σ) = c
    assert!(near(pair, [0.458_145_4, 0.0, 0.916_290_7]), "{pair:?}");
    // black is as good as black
    let black = glass("attenuation_color = 0\nattenuation_distance = 1").interior.absorption;
    assert!(black[0] > 10.0 && black[0].is_finite(), "{black:?}");
    assert_eq!(glass("priority = -4").interior.priority, Some(-4));
}

/// By wavelength, in the file or beside it: what is stated is kept, and bands are those of what is left of white.
#[test]
fn absorption_is_stated_by_wavelength() {
    for stated in ["[[400, 1], [500, 2], [700, 8]]", "\"wine.spd\""] {
        let m = glass(&format!("absorption = {{ spectrum = {stated} }}"));
        let spectrum = m.spectra.as_ref().and_then(|s| s.absorption.clone()).expect("a spectrum");
        for (lambda, value) in [(360.0, 1.0), (450.0, 1.5), (600.0, 5.0), (830.0, 8.0)] {
            assert!(
                (spectrum.at(lambda) - value).abs() < 1e-9,
                "{stated}, {lambda} nm: {}",
                spectrum.at(lambda)
            );
        }
        let [red, green, blue] = m.interior.absorption;
        assert!(red > green && green > blue && blue > 1.0 && red < 8.0, "{:?}", m.interior.absorption);
    }
    let left = "attenuation_color = { spectrum = [[400, 0.5], [700, 1]] }\nattenuation_distance = 0.5";
    let spectrum = glass(left).spectra.as_ref().and_then(|s| s.absorption.clone()).expect("a spectrum");
    // −ln .5 / .5, and between the two −ln .75 / .5
    for (lambda, value) in [(400.0, 1.386_294_4), (550.0, 0.575_364_1), (700.0, 0.0)] {
        assert!((spectrum.at(lambda) - value).abs() < 1e-6, "{lambda} nm: {}", spectrum.at(lambda));
    }
    let even = glass("absorption = { spectrum = [[400, 3], [700, 3]] }");
    assert!(near(even.interior.absorption, [3.0; 3]), "{:?}", even.interior);
}

/// What is wrong names its line and says what to do.
#[test]
fn faults_are_told() {
    let glass = "type = \"glass\"\n";
    for (keys, line, words) in [
        ("absorption = -1", 11, "at least 0"),
        ("absorption = \"much\"", 11, "at least 0"),
        ("absorption = { spectrum = [[400, -1], [500, 1]] }", 11, "ascending order"),
        ("absorption = { colour = 1 }", 11, "known are spectrum"),
        ("absorption = 1\nattenuation_color = 0.5\nattenuation_distance = 1", 11, "stated twice"),
        ("attenuation_color = 0.5", 11, "attenuation_color without attenuation_distance"),
        ("attenuation_distance = 0.5", 11, "attenuation_distance without attenuation_color"),
        ("attenuation_color = 1.5\nattenuation_distance = 1", 11, "from 0 to 1"),
        ("attenuation_color = 0.5\nattenuation_distance = 0", 12, "attenuation_distance of 0"),
        ("attenuation_color = 0.5\nattenuation_distance = inf", 12, "a finite number"),
        ("priority = 1.5", 11, "a whole number"),
    ] {
        refused(scene(&format!("{glass}{keys}")), &format!("s.toml:{line}"), words);
    }
    refused(scene("type = \"matte\"\nabsorption = 1"), "s.toml:11", "absorption of what is no glass");
    refused(scene("type = \"plastic\"\npriority = 1"), "s.toml:11", "give type = \"glass\"");
}
