//! Twins: for each part that can be skipped, a scene where it is and its twin where it is not.

use super::scenes::{Builder, emitter, glass, mirror};
use glam::DVec3;
use joton::plan::{Part, Reason};
use joton::scene::texture::{
    Bitmap, Channel, Filter, NumberMap, Opacity, Relief, ReliefKind, Space, Texels, Texture, f16,
};
use joton::scene::{
    Anisotropy, FacetKind, Facets, Inner, Interior, Layers, Light, Material, MaterialSpectra, Metallic,
    Mixture, Scene,
};
use joton::spectrum::glass::Index;
use std::path::Path;
use std::sync::Arc;

/// Every path from a light to the eye.
pub const EVERYTHING: &str = "L.*E";
/// Light that bounces once.
const ONE_BOUNCE: &str = "LDE";
/// Light of mirrors and glass, and no other.
const CAUSTICS: &str = "LS+DE";

/// A scene and the paths that are wanted of it.
pub struct Case {
    /// In a few words.
    pub name: &'static str,
    /// What is rendered.
    pub scene: Scene,
    /// Light path expression.
    pub paths: &'static str,
    /// What is kept, whether the scene needs it or not.
    pub keep: &'static [Part],
}

/// A part, where it is skipped, and the twin where it is needed.
pub struct Twins {
    /// The part.
    pub part: Part,
    /// Why it is skipped.
    pub why: Reason,
    /// Here it is skipped.
    pub without: Case,
    /// Here it is not.
    pub with: Case,
}

fn case(name: &'static str, scene: Scene) -> Case {
    Case { name, scene, paths: EVERYTHING, keep: &[] }
}

fn only(paths: &'static str, name: &'static str, scene: Scene) -> Case {
    Case { name, scene, paths, keep: &[] }
}

/// With the diffuse map, however well paths would serve.
fn by_map(name: &'static str, scene: Scene) -> Case {
    Case { name, scene, paths: EVERYTHING, keep: &[Part::DiffuseMap] }
}

/// Rendered by wavelength, whatever the scene asks for.
fn by_wavelength(name: &'static str, mut scene: Scene) -> Case {
    scene.wavelengths.are_rendered = true;
    case(name, scene)
}

/// Glass that parts colours.
fn flint() -> Material {
    let index = Index::named("SF11");
    let spectra = MaterialSpectra { index, ..MaterialSpectra::default() };
    Material { spectra: Some(Arc::new(spectra)), ..glass(1.785) }
}

/// Glass that takes the red and some of the blue on the way through it.
fn green_glass() -> Material {
    Material { interior: Interior { absorption: [3.0, 0.0, 1.0], ..Interior::default() }, ..glass(1.5) }
}

/// The scene with glass of which so much is that, the rest grey.
pub fn of_glass_in_part(mut scene: Scene, transmission: f32) -> Scene {
    for m in scene.materials.iter_mut().filter(|m| m.dielectric.is_some() && transmission < 1.0) {
        let (transmission_map, metallic, metallic_map) = (None, 0.0, None);
        let rest = Box::new(Material { relief: m.relief.clone(), ..Material::matte("rest", [0.5; 3]) });
        m.mixture = Some(Mixture { transmission, transmission_map, metallic, metallic_map, rest, number: 0 });
    }
    joton::scene::number_rests(&mut scene.materials);
    scene
}

/// One of the scenes of the repository at `size` × `size` pixels.
pub fn file(name: &str, size: u32) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("toml");
    let mut scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    scene.resize([size; 2]);
    scene
}

/// The scene with other materials.
fn changed(mut scene: Scene, change: impl Fn(&mut Material)) -> Scene {
    scene.materials.iter_mut().for_each(change);
    scene
}

/// The scene with a board of two colours on everything matte, along x and along y and z.
pub fn with_board(mut scene: Scene) -> Scene {
    let bitmap = Arc::new(Bitmap::board([[0.9, 0.7, 0.5], [0.2, 0.3, 0.4]]));
    let board = Texture { filter: Filter::Nearest, scale: [5.0; 2], ..Texture::of(bitmap, Space::Linear) };
    scene.materials.iter_mut().for_each(|m| m.diffuse_texture = Some(board.clone()));
    let along = |p: &DVec3| [p.x as f32, (p.y + p.z) as f32];
    scene.mesh.uvs = scene.mesh.positions.iter().map(along).collect();
    scene.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    scene
}

