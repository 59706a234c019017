//! Lamps seen: in how many pixels emission can be, at most. Where nothing mirrors or refracts, these are where lamps lie in the image.

use super::facts;
use crate::packed::PackedScene;
use glam::{Vec2, Vec3};

/// Lamps whose places are looked at one by one; of more all pixels count.
const LAMPS_MOST: usize = 1 << 14;
/// Bytes of a page of memory, which is touched as a whole.
const PAGE: u32 = 4096;
/// Least bytes of a pixel of a layer.
const PIXEL: u32 = 12;

/// Pixels that can show emission, and those in one page of memory with them.
pub(super) fn pixels(scene: &PackedScene) -> u64 {
    let all = scene.pixels() as u64;
    let lamps =
        || scene.triangles.iter().filter(|t| scene.materials[t.material as usize].flags().is_emissive());
    if facts::has(scene, |m| m.has_delta()) || lamps().nth(LAMPS_MOST).is_some() {
        return all;
    }
    let [width, height] = scene.size;
    // first column and the one after the last in each row
    let mut rows = vec![[width, 0]; height as usize];
    for lamp in lamps() {
        let Some([low, high]) = bounds(scene, lamp.vertices()) else { return all };
        let clamp = |x: f32, most: u32| (x.max(0.0) as u32).min(most);
        // a pixel more on each side, for what is rounded
        let columns = [clamp(low.x - 1.0, width), clamp(high.x + 2.0, width)];
        let [first, end] = [clamp(low.y - 1.0, height), clamp(high.y + 2.0, height)];
        if columns[0] < columns[1] {
            for row in &mut rows[first as usize..end as usize] {
                *row = [row[0].min(columns[0]), row[1].max(columns[1])];
            }
        }
    }
    let around = 2 * PAGE / PIXEL;
    rows.iter().filter(|[a, b]| a < b).map(|[a, b]| u64::from((b - a + around).min(width))).sum()
}

/// The rectangle in the image that these corners lie in, pixels; none where one is not in front of the eye.
fn bounds(scene: &PackedScene, corners: [Vec3; 3]) -> Option<[Vec2; 2]> {
    let camera = &scene.camera;
    let size = Vec2::new(scene.size[0] as f32, scene.size[1] as f32);
    let mut bounds = [Vec2::INFINITY, Vec2::NEG_INFINITY];
    for corner in corners {
        let to = corner - camera.eye;
        let depth = to.dot(camera.forward);
        let along = |axis: Vec3| to.dot(axis) / (axis.length_squared() * depth);
        let place = Vec2::new(0.5 + 0.5 * along(camera.right), 0.5 - 0.5 * along(camera.up)) * size;
        if depth <= 0.0 || !place.is_finite() {
            return None;
        }
        bounds = [bounds[0].min(place), bounds[1].max(place)];
    }
    Some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Every pixel that a ray finds a lamp in is counted, and few others; behind a mirror all are.
    #[test]
    fn pixels_that_show_lamps_are_counted() {
        let of = |name: &str, size: [u32; 2]| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
            let mut scene = crate::scene::load(&path).expect("a scene");
            scene.resize(size);
            PackedScene::new(&scene)
        };
        let scene = of("cornell.toml", [1200, 900]);
        let is_lamp = |pixel: u32| {
            let ray = scene.sample_camera(pixel, 0, 0, 0);
            let hit = scene.bvh.closest(&scene.triangles, ray.origin, ray.direction, f32::INFINITY);
            hit.is_some_and(|hit| {
                scene.materials[scene.triangles[hit.triangle as usize].material as usize]
                    .flags()
                    .is_emissive()
            })
        };
        let seen: Vec<u32> = (0..scene.pixels() as u32).filter(|pixel| is_lamp(*pixel)).collect();
        let mut rows: Vec<u32> = seen.iter().map(|pixel| pixel / 1200).collect();
        rows.dedup();
        let least = seen.len() as u64 + rows.len() as u64 * u64::from(2 * PAGE / PIXEL) / 2;
        let told = pixels(&scene);
        assert!(!seen.is_empty() && (least..scene.pixels() as u64 / 4).contains(&told), "{least} {told}");
        let glass = of("spheres.toml", [60, 40]);
        assert_eq!(pixels(&glass), 2400);
    }
}
