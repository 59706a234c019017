//! Recipes of random scenes: boxes, spheres and boards of every material, lights of every kind, a camera somewhere.

use crate::common::scenes::Builder;
use glam::DVec3;
use joton::scene::{Dielectric, Light, Material, Scene};
use joton::spectrum::{BANDS, Bands};
use proptest::prelude::*;

/// Pixels across and down.
pub const SIZE: u32 = 16;
/// Half the width of the world.
const WORLD: f64 = 1.0;

/// A direction, not yet a unit vector, never zero.
type Direction = [f64; 3];

/// A scene, as far as chance decides about it.
#[derive(Debug, Clone)]
pub struct Recipe {
    /// A closed room, or a floor under the open sky.
    closed: bool,
    walls: Surface,
    bodies: Vec<Body>,
    /// At least one.
    lamps: Vec<Lamp>,
    eye: [f64; 3],
    target: [f64; 3],
    tan_half_fov: f64,
}

/// What stands about.
#[derive(Debug, Clone)]
struct Body {
    shape: Shape,
    center: [f64; 3],
    size: f64,
    surface: Surface,
}

#[derive(Debug, Clone)]
enum Shape {
    Cuboid { sides: [f64; 3] },
    Sphere { smooth: bool },
    Board { along: Direction },
}

#[derive(Debug, Clone)]
enum Surface {
    Matte(Bands),
    Glossy {
        diffuse: Bands,
        glossy: Bands,
        exponent: f32,
    },
    Mirror(Bands),
    RoughMirror {
        reflectance: Bands,
        exponent: f32,
    },
    /// All lobes at once.
    Mixed {
        diffuse: Bands,
        glossy: Bands,
        specular: Bands,
        exponent: f32,
    },
    Glass {
        ior: f32,
        reflection: Bands,
        transmission: Bands,
    },
    Glowing {
        emission: Bands,
        diffuse: Bands,
    },
}

#[derive(Debug, Clone)]
enum Lamp {
    Board { center: [f64; 3], along: Direction, size: f64, emission: Bands },
    Point { position: [f64; 3], intensity: Bands },
    Spot { position: [f64; 3], direction: Direction, intensity: Bands, outer: f64, inner: f64 },
    Sun { direction: Direction, irradiance: Bands },
}

fn bands(most: f32) -> impl Strategy<Value = Bands> {
    prop::array::uniform3(0.0..most)
}

/// At least one band shines.
fn light() -> impl Strategy<Value = Bands> {
    (bands(1.0), 0..BANDS, 0.2..1.0f32).prop_map(|(mut b, band, sure)| {
        b[band] = sure;
        b
    })
}

fn place() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-0.8 * WORLD..0.8 * WORLD)
}

fn direction() -> impl Strategy<Value = Direction> {
    prop::array::uniform3(-1.0..1.0f64).prop_filter("a direction", |d| DVec3::from(*d).length() > 0.1)
}

/// Exponents on both sides of the one from which a lobe counts as a mirror.
fn exponent() -> impl Strategy<Value = f32> {
    (0.0..3.3f32).prop_map(|digits| 10f32.powf(digits))
}

fn opaque() -> impl Strategy<Value = Surface> {
    prop_oneof![
        3 => bands(0.9).prop_map(Surface::Matte),
        1 => (bands(0.45), bands(0.45), exponent())
            .prop_map(|(diffuse, glossy, exponent)| Surface::Glossy { diffuse, glossy, exponent }),
        1 => (bands(0.3), bands(0.3), bands(0.3), exponent())
            .prop_map(|(diffuse, glossy, specular, exponent)| Surface::Mixed { diffuse, glossy, specular, exponent }),
    ]
}

fn any_surface() -> impl Strategy<Value = Surface> {
    let tint = || prop_oneof![Just([1.0; 3]), bands(1.0)];
    prop_oneof![
        4 => opaque(),
        1 => bands(0.95).prop_map(Surface::Mirror),
        1 => (bands(0.95), exponent())
            .prop_map(|(reflectance, exponent)| Surface::RoughMirror { reflectance, exponent }),
        2 => (1.05..2.4f32, tint(), tint())
            .prop_map(|(ior, reflection, transmission)| Surface::Glass { ior, reflection, transmission }),
        1 => (light(), bands(0.8)).prop_map(|(emission, diffuse)| Surface::Glowing { emission, diffuse }),
    ]
}

fn body() -> impl Strategy<Value = Body> {
    let shape = prop_oneof![
        prop::array::uniform3(0.2..1.0f64).prop_map(|sides| Shape::Cuboid { sides }),
        any::<bool>().prop_map(|smooth| Shape::Sphere { smooth }),
        direction().prop_map(|along| Shape::Board { along }),
    ];
    (shape, place(), 0.1..0.6f64, any_surface()).prop_map(|(shape, center, size, surface)| Body {
        shape,
        center,
        size,
        surface,
    })
}

