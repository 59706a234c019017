//! Split: a hierarchy from the top down, for boxes that cannot be clustered from below.
//!
//! Clustering joins neighbours that choose each other. Of boxes that hold each other (a fan of slivers about one corner,
//! sheets in one place) each chooses the next smaller one: one pair is joined in a pass, and the passes are as many as the
//! boxes. Splitting takes n log n whatever they are.

use glam::Vec3;

/// Corners of a box.
pub(super) type Box3 = [Vec3; 2];

/// A node: leaves hold `count` boxes from `first` on, in the order that [`tree`] returns; inner nodes have a count of 0 and
/// their children at `first` and `first + 1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct SplitNode {
    pub(super) bounds: Box3,
    pub(super) first: u32,
    pub(super) count: u32,
}

/// Fewer boxes than this are clustered in no time, however badly they go together.
const FEW: usize = 2048;
/// Boxes looked at, over their number, in a clustering that goes well at most: each pass joins a quarter at least.
const LOOKS: usize = 16;
/// Bins of a split by surface area.
const BINS: usize = 16;
/// A side has this part of the boxes at least: deeper trees cost more than uneven ones save.
const LEAST_SIDE: usize = 8;
/// Bits of a Morton code along each axis.
const MORTON_BITS: u32 = 21;

const EMPTY: Box3 = [Vec3::INFINITY, Vec3::NEG_INFINITY];

fn union(a: Box3, b: Box3) -> Box3 {
    [a[0].min(b[0]), a[1].max(b[1])]
}

fn half_area([low, high]: Box3) -> f32 {
    let d = (high - low).max(Vec3::ZERO);
    d.x * d.y + d.y * d.z + d.z * d.x
}

fn middle([low, high]: Box3) -> Vec3 {
    0.5 * (low + high)
}

/// True where clustering neighbours in Morton order would look at more boxes than it may: found by doing so with the nearest
/// neighbours alone.
pub(super) fn stalls(boxes: &[Box3]) -> bool {
    if boxes.len() < FEW {
        return false;
    }
    let all = boxes.iter().map(|b| middle(*b)).fold(EMPTY, |all, p| union(all, [p; 2]));
    let scale = (1 << MORTON_BITS) as f32 / (all[1] - all[0]).max(Vec3::splat(f32::MIN_POSITIVE));
    let code = |b: &Box3| {
        let cell = ((middle(*b) - all[0]) * scale).as_uvec3().min(glam::UVec3::splat((1 << MORTON_BITS) - 1));
        spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
    };
    let mut sorted: Vec<(u64, Box3)> = boxes.iter().map(|b| (code(b), *b)).collect();
    sorted.sort_by_key(|b| b.0);
    let mut now: Vec<Box3> = sorted.into_iter().map(|b| b.1).collect();
    let mut looked = 0;
    while now.len() > FEW {
        looked += now.len();
        if looked > LOOKS * boxes.len() {
            return true;
        }
        // each prefers the one before it only where that is better
        let cost = |i: usize| half_area(union(now[i], now[i + 1]));
        let prefers_before = |i: usize| i + 1 == now.len() || i > 0 && cost(i - 1) < cost(i);
        let mut next = Vec::with_capacity(now.len());
        let mut i = 0;
        while i < now.len() {
            if !prefers_before(i) && prefers_before(i + 1) {
                next.push(union(now[i], now[i + 1]));
                i += 2;
            } else {
                next.push(now[i]);
                i += 1;
            }
        }
        now = next;
    }
    false
}

/// Two zeros after each of the lowest 21 bits.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

/// A hierarchy over at least one box, and the order of the boxes in its leaves, of which each holds one.
pub(super) fn tree(boxes: &[Box3]) -> (Vec<SplitNode>, Vec<u32>) {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let leaf =
        |first: usize, count: usize| SplitNode { bounds: EMPTY, first: first as u32, count: count as u32 };
    let mut nodes = vec![leaf(0, boxes.len())];
    let mut next = 0;
    while let Some(&SplitNode { first, count, .. }) = nodes.get(next) {
        let held = &mut order[first as usize..][..count as usize];
        nodes[next].bounds = held.iter().map(|&i| boxes[i as usize]).fold(EMPTY, union);
        if count > 1 {
            let left = split(boxes, held);
            let children = nodes.len() as u32;
            nodes.push(leaf(first as usize, left));
            nodes.push(leaf(first as usize + left, count as usize - left));
            (nodes[next].first, nodes[next].count) = (children, 0);
        }
        next += 1;
    }
    (nodes, order)
}

