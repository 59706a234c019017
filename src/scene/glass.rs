//! Glass: what a surface of glass is, by its shape: the boundary of a body, or a sheet that stands for a thin pane.
//!
//! Light that enters a body must leave it again. A sheet has no inside: a single quad as a window pane would bend light
//! once and for all, and scale radiance by η². So it is a thin pane instead, with both of its faces in one place [E26].
//!
//! The rule: what is closed bounds a body. What is open is a sheet where the flat lids that would close its holes are a
//! tenth of its area at least: a pane lacks as much as it has, a dome half, a tumbler or a showcase of five panes a fifth,
//! while holes in a scanned body are a few hundredths, and stay holes in a body, with a warning. Two open surfaces that share
//! a rim and face away from each other close a body between them. An index below 1.4 is no glass: water and other
//! liquids are drawn by their level alone, and stay the boundary of what is behind them.

use super::warnings::{Named, Warnings};
use super::weld::{Surface, surfaces};
use super::{Material, Mesh};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::path::PathBuf;

/// Lids of a sheet over its area, at least.
const SHEET_HOLES: f64 = 0.1;
/// Index of refraction of a sheet, at least: fused silica has 1.46, water 1.33.
const SHEET_INDEX: f32 = 1.4;
/// Rims are the same, and areas cancel, to this part of their size.
const SAME: f64 = 0.02;
/// A liquid's level faces up, to this part of its area.
const LEVEL: f64 = 0.5;
/// Comparisons of an inverted body with others that may hold it, at most.
const HOLDERS_TRIED: usize = 10_000_000;

/// Where a material comes from, and what the scene file says of its thickness.
#[derive(Debug, Clone)]
pub(crate) struct Origin {
    /// Mesh file.
    pub(crate) file: PathBuf,
    /// Line of the first face.
    pub(crate) line: usize,
    /// `thin` of a `[[material]]`.
    pub(crate) thin: Option<bool>,
}

/// What a surface of glass is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    Body,
    /// A body with holes.
    Holed,
    /// An open surface that closes a body with another one, or is a liquid's.
    Level,
    Sheet,
}

/// Decides what the glass of a scene is, marks thin panes, turns bodies that are inside out, and says so.
pub(crate) fn settle(
    mesh: &mut Mesh,
    materials: &mut Vec<Material>,
    origins: &[Origin],
    warnings: &mut Warnings,
) {
    if materials.iter().all(|m| m.dielectric.is_none()) {
        return;
    }
    let surfaces = surfaces(mesh, materials);
    let shapes = shapes(&surfaces, mesh, materials);
    let mut told = |i: u32, what: [&str; 2], materials: &[Material], mesh: &Mesh| {
        let number = mesh.triangles[i as usize].material as usize;
        let Origin { file, line, .. } = &origins[number];
        let kind = Named { noun: ["material", "materials"], what };
        warnings.add_named(file, Some(*line), kind, &materials[number].name, String::new);
    };
    let (mut thin, mut has_liquids) = (Vec::new(), false);
    let mut is_dropped = vec![false; mesh.triangles.len()];
    for (surface, shape) in surfaces.iter().zip(&shapes) {
        let is_thin = |i: u32| {
            let number = mesh.triangles[i as usize].material as usize;
            let index = materials[number].dielectric.map_or(1.0, |d| d.ior);
            origins[number].thin.unwrap_or(*shape == Shape::Sheet && index >= SHEET_INDEX)
        };
        let one = surface.triangles[0];
        match shape {
            Shape::Holed => told(one, HOLED, materials, mesh),
            Shape::Sheet if is_thin(one) && origins[material_of(mesh, one)].thin.is_none() => {
                told(one, SHEET, materials, mesh);
            }
            Shape::Sheet if !is_thin(one) && surface.facing.y < LEVEL * surface.area => {
                told(one, OPEN, materials, mesh);
            }
            _ => {}
        }
        has_liquids |= *shape == Shape::Level || *shape == Shape::Sheet && !is_thin(one);
        let panes = surface.triangles.iter().copied().filter(|&i| is_thin(i));
        let before = thin.len();
        thin.extend(panes);
        if thin.len() > before {
            // a pane that is drawn from both sides is one pane
            surface.copies.iter().for_each(|&i| is_dropped[i as usize] = true);
            let folded = *shape == Shape::Sheet && surface.open_edges == 0;
            let backs = surface.triangles.iter().zip(&surface.turned);
            let sign = normal(mesh, one);
            backs
                .filter(|(i, _)| folded && normal(mesh, **i).dot(sign) < 0.0)
                .for_each(|(i, _)| is_dropped[*i as usize] = true);
        }
    }
    flip(mesh, &turn(&surfaces, &shapes, has_liquids, mesh, materials, &mut told));
    mark(mesh, materials, &thin);
    let mut index = 0;
    mesh.triangles.retain(|_| {
        index += 1;
        !is_dropped[index - 1]
    });
}