/// The scene with a board on everything matte whose squares differ in colour, roughness and how much is metal: from what is followed to
/// what is gathered, with what lies between.
pub fn with_facet_board(scene: Scene) -> Scene {
    let mut scene = with_board(scene);
    // red is roughness, green metal
    let grid = [[40, 255, 0, 255], [150, 0, 0, 255], [90, 128, 0, 255], [200, 255, 0, 255]];
    let bitmap = Arc::new(Bitmap::new([2; 2], Texels::Bytes(grid.to_vec())));
    let texture = Texture { scale: [3.0; 2], ..Texture::of(bitmap, Space::Linear) };
    let map = |channel| NumberMap { texture: texture.clone(), channel, factor: 1.0 };
    for m in &mut scene.materials {
        m.glossy = [0.3; 3];
        m.facets = Some(Facets { alpha: 0.615, kind: FacetKind::Schlick { ior: 1.5 } });
        m.roughness = Some(map(Channel::Red));
        m.metallic = Some(Metallic { most: 1.0, map: Some(map(Channel::Green)) });
    }
    scene
}

/// The scene with smooth hills on everything that does not shine: of normals and, every second material, of heights.
pub fn with_relief(scene: Scene) -> Scene {
    let mut scene = with_board(scene);
    const SIDE: u32 = 8;
    let turn = |i: u32| std::f32::consts::TAU * (i as f32 + 0.5) / SIDE as f32;
    let byte = |x: f32| (127.5 + 127.5 * x) as u8;
    let texel = |i: u32| {
        let (x, y) = (turn(i % SIDE).sin(), turn(i / SIDE).cos());
        [byte(0.6 * x), byte(0.5 * y), byte(0.7), byte(0.5 * (x + y))]
    };
    let texels = Texels::Bytes((0..SIDE * SIDE).map(texel).collect());
    let bitmap = Arc::new(Bitmap::new([SIDE; 2], texels));
    let texture = Texture { scale: [2.0; 2], ..Texture::of(bitmap, Space::Linear) };
    for (i, m) in scene.materials.iter_mut().enumerate() {
        m.diffuse_texture = None;
        let kind = match i % 2 {
            0 => ReliefKind::Normals { strength: 0.9 },
            _ => ReliefKind::Heights { channel: Channel::Alpha, height: 0.1, is_relative: true },
        };
        m.relief = (!m.emits()).then(|| Relief { texture: texture.clone(), kind });
    }
    scene
}

/// The scene with a picture of light on all that shines: dark in part, coloured, and beyond one.
pub fn with_glow(scene: Scene) -> Scene {
    let mut scene = with_board(scene);
    let grid = [[0.0, 0.0, 0.0], [3.0, 1.0, 0.2], [0.3, 0.5, 2.0], [0.1, 0.0, 0.4]];
    let texel = |[r, g, b]: [f32; 3]| [r, g, b, 1.0].map(f16::from_f32);
    let bitmap = Arc::new(Bitmap::new([2; 2], Texels::Halves(grid.map(texel).to_vec())));
    let glow = Texture { scale: [7.0; 2], ..Texture::of(bitmap, Space::Linear) };
    for m in &mut scene.materials {
        m.diffuse_texture = None;
        m.emission_texture = m.emits().then(|| glow.clone());
    }
    scene
}

/// The scene with all of its microfacets brushed, each material another way.
pub fn brushed(mut scene: Scene) -> Scene {
    for (i, m) in scene.materials.iter_mut().enumerate().filter(|(_, m)| m.facets.is_some()) {
        m.anisotropy = Some(Anisotropy { strength: 0.8, rotation: 0.7 + i as f32, is_around: i % 3 == 2 });
    }
    scene
}

/// The scene with everything that is matte and does not shine of paper: half of its light comes through, a little bluer.
pub fn of_paper(scene: Scene) -> Scene {
    changed(scene, |m| {
        if !m.emits() && m.dielectric.is_none() {
            let halves = [0.45, 0.5, 0.55].map(|through| (through, 1.0 - through));
            m.transmit = std::array::from_fn(|b| m.diffuse[b] * halves[b].0);
            m.diffuse = std::array::from_fn(|b| m.diffuse[b] * halves[b].1);
        }
    })
}

