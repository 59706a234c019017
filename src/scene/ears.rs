//! Ears: cuts a large concave polygon into triangles, in a time that grows little faster than the number of its corners.
//!
//! A corner is an ear where it is convex and its triangle holds no other corner; only reflex corners need be asked
//! (Eberly, Triangulation by Ear Clipping). They are found in a k-d tree over their places, of which the parts that do
//! not overlap the triangle are passed over: long thin ears, as a star has, meet few of them.

use glam::DVec2;

/// Looks at all that is left for ears at most so many times where none follows from the last; then corners are cut as they
/// come. Only polygons that cross themselves need that.
const ROUNDS: u32 = 8;

/// Triangles, as indices into `corners`, of a polygon that turns counter-clockwise.
pub(crate) fn cut(corners: &[DVec2]) -> Vec<[usize; 3]> {
    let count = corners.len();
    let mut ring = Ring::new(count);
    let turn = |ring: &Ring, i: usize| {
        let [a, b, c] = ring.corner(i).map(|k| corners[k]);
        (b - a).perp_dot(c - b)
    };
    let reflex: Vec<u32> = (0..count).filter(|&i| turn(&ring, i) <= 0.0).map(|i| i as u32).collect();
    let mut blockers = Tree::new(corners, reflex);
    let mut triangles = Vec::with_capacity(count.saturating_sub(2));
    // in turns: who loses a neighbour waits for the next, or one corner would get all triangles, long and thin
    let (mut now, mut next): (Vec<usize>, Vec<usize>) = ((0..count).collect(), Vec::new());
    let (mut turns, mut waits) = (1u32, vec![0; count]);
    let (mut left, mut rounds) = (count, 0);
    while left > 2 {
        if now.is_empty() && next.is_empty() {
            rounds += 1;
            now = ring.all();
            turns += 1;
        } else if now.is_empty() {
            std::mem::swap(&mut now, &mut next);
            turns += 1;
        }
        for i in now.drain(..) {
            if left <= 2 || ring.is_cut(i) || waits[i] == turns {
                continue;
            }
            let (bend, [a, b, c]) = (turn(&ring, i), ring.corner(i));
            let is_ear = bend > 0.0 && !blockers.any_in([a, b, c].map(|k| corners[k]));
            // a corner that does not bend has no triangle
            if !is_ear && bend != 0.0 && rounds < ROUNDS {
                continue;
            }
            if bend != 0.0 {
                triangles.push(if bend > 0.0 { [a, b, c] } else { [a, c, b] });
            }
            ring.cut(i);
            blockers.remove(i);
            left -= 1;
            for k in [a, c] {
                if turn(&ring, k) > 0.0 {
                    blockers.remove(k);
                }
                if waits[k] != turns {
                    waits[k] = turns;
                    next.push(k);
                }
            }
        }
    }
    triangles
}

/// What is left of the polygon: each corner with its neighbours.
struct Ring {
    before: Vec<u32>,
    after: Vec<u32>,
    last: usize,
}

/// Neighbour of a corner that is cut off.
const CUT: u32 = u32::MAX;

impl Ring {
    fn new(count: usize) -> Self {
        let at = |i: usize| (i % count) as u32;
        Self {
            before: (0..count).map(|i| at(i + count - 1)).collect(),
            after: (0..count).map(|i| at(i + 1)).collect(),
            last: 0,
        }
    }

    /// A corner between its neighbours.
    fn corner(&self, i: usize) -> [usize; 3] {
        [self.before[i] as usize, i, self.after[i] as usize]
    }

    fn is_cut(&self, i: usize) -> bool {
        self.after[i] == CUT
    }

    fn cut(&mut self, i: usize) {
        let [a, _, c] = self.corner(i);
        (self.after[a], self.before[c]) = (c as u32, a as u32);
        self.after[i] = CUT;
        self.last = c;
    }

