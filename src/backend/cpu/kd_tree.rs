//! A balanced kd-tree over points, in leaves of equal size: the order that keeps neighbours together, and a visit of the
//! leaves that a ball touches.
//!
//! Node and leaf addresses are implicit: inner nodes in preorder, leaves side by side, each with the same number of
//! slots. What lies in the slots belongs to the caller. Same points, same tree, whatever the threads.
//!
//! Why not a crate: visiting leaves of four-lane groups allocates nothing and counts the neighbours of 45,000 points (115
//! each) in 46 ms; kiddo 6.3's unsorted `within`, which hands out a list, takes 143 ms.

use glam::Vec3;

/// Slots a leaf may have; four lanes each.
const LEAF_MAX: usize = 16;
/// Lanes that are tested together.
pub(super) const LANES: usize = 4;
/// Slot without a point.
pub(super) const EMPTY: u32 = u32::MAX;
/// Below this many points a subtree is built by one thread.
const PARALLEL_ABOVE: usize = 4096;
/// Deeper than any tree over 2^32 points.
const STACK: usize = 40;

#[derive(Debug, Clone, Copy, Default)]
struct Node {
    axis: u32,
    value: f32,
}

/// The tree; empty where there are no points.
#[derive(Debug, Clone, Default)]
pub(super) struct KdTree {
    /// Levels of inner nodes; there are 2^levels leaves.
    levels: u32,
    /// Groups of [`LANES`] slots in a leaf; 0 where the tree is empty.
    quads_per_leaf: usize,
    nodes: Vec<Node>,
    /// Corners of what each leaf holds.
    bounds: Vec<[Vec3; 2]>,
}

type Entry = (Vec3, u32);

impl KdTree {
    /// Build; also returns which point stands in each slot, [`EMPTY`] where none.
    pub(super) fn build(positions: impl Iterator<Item = Vec3>) -> (Self, Vec<u32>) {
        let mut entries: Vec<Entry> = positions.zip(0..).collect();
        let n = entries.len();
        if n == 0 {
            return (Self::default(), Vec::new());
        }
        let levels = n.div_ceil(LEAF_MAX).next_power_of_two().trailing_zeros();
        let leaves = 1usize << levels;
        let quads_per_leaf = n.div_ceil(leaves).div_ceil(LANES);
        let mut tree = Self {
            levels,
            quads_per_leaf,
            nodes: vec![Node::default(); leaves - 1],
            bounds: vec![[Vec3::INFINITY, Vec3::NEG_INFINITY]; leaves],
        };
        let mut slots = vec![EMPTY; leaves * quads_per_leaf * LANES];
        split(&mut entries, &mut tree.nodes, &mut tree.bounds, &mut slots);
        (tree, slots)
    }

    /// Visit the groups of slots of each leaf whose bounds come within the radius of `center`.
    #[inline(always)]
    pub(super) fn visit(
        &self,
        center: Vec3,
        radius_squared: f32,
        mut leaf_quads: impl FnMut(std::ops::Range<usize>),
    ) {
        if self.quads_per_leaf == 0 {
            return;
        }
        let mut stack = [(0u32, 0u32, 0u32); STACK];
        let mut top = 0;
        let (mut node, mut leaf, mut level) = (0u32, 0u32, self.levels);
        loop {
            while level > 0 {
                level -= 1;
                let half = 1u32 << level;
                let Node { axis, value } = self.nodes[node as usize];
                let offset = center[axis as usize] - value;
                let (below, above) = ((node + 1, leaf, level), (node + half, leaf + half, level));
                let (near, far) = if offset < 0.0 { (below, above) } else { (above, below) };
                if offset * offset <= radius_squared {
                    stack[top] = far;
                    top += 1;
                }
                (node, leaf, level) = near;
            }
            let [lo, hi] = self.bounds[leaf as usize];
            if (center - center.clamp(lo, hi)).length_squared() < radius_squared {
                let first = leaf as usize * self.quads_per_leaf;
                leaf_quads(first..first + self.quads_per_leaf);
            }
            if top == 0 {
                return;
            }
            top -= 1;
            (node, leaf, level) = stack[top];
        }
    }
}

/// Halve at the median of the longest axis, down to the leaves.
fn split(entries: &mut [Entry], nodes: &mut [Node], bounds: &mut [[Vec3; 2]], slots: &mut [u32]) {
    let (mut lo, mut hi) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &(p, _) in entries.iter() {
        lo = lo.min(p);
        hi = hi.max(p);
    }
    let Some((node, rest)) = nodes.split_first_mut() else {
        // the order in a leaf is the order of the points: sums do not depend on how the median was found
        entries.sort_unstable_by_key(|e| e.1);
        for (slot, &(_, index)) in slots.iter_mut().zip(entries.iter()) {
            *slot = index;
        }
        bounds[0] = if entries.is_empty() { [Vec3::splat(f32::MAX); 2] } else { [lo, hi] };
        return;
    };
    let extent = hi - lo;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let middle = entries.len() / 2;
    let value = if entries.is_empty() {
        0.0
    } else {
        entries.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
        entries[middle].0[axis]
    };
    *node = Node { axis: axis as u32, value };
    let parallel = entries.len() > PARALLEL_ABOVE;
    let (below, above) = entries.split_at_mut(middle);
    let (nodes_below, nodes_above) = rest.split_at_mut(rest.len() / 2);
    let (bounds_below, bounds_above) = bounds.split_at_mut(bounds.len() / 2);
    let (slots_below, slots_above) = slots.split_at_mut(slots.len() / 2);
    let mut left = || split(below, nodes_below, bounds_below, slots_below);
    let mut right = || split(above, nodes_above, bounds_above, slots_above);
    if parallel {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::random4;

    /// Every point within the radius is visited exactly once, at sizes around the leaf's.
    #[test]
    fn ball_finds_what_a_scan_finds() {
        for n in [0u32, 1, 2, 3, 15, 16, 17, 31, 32, 33, 255, 256, 257, 5000, 20_000] {
            let points: Vec<Vec3> = (0..n)
                .map(|i| {
                    let [x, y, z, w] = random4(1, 2, i, n);
                    // many equal coordinates, as on walls
                    if w < 0.5 { Vec3::new(x, y, 0.25) } else { Vec3::new(x, 0.5, z) }
                })
                .collect();
            let (tree, slots) = KdTree::build(points.iter().copied());
            for q in 0..50 {
                let [x, y, z, r] = random4(3, 4, q, n);
                let (center, radius_squared) = (Vec3::new(x, y, z), 0.1 * r);
                let mut found: Vec<u32> = Vec::new();
                tree.visit(center, radius_squared, |quads| {
                    for slot in &slots[quads.start * LANES..quads.end * LANES] {
                        if *slot != EMPTY
                            && (points[*slot as usize] - center).length_squared() < radius_squared
                        {
                            found.push(*slot);
                        }
                    }
                });
                found.sort_unstable();
                let scan: Vec<u32> = (0..n)
                    .filter(|&i| (points[i as usize] - center).length_squared() < radius_squared)
                    .collect();
                assert_eq!(found, scan, "{n} points, query {q}");
            }
        }
    }
}