/// The scene with every second square of what is matte and dark not there, and a part of the rest.
pub fn with_holes(scene: Scene) -> Scene {
    let mut scene = with_board(scene);
    let grid = [[255, 255, 255, 255], [255, 255, 255, 0], [255, 255, 255, 128], [255, 255, 255, 255]];
    let bitmap = Arc::new(Bitmap::new([2; 2], Texels::Bytes(grid.to_vec())));
    let holes = Texture { filter: Filter::Nearest, scale: [7.0; 2], ..Texture::of(bitmap, Space::Linear) };
    for m in &mut scene.materials {
        m.diffuse_texture = None;
        let opacity = Opacity { factor: 1.0, texture: Some(holes.clone()) };
        m.opacity = (!m.emits()).then_some(opacity);
    }
    scene
}

/// The scene with its lamps out and points of this intensity at these places.
fn lit_by_points(scene: Scene, points: &[[f64; 3]], intensity: f32) -> Scene {
    let mut b = Builder { scene: changed(scene, |m| m.emission = [0.0; 3]) };
    points.iter().for_each(|&p| b.point_light(p, intensity));
    b.scene
}

/// The scene with a ball.
fn with_ball(scene: Scene, center: [f64; 3], radius: f64, smooth: bool, material: Material) -> Scene {
    let mut b = Builder { scene };
    let m = b.material(material);
    b.icosphere(center, radius, 3, smooth, m);
    b.scene
}

/// Slope by which the lamp beside a mirror ball is turned: at 0 its plane passes below the ball, above 0.067 it does not.
pub const TURNED: f64 = 0.1;

/// A lamp that shines down, but for the slope `turned`, and a mirror ball beside and above it, in a room.
pub fn ball_above_lamp(turned: f64, size: u32) -> Scene {
    let mut b = Builder::new([0.8, 0.6, 2.8], [0.8, 0.7, 0.], [0., 1., 0.], 0.6, size);
    let white = b.matte(0.7);
    let lamp = b.material(emitter(3.0, 0.0));
    let ball = b.material(mirror(0.9));
    b.room([-1., 0., -1.], [2.5, 2., 3.], white);
    // its edges along `slope` and z: the normal looks along their cross product, down and, turned, to the ball
    let slope = DVec3::new(1.0, turned, 0.0).normalize() * 0.6;
    let corner = DVec3::new(0.0, 1.0, -0.3) - slope * 0.5;
    b.quad(corner.to_array(), slope.to_array(), [0., 0., 0.6], lamp);
    b.icosphere([1.5, 1.3, 0.], 0.2, 3, true, ball);
    b.scene
}

/// A plate under a lamp, made of `material`.
fn plate(material: Material, size: u32) -> Scene {
    let mut b = Builder::new([0., 1.2, 1.6], [0.; 3], [0., 1., 0.], 0.45, size);
    let floor = b.material(material);
    let lamp = b.material(emitter(10.0, 0.0));
    b.quad([-1., 0., -1.], [0., 0., 2.], [2., 0., 0.], floor);
    b.quad([-0.2, 1., -0.2], [0.4, 0., 0.], [0., 0., 0.4], lamp);
    b.scene
}

fn white() -> Material {
    Material::matte("white", [0.7; 3])
}

/// A plate and a ball on it.
fn plate_with_ball(plate_of: Material, ball: Material, size: u32) -> Scene {
    with_ball(plate(plate_of, size), [0., 0.301, 0.], 0.3, false, ball)
}

/// The plate under a lamp and a red one in the same place, cut along the other diagonal, that looks down.
fn doubled_plate(size: u32) -> Scene {
    let mut b = Builder { scene: plate(white(), size) };
    let red = b.material(Material::matte("red", [0.7, 0.1, 0.1]));
    b.quad([1., 0., -1.], [-2., 0., 0.], [0., 0., 2.], red);
    b.scene
}

