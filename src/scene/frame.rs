//! Frame: where to put the camera when a file does not say.
//!
//! Candidate views look at the middle of the scene from +z, -z, +x, -x, from a distance at which the bounding box
//! just fits. A coarse grid of rays tells what each would see: the share of rays that meet a surface on which
//! light falls. A room whose wall stands in the way shows the wall's dark outside; the first candidate that sees
//! nearly as much as the best is taken. Where none sees any light, the room is closed and the camera goes inside.
//! Objects without a ceiling are seen from slightly above, and near: a backdrop of few triangles need not be whole.

use super::camera::DEFAULT_FOV_X;
use super::obj::geometric_normal;
use super::{Camera, Light, LightPlace, Material, Mesh};
use crate::spectrum;
use glam::DVec3;

/// Rays across and down that judge a view.
const GRID: usize = 24;
/// Triangles that the rays are tested against: the largest, because walls are what blocks a view.
const MOST_TRIANGLES: usize = 4096;
/// Points on lights that are asked whether they reach a surface.
const MOST_LIGHTS: usize = 4;
/// Lights without a surface that are asked.
const MOST_LIGHTS_BESIDE: usize = 12;
/// A view is good enough if it sees this share of what the best one sees.
const GOOD_SHARE: f64 = 0.6;
/// Below this share of lit rays a view shows a wall.
const LEAST_LIT: f64 = 0.02;
/// Space around the bounding box, as a factor on the distance.
const MARGIN: f64 = 1.02;
/// Height of the eye over objects, as the tangent of the angle (about 17 degrees).
const ELEVATION: f64 = 0.3;
/// Field of view inside closed rooms, degrees.
const INSIDE_FOV: f64 = 75.0;
/// Where the eye stands in a closed room, as a share of the way from the middle to the wall.
const INSIDE_SHARE: f64 = 0.9;
/// The subject is what is left without this part of the triangles at either end of each axis …
const SUBJECT_TAIL: f64 = 0.02;
/// … where that is smaller than this part of the whole …
const SUBJECT_SHARE: f64 = 0.3;
/// … with this part of its size as space around it.
const SUBJECT_SPACE: f64 = 0.1;
/// From where to look, best first.
const SIDES: [DVec3; 4] = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_X];

/// Puts a camera where it sees the scene. The mesh has at least one triangle.
pub(crate) fn frame(mesh: &Mesh, materials: &[Material], lights: &[Light], size: [u32; 2]) -> Camera {
    let used = mesh.triangles.iter().flat_map(|t| t.vertex).map(|v| mesh.positions[v as usize]);
    let (low, high) = used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let probe = Probe::new(mesh, materials, lights);
    let elevation = if probe.has_ceiling(low, high) { 0.0 } else { ELEVATION };
    let fov = field_of_view(DEFAULT_FOV_X, size);
    let (near_low, near_high) =
        if elevation > 0.0 { subject(mesh).unwrap_or((low, high)) } else { (low, high) };
    let outside = SIDES.map(|side| look_from_outside(near_low, near_high, side + DVec3::Y * elevation, fov));
    let best = first_good(&probe, &outside);
    if let Some(camera) = best {
        return camera;
    }
    let middle = (low + high) / 2.0;
    let inside = SIDES.map(|side| {
        let position = middle + side * (high - low) / 2.0 * INSIDE_SHARE;
        Camera::pinhole(position, middle, DVec3::Y, field_of_view(INSIDE_FOV, size))
    });
    let flat = inside.iter().any(|c| (c.target - c.position).length() < 1e-6 * (high - low).length());
    if flat { outside[0] } else { first_good(&probe, &inside).unwrap_or(outside[0]) }
}

