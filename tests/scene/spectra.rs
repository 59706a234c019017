//! Colours, light and indices that a scene file states by wavelength.

use crate::folder::{Folder, refused};
use joton::Error;
use joton::scene::{Scene, WavelengthReason};
use joton::spectrum::Spectrum;
use joton::spectrum::glass::Index;

const SUN: &str = "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n";

fn load(toml: &str) -> Result<Scene, Error> {
    Folder::new(&[("s.toml", toml.as_bytes())]).load("s.toml")
}

/// A cube of a material under the sun.
fn cube(keys: &str) -> Result<Scene, Error> {
    load(&format!("[[shape]]\nkind = \"cube\"\nmaterial = {{ {keys} }}\n{SUN}"))
}

/// A cube under a sun of this irradiance.
fn lit(irradiance: &str) -> Result<Scene, Error> {
    load(&format!("[[shape]]\nkind = \"cube\"\n{}", SUN.replace("= 1\n", &format!("= {irradiance}\n"))))
}

/// What is stated by wavelength comes with its colour, goes to the lobes that the material has, and asks for wavelengths.
#[test]
fn spectra_are_read_and_ask_for_wavelengths() {
    let plain = cube("kd = [0.1, 0.2, 0.3]").unwrap();
    assert_eq!((plain.asks_for_wavelengths(), plain.wavelengths.are_rendered), (None, false));
    assert!(plain.materials[0].spectra.is_none());

    let scene = cube("kd = { spectrum = [[400, 0.5], [700, 0.5]] }").unwrap();
    assert_eq!(scene.asks_for_wavelengths(), Some(WavelengthReason::Spectra));
    assert!(scene.wavelengths.are_rendered);
    // a grey is grey
    assert!(
        scene.materials[0].diffuse.iter().all(|x| (x - 0.5).abs() < 1e-5),
        "{:?}",
        scene.materials[0].diffuse
    );
    let spectra = scene.materials[0].spectra.as_ref().expect("stated");
    assert!(spectra.diffuse.as_ref().is_some_and(|s| s.at(550.0) == 0.5) && spectra.specular.is_none());

    let scene = cube("type = \"mirror\", ks = { spectrum = [[400, 0.1], [700, 0.9]] }").unwrap();
    let spectra = scene.materials[0].spectra.as_ref().expect("stated");
    assert!(spectra.specular.is_some() && spectra.glossy.is_none());
    let [r, _, b] = scene.materials[0].specular;
    assert!(r > 0.6 && b < 0.4, "reddish: {:?}", scene.materials[0].specular);
}

#[test]
fn lights_have_spectra() {
    let lamp = lit("{ lamp = \"sodium\", power = 3 }").unwrap();
    assert_eq!(lamp.asks_for_wavelengths(), Some(WavelengthReason::Lines));
    let light = lamp.wavelengths.lights[0].as_ref().expect("stated");
    assert!((light.to_xyz()[1] - 3.0).abs() < 1e-9, "luminance 3: {:?}", light.to_xyz());
    // yellow: no blue of an sRGB screen, and none that is negative
    let [r, g, b] = lamp.lights[0].power();
    assert!(r > g && g > 0.0 && b == 0.0, "{r} {g} {b}");

    let daylight = lit("{ illuminant = \"D65\" }").unwrap();
    assert_eq!(daylight.asks_for_wavelengths(), Some(WavelengthReason::Spectra));
    assert!(daylight.lights[0].power().iter().all(|x| (x - 1.0).abs() < 1e-5));
    let warm = lit("{ blackbody = 2700, power = 2 }").unwrap();
    let [r, g, b] = warm.lights[0].power();
    assert!(r > 2.0 && g < 2.0 && b < g, "{r} {g} {b}");
    let laser = lit("{ lines = [[532, 1.5]] }").unwrap();
    assert_eq!(laser.wavelengths.lights[0].as_ref().expect("stated").lines[0].power, 1.5);
    let glow = cube("kd = 0.5, ke = { blackbody = 3000 }").unwrap();
    assert!(
        glow.materials[0].emits() && glow.materials[0].spectra.as_ref().expect("stated").emission.is_some()
    );
}

#[test]
fn glasses_have_indices() {
    for (ior, at_d) in [
        ("\"bk7\"", 1.5168),
        ("{ glass = \"Diamond\" }", 2.4175),
        ("{ nd = 1.62, abbe = 36.4 }", 1.62),
        ("{ cauchy = [1.5, 0.00345] }", 1.51),
        (
            "{ sellmeier = [1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, 103.560653] }",
            1.5168,
        ),
        ("{ spectrum = [[400, 1.6], [700, 1.5]] }", 1.537_48),
    ] {
        let scene = cube(&format!("type = \"glass\", ior = {ior}")).unwrap_or_else(|e| panic!("{ior}: {e}"));
        let found = scene.materials[0].dielectric.expect("glass").ior;
        assert!((found - at_d).abs() < 2e-4, "{ior}: {found}, not {at_d}");
        assert_eq!(scene.asks_for_wavelengths(), Some(WavelengthReason::Dispersion), "{ior}");
    }
    // one number has no dispersion, and what is no glass has no index
    assert_eq!(cube("type = \"glass\", ior = 1.5").unwrap().asks_for_wavelengths(), None);
    assert_eq!(cube("type = \"matte\", ior = \"bk7\"").unwrap().asks_for_wavelengths(), None);
    assert!(Index::named("bk7").is_some_and(|i| i.is_dispersive()));
}