/// A wide room under six times six lamps, of which the near ones give most of the light.
pub fn hall(size: u32) -> Scene {
    const LAMPS: u32 = 6;
    const WIDTH: f64 = 30.0;
    const HEIGHT: f64 = 3.5;
    let mut b = Builder::new([15., 1.6, 1.], [15., 1.5, 15.], [0., 1., 0.], 0.7, size);
    let white = b.matte(0.7);
    let lamp = b.material(emitter(20.0, 0.0));
    b.room([0.; 3], [WIDTH, HEIGHT, WIDTH], white);
    let place = |i: u32| WIDTH * (f64::from(i) + 0.5) / f64::from(LAMPS);
    for i in 0..LAMPS * LAMPS {
        let corner = [place(i % LAMPS), HEIGHT - 0.02, place(i / LAMPS)];
        b.quad(corner, [0.3, 0., 0.], [0., 0., 0.3], lamp);
    }
    b.scene
}

/// The pedestal in a closed room.
fn pedestal_in_a_room(size: u32) -> Scene {
    let mut b = Builder { scene: file("pedestal", size) };
    let white = b.matte(0.5);
    b.room([-1., -0.5, -1.], [1., 1., 1.], white);
    b.scene
}

/// A room with a lamp and a ball, and around it as many balls under lamps as it has walls and floors; whether a wall has a gap.
fn room_among_lamps(gap: bool, size: u32) -> Scene {
    let mut b = Builder::new([0., 0.2, 0.9], [0., -0.3, -0.5], [0., 1., 0.], 0.6, size);
    let white = b.matte(0.7);
    let lamp = b.material(emitter(10.0, 0.0));
    b.room([-1.; 3], [1.; 3], white);
    if gap {
        b.scene.mesh.triangles.pop();
    }
    b.quad([-0.2, 0.98, -0.2], [0.4, 0., 0.], [0., 0., 0.4], lamp);
    b.icosphere([0.3, -0.7, -0.4], 0.3, 3, false, white);
    for axis in DVec3::AXES.into_iter().flat_map(|a| [a, -a]) {
        let at = axis * 3.0;
        b.icosphere(at.to_array(), 0.6, 3, false, white);
        b.quad((at + DVec3::new(-0.2, 1.0, -0.2)).to_array(), [0.4, 0., 0.], [0., 0., 0.4], lamp);
    }
    b.scene
}

/// A room in which a spot makes a small part of the ceiling the lamp of all the rest: few paths find it.
fn spotted_ceiling(size: u32) -> Scene {
    let mut b = Builder::new([0., -0.5, 0.9], [0., -0.4, -0.5], [0., 1., 0.], 0.6, size);
    let white = b.matte(0.5);
    b.room([-1.; 3], [1.; 3], white);
    b.scene.lights.push(Light::Spot {
        position: DVec3::ZERO,
        direction: DVec3::Y,
        intensity: [100.0; 3],
        angle_inner: 0.18,
        angle_outer: 0.2,
    });
    b.scene
}

/// Pixels across from which on there are more jotons than the least.
pub const WIDE: u32 = 192;