/// The box that holds most triangles, with some space around, where it is much smaller than the whole: an object on a
/// backdrop is what the picture is of.
fn subject(mesh: &Mesh) -> Option<(DVec3, DVec3)> {
    let corners = |axis: usize| {
        let mut values: Vec<f64> =
            mesh.triangles.iter().map(|t| mesh.positions[t.vertex[0] as usize][axis]).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
        [at(0.0), at(SUBJECT_TAIL), at(1.0 - SUBJECT_TAIL), at(1.0)]
    };
    let axes = [0, 1, 2].map(corners);
    let [whole_low, low, high, whole_high] = [0, 1, 2, 3].map(|i| DVec3::from_array(axes.map(|a| a[i])));
    let (size, whole) = ((high - low).max_element(), (whole_high - whole_low).max_element());
    let space = DVec3::splat(SUBJECT_SPACE * size);
    (size > 0.0 && size < SUBJECT_SHARE * whole).then(|| (low - space, high + space))
}

/// The first camera that sees nearly as much as the best, if any sees something.
fn first_good(probe: &Probe, cameras: &[Camera]) -> Option<Camera> {
    let shares: Vec<f64> = cameras.iter().map(|camera| probe.lit_share(camera)).collect();
    let best = shares.iter().copied().fold(0.0, f64::max);
    let first = shares.iter().position(|&share| share >= GOOD_SHARE * best)?;
    (best >= LEAST_LIT).then(|| cameras[first])
}

/// Half tangents; the longer side of the image has the angle.
fn field_of_view(degrees: f64, size: [u32; 2]) -> [f64; 2] {
    let tangent = (degrees.to_radians() / 2.0).tan();
    let [width, height] = size.map(f64::from);
    [tangent, tangent * height / width]
}

/// A camera towards which `side` points, as near as the bounding box allows.
fn look_from_outside(low: DVec3, high: DVec3, side: DVec3, tan_half_fov: [f64; 2]) -> Camera {
    let target = (low + high) / 2.0;
    let unit = Camera::pinhole(target + side, target, DVec3::Y, tan_half_fov);
    let [right, up, forward] = unit.basis();
    let mut distance: f64 = 0.0;
    for corner in 0..8 {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        let p = DVec3::new(pick(0), pick(1), pick(2)) - target;
        for (axis, tangent) in [right, up].into_iter().zip(tan_half_fov) {
            distance = distance.max(p.dot(axis).abs() / tangent - p.dot(forward));
        }
    }
    Camera { position: target - forward * distance * MARGIN, ..unit }
}

/// A flat triangle of the probe.
struct Flat {
    corner: DVec3,
    edges: [DVec3; 2],
    normal: DVec3,
    emits: bool,
}

/// Where light comes from: a point, and the side to which an emitting triangle shines.
struct Source {
    position: DVec3,
    normal: Option<DVec3>,
}

/// Answers what a ray sees.
struct Probe {
    triangles: Vec<Flat>,
    sources: Vec<Source>,
}

impl Probe {
    fn new(mesh: &Mesh, materials: &[Material], lights: &[Light]) -> Self {
        let mut emitters: Vec<(f64, Source)> = Vec::new();
        let mut triangles: Vec<(f64, Flat)> = Vec::new();
        for t in &mesh.triangles {
            let corners = t.vertex.map(|v| mesh.positions[v as usize]);
            let [a, b, c] = corners;
            let Some(normal) = geometric_normal(corners) else { continue };
            let material = &materials[t.material as usize];
            let area = (b - a).cross(c - a).length() / 2.0;
            let emits = material.emits();
            if emits {
                let source = Source { position: (a + b + c) / 3.0, normal: Some(normal) };
                emitters.push((area * spectrum::sum(&material.emission), source));
            }
            // Rays pass straight through glass and water: that is near enough to what is seen.
            if material.dielectric.is_none() {
                triangles.push((area, Flat { corner: a, edges: [b - a, c - a], normal, emits }));
            }
        }
        let mut sources: Vec<Source> = largest(emitters, MOST_LIGHTS);
        let far = mesh.positions.iter().map(|p| p.length()).fold(1.0, f64::max);
        // evenly spread in the list where there are too many
        for light in lights.iter().step_by(lights.len().div_ceil(MOST_LIGHTS_BESIDE).max(1)) {
            let position = match light.place() {
                LightPlace::At(position) => position,
                LightPlace::Infinity(direction) => -direction * far * 1e3,
            };
            sources.push(Source { position, normal: None });
        }
        Self { triangles: largest(triangles, MOST_TRIANGLES), sources }
    }

