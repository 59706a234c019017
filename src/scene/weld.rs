//! Weld: the glass of a scene as surfaces that hang together, corners that lie in one place taken as one.

use super::{Material, Mesh};
use glam::DVec3;
use rustc_hash::{FxBuildHasher, FxHashMap};

/// Corners nearer than this share of the size of all glass are one: what exporters round differently at a seam.
const WELD_SHARE: f64 = 1e-7;
/// An edge of one triangle has none on its other side.
const NONE: u32 = u32::MAX;

/// A surface of glass: all that is joined over edges.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    /// Indices of its triangles.
    pub(crate) triangles: Vec<u32>,
    /// For each of them whether it is wound against the first.
    pub(crate) turned: Vec<bool>,
    /// Triangles that lie on another of the surface, corner on corner.
    pub(crate) copies: Vec<u32>,
    /// Edges with a triangle on one side only.
    pub(crate) open_edges: usize,
    /// Some edge has more than two: which way its triangles look is not told from each other.
    pub(crate) branches: bool,
    /// Area of the flat lids that would close its holes.
    pub(crate) holes: f64,
    /// Number of the group of surfaces whose open edges meet in corners; its surfaces are judged together.
    pub(crate) group: u32,
    /// Corners of the box around its open edges; turned inside out where there is none.
    pub(crate) rim: [DVec3; 2],
    /// Area.
    pub(crate) area: f64,
    /// Sum of the areas times their normals, as the triangles are wound.
    pub(crate) facing: DVec3,
    /// Enclosed volume with all triangles wound as the first; of a closed surface it is positive where the fronts are outside.
    pub(crate) volume: f64,
    /// The same with all triangles wound as they are.
    pub(crate) volume_outward: f64,
    /// Corners of its box.
    pub(crate) bounds: [DVec3; 2],
    /// All triangles lie in one plane.
    pub(crate) is_flat: bool,
}

/// The surfaces of glass, in the order of their first triangles.
pub(crate) fn surfaces(mesh: &Mesh, materials: &[Material]) -> Vec<Surface> {
    let is_glass = |i: &u32| materials[mesh.triangles[*i as usize].material as usize].dielectric.is_some();
    let glass: Vec<u32> = (0..mesh.triangles.len() as u32).filter(is_glass).collect();
    let corners = welded(mesh, &glass);
    let mut seen: FxHashMap<[u32; 3], u32> = FxHashMap::with_capacity_and_hasher(glass.len(), FxBuildHasher);
    // of triangles with the same corners the first counts
    let first: Vec<u32> = (0..glass.len() as u32)
        .map(|k| {
            let mut key = corners[k as usize];
            key.sort_unstable();
            *seen.entry(key).or_insert(k)
        })
        .collect();
    let edges = Edges::new(&corners, &first);
    let mut found: Vec<Surface> = Vec::new();
    let mut surface_of = vec![NONE; glass.len()];
    for start in 0..glass.len() {
        if first[start] as usize == start && surface_of[start] == NONE {
            found.push(follow(mesh, &glass, &edges, start, found.len() as u32, &mut surface_of));
        }
    }
    // where a sliver without area was dropped, or an edge is cut on one side only, a body falls into pieces
    let mut parent: Vec<u32> = (0..found.len() as u32).collect();
    let mut met: FxHashMap<u32, u32> = FxHashMap::default();
    for (edge, ([k, _], _)) in edges.at.iter().filter(|(_, (_, count))| *count == 1) {
        for corner in edge {
            let surface = surface_of[*k as usize];
            let other = *met.entry(*corner).or_insert(surface);
            let (a, b) = (root(&mut parent, surface), root(&mut parent, other));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    for (i, surface) in found.iter_mut().enumerate() {
        surface.group = root(&mut parent, i as u32);
    }
    for (k, &i) in glass.iter().enumerate().filter(|(k, _)| first[*k] as usize != *k) {
        found[surface_of[first[k] as usize] as usize].copies.push(i);
    }
    found
}

/// For each triangle its corners, numbered by place.
fn welded(mesh: &Mesh, glass: &[u32]) -> Vec<[u32; 3]> {
    let at = |v: u32| mesh.positions[v as usize];
    let used = || glass.iter().flat_map(|&i| mesh.triangles[i as usize].vertex);
    let (low, high) =
        used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), v| (l.min(at(v)), h.max(at(v))));
    let near = (WELD_SHARE * (high - low).length()).max(f64::MIN_POSITIVE);
    let mut number: FxHashMap<u32, u32> = FxHashMap::default();
    // places by the cell that they lie in; a place near a cell's border is looked for beyond it, too
    let mut places: FxHashMap<[i64; 3], u32> = FxHashMap::default();
    let mut count = 0;
    for v in used() {
        if number.contains_key(&v) {
            continue;
        }
        let cell = |p: DVec3| ((p - low) / (4.0 * near)).floor().to_array().map(|x| x as i64);
        let near_by = |corner: u32| {
            let side = |bit: u32| if corner >> bit & 1 == 0 { -near } else { near };
            cell(at(v) + DVec3::new(side(0), side(1), side(2)))
        };
        // most cells are met by one place and all that is near it
        let around = if near_by(0) == near_by(7) { 0..1 } else { 0..8 };
        let known = around.map(near_by).find_map(|c| places.get(&c).copied());
        let place = known.unwrap_or(count);
        if known.is_none() {
            count += 1;
            places.insert(cell(at(v)), place);
        }
        number.insert(v, place);
    }
    glass.iter().map(|&i| mesh.triangles[i as usize].vertex.map(|v| number[&v])).collect()
}

