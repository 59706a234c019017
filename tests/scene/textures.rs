//! Textures: coordinates, pictures, and what MTL and scene files say of them.

use crate::folder::{Folder, refused, warned};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use joton::Error;
use joton::scene::Scene;
use joton::scene::texture::{Channel, Filter, ReliefKind, Space, Texels, Wrap};
use std::io::Cursor;

const SQUARE: &str =
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\n";

/// A picture of one colour in a format.
fn picture(colour: [u8; 3], format: ImageFormat) -> Vec<u8> {
    let image = DynamicImage::ImageRgb8(RgbImage::from_pixel(3, 2, Rgb(colour)));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn png(colour: [u8; 3]) -> Vec<u8> {
    picture(colour, ImageFormat::Png)
}

/// A square with texture coordinates, of material `m`, beside pictures.
fn load(faces: &str, mtl: &str, pictures: &[(&str, &[u8])]) -> Result<Scene, Error> {
    let obj = format!("{SQUARE}{faces}\n");
    let mtl = format!("newmtl m\n{mtl}\n");
    let mut files = vec![("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_bytes())];
    files.extend_from_slice(pictures);
    Folder::new(&files).load("a.obj")
}

/// The square with a picture `a.png` of one colour.
fn textured(mtl: &str) -> Scene {
    load("f 1/1 2/2 3/3 4/4", mtl, &[("a.png", &png([255, 0, 102]))]).unwrap()
}

/// The texture coordinates of each corner of each triangle, by where it lies.
fn corners(scene: &Scene) -> Vec<([f64; 2], [f32; 2])> {
    let mesh = &scene.mesh;
    let of = |t: &joton::scene::Triangle| {
        let uv = t.uv.expect("coordinates");
        let corner = move |k: usize| {
            let p = mesh.positions[t.vertex[k] as usize];
            ([p.x, p.y], mesh.uvs[uv[k] as usize])
        };
        [0, 1, 2].map(corner)
    };
    mesh.triangles.iter().flat_map(of).collect()
}

/// Corners keep their coordinates in polygons that are cut, with and without normals, counted backwards, and where a mirror turns the
/// triangle over.
#[test]
fn corners_keep_their_coordinates() {
    for faces in ["f 1/1 2/2 3/3 4/4", "f -4/-4 -3/-3 -2/-2 -1/-1", "vn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1"] {
        let scene = load(faces, "map_Kd a.png", &[("a.png", &png([9; 3]))]).unwrap();
        assert_eq!(corners(&scene).len(), 6);
        for ([x, y], [u, v]) in corners(&scene) {
            assert_eq!([x as f32, y as f32], [u, v], "{faces}");
        }
    }
    let obj = format!("{SQUARE}f 1/1 2/2 3/3 4/4\n");
    let toml = "[[mesh]]\nfile = \"a.obj\"\nmatrix = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]\n\
        [[light]]\nkind = \"sun\"\ndirection = [0, 0, 1]\nirradiance = 1\n";
    let files = [
        ("a.obj", obj.as_bytes()),
        ("m.mtl", &b"newmtl m\nmap_Kd a.png\n"[..]),
        ("a.png", &png([9; 3])),
        ("s.toml", toml.as_bytes()),
    ];
    let scene = Folder::new(&files).load("s.toml").unwrap();
    for ([x, y], [u, v]) in corners(&scene) {
        assert_eq!([-x as f32, y as f32], [u, v], "mirrored");
    }
}

/// Coordinates that are wrong or missing are told, and nothing is lost by them; a scene without textures keeps none.
#[test]
fn faults_of_coordinates_are_told() {
    let picture = png([9; 3]);
    let with = |faces: &str| load(faces, "map_Kd a.png", &[("a.png", &picture)]).unwrap();
    let scene = with("f 1/1 2/2 3/9");
    warned(&scene, "a.obj:11", "texture coordinates that do not exist");
    warned(&scene, "a.obj:11", "without texture coordinates");
    assert!(scene.mesh.triangles[0].uv.is_none());
    let scene = with("vt x 1\nvt 0.5\nvt 1 2 3\nf 1/5 2/6 3/7");
    warned(&scene, "a.obj:11", "not finite numbers");
    let uvs: Vec<[f32; 2]> = corners(&scene).into_iter().map(|(_, uv)| uv).collect();
    assert_eq!(uvs, [[0.0; 2], [0.5, 0.0], [1.0, 2.0]]);
    let plain = load("f 1/1 2/2 3/3", "Kd .5 .5 .5", &[]).unwrap();
    assert!(plain.mesh.uvs.is_empty() && plain.mesh.triangles[0].uv.is_none());
}

/// map_Kd multiplies Kd, and stands alone where Kd is black or absent; the largest texel says how much is reflected.
#[test]
fn map_kd_multiplies_kd() {
    for (mtl, wanted) in [("Kd .5 .25 1\n", [0.5, 0.25, 1.0]), ("", [1.0; 3]), ("Kd 0 0 0\n", [1.0; 3])] {
        let scene = textured(&format!("{mtl}map_Kd a.png"));
        assert_eq!(scene.materials[0].diffuse, wanted, "{mtl}");
        let texture = scene.materials[0].diffuse_texture.as_ref().expect("a texture");
        assert_eq!((texture.bitmap.size, texture.space), ([3, 2], Space::Srgb));
        let most = texture.most();
        assert!(most[0] == 1.0 && most[1] == 0.0 && (most[2] - 0.132_868_3).abs() < 1e-6, "{most:?}");
        assert!(scene.files.iter().any(|f| f.ends_with("a.png")), "it is read, so it is not written over");
    }
    // 1 + 0.5 in red, 0.13 + 0.5 in blue
    let m = textured("Ks .5 .5 .5\nNs 10\nmap_Kd a.png").materials.remove(0);
    assert!((m.diffuse[0] - 2.0 / 3.0).abs() < 1e-6 && (m.glossy[0] - 1.0 / 3.0).abs() < 1e-6, "{m:?}");
}

/// In Blender's libraries the texture is the whole of the colour, of metal as of the rest.
#[test]
fn blender_means_the_texture_alone() {
    for (statements, wanted) in [("Kd .5 .5 .5\n", 1.0), ("", 1.0), ("Kd .5 .5 .5\nillum 3\nPm 0.25\n", 1.0)]
    {
        let mtl = format!("# Blender 4.0\nnewmtl m\n{statements}map_Kd a.png\n");
        let obj = format!("{SQUARE}f 1/1 2/2 3/3\n");
        let files = [("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_bytes()), ("a.png", &png([128; 3]))];
        let m = Folder::new(&files).load("a.obj").unwrap().materials.remove(0);
        assert_eq!(m.diffuse, [wanted; 3], "{statements}");
        let metal = m.metallic.map_or(0.0, |metal| metal.most);
        assert_eq!(metal, if statements.contains("Pm") { 0.25 } else { 0.0 }, "{statements}");
    }
}

/// Blender without PBR extensions writes the picture of the roughness as map_Ns, and that of the metallic part as map_refl. Elsewhere
/// these are not read.
#[test]
fn blender_calls_the_picture_of_roughness_map_ns() {
    let with = |first: &str, statements: &str| {
        let mtl = format!("{first}\nnewmtl m\nKd .5 .5 .5\nNs 250\n{statements}");
        let obj = format!("{SQUARE}f 1/1 2/2 3/3\n");
        let picture = DynamicImage::ImageRgb8(RgbImage::from_fn(2, 1, |x, _| Rgb([51 + 153 * x as u8; 3])));
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let files = [("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_bytes()), ("a.png", bytes.get_ref())];
        Folder::new(&files).load("a.obj").unwrap()
    };
    let scene = with("# Blender 4.0", "map_Ns a.png\nmap_refl a.png\n");
    let m = &scene.materials[0];
    let roughness = m.roughness.as_ref().expect("a picture").range();
    let metallic = m.metallic.as_ref().and_then(|metal| metal.map.as_ref()).expect("a picture").range();
    for range in [roughness, metallic] {
        assert!((range[0] - 0.2).abs() < 1e-6 && (range[1] - 0.8).abs() < 1e-6, "{range:?}");
    }
    assert!(!scene.warnings.iter().any(|w| w.contains("is not read")), "{:?}", scene.warnings);
    let scene = with("# Blender 4.0", "map_Pr a.png\nmap_Ns a.png\nmap_Ks a.png\n");
    warned(&scene, "m.mtl:6", "map_ns is not read");
    warned(&scene, "m.mtl:7", "map_ks is not read");
    let scene = with("", "Pr .5\nmap_Ns a.png\n");
    warned(&scene, "m.mtl:6", "map_ns is not read");
    assert!(scene.materials[0].roughness.is_none());
}

/// Each format gives its colour; the name is found as those of libraries are; a file is read once.
#[test]
fn pictures_are_read() {
    use ImageFormat::{Bmp, Jpeg, Png, Tga};
    for (format, name) in [(Png, "a.png"), (Jpeg, "a.jpg"), (Bmp, "a.bmp"), (Tga, "a.tga")] {
        let scene =
            load("f 1/1 2/2 3/3", &format!("map_Kd C:\\tmp\\{name}"), &[(name, &picture([200; 3], format))]);
        let scene = scene.unwrap();
        let texture = scene.materials[0].diffuse_texture.as_ref().expect(name);
        let Texels::Bytes(texels) = &texture.bitmap.texels else { panic!("bytes") };
        assert!(
            texels.len() == 6 && texels.iter().all(|t| t[0].abs_diff(200) <= 2 && t[3] == 255),
            "{texels:?}"
        );
    }
    let two = load(
        "f 1/1 2/2 3/3\nusemtl n\nf 1/1 3/3 4/4",
        "map_Kd A.PNG\nnewmtl n\nmap_Kd -s 2 2 a.png",
        &[("a.png", &png([1; 3]))],
    );
    let two = two.unwrap();
    let [a, b] = [0, 1].map(|i| two.materials[i].diffuse_texture.as_ref().expect("a texture"));
    assert!(std::sync::Arc::ptr_eq(&a.bitmap, &b.bitmap) && b.scale == [2.0; 2]);
}

/// Radiance and OpenEXR files are linear; what they have beyond one is cut, which a warning says.
#[test]
fn linear_pictures_are_halves() {
    let float = image::Rgb32FImage::from_pixel(2, 1, Rgb([0.25f32, 0.5, 4.0]));
    let mut hdr = Vec::new();
    let pixels: Vec<Rgb<f32>> = float.pixels().copied().collect();
    image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&pixels, 2, 1).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut picture = joton::film::Image::new(2, 1);
    picture.pixels.fill([0.25, 0.5, 4.0]);
    joton::output::exr::write_image(&folder.path().join("a.exr"), &picture, "").unwrap();
    let exr = std::fs::read(folder.path().join("a.exr")).unwrap();
    for (name, bytes) in [("a.hdr", hdr), ("a.exr", exr)] {
        let scene = load("f 1/1 2/2 3/3", &format!("map_Kd {name}"), &[(name, &bytes)]).unwrap();
        warned(&scene, "m.mtl:2", "they are cut");
        let texture = scene.materials[0].diffuse_texture.as_ref().expect(name);
        assert_eq!(texture.space, Space::Linear);
        let most = texture.most();
        assert!([0.25, 0.5, 1.0].iter().zip(most).all(|(a, b)| (a - b).abs() < 0.005), "{name}: {most:?}");
    }
}

/// What files of 16 bits say is finer than a byte; colours are encoded unless something else is said, numbers are not, and `-mm` counts
/// before that.
#[test]
fn sixteen_bits_are_kept() {
    let grey = |x: u16| {
        let image = DynamicImage::ImageLuma16(ImageBuffer::from_pixel(2, 2, Luma([x])));
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let of = |mtl: &str, x: u16| {
        let scene = load("f 1/1 2/2 3/3 4/4", mtl, &[("a.png", &grey(x))]).unwrap();
        let material = scene.materials.into_iter().find(|m| m.name == "m").unwrap();
        let roughness = material.roughness.map(|map| map.texture);
        let texture = material.diffuse_texture.or(roughness).unwrap();
        let Texels::Halves(texels) = &texture.bitmap.texels else { panic!("{:?}", texture.bitmap) };
        assert_eq!(texture.space, Space::Linear);
        f64::from(texels[0][0])
    };
    let srgb = |x: f64| ((x + 0.055) / 1.055).powf(2.4);
    for x in [20_000u16, 20_100] {
        let part = f64::from(x) / 65_535.0;
        let halves = 2f64.powi(-11);
        for (mtl, value) in [
            ("map_Kd a.png", srgb(part)),
            ("map_Kd -colorspace linear a.png", part),
            ("map_Kd -mm 0.25 0.5 a.png", srgb(0.25 + 0.5 * part)),
            ("Pr 1\nmap_Pr a.png", part),
        ] {
            let found = of(mtl, x);
            assert!((found / value - 1.0).abs() < 3.0 * halves, "{mtl}, {x}: {found}, not {value}");
        }
    }
    assert!(of("map_Kd a.png", 20_000) < of("map_Kd a.png", 20_100));
}

/// A picture that is cut, empty, no picture, or not there leaves the plain colour of an MTL, with a warning; in a scene file that is an
/// error with its line.
#[test]
fn faults_of_pictures_are_told() {
    let whole = png([9; 3]);
    let cut = &whole[..whole.len() - 20];
    for (name, bytes, words) in [
        ("a.png", cut, "no picture that can be read"),
        ("a.png", &b""[..], "no picture that can be read"),
        ("a.jpg", &b"hello"[..], "no picture that can be read"),
        ("a.exr", &b"\x76\x2f\x31\x01junk"[..], "no picture that can be read"),
        ("a.txt", &b"hello"[..], "give PNG"),
    ] {
        let scene = load("f 1/1 2/2 3/3", &format!("Kd .3 .3 .3\nmap_Kd {name}"), &[(name, bytes)]).unwrap();
        warned(&scene, "m.mtl:3", words);
        warned(&scene, "m.mtl:3", "the plain colour is used");
        assert!(scene.materials[0].diffuse_texture.is_none());
        assert_eq!(scene.materials[0].diffuse, [0.3; 3]);
        let toml = format!("{TOML}[[material]]\nname = \"m\"\nkd = {{ texture = \"{name}\" }}\n");
        refused(from_toml(&toml, &[(name, bytes)]), "s.toml:9", words);
    }
    refused(from_toml(&format!("{TOML}{NAMED}kd = {{ texture = \"no.png\" }}\n"), &[]), "s.toml:9", "no.png");
}

const TOML: &str =
    "[[mesh]]\nfile = \"a.obj\"\n[[light]]\nkind = \"sun\"\ndirection = [0, 0, 1]\nirradiance = 1\n";
const NAMED: &str = "[[material]]\nname = \"m\"\n";

/// A scene file about the square.
fn from_toml(toml: &str, pictures: &[(&str, &[u8])]) -> Result<Scene, Error> {
    let obj = format!("{SQUARE}f 1/1 2/2 3/3 4/4\n");
    let mut files =
        vec![("a.obj", obj.as_bytes()), ("m.mtl", b"newmtl m\nKd .2 .2 .2\n"), ("s.toml", toml.as_bytes())];
    files.extend_from_slice(pictures);
    Folder::new(&files).load("s.toml")
}

/// Every key of a texture arrives; a board is sharp.
#[test]
fn scene_files_say_how_a_texture_lies() {
    let picture = png([100; 3]);
    let with = |what: &str| from_toml(&format!("{TOML}{NAMED}{what}\n"), &[("a.png", &picture)]);
    let all =
        "kd = { texture = \"a.png\", scale = [2, 3], offset = 0.5, wrap = \"mirror\", space = \"linear\" }";
    let scene = with(all).unwrap();
    let t = scene.materials[0].diffuse_texture.clone().expect("a texture");
    assert_eq!((t.scale, t.offset, t.wrap, t.space), ([2.0, 3.0], [0.5; 2], Wrap::Mirror, Space::Linear));
    assert_eq!((t.filter, scene.materials[0].diffuse), (Filter::Linear, [1.0; 3]));
    let board = with("kd = { checkerboard = [[0.5, 0.5, 0.5], [0.25, 0.125, 0]], scale = 4 }").unwrap();
    let t = board.materials[0].diffuse_texture.clone().expect("a texture");
    assert_eq!((t.filter, t.scale, t.most()), (Filter::Nearest, [4.0; 2], [0.5; 3]));
    for (what, words) in [
        ("kd = { texture = \"a.png\", wrap = \"mirrored\" }", "did you mean \"mirror\"?"),
        (
            "kd = { texture = \"a.png\", checkerboard = [[0, 0, 0], [1, 1, 1]] }",
            "both texture and checkerboard",
        ),
        ("kd = { checkerboard = [[0, 0, 0], [2, 1, 1]] }", "not from 0 to 1"),
        ("kd = { checkerboard = [[0, 0, 0]] }", "two colours"),
        ("kd = { texture = \"a.png\", scale = 1e9 }", "beyond"),
        ("kd = { texture = \"a.png\", size = 2 }", "unknown key"),
        ("kd = { texture = 3 }", "a text in quotes"),
        ("opacity = 1.5", "0 (not there) to 1"),
        ("opacity = { texture = \"a.png\", wrap = 1 }", "a text in quotes"),
    ] {
        refused(with(what), "s.toml:9", words);
    }
}

/// Opacity is the picture's own where it has some, else its luminance; what shines, and glass, is opaque.
#[test]
fn opacity_is_read() {
    let mut leaf = RgbaImage::from_pixel(2, 1, Rgba([255, 255, 255, 51]));
    leaf.put_pixel(0, 0, Rgba([0, 0, 0, 255]));
    let mut bytes = Cursor::new(Vec::new());
    leaf.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let (leaf, grey) = (bytes.into_inner(), png([51; 3]));
    let with = |mtl: &str| load("f 1/1 2/2 3/3", mtl, &[("leaf.png", &leaf), ("a.png", &grey)]).unwrap();
    for (mtl, wanted) in [
        ("map_d leaf.png", [255, 51]),
        ("map_d a.png", [51, 51]),
        ("d 0\nmap_d -mm 0.5 0.5 a.png", [153, 153]),
    ] {
        let scene = with(&format!("Kd .5 .5 .5\n{mtl}"));
        let opacity = scene.materials[0].opacity.clone().expect("an opacity");
        let texture = opacity.texture.expect("a texture");
        let Texels::Bytes(texels) = &texture.bitmap.texels else { panic!("bytes") };
        assert_eq!([texels[0][3], texels[1][3]], wanted, "{mtl}");
        assert_eq!((opacity.factor, texture.space), (1.0, Space::Linear));
    }
    let shines = with("Ke 1 1 1\nmap_d a.png");
    assert!(shines.materials[0].opacity.is_none());
    warned(&shines, "m.mtl:1", "opaque");
    let glass = with("illum 4\nNi 1.5\nmap_d a.png");
    assert!(glass.materials[0].opacity.is_none());
    warned(&glass, "m.mtl:4", "textures of a glass are not read");
    let half = from_toml(&format!("{TOML}{NAMED}opacity = 0.5\n"), &[]).unwrap();
    assert_eq!(half.materials[0].opacity.as_ref().map(|o| o.factor), Some(0.5));
    assert_eq!(half.materials[0].diffuse, [0.2; 3], "the rest stays");
}

/// Roughness and metallic part from the channels of one picture, as glTF packs them; in MTL they stand in place of Pr and Pm. Where all of
/// a number is the same nothing varies.
#[test]
fn roughness_and_metal_are_read() {
    let mut packed = RgbImage::from_pixel(2, 1, Rgb([7, 51, 255]));
    packed.put_pixel(1, 0, Rgb([7, 204, 0]));
    let mut bytes = Cursor::new(Vec::new());
    packed.write_to(&mut bytes, ImageFormat::Png).unwrap();
    let packed = bytes.into_inner();
    let principled = format!("{TOML}{NAMED}type = \"principled\"\nkd = [0.8, 0.4, 0.2]\n");
    let with = |what: &str| from_toml(&format!("{principled}{what}\n"), &[("orm.png", &packed)]);
    let scene = with(
        "roughness = { texture = \"orm.png\", channel = \"g\", factor = 0.5 }\n\
         metallic = { texture = \"orm.png\", channel = \"b\" }",
    )
    .unwrap();
    let m = &scene.materials[0];
    let roughness = m.roughness.as_ref().expect("a texture");
    let metallic = m.metallic.as_ref().expect("metal");
    let metal = metallic.map.as_ref().expect("a texture");
    assert_eq!((roughness.channel, roughness.texture.space), (Channel::Green, Space::Linear));
    let [least, most] = roughness.range();
    assert!((least - 0.1).abs() < 1e-6 && (most - 0.4).abs() < 1e-6, "{least} {most}");
    assert!((m.facets.expect("facets").alpha - 0.16).abs() < 1e-6);
    assert_eq!((metallic.most, metal.channel, metal.range()), (1.0, Channel::Blue, [0.0, 1.0]));
    assert_eq!(m.diffuse, [0.8, 0.4, 0.2], "the colour of both");
    assert!(std::sync::Arc::ptr_eq(&metal.texture.bitmap, &roughness.texture.bitmap), "read once");
    // a plain number in its place, and the other way round
    let even = with("metallic = { texture = \"orm.png\", channel = \"r\", factor = 0 }").unwrap();
    assert!(even.materials[0].metallic.is_none() && even.materials[0].roughness.is_none());
    let mtl = "Kd .8 .4 .2\nPr .9\nmap_Pr -imfchan g orm.png\nmap_Pm -imfchan b orm.png";
    let scene = load("f 1/1 2/2 3/3", mtl, &[("orm.png", &packed)]).unwrap();
    let m = &scene.materials[0];
    assert!((m.facets.expect("facets").alpha - 0.64).abs() < 1e-6 && m.metallic.is_some(), "{m:?}");
    assert!(!scene.warnings.iter().any(|w| w.contains("m.mtl")), "{:?}", scene.warnings);
    let lost = load("f 1/1 2/2 3/3", "Kd .8 .4 .2\nPr .5\nmap_Pr no.png", &[]).unwrap();
    warned(&lost, "m.mtl:4", "is not found; the plain value is used");
    assert_eq!(lost.materials[0].facets.expect("facets").alpha, 0.25);
    // a metal's colour is its texture's, place by place
    let gold = format!("{TOML}{NAMED}type = \"metal\"\nkd = {{ texture = \"orm.png\" }}\n");
    let gold = from_toml(&gold, &[("orm.png", &packed)]).unwrap();
    assert!(gold.warnings.is_empty() && gold.materials[0].diffuse_texture.is_some(), "{:?}", gold.warnings);
    for (what, words) in [
        ("roughness = { texture = \"orm.png\", channel = \"x\" }", "\"x\""),
        ("roughness = { texture = \"orm.png\", factor = 2 }", "factor 2 of roughness"),
        ("roughness = { texture = \"no.png\" }", "no.png does not exist"),
        ("kd = { texture = \"orm.png\", channel = \"r\" }", "unknown key"),
    ] {
        refused(from_toml(&format!("{TOML}{NAMED}{what}\n"), &[("orm.png", &packed)]), "s.toml:9", words);
    }
    let matte = "type = \"matte\"\nmetallic = { texture = \"orm.png\" }";
    refused(from_toml(&format!("{TOML}{NAMED}{matte}\n"), &[]), "s.toml:10", "not of its kind");
}

/// Normals and heights arrive with their strength; what a library calls a bump map and has the colours of normals is one of normals.
#[test]
fn reliefs_are_read() {
    let (blue, grey) = (png([130, 120, 250]), png([90; 3]));
    let pictures = [("n.png", &blue[..]), ("h.png", &grey[..])];
    let height = |height, is_relative| ReliefKind::Heights { channel: Channel::Red, height, is_relative };
    for (mtl, wanted) in [
        ("norm n.png", ReliefKind::Normals { strength: 1.0 }),
        ("norm -bm 0.5 n.png", ReliefKind::Normals { strength: 0.5 }),
        ("map_Bump -bm 0.25 n.png", ReliefKind::Normals { strength: 0.25 }),
        ("bump -bm 3 h.png", height(0.03, true)),
        ("map_bump -bm -1 -imfchan l h.png", height(-0.01, true)),
    ] {
        let scene = load("f 1/1 2/2 3/3", &format!("Kd .5 .5 .5\n{mtl}"), &pictures).unwrap();
        let relief = scene.materials[0].relief.as_ref().expect("a relief");
        assert_eq!((relief.kind, relief.texture.space), (wanted, Space::Linear), "{mtl}");
        if mtl.starts_with("map_Bump") {
            warned(&scene, "m.mtl:3", "colours of normals");
        }
    }
    let lost = load("f 1/1 2/2 3/3", "Kd .5 .5 .5\nbump no.png", &[]).unwrap();
    warned(&lost, "m.mtl:3", "is not found");
    assert!(lost.materials[0].relief.is_none());
    let with = |what: &str| from_toml(&format!("{TOML}{NAMED}{what}\n"), &pictures);
    let kind = |what: &str| with(what).unwrap().materials[0].relief.as_ref().expect("a relief").kind;
    assert_eq!(kind("normal = { texture = \"n.png\", strength = 2 }"), ReliefKind::Normals { strength: 2.0 });
    // heights are what is said, whatever their colours
    assert_eq!(kind("bump = { texture = \"n.png\", height = 0.5 }"), height(0.5, false));
    for (what, words) in [
        ("normal = \"n.png\"", "normal is no picture"),
        ("bump = { texture = \"h.png\" }", "height"),
        ("normal = { texture = \"n.png\", height = 1 }", "unknown key"),
        ("normal = { texture = \"n.png\", wrap = \"mirror\" }", "cannot be mirrored"),
        ("bump = { texture = \"h.png\", height = 1e9 }", "beyond"),
    ] {
        refused(with(what), "s.toml:9", words);
    }
    let both = "normal = { texture = \"n.png\" }\nbump = { texture = \"h.png\", height = 1 }";
    refused(with(both), "s.toml:10", "both normal and bump");
}

/// Pictures of light multiply Ke, and stand alone where a library has none; what they have beyond one stays, and black ones are no light.
#[test]
fn pictures_of_light_are_read() {
    let (red, black) = (png([255, 0, 0]), png([0; 3]));
    let mut bright = joton::film::Image::new(2, 1);
    bright.pixels.fill([0.5, 2.0, 40.0]);
    let folder = tempfile::tempdir().unwrap();
    joton::output::exr::write_image(&folder.path().join("a.exr"), &bright, "").unwrap();
    let exr = std::fs::read(folder.path().join("a.exr")).unwrap();
    let pictures = [("r.png", &red[..]), ("k.png", &black[..]), ("b.exr", &exr[..])];
    for (mtl, wanted) in [
        ("map_Ke r.png", [1.0; 3]),
        ("Ke 0 0 0\nmap_Ke r.png", [1.0; 3]),
        ("Ke 2 3 4\nmap_Ke r.png", [2.0, 3.0, 4.0]),
    ] {
        let m = load("f 1/1 2/2 3/3", mtl, &pictures).unwrap().materials.remove(0);
        assert_eq!((m.emission, m.emission_texture.is_some()), (wanted, true), "{mtl}");
        assert_eq!(m.diffuse, [0.0; 3], "what shines and says no more is black");
    }
    let none = load("f 1/1 2/2 3/3", "Kd .5 .5 .5\nKe 1 1 1\nmap_Ke k.png", &pictures).unwrap();
    assert!(!none.materials[0].emits() && none.materials[0].emission_texture.is_none());
    let both = load("f 1/1 2/2 3/3", "map_Kd b.exr\nmap_Ke b.exr", &pictures).unwrap();
    let m = &both.materials[0];
    let [kd, ke] = [&m.diffuse_texture, &m.emission_texture].map(|t| t.as_ref().expect("a texture").most());
    assert_eq!((kd, ke), ([0.5, 1.0, 1.0], [0.5, 2.0, 40.0]));
    let with = |what: &str| from_toml(&format!("{TOML}{NAMED}{what}\n"), &pictures);
    let scene = with("ke = { texture = \"r.png\", power = 5 }").unwrap();
    assert_eq!(scene.materials[0].emission, [5.0; 3]);
    for (what, words) in [
        ("ke = { texture = \"no.png\" }", "does not exist"),
        ("ke = { texture = \"r.png\", power = -1 }", "power is negative"),
        ("ke = { texture = \"r.png\", blackbody = 3000 }", "unknown key"),
    ] {
        refused(with(what), "s.toml:9", words);
    }
}
