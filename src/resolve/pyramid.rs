//! Pyramid: what the pixels of blocks of 1, 2 × 2, 4 × 4 … found of each surface that they show, in the mean.

use super::patch::Place;
use super::surfaces::Surfaces;
use super::told::{Told, count};
use crate::spectrum::{BANDS, Bands};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Cosine between the normals of nodes that are joined.
const JOIN_COS: f32 = 0.9;
/// Difference between their clearances.
const JOIN_CLEARANCE: f32 = 0.6;

/// One surface in a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Mean place.
    pub(super) place: Place,
    /// Mean place in the image, pixels.
    pub(super) at: Vec2,
    /// Pixels.
    pub(super) count: f32,
}

/// Mean irradiance that each half of the passes found, one after the other: the bands, and zeros up to whole vectors of four.
pub(super) type Values = [f32; (2 * BANDS).next_multiple_of(4)];

/// Both halves in one array.
fn values(halves: &[Bands; 2]) -> Values {
    let mut values = Values::default();
    for (value, band) in values.iter_mut().zip(halves.as_flattened()) {
        *value = *band;
    }
    values
}

/// The blocks of one size.
#[derive(Debug)]
pub(super) struct Level {
    /// Width of a block, pixels.
    pub(super) width: u32,
    /// Blocks across and down.
    pub(super) size: [u32; 2],
    first: Vec<u32>,
    nodes: Vec<Node>,
    /// What the nodes found of each layer.
    values: Vec<Vec<Values>>,
}

impl Level {
    /// Single pixels, of what they tell of each layer.
    pub(super) fn of_pixels(size: [u32; 2], surfaces: &Surfaces, told: &[Told]) -> Self {
        let pixels = (size[0] * size[1]) as usize;
        let (mut first, mut nodes) = (Vec::with_capacity(pixels + 1), Vec::new());
        for pixel in 0..pixels {
            first.push(nodes.len() as u32);
            let count = count(surfaces, pixel);
            nodes.extend(surfaces.at(pixel).iter().map(|patch| Node {
                place: patch.place,
                at: middle(pixel as u32, size),
                count: count * patch.share,
            }));
        }
        first.push(nodes.len() as u32);
        let values = told.iter().map(|told| told.irradiance.iter().map(values).collect()).collect();
        Self { width: 1, size, first, nodes, values }
    }

    /// Blocks of twice the size.
    pub(super) fn coarser(&self) -> Self {
        let size = self.size.map(|n| n.div_ceil(2));
        let blocks: Vec<(Vec<Node>, Vec<Part>)> = (0..size[0] * size[1])
            .into_par_iter()
            .map(|block| {
                let (x, y) = (block % size[0] * 2, block / size[0] * 2);
                let (mut joined, mut parts): (Vec<Node>, Vec<Part>) = (Vec::new(), Vec::new());
                for (x, y) in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)] {
                    if x >= self.size[0] || y >= self.size[1] {
                        continue;
                    }
                    for id in self.ids(x, y) {
                        let node = &self.nodes[id];
                        let of = joined.iter().position(|other| other.goes_with(node, self.width));
                        match of {
                            Some(of) => joined[of].join(node),
                            None => joined.push(*node),
                        }
                        let of = of.unwrap_or(joined.len() - 1);
                        parts.push(Part { id: id as u32, of: of as u32, count: node.count });
                    }
                }
                joined.iter_mut().for_each(|n| n.place.normal = n.place.normal.normalize_or(Vec3::Z));
                (joined, parts)
            })
            .collect();
        let (mut first, mut nodes) = (Vec::with_capacity(blocks.len() + 1), Vec::new());
        let mut coarser = vec![Vec::new(); self.values.len()];
        for (block, parts) in blocks {
            first.push(nodes.len() as u32);
            for (finer, coarser) in self.values.iter().zip(&mut coarser) {
                coarser.resize(nodes.len() + block.len(), Values::default());
                for &Part { id, of, count } in &parts {
                    let part = count / block[of as usize].count;
                    let sums = &mut coarser[nodes.len() + of as usize];
                    sums.iter_mut().zip(&finer[id as usize]).for_each(|(sum, value)| *sum += part * value);
                }
            }
            nodes.extend(block);
        }
        first.push(nodes.len() as u32);
        Self { width: 2 * self.width, size, first, nodes, values: coarser }
    }

    /// Numbers of the surfaces of a block.
    #[inline]
    pub(super) fn ids(&self, x: u32, y: u32) -> Range<usize> {
        let block = (y * self.size[0] + x) as usize;
        self.first[block] as usize..self.first[block + 1] as usize
    }

    /// One of them.
    #[inline]
    pub(super) fn node(&self, id: usize) -> &Node {
        &self.nodes[id]
    }

    /// What all of them found of a layer.
    pub(super) fn values(&self, layer: usize) -> &[Values] {
        &self.values[layer]
    }
}

/// A node as a part of one of a coarser block: its number, which of the block's it is part of, and its pixels.
struct Part {
    id: u32,
    of: u32,
    count: f32,
}

/// Middle of a pixel in the image.
pub(super) fn middle(pixel: u32, [width, _]: [u32; 2]) -> Vec2 {
    Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5)
}

impl Node {
    fn goes_with(&self, other: &Node, width: u32) -> bool {
        let (mine, theirs) = (&self.place, &other.place);
        let d = theirs.position - mine.position;
        mine.kind == theirs.kind
            && (mine.clearance - theirs.clearance).abs() < JOIN_CLEARANCE
            && mine.normal.dot(theirs.normal) > JOIN_COS * mine.normal.length()
            && d.dot(theirs.normal).abs() < 0.5 * width as f32 * theirs.footprint
    }

    /// The mean of both, but for the length of the normal.
    fn join(&mut self, other: &Node) {
        let count = self.count + other.count;
        let (mine, theirs) = (self.count / count, other.count / count);
        self.place.join(self.count, &other.place, other.count);
        self.at = self.at * mine + other.at * theirs;
        self.count = count;
    }
}
