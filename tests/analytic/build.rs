//! Scenes in code, and the optics that their closed forms share.

use glam::DVec3;
use joton::scene::{Camera, Dielectric, Light, Material, Mesh, Scene, Triangle};
use joton::spectrum::Bands;

/// A scene under construction.
pub struct Build(pub Scene);

/// A vector.
pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

impl Build {
    /// A camera at `position` that looks at `target`; tangent of half its square field of view; `size` pixels squared.
    pub fn new(position: DVec3, target: DVec3, tan_half_fov: f64, size: u32) -> Self {
        let along = (target - position).normalize();
        let up = if along.z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
        Self(Scene {
            camera: Camera::pinhole(position, target, up, [tan_half_fov; 2]),
            size: [size; 2],
            mesh: Mesh::default(),
            materials: Vec::new(),
            lights: Vec::new(),
            wavelengths: Default::default(),
            warnings: Vec::new(),
            files: Vec::new(),
        })
    }

    fn material(&mut self, material: Material) -> u32 {
        let materials = &mut self.0.materials;
        let known = materials.iter().position(|m| *m == material);
        known.unwrap_or_else(|| {
            materials.push(material);
            materials.len() - 1
        }) as u32
    }

    /// A triangle, front where its corners run counter-clockwise.
    pub fn triangle(&mut self, corners: [DVec3; 3], material: &Material) {
        self.smooth(corners, None, material);
    }

    /// A triangle with shading normals.
    pub fn smooth(&mut self, corners: [DVec3; 3], normals: Option<[DVec3; 3]>, material: &Material) {
        let material = self.material(material.clone());
        let mesh = &mut self.0.mesh;
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        let normal = normals.map(|n| {
            let first = mesh.normals.len() as u32;
            mesh.normals.extend(n.map(|n| n.normalize().as_vec3()));
            [first, first + 1, first + 2]
        });
        mesh.triangles.push(Triangle { vertex: [first, first + 1, first + 2], normal, uv: None, material });
    }

    /// A parallelogram whose front looks along `u` × `w`.
    pub fn quad(&mut self, corner: DVec3, u: DVec3, w: DVec3, material: &Material) {
        self.triangle([corner, corner + u, corner + u + w], material);
        self.triangle([corner, corner + u + w, corner + w], material);
    }

    /// A horizontal square about `centre` that looks up.
    pub fn floor(&mut self, centre: DVec3, half: f64, material: &Material) {
        self.quad(centre - v(half, half, 0.), v(2. * half, 0., 0.), v(0., 2. * half, 0.), material);
    }

    /// A horizontal square about `centre` that looks down.
    pub fn ceiling(&mut self, centre: DVec3, half: f64, material: &Material) {
        self.quad(centre - v(half, half, 0.), v(0., 2. * half, 0.), v(2. * half, 0., 0.), material);
    }

    /// The six sides of a box, that look inward, or outward where `outward`.
    pub fn cuboid(&mut self, low: DVec3, high: DVec3, outward: bool, material: &Material) {
        let d = high - low;
        let [x, y, z] = [v(d.x, 0., 0.), v(0., d.y, 0.), v(0., 0., d.z)];
        for (corner, a, b) in
            [(low, x, y), (low, y, z), (low, z, x), (low + z, y, x), (low + x, z, y), (low + y, x, z)]
        {
            let (a, b) = if outward { (b, a) } else { (a, b) };
            self.quad(corner, a, b, material);
        }
    }

    /// A faceted sphere that looks outward, or inward; with smooth normals or flat. It is blown up so that its area is
    /// that of the true sphere.
    pub fn sphere(&mut self, centre: DVec3, radius: f64, level: u32, look: Look, material: &Material) {
        let faces = icosphere(level);
        let area: f64 = faces.iter().map(|&[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum();
        let blown = radius * (4.0 * std::f64::consts::PI / area).sqrt();
        for [a, b, c] in faces {
            let at = |p: DVec3| centre + p * blown;
            match look {
                Look::Outward => self.triangle([at(a), at(b), at(c)], material),
                Look::Inward => self.triangle([at(c), at(b), at(a)], material),
                Look::OutwardSmooth => self.smooth([at(a), at(b), at(c)], Some([a, b, c]), material),
            }
        }
    }

    /// A light without a surface.
    pub fn light(&mut self, light: Light) {
        self.0.lights.push(light);
    }

    /// A point light.
    pub fn point(&mut self, position: DVec3, intensity: Bands) {
        self.light(Light::Point { position, intensity });
    }

    /// A sun whose light travels along `direction`.
    pub fn sun(&mut self, direction: DVec3, irradiance: Bands) {
        self.light(Light::Sun { direction: direction.normalize(), irradiance });
    }
}

/// Which way a sphere's front looks.
#[derive(Debug, Clone, Copy)]
pub enum Look {
    Outward,
    Inward,
    OutwardSmooth,
}

/// Triangles of a sphere of radius 1, fronts outward: an icosahedron, each face cut in four `level` times.
pub fn icosphere(level: u32) -> Vec<[DVec3; 3]> {
    // corners (0, ±1, ±φ) and their cyclic permutations: faces are the triples at distance 2
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let corners: Vec<DVec3> = (0..12)
        .map(|i| {
            let sign = |bit: i32| if i >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let (a, b) = (sign(0), sign(1) * golden);
            [v(0., a, b), v(a, b, 0.), v(b, 0., a)][i as usize / 4]
        })
        .collect();
    let near = |a: usize, b: usize| (corners[a].distance(corners[b]) - 2.0).abs() < 1e-6;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let [p, q, r] = [a, b, c].map(|i| corners[i].normalize());
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    faces.push(if outward { [p, q, r] } else { [p, r, q] });
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..level {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces
}

/// A matte surface.
pub fn matte(reflectance: Bands) -> Material {
    Material::matte("matte", reflectance)
}

/// A surface that takes all light.
pub fn black() -> Material {
    matte([0.0; 3])
}

/// A surface that shines and reflects.
pub fn glowing(emission: Bands, reflectance: Bands) -> Material {
    Material { emission, ..Material::matte("glowing", reflectance) }
}

/// A mirror.
pub fn mirror(reflectance: Bands) -> Material {
    Material { specular: reflectance, ..Material::matte("mirror", [0.0; 3]) }
}

/// A clear body.
pub fn clear(ior: f32) -> Material {
    let d = Dielectric { ior, reflection_tint: [1.0; 3], transmission_tint: [1.0; 3] };
    Material { dielectric: Some(d), ..Material::matte("clear", [0.0; 3]) }
}

/// A pane without thickness.
pub fn pane(ior: f32) -> Material {
    Material { thin: true, ..clear(ior) }
}

/// Unpolarised reflectance from index 1 into `ior` at an angle of incidence in radians, by Fresnel's sines and tangents:
/// not the form that the renderers use.
pub fn reflectance(angle: f64, ior: f64) -> f64 {
    if angle < 1e-6 {
        return ((ior - 1.0) / (ior + 1.0)).powi(2);
    }
    let inside = (angle.sin() / ior).asin();
    let s = ((angle - inside).sin() / (angle + inside).sin()).powi(2);
    let p = ((angle - inside).tan() / (angle + inside).tan()).powi(2);
    (s + p) / 2.0
}

/// Bands in f64.
pub fn wide(b: Bands) -> [f64; 3] {
    b.map(f64::from)
}