/// A statement of a scene file replaces another whole: a colour takes away a spectrum that was stated before.
#[test]
fn statements_replace_spectra() {
    let stated = "[[material]]\nname = \"a\"\nkd = { spectrum = [[400, 0.2], [700, 0.2]] }\n";
    let again = "[[material]]\nname = \"a\"\nkd = 0.7\n";
    let shape = "[[shape]]\nkind = \"cube\"\nmaterial = \"a\"\n";
    let scene = load(&format!("{shape}{stated}{again}{SUN}")).unwrap();
    assert_eq!((scene.materials[0].diffuse, scene.asks_for_wavelengths()), ([0.7; 3], None));
    let scene = load(&format!("{shape}{again}{stated}{SUN}")).unwrap();
    let spectra = scene.materials[0].spectra.as_ref().expect("stated");
    assert!(matches!(spectra.diffuse, Some(Spectrum::Table(_))));
}

/// Faults name their line and what was meant.
#[test]
fn faults_of_spectra_have_lines() {
    for (keys, words) in [
        ("kd = { spectrum = [[400, 0.5]] }", "ascending order"),
        ("kd = { spectrum = [[700, 0.5], [400, 0.5]] }", "ascending order"),
        ("kd = { spectrum = [[400, 0.5], [700, 1.5]] }", "must be 1 or less"),
        ("kd = { spectrum = [400, 0.5] }", "pairs of finite numbers"),
        ("kd = { colour = 1 }", "unknown key in kd: \"colour\""),
        ("kd = \"red\"", "three finite numbers"),
        ("type = \"glass\", ior = \"bk8\"", "did you mean \"bk7\"?"),
        ("type = \"glass\", ior = { nd = 1.5 }", "ior has no abbe"),
        ("type = \"glass\", ior = { nd = 1.5, abbe = -3 }", "an Abbe number is above zero"),
        ("type = \"glass\", ior = { cauchy = [1.5] }", "cauchy has a wrong number of values"),
        ("type = \"glass\", ior = { cauchy = [-1, 0] }", "no number above zero"),
        ("ke = { blackbody = 20 }", "not a temperature of a light"),
    ] {
        refused(cube(keys), "s.toml:3", words);
    }
    for (irradiance, words) in [
        ("{ power = 3 }", "irradiance is stated by 0 of spectrum, lines, blackbody, illuminant, lamp"),
        ("{ lamp = \"sodium\", illuminant = \"A\" }", "stated by 2"),
        ("{ lamp = \"natrium\" }", "unknown lamp \"natrium\"; known are sodium, mercury"),
        ("{ illuminant = \"D66\" }", "unknown illuminant \"D66\""),
        ("{ lines = [[1064, 1]] }", "a line at 1064 nm cannot be seen"),
        ("{ lines = [[532, 0]] }", "has the power 0"),
        ("{ blackbody = 3000, power = -1 }", "power is negative"),
        ("{ blackbody = 3000, power = 1e300 }", "too bright for a number"),
        ("{ blackbody = 3000, power = 0 }", "light without irradiance"),
    ] {
        refused(lit(irradiance), "s.toml:6", words);
    }
}