/// Who meets whom over which edge.
struct Edges<'a> {
    corners: &'a [[u32; 3]],
    /// For each edge, its ends in order: up to two triangles, and how many there are.
    at: FxHashMap<[u32; 2], ([u32; 2], u32)>,
}

impl<'a> Edges<'a> {
    fn new(corners: &'a [[u32; 3]], first: &[u32]) -> Self {
        let mut at: FxHashMap<[u32; 2], ([u32; 2], u32)> =
            FxHashMap::with_capacity_and_hasher(2 * corners.len(), FxBuildHasher);
        for (k, triangle) in corners.iter().enumerate().filter(|(k, _)| first[*k] as usize == *k) {
            for (a, b) in ends(triangle) {
                let (held, count) = at.entry([a.min(b), a.max(b)]).or_insert(([NONE; 2], 0));
                if let Some(free) = held.get_mut(*count as usize) {
                    *free = k as u32;
                }
                *count += 1;
            }
        }
        Self { corners, at }
    }
}

/// The edges of a triangle as it is wound; corners that are welded into one have none between them.
fn ends(&[a, b, c]: &[u32; 3]) -> impl Iterator<Item = (u32, u32)> {
    [(a, b), (b, c), (c, a)].into_iter().filter(|(p, q)| p != q)
}

/// Collects the surface that a triangle belongs to.
fn follow(
    mesh: &Mesh,
    glass: &[u32],
    edges: &Edges<'_>,
    start: usize,
    number: u32,
    surface_of: &mut [u32],
) -> Surface {
    let corners_of = |k: usize| {
        let triangle = &mesh.triangles[glass[k] as usize];
        triangle.vertex.map(|v| mesh.positions[v as usize])
    };
    let origin = corners_of(start)[0];
    let mut members: Vec<(usize, bool)> = vec![(start, false)];
    surface_of[start] = number;
    let mut rims: Vec<(u32, u32, [DVec3; 2])> = Vec::new();
    let (mut next, mut branches) = (0, false);
    while let Some(&(k, turned)) = members.get(next) {
        next += 1;
        for (a, b) in ends(&edges.corners[k]) {
            let (held, count) = &edges.at[&[a.min(b), a.max(b)]];
            branches |= *count > 2;
            if *count == 1 {
                let place = |corner: u32| {
                    let i = edges.corners[k].iter().position(|&c| c == corner).unwrap_or(0);
                    corners_of(k)[i]
                };
                rims.push(if turned { (b, a, [place(b), place(a)]) } else { (a, b, [place(a), place(b)]) });
            }
            // where more than two meet, none continues another for sure, but they hang together
            let beyond = held.iter().filter(|&&other| other != NONE && other as usize != k);
            for &other in beyond {
                if surface_of[other as usize] == NONE {
                    surface_of[other as usize] = number;
                    let runs_alike = ends(&edges.corners[other as usize]).any(|e| e == (a, b));
                    members.push((other as usize, turned ^ runs_alike));
                }
            }
        }
    }
    let mut surface = Surface {
        triangles: members.iter().map(|m| glass[m.0]).collect(),
        turned: members.iter().map(|m| m.1).collect(),
        copies: Vec::new(),
        open_edges: rims.len(),
        branches,
        holes: lids(&rims),
        group: number,
        rim: [DVec3::INFINITY, DVec3::NEG_INFINITY],
        area: 0.0,
        facing: DVec3::ZERO,
        volume: 0.0,
        volume_outward: 0.0,
        bounds: [DVec3::INFINITY, DVec3::NEG_INFINITY],
        is_flat: true,
    };
    for p in rims.iter().flat_map(|r| r.2) {
        surface.rim = [surface.rim[0].min(p), surface.rim[1].max(p)];
    }
    let mut plane: Option<DVec3> = None;
    for &(k, turned) in &members {
        let [a, b, c] = corners_of(k);
        let across = (b - a).cross(c - a) / 2.0;
        surface.area += across.length();
        surface.facing += across;
        let part = (a - origin).dot((b - origin).cross(c - origin)) / 6.0;
        surface.volume_outward += part;
        surface.volume += if turned { -part } else { part };
        surface.bounds = [surface.bounds[0].min(a.min(b).min(c)), surface.bounds[1].max(a.max(b).max(c))];
        let normal = across.normalize_or_zero();
        let plane = *plane.get_or_insert(normal);
        surface.is_flat &= normal.cross(plane).length() < FLAT;
    }
    surface
}

/// Sine of the angle between triangles that lie in one plane.
const FLAT: f64 = 1e-6;

/// Area of the lids over closed rims: half the length of Σ p × q along each, rims that meet taken as one.
fn lids(rims: &[(u32, u32, [DVec3; 2])]) -> f64 {
    let mut group_of: FxHashMap<u32, u32> = FxHashMap::default();
    let mut parent: Vec<u32> = Vec::new();
    for &(a, b, _) in rims {
        let [p, q] = [a, b].map(|v| {
            *group_of.entry(v).or_insert_with(|| {
                parent.push(parent.len() as u32);
                parent.len() as u32 - 1
            })
        });
        let (p, q) = (root(&mut parent, p), root(&mut parent, q));
        parent[p.max(q) as usize] = p.min(q);
    }
    let mut sums: FxHashMap<u32, (DVec3, DVec3)> = FxHashMap::default();
    for &(a, _, [p, q]) in rims {
        let (origin, sum) = sums.entry(root(&mut parent, group_of[&a])).or_insert((p, DVec3::ZERO));
        *sum += (p - *origin).cross(q - *origin) / 2.0;
    }
    sums.values().map(|(_, sum)| sum.length()).sum()
}

/// The least of a set of joined numbers.
fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}