    /// All corners that are left.
    fn all(&self) -> Vec<usize> {
        let mut all = vec![self.last];
        let mut next = self.after[self.last] as usize;
        while next != self.last {
            all.push(next);
            next = self.after[next] as usize;
        }
        all
    }
}

/// A balanced k-d tree over some corners, that forgets them one by one. Node `k` has the children `2k + 1` and `2k + 2`;
/// the leaves hold a run of `places` each.
struct Tree<'a> {
    corners: &'a [DVec2],
    /// Corners in the order of the leaves.
    places: Vec<u32>,
    /// Bounds, and how many are left.
    nodes: Vec<(DVec2, DVec2, u32)>,
    /// For each corner its place, or [`CUT`].
    place_of: Vec<u32>,
    levels: u32,
}

/// Corners in a leaf, about.
const LEAF: usize = 8;

impl<'a> Tree<'a> {
    fn new(corners: &'a [DVec2], places: Vec<u32>) -> Self {
        let levels = places.len().div_ceil(LEAF).next_power_of_two().ilog2();
        let nodes = vec![(DVec2::INFINITY, DVec2::NEG_INFINITY, 0); (2 << levels) - 1];
        let mut tree = Self { corners, places, nodes, place_of: vec![CUT; corners.len()], levels };
        tree.build(0, 0, tree.places.len(), 0);
        for (place, &i) in tree.places.iter().enumerate() {
            tree.place_of[i as usize] = place as u32;
        }
        tree
    }

    fn build(&mut self, node: usize, from: usize, to: usize, level: u32) {
        let corners = self.corners;
        let held = &mut self.places[from..to];
        let bounds = held
            .iter()
            .map(|&i| corners[i as usize])
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        self.nodes[node] = (bounds.0, bounds.1, held.len() as u32);
        if level == self.levels {
            return;
        }
        let size = bounds.1 - bounds.0;
        let axis = usize::from(size.y > size.x);
        let middle = held.len() / 2;
        if middle > 0 {
            held.select_nth_unstable_by(middle, |&a, &b| {
                corners[a as usize][axis].total_cmp(&corners[b as usize][axis])
            });
        }
        self.build(2 * node + 1, from, from + middle, level + 1);
        self.build(2 * node + 2, from + middle, to, level + 1);
    }

    /// Forgets a corner, if it is known.
    fn remove(&mut self, i: usize) {
        let place = self.place_of[i];
        if place == CUT {
            return;
        }
        self.place_of[i] = CUT;
        let (mut node, mut from, mut to) = (0, 0, self.places.len());
        for _ in 0..self.levels {
            self.nodes[node].2 -= 1;
            let middle = from + (to - from) / 2;
            if (place as usize) < middle {
                (node, to) = (2 * node + 1, middle);
            } else {
                (node, from) = (2 * node + 2, middle);
            }
        }
        self.nodes[node].2 -= 1;
    }

    /// True where a corner that is left lies in a triangle that turns counter-clockwise, or on its edges, its own places
    /// excepted.
    fn any_in(&self, triangle: [DVec2; 3]) -> bool {
        self.any_below(&triangle, 0, 0, self.places.len(), 0)
    }

    fn any_below(&self, triangle: &[DVec2; 3], node: usize, from: usize, to: usize, level: u32) -> bool {
        let (low, high, left) = self.nodes[node];
        if left == 0 || !overlaps(triangle, low, high) {
            return false;
        }
        if level == self.levels {
            return self.places[from..to].iter().any(|&i| {
                let p = self.corners[i as usize];
                self.place_of[i as usize] != CUT && holds(triangle, p) && !triangle.contains(&p)
            });
        }
        let middle = from + (to - from) / 2;
        self.any_below(triangle, 2 * node + 1, from, middle, level + 1)
            || self.any_below(triangle, 2 * node + 2, middle, to, level + 1)
    }
}