/// Sorts boxes into two sides; how many are on the first, neither all nor none.
fn split(boxes: &[Box3], held: &mut [u32]) -> usize {
    let at = |i: u32| middle(boxes[i as usize]);
    let [low, high] = held.iter().fold(EMPTY, |all, &i| union(all, [at(i); 2]));
    let size = high - low;
    let axis = size.max_position();
    let half = held.len() / 2;
    let bin = |i: u32| (((at(i)[axis] - low[axis]) / size[axis] * BINS as f32) as usize).min(BINS - 1);
    if size[axis] > 0.0 && held.len() > BINS {
        let mut bins = [(EMPTY, 0usize); BINS];
        for &i in held.iter() {
            let (bounds, count) = &mut bins[bin(i)];
            (*bounds, *count) = (union(*bounds, boxes[i as usize]), *count + 1);
        }
        let side = |from: usize, to: usize| {
            bins[from..to].iter().fold((EMPTY, 0), |(all, n), &(b, count)| (union(all, b), n + count))
        };
        let cost = |k: &usize| {
            let [(a, n), (b, m)] = [side(0, *k), side(*k, BINS)];
            half_area(a) * n as f32 + half_area(b) * m as f32
        };
        let is_even = |k: &usize| side(0, *k).1.min(side(*k, BINS).1) * LEAST_SIDE >= held.len();
        let best = (1..BINS).filter(is_even).min_by(|a, b| cost(a).total_cmp(&cost(b)));
        if let Some(k) = best {
            held.sort_by_key(|&i| bin(i) >= k);
            return side(0, k).1;
        }
    }
    held.select_nth_unstable_by(half, |&a, &b| at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(&b)));
    half
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes in each other and sheets in one place stall; a plane of squares does not.
    #[test]
    fn boxes_that_hold_each_other_stall() {
        let n = 4 * FEW;
        let nested: Vec<Box3> = (0..n).map(|i| [Vec3::splat(-(i as f32)), Vec3::splat(i as f32)]).collect();
        assert!(stalls(&nested));
        assert!(stalls(&vec![[Vec3::ZERO, Vec3::ONE]; n]));
        let square = |i: usize| {
            let p = Vec3::new((i % 128) as f32, (i / 128) as f32, 0.0);
            [p, p + 1.0]
        };
        assert!(!stalls(&(0..n).map(square).collect::<Vec<_>>()));
    }

    /// Every box is in one leaf, every node holds its children, and the tree is shallow.
    #[test]
    fn trees_hold_their_boxes() {
        let n = 5000;
        for boxes in [
            vec![[Vec3::ZERO, Vec3::ONE]; n],
            (0..n).map(|i| [Vec3::splat(-(i as f32)), Vec3::splat(i as f32)]).collect(),
            (0..n).map(|i| [Vec3::splat((i * i) as f32); 2]).collect(),
        ] {
            let (nodes, order) = tree(&boxes);
            let mut seen = vec![0; n];
            let mut open = vec![(0usize, 0u32)];
            while let Some((k, depth)) = open.pop() {
                assert!(depth < 60);
                let node = nodes[k];
                if node.count > 0 {
                    assert_eq!((node.count, node.bounds), (1, boxes[order[node.first as usize] as usize]));
                    seen[order[node.first as usize] as usize] += 1;
                    continue;
                }
                let children = [node.first as usize, node.first as usize + 1];
                assert_eq!(node.bounds, children.map(|c| nodes[c].bounds).into_iter().fold(EMPTY, union));
                open.extend(children.map(|c| (c, depth + 1)));
            }
            assert!(seen.iter().all(|&times| times == 1));
        }
    }
}
