//! Pyramid: what the pixels of blocks of 1, 2 × 2, 4 × 4 … found of each surface that they show, in the mean.

use super::surfaces::{Patch, Place, Surfaces};
use crate::spectrum::{BANDS, BLACK, Bands, add};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// What pixels of several surfaces found counts as so many pixels: where surfaces are seen whole anywhere near, these alone tell of them.
const MIXED: f32 = 0.02;
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
    /// Mean irradiance that each half of the passes found, one after the other.
    pub(super) values: [f32; VALUES],
}

/// The bands of both halves, and zeros up to whole vectors of four.
pub(super) const VALUES: usize = (2 * BANDS).next_multiple_of(4);

/// Both halves in one array.
fn values(halves: &[Bands; 2]) -> [f32; VALUES] {
    let mut values = [0.0; VALUES];
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
}

/// What a pixel tells of the surfaces that it shows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Told {
    /// Mean irradiance of each half of the passes, over all that the pixel shows; 0 in bands that it takes nothing of.
    pub(super) halves: [Bands; 2],
    /// Pixels that this counts as, for a part of the pixel of one.
    pub(super) count: f32,
}

impl Told {
    /// Of the mean radiance of each half.
    pub(super) fn new(patches: &[Patch], is_mixed: bool, radiance: [Bands; 2]) -> Self {
        let weight = patches.iter().fold(BLACK, |sum, patch| add(&sum, &patch.weight));
        let over = |x: f32, weight: f32| if weight > 0.0 { x / weight } else { 0.0 };
        let halves = radiance.map(|half| std::array::from_fn(|b| over(half[b], weight[b])));
        Self { halves, count: if is_mixed { MIXED } else { 1.0 } }
    }
}

impl Level {
    /// Single pixels, of the mean radiance of each half.
    pub(super) fn of_pixels(size: [u32; 2], surfaces: &Surfaces, halves: [&[Bands]; 2]) -> Self {
        let (mut first, mut nodes) = (Vec::with_capacity(halves[0].len() + 1), Vec::new());
        for pixel in 0..halves[0].len() {
            first.push(nodes.len() as u32);
            let patches = surfaces.at(pixel);
            let told = Told::new(patches, surfaces.is_mixed(pixel), halves.map(|half| half[pixel]));
            nodes.extend(patches.iter().map(|patch| Node {
                place: patch.place,
                at: middle(pixel as u32, size),
                count: told.count * patch.share,
                values: values(&told.halves),
            }));
        }
        first.push(nodes.len() as u32);
        Self { width: 1, size, first, nodes }
    }

    /// Blocks of twice the size.
    pub(super) fn coarser(&self) -> Self {
        let size = self.size.map(|n| n.div_ceil(2));
        let blocks: Vec<Vec<Node>> = (0..size[0] * size[1])
            .into_par_iter()
            .map(|block| {
                let (x, y) = (block % size[0] * 2, block / size[0] * 2);
                let mut joined: Vec<Node> = Vec::new();
                for (x, y) in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)] {
                    if x >= self.size[0] || y >= self.size[1] {
                        continue;
                    }
                    for node in self.of(x, y) {
                        match joined.iter_mut().find(|other| other.goes_with(node, self.width)) {
                            Some(other) => other.join(node),
                            None => joined.push(*node),
                        }
                    }
                }
                joined.iter_mut().for_each(|n| n.place.normal = n.place.normal.normalize_or(Vec3::Z));
                joined
            })
            .collect();
        let (mut first, mut nodes) = (Vec::with_capacity(blocks.len() + 1), Vec::new());
        for block in blocks {
            first.push(nodes.len() as u32);
            nodes.extend(block);
        }
        first.push(nodes.len() as u32);
        Self { width: 2 * self.width, size, first, nodes }
    }

    /// The surfaces of a block.
    #[inline]
    pub(super) fn of(&self, x: u32, y: u32) -> &[Node] {
        let block = (y * self.size[0] + x) as usize;
        &self.nodes[self.first[block] as usize..self.first[block + 1] as usize]
    }
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
        for (value, others) in self.values.iter_mut().zip(&other.values) {
            *value = *value * mine + others * theirs;
        }
        self.count = count;
    }
}