/// Edges of a triangle, each from its start.
fn edges([a, b, c]: &[DVec2; 3]) -> [(DVec2, DVec2); 3] {
    [(*a, b - a), (*b, c - b), (*c, a - c)]
}

fn holds(triangle: &[DVec2; 3], p: DVec2) -> bool {
    edges(triangle).iter().all(|(start, edge)| edge.perp_dot(p - start) >= 0.0)
}

/// False only where a triangle and a box have no point in common.
fn overlaps(triangle: &[DVec2; 3], low: DVec2, high: DVec2) -> bool {
    let [a, b, c] = *triangle;
    if a.min(b).min(c).cmpgt(high).any() || a.max(b).max(c).cmplt(low).any() {
        return false;
    }
    // the box's corner that lies farthest to the inner side of each edge
    edges(triangle).iter().all(|(start, edge)| {
        let inner =
            DVec2::new(if edge.y > 0.0 { low.x } else { high.x }, if edge.x > 0.0 { high.y } else { low.y });
        edge.perp_dot(inner - start) >= 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec2]) -> f64 {
        let parts = cut(corners);
        let part = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).perp_dot(corners[c] - corners[a]) / 2.0;
        parts.into_iter().map(part).inspect(|a| assert!(*a > 0.0, "turned over")).sum()
    }

    /// Corners of a closed curve about the origin.
    fn polar(count: usize, radius: impl Fn(usize) -> f64) -> Vec<DVec2> {
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / count as f64;
        (0..count).map(|i| DVec2::from_angle(angle(i)) * radius(i)).collect()
    }

    /// Stars, combs and spirals keep their area (the shoelace formula), as triangles that all turn alike: as many as
    /// cover it, so none overlaps another.
    #[test]
    fn areas_are_kept() {
        let star = |n: usize| polar(n, |i| if i % 2 == 0 { 1.0 } else { 0.1 });
        let saw = |n: usize| polar(n, |i| 1.0 + (i * 7919 % 31) as f64);
        let comb = |n: usize| {
            let teeth = (0..n).map(|i| DVec2::new(i as f64, if i % 2 == 0 { 0.0 } else { 9.0 }));
            [DVec2::new(n as f64, 10.0), DVec2::new(-1.0, 10.0)]
                .into_iter()
                .rev()
                .chain(teeth)
                .collect::<Vec<_>>()
        };
        let spiral = |n: usize| {
            let arm = |i: usize, wide: f64| {
                DVec2::from_angle(i as f64 * 30.0 / n as f64) * (1.0 + wide + 9.0 * i as f64 / n as f64)
            };
            (0..n).map(|i| arm(i, 0.5)).chain((0..n).rev().map(|i| arm(i, 0.0))).collect::<Vec<_>>()
        };
        for n in [6, 50, 1000] {
            for corners in [star(n), saw(n), comb(n), spiral(n)] {
                let next = corners.iter().cycle().skip(1);
                let shoelace: f64 = corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b) / 2.0).sum();
                assert!(shoelace > 0.0);
                assert!((area(&corners) / shoelace - 1.0).abs() < 1e-9, "{n}: {} {shoelace}", area(&corners));
            }
        }
    }

    /// No corner of a circle gets many triangles.
    #[test]
    fn circles_are_halved() {
        let mut uses = [0; 1000];
        cut(&polar(1000, |_| 1.0)).iter().flatten().for_each(|&i| uses[i] += 1);
        assert!(uses.iter().all(|&times| times < 25), "{:?}", uses.iter().max());
    }

    /// What crosses itself, or has no area, ends.
    #[test]
    fn crossed_polygons_end() {
        let pentagram = polar(5, |_| 1.0);
        let crossed: Vec<DVec2> = (0..500).map(|i| pentagram[i * 2 % 5] * (1.0 + i as f64 / 500.0)).collect();
        assert!(cut(&crossed).len() < 500);
        assert!(cut(&[DVec2::ONE; 40]).is_empty());
        assert!(cut(&[]).is_empty());
    }
}
