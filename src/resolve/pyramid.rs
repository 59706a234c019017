//! Pyramid: what the pixels of blocks of 1, 2 × 2, 4 × 4 … found of each surface that they show, in the mean.

use super::patch::Place;
use super::surfaces::Surfaces;
use super::told::{Values, alike, count, halves, values};
use crate::spectrum::Bands;
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

/// The blocks of one size.
#[derive(Debug)]
pub(super) struct Level {
    /// Width of a block, pixels.
    pub(super) width: u32,
    /// Blocks across and down.
    pub(super) size: [u32; 2],
    first: Vec<u32>,
    nodes: Vec<Node>,
    /// What the nodes are joined from, block by block; nothing for single pixels.
    parts: Vec<Part>,
    /// What the nodes found of each layer.
    values: Vec<Vec<Values>>,
}

impl Level {
    /// Single pixels, of the mean radiance of each half of some layers. Nodes have the numbers of their patches.
    pub(super) fn of_pixels(size: [u32; 2], surfaces: &Surfaces, layers: &[[&[Bands]; 2]]) -> Self {
        let nodes = (0..size[0] * size[1])
            .into_par_iter()
            .flat_map_iter(|pixel| {
                let count = count(surfaces, pixel as usize);
                surfaces.at(pixel as usize).iter().map(move |patch| Node {
                    place: patch.place,
                    at: middle(pixel, size),
                    count: count * patch.share,
                })
            })
            .collect();
        let values = layers.iter().map(|halves| alike(surfaces, *halves)).collect();
        Self { width: 1, size, first: surfaces.firsts().to_vec(), nodes, parts: Vec::new(), values }
    }

    /// Blocks of twice the size.
    pub(super) fn coarser(&self) -> Self {
        let size = self.size.map(|n| n.div_ceil(2));
        let blocks: Vec<(Vec<Node>, Vec<Part>)> =
            (0..size[0] * size[1]).into_par_iter().map(|block| self.joined(block, size[0])).collect();
        let (mut first, mut nodes, mut all) = (Vec::with_capacity(blocks.len() + 1), Vec::new(), Vec::new());
        for (block, parts) in blocks {
            let before = nodes.len() as u32;
            first.push(before);
            all.extend(parts.into_iter().map(|part| Part { of: before + part.of, ..part }));
            nodes.extend(block);
        }
        first.push(nodes.len() as u32);
        let values = vec![vec![Values::default(); nodes.len()]; self.values.len()];
        let mut coarser = Self { width: 2 * self.width, size, first, nodes, parts: all, values };
        coarser.take_from(self, None);
        coarser
    }

    /// The surfaces of a block of twice the size, and what they are joined from.
    fn joined(&self, block: u32, across: u32) -> (Vec<Node>, Vec<Part>) {
        let (x, y) = (block % across * 2, block / across * 2);
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
    }

    /// Say anew what a node found of a layer.
    pub(super) fn set(&mut self, layer: usize, id: usize, halves: &[Bands; 2]) {
        self.values[layer][id] = values(halves);
    }

    /// What a node found of a layer.
    pub(super) fn of(&self, layer: usize, id: usize) -> [Bands; 2] {
        halves(&self.values[layer][id])
    }

    /// Nodes that hold one of some nodes of the finer level.
    pub(super) fn holders(&self, finer: &[bool]) -> Vec<bool> {
        let mut holders = vec![false; self.nodes.len()];
        self.parts.iter().for_each(|part| holders[part.of as usize] |= finer[part.id as usize]);
        holders
    }

    /// What nodes found, from what those of the finer level did: of all, or of these.
    pub(super) fn take_from(&mut self, finer: &Self, only: Option<&[bool]>) {
        let (nodes, parts) = (&self.nodes, &self.parts);
        let is_taken = |of: usize| only.is_none_or(|only| only[of]);
        self.values.par_iter_mut().zip(&finer.values).for_each(|(values, finer)| {
            (0..values.len()).filter(|of| is_taken(*of)).for_each(|of| values[of] = Values::default());
            for part in parts.iter().filter(|part| is_taken(part.of as usize)) {
                let share = part.count / nodes[part.of as usize].count;
                let sums = values[part.of as usize].iter_mut();
                sums.zip(&finer[part.id as usize]).for_each(|(sum, value)| *sum += share * value);
            }
        });
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

/// A node as a part of one of a coarser level: its number, the number of that, and its pixels.
#[derive(Debug)]
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