    /// The first triangle that the ray meets beyond a hair's breadth, and how far, in lengths of `direction`.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<(f64, &Flat)> {
        /// Nearer hits are the surface that the ray starts on.
        const NEAREST: f64 = 1e-6;
        let mut first: Option<(f64, &Flat)> = None;
        for triangle in &self.triangles {
            // Möller and Trumbore 1997.
            let [e1, e2] = triangle.edges;
            let p = direction.cross(e2);
            let determinant = e1.dot(p);
            let s = origin - triangle.corner;
            let u = s.dot(p) / determinant;
            let q = s.cross(e1);
            let v = direction.dot(q) / determinant;
            let distance = e2.dot(q) / determinant;
            let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0; // false for the NaN of a parallel ray
            if inside && distance > NEAREST && first.is_none_or(|(nearest, _)| distance < nearest) {
                first = Some((distance, triangle));
            }
        }
        first
    }

    /// Share of the view's rays that meet a lit or shining surface. Without lights (a headlight will be put at the
    /// eye): those that meet a front.
    fn lit_share(&self, camera: &Camera) -> f64 {
        let [right, up, forward] = camera.basis();
        let [tan_x, tan_y] = camera.tan_half_fov;
        let mut lit = 0;
        for i in 0..GRID * GRID {
            let across = |index: usize| (2 * index + 1) as f64 / GRID as f64 - 1.0;
            let (x, y) = (across(i % GRID), across(i / GRID));
            let direction = forward + right * (tan_x * x) + up * (tan_y * y);
            let Some((distance, surface)) = self.hit(camera.position, direction) else { continue };
            let is_front = surface.normal.dot(direction) < 0.0;
            let point = camera.position + direction * distance;
            let is_lit = if self.sources.is_empty() || surface.emits {
                is_front
            } else {
                self.sources.iter().any(|source| self.reaches(source, point, surface, is_front))
            };
            lit += usize::from(is_lit);
        }
        lit as f64 / (GRID * GRID) as f64
    }

    /// Whether light reaches the side of the surface that is seen.
    fn reaches(&self, source: &Source, point: DVec3, surface: &Flat, is_front: bool) -> bool {
        let way = source.position - point;
        let falls_on_front = surface.normal.dot(way) > 0.0;
        let shines_here = source.normal.is_none_or(|normal| normal.dot(way) < 0.0);
        /// Just short of the light itself.
        const BEFORE_LIGHT: f64 = 1.0 - 1e-4;
        falls_on_front == is_front
            && shines_here
            && self.hit(point, way).is_none_or(|(distance, blocker)| distance > BEFORE_LIGHT || blocker.emits)
    }

    /// Whether most rays from above meet, at the very top, a surface from behind: a ceiling.
    fn has_ceiling(&self, low: DVec3, high: DVec3) -> bool {
        /// How near to the top of the bounding box, as a share of its height.
        const TOP: f64 = 0.05;
        let extent = high - low;
        let height = extent.y.max(extent.max_element() * 1e-3);
        let mut ceilings = 0;
        for i in 0..GRID * GRID {
            let share = |index: usize| (2 * index + 1) as f64 / (2 * GRID) as f64;
            let start = low + extent * DVec3::new(share(i % GRID), 0.0, share(i / GRID));
            let start = DVec3::new(start.x, high.y + height, start.z);
            let ceiling = self
                .hit(start, DVec3::NEG_Y * height)
                .is_some_and(|(distance, surface)| distance < 1.0 + TOP && surface.normal.y < 0.0);
            ceilings += usize::from(ceiling);
        }
        ceilings > GRID * GRID / 2
    }
}

/// The `count` items with the largest keys.
fn largest<T>(mut items: Vec<(f64, T)>, count: usize) -> Vec<T> {
    items.sort_by(|a, b| b.0.total_cmp(&a.0));
    items.truncate(count);
    items.into_iter().map(|(_, item)| item).collect()
}