const SHEET: [&str; 2] = [
    ": open glass without thickness is taken for a thin pane, which reflects 2R/(1+R) and lets the rest pass unbent (close it to make \
     it a body, or set thin)",
    ": open glass without thickness is taken for thin panes, which reflect 2R/(1+R) and let the rest pass unbent (close them to make \
     them bodies, or set thin)",
];
const HOLED: [&str; 2] = [
    ": the glass body has holes, and light that passes one is refracted only once; close them",
    ": these glass bodies have holes, and light that passes one is refracted only once; close them",
];
const OPEN: [&str; 2] = [
    ": an open surface of so low an index is taken for a liquid's, with all behind its front inside; close it, or set thin = true",
    ": open surfaces of so low an index are taken for a liquid's, with all behind their fronts inside; close them, or set thin = true",
];
const INSIDE_OUT: [&str; 2] = [
    ": the fronts of this glass body look inward, which makes it a bubble in glass; turn its faces if that is not meant",
    ": the fronts of these glass bodies look inward, which makes them bubbles in glass; turn their faces if that is not meant",
];
const TURNED: [&str; 2] = [
    ": fronts of this glass body look inward, as mirrored exports do; they are turned",
    ": fronts of these glass bodies look inward, as mirrored exports do; they are turned",
];

fn material_of(mesh: &Mesh, triangle: u32) -> usize {
    mesh.triangles[triangle as usize].material as usize
}

fn normal(mesh: &Mesh, triangle: u32) -> DVec3 {
    let [a, b, c] = mesh.triangles[triangle as usize].vertex.map(|v| mesh.positions[v as usize]);
    (b - a).cross(c - a)
}

fn shapes(surfaces: &[Surface], mesh: &Mesh, materials: &[Material]) -> Vec<Shape> {
    let mut group = vec![(0.0, 0.0); surfaces.len()];
    for s in surfaces {
        let (holes, area) = &mut group[s.group as usize];
        (*holes, *area) = (*holes + s.holes, *area + s.area);
    }
    let is_sheet = |s: &Surface| {
        let index = materials[material_of(mesh, s.triangles[0])].dielectric.map_or(1.0, |d| d.ior);
        let (holes, area) = group[s.group as usize];
        match s.open_edges {
            0 => s.is_flat && s.facing.length() < SAME * s.area,
            _ => holes >= SHEET_HOLES * area || index < SHEET_INDEX,
        }
    };
    let mut shapes: Vec<Shape> = surfaces
        .iter()
        .map(|s| match (is_sheet(s), s.open_edges) {
            (true, _) => Shape::Sheet,
            (false, 0) => Shape::Body,
            (false, _) => Shape::Holed,
        })
        .collect();
    let mut by_rim: FxHashMap<[i64; 4], Vec<usize>> = FxHashMap::default();
    for (i, s) in surfaces.iter().enumerate() {
        if shapes[i] != Shape::Sheet || s.open_edges == 0 {
            continue;
        }
        let [low, high] = s.rim;
        let (middle, size) = ((low + high) / 2.0, (high - low).length());
        let key = |size: f64, shift: DVec3| {
            let level = size.log2().floor();
            let [x, y, z] = (middle / level.exp2() * 4.0 + shift).floor().to_array().map(|v| v as i64);
            [level as i64, x, y, z]
        };
        let mut keys: Vec<[i64; 4]> = (0..16u32)
            .map(|k| {
                let sign = |bit: u32| if k >> bit & 1 == 0 { -8.0 * SAME } else { 8.0 * SAME };
                key(size * (1.0 + sign(3) / 8.0), DVec3::new(sign(0), sign(1), sign(2)))
            })
            .collect();
        keys.sort_unstable();
        keys.dedup();
        let partner =
            keys.iter().filter_map(|k| by_rim.get(k)).flatten().copied().find(|&j| closes(s, &surfaces[j]));
        if let Some(j) = partner {
            (shapes[i], shapes[j]) = (Shape::Level, Shape::Level);
        }
        let here = by_rim.entry(key(size, DVec3::ZERO)).or_default();
        if here.len() < RIMS_IN_A_CELL {
            here.push(i);
        }
    }
    shapes
}

/// Open surfaces with rims in one place that are told apart, at most.
const RIMS_IN_A_CELL: usize = 16;

