//! Rays and what they meet: surfaces with both normals turned toward where the ray came from.

use crate::optics::media::{Sides, transmittance};
use crate::optics::shading::cutout::stops;
use crate::optics::shading::frame::Frame;
use crate::optics::shading::mixture::Met;
use crate::optics::shading::relief::{self, Plain};
use crate::optics::shading::texture::TexturePlace;
use crate::packed::accel::Hit;
use crate::packed::constants::{LIFT, LIFT_LEAST};
use crate::packed::{
    CUT, Inside, MaterialFlags, NESTED, PackedMaterial, PackedScene, PackedTriangle, SMOOTH, TEXTURED,
    Textures,
};
use crate::spectrum::{Bands, mul};
use glam::Vec3;

/// A ray; the direction is a unit vector.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Back faces nearer than this are not met: the ray starts so little inside of a body that it leaves. Where it is negative: front faces
    /// nearer than that, of one that it enters.
    pub(crate) t_back: f32,
    /// The bodies that it starts in.
    pub(crate) inside: Inside,
}

impl Ray {
    /// A ray that leaves no body, outside of all.
    pub(crate) fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_back: 0.0, inside: Inside::default() }
    }

    /// The same ray in these bodies.
    pub(crate) fn within(self, inside: Inside) -> Self {
        Self { inside, ..self }
    }

    /// What is left of light that it brings from beyond the scene; none where that is all.
    pub(crate) fn brings_from_afar(&self, scene: &PackedScene, light: &Bands) -> Bands {
        transmittance(scene, self.inside, f32::INFINITY).map_or(*light, |left| mul(light, &left))
    }
}

/// Where a ray met a triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfaceInteraction<'a> {
    /// The point, internal units; from the vertices, so it lies in the triangle's plane.
    pub(crate) position: Vec3,
    /// Unit vector back along the ray.
    pub(crate) back: Vec3,
    /// Distance along the ray.
    pub(crate) distance: f32,
    /// Unit geometric normal, on the ray's side.
    pub(crate) ng: Vec3,
    /// Unit shading normal, in the hemisphere of `ng`.
    pub(crate) ns: Vec3,
    /// The ray came from the side where the vertices run counter-clockwise.
    pub(crate) front: bool,
    /// The normals of its front, before a relief.
    pub(crate) plain: Plain,
    /// `ns` may differ from `ng`.
    pub(crate) smooth: bool,
    pub(crate) triangle: &'a PackedTriangle,
    pub(crate) material: &'a PackedMaterial,
    /// Which part it is of what is glass in part; none of what is one thing all over.
    pub(crate) met: Option<Met>,
    /// The bodies before it and beyond.
    pub(crate) sides: Sides,
    /// The material of a boundary as it is between the media that meet there; none where that is as it says.
    boundary: Option<PackedMaterial>,
    /// What is left of light that comes by the ray, per band; none where it is all.
    transmittance: Option<Bands>,
    /// Where its texture lies.
    pub(crate) texture: TexturePlace,
    /// Those of the scene.
    pub(crate) textures: &'a Textures,
    /// What texels reflect in the bands; none where these are red, green and blue.
    pub(crate) of_texel: Option<&'a [Bands; 3]>,
}

impl<'a> SurfaceInteraction<'a> {
    /// What `ray` meets first.
    pub(crate) fn hit(scene: &'a PackedScene, ray: &Ray) -> Option<Self> {
        Self::hit_of(scene, ray, None)
    }

    /// The same, and of what is glass in part the rest or the glass, where that is said.
    pub(crate) fn hit_of(scene: &'a PackedScene, ray: &Ray, is_rest: Option<bool>) -> Option<Self> {
        let hit = nearest(scene, ray, f32::INFINITY)?;
        let triangle = &scene.triangles[hit.triangle as usize];
        let front_normal = triangle.normal();
        let front = ray.direction.dot(front_normal) < 0.0;
        let ng = if front { front_normal } else { -front_normal };
        let smooth = triangle.flags & SMOOTH != 0;
        let texture = if triangle.flags & (TEXTURED | CUT) != 0 {
            TexturePlace::on(triangle, &scene.textures.uvs[hit.triangle as usize], hit.u, hit.v)
        } else {
            TexturePlace::default()
        };
        let (mut material, back) = (&scene.materials[triangle.material as usize], -ray.direction);
        let mut plain = Plain { front: front_normal, ns: front_normal };
        let mut ns = if smooth {
            let [a, b, c] = scene.shading_normals[hit.triangle as usize];
            let n = (a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v).normalize_or(ng);
            let n = if n.dot(ng) < 0.0 { -n } else { n };
            plain.ns = if front { n } else { -n };
            // where the two disagree about the side that is seen, the geometric one holds
            if n.dot(ray.direction) < 0.0 { n } else { ng }
        } else {
            ng
        };
        if let Some(n) = relief::seen(&scene.textures, material, &texture, plain, back, 0.0) {
            ns = n;
        }
        let sides = if scene.media.is_empty() {
            Sides::default()
        } else {
            Sides::at(&scene.media, material, front, ray.inside)
        };
        let position = triangle.v0 + triangle.e1 * hit.u + triangle.e2 * hit.v;
        let mut met = Met::at(material, &scene.textures, texture.uv, position, ray.direction);
        if let (Some(met), Some(is_rest)) = (&mut met, is_rest) {
            met.is_rest = is_rest;
        }
        // where light stays in the body that it is in there is no surface
        met = met.filter(|_| !sides.is_no_boundary(&scene.media, material));
        if let Some(rest) = material.rest().filter(|_| met.is_some_and(|met| met.is_rest)) {
            material = &scene.materials[rest];
        }
        Some(Self {
            position,
            back,
            distance: hit.t,
            ng,
            ns,
            plain,
            front,
            smooth,
            triangle,
            material,
            met,
            sides,
            boundary: sides.between(scene, material, front),
            transmittance: transmittance(scene, sides.here, hit.t),
            texture,
            textures: &scene.textures,
            of_texel: scene.of_texel.as_ref(),
        })
    }