fn lamp() -> impl Strategy<Value = Lamp> {
    prop_oneof![
        3 => (place(), direction(), 0.05..0.5f64, light())
            .prop_map(|(center, along, size, emission)| Lamp::Board { center, along, size, emission }),
        1 => (place(), light()).prop_map(|(position, intensity)| Lamp::Point { position, intensity }),
        1 => (place(), direction(), light(), 0.0..0.95f64, 0.05..1.0f64).prop_map(
            |(position, direction, intensity, outer, part)| {
                let inner = outer + part * (1.0 - outer);
                Lamp::Spot { position, direction, intensity, outer, inner }
            }
        ),
        1 => (direction(), light()).prop_map(|(direction, irradiance)| Lamp::Sun { direction, irradiance }),
    ]
}

/// Any scene.
pub fn recipe() -> impl Strategy<Value = Recipe> {
    let camera =
        (place(), place(), 0.2..1.5f64).prop_filter("a view that is not upright", |(eye, target, _)| {
            let along = DVec3::from(*target) - DVec3::from(*eye);
            along.cross(DVec3::Y).length() > 0.2
        });
    let things = (prop::collection::vec(body(), 0..5), prop::collection::vec(lamp(), 1..4));
    (any::<bool>(), opaque(), things, camera).prop_map(
        |(closed, walls, (bodies, lamps), (eye, target, tan_half_fov))| Recipe {
            closed,
            walls,
            bodies,
            lamps,
            eye,
            target,
            tan_half_fov,
        },
    )
}

impl Surface {
    fn material(&self) -> Material {
        let none = || Material::matte("random", [0.0; BANDS]);
        match *self {
            Surface::Matte(diffuse) => Material { diffuse, ..none() },
            Surface::Glossy { diffuse, glossy, exponent } => {
                Material { diffuse, glossy, glossy_exponent: exponent, ..none() }
            }
            Surface::Mirror(specular) => Material { specular, ..none() },
            Surface::RoughMirror { reflectance, exponent } => {
                Material { glossy: reflectance, glossy_exponent: exponent, ..none() }
            }
            Surface::Mixed { diffuse, glossy, specular, exponent } => {
                Material { diffuse, glossy, specular, glossy_exponent: exponent, ..none() }
            }
            Surface::Glass { ior, reflection, transmission } => {
                let d = Dielectric { ior, reflection_tint: reflection, transmission_tint: transmission };
                Material { dielectric: Some(d), ..none() }
            }
            Surface::Glowing { emission, diffuse } => Material { emission, diffuse, ..none() },
        }
    }
}

/// A square about `center` whose front looks along `along`.
fn board(b: &mut Builder, center: [f64; 3], along: Direction, size: f64, material: u32) {
    let n = DVec3::from(along).normalize();
    let [u, v] = [n.any_orthonormal_vector() * size, n.cross(n.any_orthonormal_vector()) * size];
    let corner = DVec3::from(center) - 0.5 * (u + v);
    b.quad(corner.into(), u.into(), v.into(), material);
}

impl Recipe {
    /// Cook it.
    pub fn scene(&self) -> Scene {
        let mut b = Builder::new(self.eye, self.target, [0., 1., 0.], self.tan_half_fov, SIZE);
        let walls = b.material(self.walls.material());
        if self.closed {
            b.room([-WORLD; 3], [WORLD; 3], walls);
        } else {
            b.quad([-WORLD; 3], [0., 0., 2. * WORLD], [2. * WORLD, 0., 0.], walls);
        }
        for body in &self.bodies {
            let m = b.material(body.surface.material());
            match &body.shape {
                Shape::Cuboid { sides } => {
                    let half = DVec3::from(*sides) * 0.5 * body.size;
                    let [lo, hi] = [-1.0, 1.0].map(|s| DVec3::from(body.center) + half * s);
                    outward_box(&mut b, lo, hi, m);
                }
                Shape::Sphere { smooth } => b.icosphere(body.center, 0.5 * body.size, 2, *smooth, m),
                Shape::Board { along } => board(&mut b, body.center, *along, body.size, m),
            }
        }
        for lamp in &self.lamps {
            let light = match *lamp {
                Lamp::Board { center, along, size, emission } => {
                    let m = b.material(Material { emission, ..Material::matte("lamp", [0.3; BANDS]) });
                    board(&mut b, center, along, size, m);
                    continue;
                }
                Lamp::Point { position, intensity } => Light::Point { position: position.into(), intensity },
                Lamp::Spot { position, direction, intensity, outer, inner } => Light::Spot {
                    position: position.into(),
                    direction: DVec3::from(direction).normalize(),
                    intensity,
                    angle_inner: f64::acos(inner),
                    angle_outer: f64::acos(outer),
                },
                Lamp::Sun { direction, irradiance } => {
                    Light::Sun { direction: DVec3::from(direction).normalize(), irradiance }
                }
            };
            b.scene.lights.push(light);
        }
        b.scene
    }
}

/// The six outward sides of a box.
fn outward_box(b: &mut Builder, lo: DVec3, hi: DVec3, material: u32) {
    let d = hi - lo;
    let [x, y, z] = [DVec3::X * d.x, DVec3::Y * d.y, DVec3::Z * d.z];
    for (corner, u, v) in [(lo, y, x), (lo, z, y), (lo, x, z), (lo + z, x, y), (lo + x, y, z), (lo + y, z, x)]
    {
        b.quad(corner.into(), u.into(), v.into(), material);
    }
}
