//! Pyramid: what the pixels of blocks of 1, 2 × 2, 4 × 4 … found of each surface that they show, in the mean.

use super::lit::Lit;
use super::patch::Place;
use super::surfaces::Surfaces;
use super::told::{Values, alike, count, halves, values};
use super::window::Window;
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

/// The blocks of one size, of some rows.
#[derive(Debug)]
pub(super) struct Level {
    /// Width of a block, pixels.
    pub(super) width: u32,
    /// Blocks across and down in the image.
    pub(super) size: [u32; 2],
    /// First node of each block, and the end.
    first: Window<u32>,
    /// None of single pixels.
    nodes: Window<Node>,
    /// What the nodes found of each layer.
    pub(super) values: Vec<Window<Values>>,
}

/// A node as a part of one of a coarser level: its number, the number of that, and its pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) id: u32,
    pub(super) of: u32,
    count: f32,
}

/// Nodes that follow, block by block, and what they are joined from: as many parts as the finer level has nodes there.
pub(super) struct Joined {
    pub(super) parts: Vec<Part>,
    /// What the nodes found of each layer.
    pub(super) values: Vec<Vec<Values>>,
}

impl Level {
    /// Nothing yet of blocks so wide.
    pub(super) fn new(width: u32, size: [u32; 2], layers: usize) -> Self {
        let size = size.map(|n| n.div_ceil(width));
        let values = (0..layers).map(|_| Window::default()).collect();
        Self { width, size, first: Window::from_iter([0]), nodes: Window::default(), values }
    }

    /// Rows of blocks whose nodes are known.
    pub(super) fn rows(&self) -> u32 {
        (self.first.end() - 1) as u32 / self.size[0]
    }

    /// Rows of pixels that these are.
    pub(super) fn pixel_rows(&self, height: u32) -> u32 {
        (self.rows() * self.width).min(height)
    }

    /// Single pixels up to a row, as the halves of some layers have found them. Their nodes are their patches and have their numbers.
    pub(super) fn take_pixels(&mut self, surfaces: &Surfaces, layers: &[Lit<'_>], rows: u32) {
        let size = self.size;
        let pixels = (self.rows() * size[0]) as usize..(rows * size[0]) as usize;
        for (values, lit) in self.values.iter_mut().zip(layers) {
            values.extend(alike(surfaces, lit, pixels.clone()));
        }
        self.first.extend(surfaces.firsts(pixels).skip(1).collect());
    }

    /// Take the nodes of all blocks that the finer level is known for up to a row of pixels, and give what they found.
    pub(super) fn join(&mut self, finer: &Self, surfaces: &Surfaces, rows: u32, height: u32) -> Joined {
        let across = self.size[0];
        let rows = if rows >= height { self.size[1] } else { rows / self.width };
        debug_assert!(rows * self.width <= finer.pixel_rows(height) || rows == self.size[1]);
        let blocks: Vec<(Vec<Node>, Vec<Part>)> = (self.rows() * across..rows * across)
            .into_par_iter()
            .map(|block| finer.joined(surfaces, block, across))
            .collect();
        let begin = self.nodes.end();
        let (mut first, mut nodes, mut parts) = (Vec::with_capacity(blocks.len()), Vec::new(), Vec::new());
        for (block, of_block) in blocks {
            let before = (begin + nodes.len()) as u32;
            parts.extend(of_block.into_iter().map(|part| Part { of: before + part.of, ..part }));
            nodes.extend(block);
            first.push((begin + nodes.len()) as u32);
        }
        self.first.extend(first);
        self.nodes.extend(nodes);
        let nodes = self.nodes.end() - begin;
        let values = finer.values.par_iter().map(|finer| {
            let mut values = vec![Values::default(); nodes];
            for part in &parts {
                self.add_part(&mut values[part.of as usize - begin], part, finer);
            }
            values
        });
        Joined { values: values.collect(), parts }
    }

    /// Add what one part found of a layer to what its node did.
    pub(super) fn add_part(&self, values: &mut Values, part: &Part, finer: &Window<Values>) {
        let share = part.count / self.nodes[part.of as usize].count;
        values.iter_mut().zip(&finer[part.id as usize]).for_each(|(sum, value)| *sum += share * value);
    }

    /// The surfaces of a block of twice the size, and what they are joined from.
    fn joined(&self, surfaces: &Surfaces, block: u32, across: u32) -> (Vec<Node>, Vec<Part>) {
        let (x, y) = (block % across * 2, block / across * 2);
        let (mut joined, mut parts): (Vec<Node>, Vec<Part>) = (Vec::new(), Vec::new());
        for (x, y) in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)] {
            if x >= self.size[0] || y >= self.size[1] {
                continue;
            }
            self.for_each(surfaces, y, x..x + 1, |id, node| {
                let of = joined.iter().position(|other| other.goes_with(node, self.width));
                match of {
                    Some(of) => joined[of].join(node),
                    None => joined.push(*node),
                }
                let of = of.unwrap_or(joined.len() - 1);
                parts.push(Part { id: id as u32, of: of as u32, count: node.count });
            });
        }
        joined.iter_mut().for_each(|n| n.place.normal = n.place.normal.normalize_or(Vec3::Z));
        (joined, parts)
    }

    /// Let go of all blocks that end before this row of pixels.
    pub(super) fn drop_before(&mut self, row: u32) {
        let block = (row / self.width * self.size[0]) as usize;
        let id = self.first[block] as usize;
        self.nodes.drop_before(id);
        self.values.iter_mut().for_each(|values| values.drop_before(id));
        self.first.drop_before(block);
    }

    /// Say anew what a node found of a layer.
    pub(super) fn set(&mut self, layer: usize, id: usize, halves: &[Bands; 2]) {
        self.values[layer][id] = values(halves);
    }

    /// What a node found of a layer.
    pub(super) fn of(&self, layer: usize, id: usize) -> [Bands; 2] {
        halves(&self.values[layer][id])
    }

    /// What the nodes that follow found of each layer.
    pub(super) fn take_values(&mut self, values: Vec<Vec<Values>>) {
        self.values.iter_mut().zip(values).for_each(|(all, values)| all.extend(values));
    }

    /// The number after that of the last node.
    pub(super) fn ids_end(&self) -> usize {
        self.first[self.first.end() - 1] as usize
    }

    /// Numbers of the nodes of some rows of blocks.
    pub(super) fn ids_of_rows(&self, rows: Range<u32>) -> Range<usize> {
        let [begin, end] =
            [rows.start, rows.end].map(|row| self.first[(row * self.size[0]) as usize] as usize);
        begin..end
    }

    /// Do something with each surface of some blocks of a row and its number.
    #[inline]
    pub(super) fn for_each(
        &self,
        surfaces: &Surfaces,
        y: u32,
        columns: Range<u32>,
        mut work: impl FnMut(usize, &Node),
    ) {
        let row = y * self.size[0];
        if self.width > 1 {
            let [begin, end] = [columns.start, columns.end].map(|x| self.first[(row + x) as usize] as usize);
            let mut id = begin;
            self.nodes.range(begin..end).for_each(|node| {
                work(id, node);
                id += 1;
            });
            return;
        }
        for x in columns {
            let pixel = (row + x) as usize;
            let count = count(surfaces, pixel);
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            for id in surfaces.ids(pixel) {
                let patch = surfaces.patch(id);
                work(id, &Node { place: patch.place, at, count: count * patch.share });
            }
        }
    }

    /// What all of them found of a layer.
    pub(super) fn values(&self, layer: usize) -> &Window<Values> {
        &self.values[layer]
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
        self.count = count;
    }
}