    /// The material, as it is between the media that meet there.
    pub(crate) fn between(&self) -> &PackedMaterial {
        self.boundary.as_ref().unwrap_or(self.material)
    }

    /// What of `light` is left that came by the ray.
    pub(crate) fn through(&self, light: &Bands) -> Bands {
        self.transmittance.map_or(*light, |left| mul(light, &left))
    }

    /// What the material can do.
    pub(crate) fn flags(&self) -> MaterialFlags {
        self.material.flags()
    }

    /// A ray that leaves in `direction`, on whichever side that is. A ray out of a body starts on its inner side, where it
    /// still meets the front of what touches the body.
    pub(crate) fn leave(&self, direction: Vec3) -> Ray {
        let crosses = direction.dot(self.ng) < 0.0;
        if self.triangle.flags & NESTED != 0 {
            // before the front of a boundary, whose like is not met again on the way in: so others in one place with it are passed, too
            let front = if self.front { self.ng } else { -self.ng };
            let inward = -direction.dot(front);
            let t_back = if inward > 0.0 { -2.0 * lift_of(front, self.triangle) / inward } else { 0.0 };
            let inside = if crosses { self.sides.beyond } else { self.sides.here };
            return Ray { origin: lift(self.position, front, self.triangle), direction, t_back, inside };
        }
        let side = if crosses { -self.ng } else { self.ng };
        if crosses && !self.front {
            let lift = lift_of(side, self.triangle);
            let t_back = 2.0 * lift / direction.dot(side);
            return Ray { origin: self.position - side * lift, direction, t_back, inside: self.sides.beyond };
        }
        let inside = if crosses { self.sides.beyond } else { self.sides.here };
        Ray::new(lift(self.position, side, self.triangle), direction).within(inside)
    }

    /// The directions that lobes depend on.
    pub(crate) fn frame(&self) -> Frame {
        Frame { back: self.back, ng: self.ng, ns: self.ns, front: self.front }
    }

    /// The same to who sees so wide a part of the surface at once, internal units.
    pub(crate) fn frame_seen(&self, width: f32) -> Frame {
        let of_texture = width * self.texture.per_unit;
        let seen =
            relief::seen(self.textures, self.material, &self.texture, self.plain, self.back, of_texture);
        Frame { ns: seen.unwrap_or(self.ns), ..self.frame() }
    }
}

/// How far off a triangle's plane f32 may put a point that lies in it.
fn lift_of(normal: Vec3, triangle: &PackedTriangle) -> f32 {
    let extent = triangle.v0.abs() + triangle.e1.abs() + triangle.e2.abs();
    (normal.abs().dot(extent) * LIFT).max(LIFT_LEAST)
}

/// `position` on `triangle`, lifted to the side of `normal` so far that rounding cannot put it on the other side.
pub(crate) fn lift(position: Vec3, normal: Vec3, triangle: &PackedTriangle) -> Vec3 {
    position + normal * lift_of(normal, triangle)
}

impl SurfaceInteraction<'_> {
    /// Where shadow rays to a direction start: lifted off the side that it is on.
    pub(crate) fn origin_toward(&self, direction: Vec3) -> Vec3 {
        toward(self.position, self.ng, self.triangle, direction)
    }
}

/// `position` on `triangle`, lifted to the side of a direction; `normal` is that of either side.
pub(crate) fn toward(position: Vec3, normal: Vec3, triangle: &PackedTriangle, direction: Vec3) -> Vec3 {
    lift(position, if direction.dot(normal) < 0.0 { -normal } else { normal }, triangle)
}

