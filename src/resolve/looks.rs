//! Looks: what camera rays see through mirrors and glass. Where light comes by several ways the ray is split, so that what a pixel takes of
//! each surface is no matter of chance. They are no part of the picture.

use super::patch::{CLEARANCE_MOST, Patch, Place};
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::optics::shading::DELTA_MOST;
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::{CameraRay, PackedScene, TEXTURED};
use crate::sampling::rng::purpose::{DIMENSION_PATCH, STREAM_PATCH};
use crate::sampling::rng::{pcg4d, random4};
use crate::spectrum::{BANDS, Bands, mul, scale};

/// Longest specular chain that is followed.
const CHAIN: u32 = 24;
/// Ways that would have less than this part of a look are left to the others.
const LEAST_PART: f32 = 0.02;

/// One of a look's ways through the scene.
struct Branch {
    ray: Ray,
    throughput: Bands,
    /// From the eye, internal units.
    length: f32,
    /// What was met on the way.
    kind: u32,
    event: u32,
    /// Part of the look.
    part: f32,
    /// Of what is glass in part the rest is looked at, or the glass; none where both are.
    is_rest: Option<bool>,
}

/// Say where look `number` at a pixel ends; the first goes through its middle. The patches' shares are parts of the look.
pub(super) fn look(scene: &PackedScene, seed: u32, pixel: u32, number: u32, mut found: impl FnMut(Patch)) {
    let CameraRay { origin, direction, travelled: length } = if number == 0 {
        let [width, height] = scene.size;
        let at = |i: u32, n: u32| (i as f32 + 0.5) / n as f32;
        scene.camera.ray([at(pixel % width, width), at(pixel / width, height)])
    } else {
        scene.sample_camera(pixel, number.into(), seed, STREAM_PATCH)
    };
    let ray = Ray::new(origin, direction).within(scene.media.camera);
    // the first way of each split is followed at once, the others later
    let mut later = Vec::new();
    let mut next =
        Some(Branch { ray, throughput: [1.0; BANDS], length, kind: 0, event: 0, part: 1.0, is_rest: None });
    while let Some(branch) = next.take().or_else(|| later.pop()) {
        let Some(s) = SurfaceInteraction::hit_of(scene, &branch.ray, branch.is_rest) else { continue };
        if let (Some(met), None) = (s.met, branch.is_rest) {
            for (is_rest, part) in [(true, 1.0 - met.glass), (false, met.glass)] {
                let throughput = scale(&branch.throughput, part);
                let way = Branch { part: branch.part * part, throughput, is_rest: Some(is_rest), ..branch };
                later.extend(Some(way).filter(|way| way.part > 0.0));
            }
            continue;
        }
        let length = branch.length + s.distance;
        let bsdf = Bsdf::seen(scene, &s, length);
        let arrives = s.through(&branch.throughput);
        let shares = bsdf.shares(&arrives);
        let ways: [f32; 1 + DELTA_MOST] =
            std::array::from_fn(|way| if way == 0 { shares.scatter } else { shares.delta[way - 1] });
        let largest = ways.iter().fold(0.0f32, |a, b| a.max(*b));
        let least = (LEAST_PART / branch.part * shares.kept()).min(largest);
        let goes_on = |way: usize| ways[way] > 0.0 && ways[way] >= least;
        let followed: f32 = (0..ways.len()).filter(|way| goes_on(*way)).map(|way| ways[way]).sum();
        if followed <= 0.0 {
            continue;
        }
        let throughput = scale(&arrives, shares.kept() / followed);
        if goes_on(0) {
            let varies = bsdf.scatter.varies() || bsdf.scatter.crosses();
            let place = Place {
                position: s.position,
                normal: bsdf.shading_normal(),
                footprint: length * scene.pixel_angle(),
                kind: if varies {
                    pcg4d([branch.kind, s.triangle.material + 1, 1, 0])[0]
                } else {
                    branch.kind
                },
                clearance: CLEARANCE_MOST,
            };
            let weight = mul(&throughput, &bsdf.scatter.albedo());
            found(Patch {
                place,
                weight,
                share: branch.part * ways[0] / followed,
                is_through: branch.event > 0,
                is_textured: s.triangle.flags & TEXTURED != 0,
            });
        }
        if branch.event + 1 == CHAIN {
            continue;
        }
        let [u0, u1, ..] = random4(seed, number, pixel, DIMENSION_PATCH + branch.event);
        for lobe in (0..DELTA_MOST).filter(|lobe| goes_on(lobe + 1)) {
            let Some(direction) = bsdf.sample_delta(lobe, [u0, u1]) else { continue };
            let way = Branch {
                ray: s.leave(direction),
                throughput: bsdf.through_delta(lobe, direction, &throughput),
                length,
                kind: pcg4d([branch.kind, lobe as u32, s.triangle.material, 2])[0],
                event: branch.event + 1,
                part: branch.part * ways[lobe + 1] / followed,
                is_rest: None,
            };
            if next.is_none() { next = Some(way) } else { later.push(way) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Material, Mesh, Scene, Triangle};
    use glam::DVec3;

    /// A look takes each way that light comes by, with exactly its part: a floor that mirrors some of a ceiling shows both, in every look.
    #[test]
    fn looks_split() {
        let mut mesh = Mesh::default();
        for (z, material) in [(0.0, 0), (4.0, 1)] {
            let first = mesh.positions.len() as u32;
            let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
            mesh.positions.extend(corners.map(|[x, y]| DVec3::new(x, y, z)));
            for vertex in [[0, 1, 2], [0, 2, 3]] {
                mesh.triangles.push(Triangle {
                    vertex: vertex.map(|k| first + k),
                    normal: None,
                    uv: None,
                    material,
                });
            }
        }
        let floor = Material { specular: [0.3; BANDS], ..Material::matte("floor", [0.5; BANDS]) };
        let scene = PackedScene::whole(&Scene {
            camera: Camera::pinhole(DVec3::new(0.0, -2.0, 2.0), DVec3::ZERO, DVec3::Z, [0.2; 2]),
            size: [4; 2],
            mesh,
            materials: vec![floor, Material::matte("ceiling", [0.8; BANDS])],
            lights: Vec::new(),
            wavelengths: Default::default(),
            warnings: Vec::new(),
            files: Vec::new(),
        });
        for (pixel, number) in (0..16).flat_map(|pixel| (0..4).map(move |number| (pixel, number))) {
            let mut seen = Vec::new();
            look(&scene, 1, pixel, number, |patch| seen.push(patch));
            let found: Vec<[f32; 2]> = seen.iter().map(|patch| [patch.weight[0], patch.share]).collect();
            for (found, wanted) in found.iter().zip([[0.5, 0.5 / 0.8], [0.3 * 0.8, 0.3 / 0.8]]) {
                assert!(
                    (0..2).all(|i| (found[i] - wanted[i]).abs() < 1e-6),
                    "{pixel}: {found:?}, {wanted:?}"
                );
            }
            assert_eq!(found.len(), 2, "pixel {pixel}, look {number}");
            assert_ne!(seen[0].place.kind, seen[1].place.kind);
        }
    }
}