/// A file of a spectrum stands for its pairs, however it is written, beside the scene file; it counts as read.
#[test]
fn spectra_come_from_files() {
    let scene = |keys: &str| {
        format!(
            "[[shape]]\nkind = \"cube\"\nmaterial = {{ {keys} }}\n{}",
            SUN.replace("= 1\n", "= { spectrum = \"sun.spd\" }\n")
        )
    };
    let paint = "# measured\r\n 700.5,0.75\r\n400\t0.25 # ends\r\n\r\n550 ; 5e-1\r\n";
    let folder = |keys: &str, paint: &str| {
        let (toml, sun) = (scene(keys), "360 1\n830 3\n");
        Folder::new(&[
            ("s.toml", toml.as_bytes()),
            ("paint.SPD", paint.as_bytes()),
            ("sun.spd", sun.as_bytes()),
        ])
    };
    let read = folder("kd = { spectrum = \"paint.SPD\" }", paint).load("s.toml").unwrap();
    let stated =
        folder("kd = { spectrum = [[400, 0.25], [550, 0.5], [700.5, 0.75]] }", paint).load("s.toml").unwrap();
    assert_eq!(read.materials[0].spectra.as_ref().unwrap(), stated.materials[0].spectra.as_ref().unwrap());
    assert_eq!(read.materials[0].diffuse, stated.materials[0].diffuse);
    let light = read.wavelengths.lights[0].as_ref().and_then(|e| e.continuous.as_ref()).expect("stated");
    assert_eq!((light.at(595.0), light.at(359.0)), (2.0, 0.0));
    let names = |scene: &Scene| -> Vec<String> {
        let mut names: Vec<_> =
            scene.files.iter().map(|f| f.file_name().unwrap().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    assert_eq!(names(&read), ["paint.SPD", "s.toml", "sun.spd"]);
    let glass = folder("type = \"glass\", ior = { spectrum = \"paint.SPD\" }", "400 1.7\n700 1.5\n")
        .load("s.toml")
        .unwrap();
    assert_eq!(glass.asks_for_wavelengths(), Some(WavelengthReason::Dispersion));

    for (text, parts) in [
        ("400 0.1\n500 0.2 0.3\n", &["paint.SPD:2:", "no wavelength and value", "550 0.25"][..]),
        ("400 0.1\nred 0.2\n", &["paint.SPD:2:", "no wavelength and value"]),
        ("400 0.1\n500 nan\n", &["paint.SPD:2:", "no wavelength and value"]),
        ("400 10\n500 20\n", &["paint.SPD:1:", "at 400 nm is 10", "no percents"]),
        ("-400 0.1\n500 0.2\n", &["paint.SPD:1:", "not a wavelength"]),
        ("500 0.1\n400 0.2\n500 0.3\n", &["paint.SPD:3:", "on line 1, too", "once"]),
        ("# nothing\n500 0.1\n", &["paint.SPD", "two wavelengths or more, this has 1"]),
    ] {
        let told = folder("kd = { spectrum = \"paint.SPD\" }", text).load("s.toml").unwrap_err().to_string();
        assert!(parts.iter().all(|part| told.contains(part)), "{text}: {told}");
    }
    let told = folder("kd = { spectrum = \"none.spd\" }", paint).load("s.toml").unwrap_err().to_string();
    assert!(["s.toml:3:", "none.spd"].iter().all(|part| told.contains(part)), "{told}");
}

/// Material libraries name such files, in any case of letters, with a factor or without; what cannot be read is ignored with a warning.
/// Of two statements the later counts, whichever is by wavelength.
#[test]
fn material_libraries_name_files_of_spectra() {
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 -1\nusemtl a\nf 1 2 3\n";
    let load = |mtl: &str| {
        let files = [
            ("s.obj", obj.as_bytes()),
            ("m.mtl", mtl.as_bytes()),
            ("my paint.spd", b"700 0.8\n400 0.4\n".as_slice()),
            ("lamp.spd", b"400 1\n700 1\n"),
            ("wrong.spd", b"400 1\nred\n"),
        ];
        Folder::new(&files).load("s.obj").unwrap()
    };
    let scene = load("newmtl a\nKd spectral My Paint.spd 0.5\nKe spectral lamp.spd 3 # bright\n");
    let spectra = scene.materials[0].spectra.as_ref().expect("stated");
    let value = spectra.diffuse.as_ref().map_or(0.0, |s| s.at(550.0));
    assert!((value - 0.3).abs() < 1e-12, "{value}, {:?}", scene.warnings);
    let light = spectra.emission.as_ref().and_then(|e| e.continuous.as_ref());
    assert_eq!(light.map(|s| s.at(550.0)), Some(3.0));
    assert!(scene.wavelengths.are_rendered && scene.materials[0].emission.iter().all(|x| *x > 0.0));
    for name in ["my paint.spd", "lamp.spd"] {
        assert!(scene.files.iter().any(|f| f.ends_with(name)), "{name}: {:?}", scene.files);
    }
    let later = load("newmtl a\nKd spectral my paint.spd\nKd 0.1 0.2 0.3\n");
    assert!(later.materials[0].spectra.is_none() && later.materials[0].diffuse == [0.1, 0.2, 0.3]);
    let later = load("newmtl a\nKd 0.1 0.2 0.3\nKd spectral my paint.spd\n");
    assert!(later.materials[0].spectra.is_some());
    for (mtl, parts) in [
        ("Kd spectral none.spd", &["m.mtl:2", "Kd: there is no file none.spd", "ignored"][..]),
        ("Kd spectral wrong.spd", &["m.mtl:2", "wrong.spd:2", "no wavelength and value", "ignored"]),
        ("Ni spectral lamp.spd", &["m.mtl:2", "only Kd, Ks, Ke and Tf"]),
    ] {
        let scene = load(&format!("newmtl a\n{mtl}\n"));
        let told = scene.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
        assert!(parts.iter().all(|part| told.contains(part)), "{mtl}: {told}");
        assert!(scene.materials[0].spectra.is_none());
    }
}