/// True where nothing stands between two points that are already lifted off their surfaces.
pub(crate) fn visible(scene: &PackedScene, from: Vec3, to: Vec3) -> bool {
    is_clear(scene, from, to, 0.0)
}

/// True where nothing stands between a surface that a ray leaves and a point toward which it does: what the ray would pass at its start,
/// a shadow ray passes, too.
pub(crate) fn reaches(scene: &PackedScene, ray: &Ray, to: Vec3) -> bool {
    let length = (to - ray.origin).length();
    is_clear(scene, ray.origin, to, ray.t_back / length.max(f32::MIN_POSITIVE))
}

/// Whether nothing stops a ray between two points; `t_back` as in [`Ray`], a part of the way.
fn is_clear(scene: &PackedScene, from: Vec3, to: Vec3, t_back: f32) -> bool {
    let (bvh, triangles) = (&scene.bvh, &scene.triangles[..]);
    if !scene.textures.has_cutouts {
        return !bvh.stops_between(triangles, from, to, t_back, |_, _, _| true);
    }
    !bvh.stops_between(triangles, from, to, t_back, stops(scene, from, to - from))
}

/// Which triangle a ray meets first, nearer than this.
pub(crate) fn nearest(scene: &PackedScene, ray: &Ray, t_max: f32) -> Option<Hit> {
    let Ray { origin, direction, t_back, .. } = *ray;
    let (bvh, triangles) = (&scene.bvh, &scene.triangles[..]);
    if !scene.textures.has_cutouts {
        return bvh.closest_from_within(triangles, origin, direction, t_max, t_back, |_, _, _| true);
    }
    bvh.closest_from_within(triangles, origin, direction, t_max, t_back, stops(scene, origin, direction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::distributions::sphere;
    use crate::sampling::rng::sobol2;
    use crate::scene::{Camera, Material, Mesh, Scene, Triangle};
    use glam::{DQuat, DVec3};

    /// A turned cube whose faces are cut unevenly into many triangles, fronts outward.
    fn cut_cube() -> PackedScene {
        const CUTS: [f64; 7] = [-1.0, -0.99, -0.3, 0.0, 0.7, 0.95, 1.0];
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.2, 0.8);
        let mut mesh = Mesh::default();
        for face in 0..6 {
            let (axis, side) = (face / 2, if face % 2 == 0 { -1.0 } else { 1.0 });
            for cell in 0..36 {
                let at = |i: usize, j: usize| {
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) =
                        (side, CUTS[cell / 6 + i], CUTS[cell % 6 + j]);
                    turn * DVec3::from(p)
                };
                let first = mesh.positions.len() as u32;
                mesh.positions.extend([at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
                for corners in [[0, 1, 2], [0, 2, 3]] {
                    let mut vertex = corners.map(|k| first + k);
                    if side < 0.0 {
                        vertex.swap(0, 2);
                    }
                    mesh.triangles.push(Triangle { vertex, normal: None, uv: None, material: 0 });
                }
            }
        }
        let camera = Camera::pinhole(DVec3::ZERO, DVec3::X, DVec3::Z, [1.0; 2]);
        PackedScene::whole(&Scene {
            camera,
            size: [1; 2],
            mesh,
            materials: vec![Material::matte("m", [0.5; 3])],
            lights: Vec::new(),
            wavelengths: Default::default(),
            warnings: Vec::new(),
            files: Vec::new(),
        })
    }

    /// Below this cosine the planes of slivers are rounded further off than a ray rises over them; one light path in 1e8 is there.
    const GRAZING: f32 = 1e-3;

    /// What leaves a convex body meets nothing; what goes back into it does not meet the face that it left.
    #[test]
    fn rays_leave_a_surface_without_meeting_it_again() {
        let scene = cut_cube();
        for i in 0..200_000 {
            let s = SurfaceInteraction::hit(&scene, &Ray::new(Vec3::ZERO, sphere(sobol2(i, 1))))
                .expect("a closed body");
            let d = sphere(sobol2(i, 2));
            // from inside the front is out; every third ray grazes
            let out = -s.ng;
            let d = if i % 3 == 0 { (d - out * d.dot(out) * 0.99).normalize() } else { d };
            let d = if d.dot(out) < 0.0 { -d } else { d };
            if d.dot(out) < GRAZING {
                continue;
            }
            for (how, ray) in
                [("through", s.leave(d)), ("off", Ray::new(lift(s.position, out, s.triangle), d))]
            {
                assert!(
                    SurfaceInteraction::hit(&scene, &ray).is_none(),
                    "{i}: a ray {how} the face meets it again"
                );
            }
            let again = SurfaceInteraction::hit(&scene, &s.leave(-d)).expect("a closed body");
            assert!(again.ng.dot(s.ng) < 0.99, "{i}: a ray inward meets the face that it left");
        }
    }
}
