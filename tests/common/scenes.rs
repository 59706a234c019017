//! Small scenes in code.

use glam::DVec3;
use joton::packed::PackedScene;
use joton::scene::{Camera, Light, Material, Mesh, Scene, Triangle};

/// A scene under construction.
pub struct Builder {
    /// What has been built so far.
    pub scene: Scene,
}

impl Builder {
    /// A camera at `position` that looks at `target`; the tangent of half the (square) field of view.
    pub fn new(position: [f64; 3], target: [f64; 3], up: [f64; 3], tan_half_fov: f64, size: u32) -> Self {
        Self {
            scene: Scene {
                camera: Camera::pinhole(position.into(), target.into(), up.into(), [tan_half_fov; 2]),
                size: [size; 2],
                mesh: Mesh::default(),
                materials: Vec::new(),
                lights: Vec::new(),
                wavelengths: Default::default(),
                warnings: Vec::new(),
                files: Vec::new(),
            },
        }
    }

    /// Add a material; its index.
    pub fn material(&mut self, m: Material) -> u32 {
        self.scene.materials.push(m);
        self.scene.materials.len() as u32 - 1
    }

    /// Add a matte material; its index.
    pub fn matte(&mut self, reflectance: f32) -> u32 {
        self.material(Material::matte("matte", [reflectance; 3]))
    }

    /// Add a triangle.
    pub fn triangle(&mut self, vertices: [DVec3; 3], material: u32) {
        let at = self.scene.mesh.positions.len() as u32;
        self.scene.mesh.positions.extend(vertices);
        self.scene.mesh.triangles.push(Triangle {
            vertex: [at, at + 1, at + 2],
            normal: None,
            uv: None,
            material,
        });
    }

    /// Add a parallelogram whose front looks along `u` × `v`.
    pub fn quad(&mut self, corner: [f64; 3], u: [f64; 3], v: [f64; 3], material: u32) {
        let [c, u, v] = [corner, u, v].map(DVec3::from);
        self.triangle([c, c + u, c + u + v], material);
        self.triangle([c, c + u + v, c + v], material);
    }

    /// Add the six inward walls of a box.
    pub fn room(&mut self, lo: [f64; 3], hi: [f64; 3], material: u32) {
        let [x, y, z] = lo;
        let [dx, dy, dz] = [hi[0] - x, hi[1] - y, hi[2] - z];
        self.quad(lo, [0., 0., dz], [dx, 0., 0.], material);
        self.quad([x, y + dy, z], [dx, 0., 0.], [0., 0., dz], material);
        self.quad(lo, [dx, 0., 0.], [0., dy, 0.], material);
        self.quad([x, y, z + dz], [0., dy, 0.], [dx, 0., 0.], material);
        self.quad(lo, [0., dy, 0.], [0., 0., dz], material);
        self.quad([x + dx, y, z], [0., 0., dz], [0., dy, 0.], material);
    }

    /// Add a sphere of 20 · 4^`levels` triangles, with normals where it is smooth.
    pub fn icosphere(&mut self, center: [f64; 3], radius: f64, levels: u32, smooth: bool, material: u32) {
        for t in icosphere(levels) {
            let at = self.scene.mesh.positions.len() as u32;
            let n = self.scene.mesh.normals.len() as u32;
            self.scene.mesh.positions.extend(t.map(|p| DVec3::from(center) + p * radius));
            let normal = smooth.then_some([n, n + 1, n + 2]);
            if smooth {
                self.scene.mesh.normals.extend(t.map(|p| p.as_vec3().normalize()));
            }
            self.scene.mesh.triangles.push(Triangle {
                vertex: [at, at + 1, at + 2],
                normal,
                uv: None,
                material,
            });
        }
    }

    /// Add a point light of this intensity in every band.
    pub fn point_light(&mut self, position: [f64; 3], intensity: f32) {
        self.scene.lights.push(Light::Point { position: position.into(), intensity: [intensity; 3] });
    }
}

/// Triangles of a unit sphere, outward.
pub fn icosphere(levels: u32) -> Vec<[DVec3; 3]> {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let v = [
        [-1., g, 0.],
        [1., g, 0.],
        [-1., -g, 0.],
        [1., -g, 0.],
        [0., -1., g],
        [0., 1., g],
        [0., -1., -g],
        [0., 1., -g],
        [g, 0., -1.],
        [g, 0., 1.],
        [-g, 0., -1.],
        [-g, 0., 1.],
    ]
    .map(|p: [f64; 3]| DVec3::from(p).normalize());
    let faces: [[usize; 3]; 20] = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let mut triangles: Vec<[DVec3; 3]> = faces.iter().map(|f| f.map(|i| v[i])).collect();
    for _ in 0..levels {
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    triangles
}

/// Glass with this index.
pub fn glass(ior: f32) -> Material {
    Material {
        dielectric: Some(joton::scene::Dielectric {
            ior,
            reflection_tint: [1.0; 3],
            transmission_tint: [1.0; 3],
        }),
        ..Material::matte("glass", [0.0; 3])
    }
}

/// A mirror.
pub fn mirror(reflectance: f32) -> Material {
    Material { specular: [reflectance; 3], ..Material::matte("mirror", [0.0; 3]) }
}

/// A matte emitter.
pub fn emitter(radiance: f32, reflectance: f32) -> Material {
    Material { emission: [radiance; 3], ..Material::matte("emitter", [reflectance; 3]) }
}

/// Three glass spheres that overlap as seen from most lights, on a floor, under the lights of `build`.
pub fn three_glass_spheres(build: impl Fn(&mut Builder)) -> PackedScene {
    let mut b = Builder::new([0., 1., 5.], [0.; 3], [0., 1., 0.], 0.5, 16);
    let floor = b.matte(0.5);
    let g = b.material(glass(1.5));
    b.quad([-2., -1., -2.], [0., 0., 4.], [4., 0., 0.], floor);
    b.icosphere([0.3, 0., 0.], 0.4, 1, false, g);
    b.icosphere([-0.5, -0.2, 0.4], 0.3, 1, false, g);
    b.icosphere([0.2, -0.7, 0.1], 0.2, 1, false, g);
    build(&mut b);
    PackedScene::new(&b.scene)
}