/// True where two open surfaces share a rim and face away from each other: together they are closed.
fn closes(a: &Surface, b: &Surface) -> bool {
    let size = (a.rim[1] - a.rim[0]).length();
    let is_near = |i: usize| (a.rim[i] - b.rim[i]).length() < SAME * size;
    let facing = a.facing.length() + b.facing.length();
    is_near(0) && is_near(1) && (a.facing + b.facing).length() < SAME * facing
}

/// Triangles to turn over: those of bodies whose fronts look inward. A body that another may hold is a bubble where all
/// of them do, and has the fronts of its greater part where some do; so may be one that lies in a liquid: it is left.
fn turn(
    surfaces: &[Surface],
    shapes: &[Shape],
    has_liquids: bool,
    mesh: &Mesh,
    materials: &[Material],
    told: &mut impl FnMut(u32, [&str; 2], &[Material], &Mesh),
) -> Vec<u32> {
    let is_body = |shape: &Shape| matches!(shape, Shape::Body | Shape::Holed);
    let bodies = surfaces.iter().zip(shapes).filter(|(s, shape)| is_body(shape) && !s.branches);
    let doubtful: Vec<(&Surface, [Vec<u32>; 2])> =
        bodies.map(|(s, _)| (s, sides(s))).filter(|(_, [_, inward])| !inward.is_empty()).collect();
    // more than can be compared: the careful answer
    let too_many = doubtful.len() * surfaces.len() > HOLDERS_TRIED;
    let area = |side: &[u32]| -> f64 { side.iter().map(|&i| normal(mesh, i).length()).sum() };
    let mut wrong = Vec::new();
    for (s, [outward, inward]) in doubtful {
        let one = s.triangles[0];
        let is_held = too_many || is_held(s, surfaces);
        let shines = s.triangles.iter().any(|&i| materials[material_of(mesh, i)].emits());
        if is_held && outward.is_empty() {
            continue;
        }
        if shines || outward.is_empty() && has_liquids {
            told(one, INSIDE_OUT, materials, mesh);
            continue;
        }
        told(one, TURNED, materials, mesh);
        wrong.extend(if is_held && area(&inward) > area(&outward) { outward } else { inward });
    }
    wrong
}

/// Triangles whose fronts look out of the body, and into it.
fn sides(surface: &Surface) -> [Vec<u32>; 2] {
    if surface.volume.abs() < NO_VOLUME * surface.area.powf(1.5) {
        return Default::default();
    }
    let looks_out = |turned: bool| (surface.volume > 0.0) != turned;
    let (outward, inward) =
        surface.triangles.iter().zip(&surface.turned).partition::<Vec<_>, _>(|(_, t)| looks_out(**t));
    [outward, inward].map(|side| side.into_iter().map(|(&i, _)| i).collect())
}

/// Volume over area^1.5 below which a body has no inside; a ball has 0.094.
const NO_VOLUME: f64 = 1e-9;

/// True where the box of another surface holds this one's.
fn is_held(surface: &Surface, all: &[Surface]) -> bool {
    let [low, high] = surface.bounds;
    let holds = |s: &Surface| s.bounds[0].cmple(low).all() && s.bounds[1].cmpge(high).all();
    all.iter().any(|s| !std::ptr::eq(s, surface) && holds(s))
}

/// Turns triangles over, with their shading normals.
fn flip(mesh: &mut Mesh, triangles: &[u32]) {
    let mut opposite: FxHashMap<u32, u32> = FxHashMap::default();
    for &i in triangles {
        let t = &mut mesh.triangles[i as usize];
        t.vertex.swap(1, 2);
        if let Some(normals) = &mut t.normal {
            normals.swap(1, 2);
            for n in normals {
                *n = *opposite.entry(*n).or_insert_with(|| {
                    mesh.normals.push(-mesh.normals[*n as usize]);
                    mesh.normals.len() as u32 - 1
                });
            }
        }
    }
}

/// Gives thin panes a material of their own, where they share it with a body.
fn mark(mesh: &mut Mesh, materials: &mut Vec<Material>, thin: &[u32]) {
    let mut is_thin = vec![false; mesh.triangles.len()];
    thin.iter().for_each(|&i| is_thin[i as usize] = true);
    let mut has_body = vec![false; materials.len()];
    for (t, _) in mesh.triangles.iter().zip(&is_thin).filter(|(_, thin)| !**thin) {
        has_body[t.material as usize] = true;
    }
    let mut pane_of: FxHashMap<u32, u32> = FxHashMap::default();
    for &i in thin {
        let number = mesh.triangles[i as usize].material;
        let pane = *pane_of.entry(number).or_insert_with(|| {
            if !has_body[number as usize] {
                materials[number as usize].thin = true;
                return number;
            }
            materials.push(Material { thin: true, ..materials[number as usize].clone() });
            materials.len() as u32 - 1
        });
        mesh.triangles[i as usize].material = pane;
    }
}