/// Twins for all parts that a plan skips, `size` pixels wide.
pub fn all(size: u32) -> Vec<Twins> {
    let cornell = || case("cornell", file("cornell", size));
    // fewer pixels have the least number of jotons, with or without a background
    let wide = size.max(WIDE);
    let pedestal = || case("pedestal", file("pedestal", wide));
    let mirror_ball = || case("white plate, mirror ball", plate_with_ball(white(), mirror(0.9), size));
    let cornell_by_map = || by_map("cornell, by map", file("cornell", size));
    let point = [[0.278, 0.5, 0.279]];
    let points = [point[0], [0.1, 0.4, 0.1]];
    let glossy = |m: &mut Material| {
        (m.glossy, m.glossy_exponent) = if m.name == "white" { ([0.2; 3], 30.0) } else { ([0.0; 3], 0.0) };
    };
    let coated = |m: &mut Material| {
        let kind = FacetKind::Coat { ior: 1.5, inner: Inner::Even };
        (m.glossy, m.facets) = ([1.0; 3], Some(Facets { alpha: 0.2, kind }));
    };
    let layered = |m: &mut Material| {
        coated(m);
        m.facets = Some(Facets { alpha: 0.2, kind: FacetKind::Schlick { ior: 1.5 } });
        m.glossy = [0.04; 3];
        m.layers = Some(Layers { clear_coat: 0.5, clear_coat_alpha: 0.3, sheen: [0.5; 3], ..Layers::PLAIN });
    };
    let sunny = |mut scene: Scene| {
        let direction = DVec3::new(0.3, -1.0, 0.5).normalize();
        scene.lights.push(Light::Sun { direction, irradiance: [1.0; 3] });
        scene
    };
    let ball = |smooth| with_ball(file("cornell", size), [0.15, 0.4, 0.15], 0.1, smooth, white());
    let twins = |part, why, without, with| Twins { part, why, without, with };
    vec![
        twins(
            Part::OutOfReach,
            Reason::ClosedRoom,
            case("room among lamps", room_among_lamps(false, size)),
            case("the room with a gap", room_among_lamps(true, size)),
        ),
        twins(
            Part::Emission,
            Reason::NoEmissiveSurface,
            case("box, a point", lit_by_points(file("cornell", size), &point, 0.3)),
            cornell(),
        ),
        twins(
            Part::Emission,
            Reason::ExcludedByPaths,
            only(ONE_BOUNCE, "cornell, one bounce", file("cornell", size)),
            cornell(),
        ),
        twins(
            Part::DirectLight,
            Reason::NoDiffuseSurface,
            case("mirror plate and ball", plate_with_ball(mirror(0.9), mirror(0.9), size)),
            mirror_ball(),
        ),
        twins(
            Part::DirectLight,
            Reason::ExcludedByPaths,
            only(CAUSTICS, "mirror ball, caustics", plate_with_ball(white(), mirror(0.9), size)),
            mirror_ball(),
        ),
        twins(Part::CausticMap, Reason::NoSpecularSurface, cornell(), case("spheres", file("spheres", size))),
        twins(
            Part::CausticMap,
            Reason::NoDiffuseSurface,
            case("mirror plate and ball", plate_with_ball(mirror(0.9), mirror(0.9), size)),
            mirror_ball(),
        ),
        twins(
            Part::CausticMap,
            Reason::SpecularInTheDark,
            case("mirror ball above a lamp", ball_above_lamp(0.0, size)),
            case("the lamp turned by 6 degrees", ball_above_lamp(TURNED, size)),
        ),
        twins(
            Part::CausticMap,
            Reason::ExcludedByPaths,
            only(ONE_BOUNCE, "mirror ball, one bounce", plate_with_ball(white(), mirror(0.9), size)),
            mirror_ball(),
        ),
        twins(
            Part::DiffuseMap,
            Reason::NoDiffuseSurface,
            case("mirror plate and ball", plate_with_ball(mirror(0.9), mirror(0.9), size)),
            by_map("white plate, mirror ball, by map", plate_with_ball(white(), mirror(0.9), size)),
        ),
        twins(
            Part::DiffuseMap,
            Reason::ExcludedByPaths,
            only(ONE_BOUNCE, "cornell, one bounce", file("cornell", size)),
            cornell_by_map(),
        ),
        twins(
            Part::DiffuseMap,
            Reason::OnePlane,
            case("a plate", plate(white(), size)),
            by_map("a plate and a ball, by map", plate_with_ball(white(), white(), size)),
        ),
        twins(
            Part::DiffuseMap,
            Reason::PathsServe,
            cornell(),
            case("a spot on the ceiling", spotted_ceiling(size)),
        ),
        twins(
            Part::Mirrors,
            Reason::NoMirror,
            case("white plate, glass ball", plate_with_ball(white(), glass(1.5), size)),
            mirror_ball(),
        ),
        twins(
            Part::Refraction,
            Reason::NoDielectric,
            mirror_ball(),
            case("white plate, glass ball", plate_with_ball(white(), glass(1.5), size)),
        ),
        twins(
            Part::Textures,
            Reason::NoTexture,
            cornell(),
            case("cornell with a board", with_board(file("cornell", size))),
        ),
        twins(
            Part::FacetTextures,
            Reason::SameFacetsAllOver,
            case("cornell, coated", changed(file("cornell", size), coated)),
            case("cornell with a board of facets", with_facet_board(file("cornell", size))),
        ),
        twins(
            Part::Relief,
            Reason::NoRelief,
            cornell(),
            case("cornell with a relief", with_relief(file("cornell", size))),
        ),
        twins(
            Part::Glow,
            Reason::LightsAreEven,
            cornell(),
            case("cornell with a picture of light", with_glow(file("cornell", size))),
        ),
        twins(
            Part::CutOuts,
            Reason::NothingCut,
            cornell(),
            case("cornell with holes", with_holes(file("cornell", size))),
        ),
        twins(
            Part::Media,
            Reason::PlainBodies,
            case("white plate, glass ball", plate_with_ball(white(), glass(1.5), size)),
            case("white plate, ball of green glass", plate_with_ball(white(), green_glass(), size)),
        ),
        twins(
            Part::Dispersion,
            Reason::NothingDisperses,
            by_wavelength("glass ball, by wavelength", plate_with_ball(white(), glass(1.5), size)),
            by_wavelength("ball of flint, by wavelength", plate_with_ball(white(), flint(), size)),
        ),
        twins(
            Part::GlossyLobes,
            Reason::NoGlossySurface,
            cornell(),
            case("cornell, glossy", changed(file("cornell", size), glossy)),
        ),
        twins(
            Part::Translucency,
            Reason::NothingTranslucent,
            cornell(),
            case("cornell of paper", of_paper(file("cornell", size))),
        ),
        twins(
            Part::Microfacets,
            Reason::NoMicrofacets,
            case("cornell, glossy", changed(file("cornell", size), glossy)),
            case("cornell, coated", changed(file("cornell", size), coated)),
        ),
        twins(
            Part::Anisotropy,
            Reason::NothingBrushed,
            case("cornell, coated", changed(file("cornell", size), coated)),
            case("cornell, brushed", brushed(changed(file("cornell", size), coated))),
        ),
        twins(
            Part::Layers,
            Reason::NoLayers,
            case("cornell, coated", changed(file("cornell", size), coated)),
            case("cornell with layers", changed(file("cornell", size), layered)),
        ),
        twins(
            Part::Mixtures,
            Reason::NothingMixed,
            case("plate, glass ball", plate_with_ball(white(), glass(1.5), size)),
            case(
                "plate, ball of glass in part",
                of_glass_in_part(plate_with_ball(white(), glass(1.5), size), 0.5),
            ),
        ),
        twins(
            Part::ShadingNormals,
            Reason::AllFlat,
            case("box with a faceted ball", ball(false)),
            case("box with a smooth ball", ball(true)),
        ),
        twins(
            Part::DeltaLights,
            Reason::AllLightsAreSurfaces,
            case("a plate and a ball", plate_with_ball(white(), white(), size)),
            case("the same with a sun", sunny(plate_with_ball(white(), white(), size))),
        ),
        twins(
            Part::Contacts,
            Reason::NothingTouches,
            case("a plate", plate(white(), size)),
            case("a plate of two colours", doubled_plate(size)),
        ),
        twins(
            Part::PathFilter,
            Reason::AllPathsWanted,
            mirror_ball(),
            only("L.?.?E", "mirror ball, two bounces", plate_with_ball(white(), mirror(0.9), size)),
        ),
        twins(
            Part::FurtherShadowRays,
            Reason::OneDirection,
            case("box, a point", lit_by_points(file("cornell", size), &point, 0.3)),
            case("box, two points", lit_by_points(file("cornell", size), &points, 0.3)),
        ),
        twins(Part::Warps, Reason::NothingLearned, cornell_by_map(), pedestal()),
        twins(Part::FaintLight, Reason::FaintAmongStrong, case("hall", hall(size)), cornell()),
        twins(Part::UnseenLight, Reason::LightElsewhere, case("rooms", file("rooms", size)), cornell()),
        twins(
            Part::UnseenJotons,
            Reason::JotonsElsewhere,
            by_map("rooms, by map", file("rooms", size)),
            cornell_by_map(),
        ),
        twins(
            Part::Background,
            Reason::MuchBackground,
            by_map("pedestal, by map", file("pedestal", wide)),
            case("pedestal in a room", pedestal_in_a_room(wide)),
        ),
        twins(
            Part::Rest,
            Reason::NothingChanges,
            pedestal(),
            case("pedestal in a room", pedestal_in_a_room(wide)),
        ),
    ]
}
