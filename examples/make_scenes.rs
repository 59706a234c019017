//! Writes the scenes under `scenes/`: `cargo run --example make_scenes`.
//!
//! Everything is computed from published data or formulas, in metres, y up, fronts counter-clockwise, and always
//! gives the same bytes; a test compares the committed files with what this program makes.

use std::fmt::Write as _;
use std::path::Path;

type Point = [f64; 3];

/// Published Cornell box (Cornell University Program of Computer Graphics), millimetres to metres.
const CORNELL_HEIGHT: f64 = 0.5488;
const CORNELL_DEPTH: f64 = 0.5592;
const CORNELL_WIDTH: f64 = 0.556;
/// The published opening in the ceiling: x from, x to, z from, z to.
const CORNELL_LIGHT: [f64; 4] = [0.213, 0.343, 0.227, 0.332];
const CORNELL_CAMERA: &str =
    "[camera]\nposition = [0.278, 0.273, -0.8]\ntarget = [0.278, 0.273, 0.0]\nfov_x = 39.3077\n";
const CORNELL_COLOURS: &str = "newmtl white\nKd 0.73 0.73 0.73\nillum 1\n\nnewmtl green\nKd 0.12 0.45 0.15\nillum 1\n\n\
     newmtl red\nKd 0.65 0.05 0.05\nillum 1\n";

fn main() -> std::io::Result<()> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for (name, text) in files() {
        std::fs::write(directory.join(&name), &text)?;
        println!("{name}: {} bytes", text.len());
    }
    Ok(())
}

/// All files: name and text.
pub fn files() -> Vec<(String, String)> {
    [cornell(), spheres(), pool(), furnace(), ring(), rooms(), pedestal()].concat()
}

/// A mesh that grows face by face.
#[derive(Default)]
struct Obj {
    text: String,
    positions: usize,
    normals: usize,
}

impl Obj {
    fn new(name: &str) -> Self {
        Self { text: format!("# made by examples/make_scenes.rs\nmtllib {name}.mtl\n"), ..Self::default() }
    }

    fn material(&mut self, name: &str) {
        let _ = writeln!(self.text, "usemtl {name}");
    }

    /// A flat face.
    fn face(&mut self, corners: &[Point]) {
        for p in corners {
            let _ = writeln!(self.text, "v {}", triple(*p));
        }
        let indices: Vec<String> = (1..=corners.len()).map(|i| (self.positions + i).to_string()).collect();
        let _ = writeln!(self.text, "f {}", indices.join(" "));
        self.positions += corners.len();
    }

    /// Faces over shared vertices, each vertex with its normal.
    fn smooth(&mut self, vertices: &[(Point, Point)], faces: &[Vec<usize>]) {
        for (p, _) in vertices {
            let _ = writeln!(self.text, "v {}", triple(*p));
        }
        for (_, n) in vertices {
            let _ = writeln!(self.text, "vn {}", triple(*n));
        }
        for face in faces {
            let corner = |i: &usize| format!("{}//{}", self.positions + i + 1, self.normals + i + 1);
            let _ = writeln!(self.text, "f {}", face.iter().map(corner).collect::<Vec<_>>().join(" "));
        }
        self.positions += vertices.len();
        self.normals += vertices.len();
    }
}

/// At most 6 significant digits and 6 decimals, without trailing zeros.
fn number(x: f64) -> String {
    let whole_digits = if x.abs() < 1.0 { 0 } else { x.abs().log10() as usize + 1 };
    let text = format!("{x:.*}", 6_usize.saturating_sub(whole_digits));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn triple(p: Point) -> String {
    p.map(number).join(" ")
}

/// Scene file, mesh and materials of one name.
fn scene(name: &str, comment: &str, view: &str, obj: Obj, mtl: &str) -> Vec<(String, String)> {
    let toml = format!(
        "# {comment}\n{view}\n[film]\nwidth = 256\nheight = 256\n\n[[mesh]]\nfile = \"{name}.obj\"\n"
    );
    let mtl = format!("# made by examples/make_scenes.rs\n{mtl}");
    vec![(format!("{name}.toml"), toml), (format!("{name}.obj"), obj.text), (format!("{name}.mtl"), mtl)]
}

/// The walls of the Cornell box around a light in the ceiling at `[x from, x to, z from, z to]`.
fn cornell_room(obj: &mut Obj, [x0, x1, z0, z1]: [f64; 4]) {
    let (w, h, d) = (CORNELL_WIDTH, CORNELL_HEIGHT, CORNELL_DEPTH);
    obj.material("white");
    obj.face(&[[0.5528, 0., 0.], [0., 0., 0.], [0., 0., d], [0.5496, 0., d]]);
    obj.face(&[[0., h, 0.], [w, h, 0.], [x1, h, z0], [x0, h, z0]]);
    obj.face(&[[w, h, 0.], [w, h, d], [x1, h, z1], [x1, h, z0]]);
    obj.face(&[[w, h, d], [0., h, d], [x0, h, z1], [x1, h, z1]]);
    obj.face(&[[0., h, d], [0., h, 0.], [x0, h, z0], [x0, h, z1]]);
    obj.face(&[[0.5496, 0., d], [0., 0., d], [0., h, d], [w, h, d]]);
    obj.material("green");
    obj.face(&[[0., 0., d], [0., 0., 0.], [0., h, 0.], [0., h, d]]);
    obj.material("red");
    obj.face(&[[0.5528, 0., 0.], [0.5496, 0., d], [w, h, d], [w, h, 0.]]);
    obj.material("light");
    obj.face(&[[x0, h, z0], [x1, h, z0], [x1, h, z1], [x0, h, z1]]);
}

/// A block from its top, given counter-clockwise seen from above, down to the floor.
fn block(obj: &mut Obj, height: f64, top: [[f64; 2]; 4]) {
    obj.face(&top.map(|[x, z]| [x, height, z]));
    for i in 0..4 {
        let ([ax, az], [bx, bz]) = (top[i], top[(i + 1) % 4]);
        obj.face(&[[ax, height, az], [ax, 0., az], [bx, 0., bz], [bx, height, bz]]);
    }
}

fn light(radiance: [f64; 3]) -> String {
    format!("\nnewmtl light\nKd 0 0 0\nKe {}\nillum 1\n", triple(radiance))
}

fn cornell() -> Vec<(String, String)> {
    let mut obj = Obj::new("cornell");
    cornell_room(&mut obj, CORNELL_LIGHT);
    obj.material("white");
    block(&mut obj, 0.165, [[0.13, 0.065], [0.082, 0.225], [0.24, 0.272], [0.29, 0.114]]);
    block(&mut obj, 0.33, [[0.423, 0.247], [0.265, 0.296], [0.314, 0.456], [0.472, 0.406]]);
    let comment = "The published Cornell box: soft shadows, and red and green light on the white blocks.";
    scene("cornell", comment, CORNELL_CAMERA, obj, &(CORNELL_COLOURS.to_owned() + &light([17., 12., 4.])))
}

fn spheres() -> Vec<(String, String)> {
    let mut obj = Obj::new("spheres");
    // Half as wide and four times as bright as the box's own light: the same power, sharper caustics.
    cornell_room(&mut obj, [0.2455, 0.3105, 0.25325, 0.30575]);
    let radius = 0.09;
    let (glass, mirror) = ([0.165, 0.1, 0.2], [0.385, 0.0901, 0.37]);
    for (material, centre) in [("glass", glass), ("mirror", mirror)] {
        obj.material(material);
        let (vertices, faces) = icosphere(4, centre, radius);
        obj.smooth(&vertices, &faces);
    }
    let mtl = CORNELL_COLOURS.to_owned()
        + &light([68., 48., 16.])
        + "\nnewmtl glass\nKd 0 0 0\nKs 1 1 1\nTf 1 1 1\nNi 1.5\nillum 7\n\nnewmtl mirror\nKd 0 0 0\nKs 1 1 1\nillum 3\n";
    let comment =
        "A glass and a mirror sphere: a bright caustic under the glass, the whole box in the mirror.";
    scene("spheres", comment, CORNELL_CAMERA, obj, &mtl)
}

fn pool() -> Vec<(String, String)> {
    /// Light 3 cm wide in the middle of the ceiling.
    const LIGHT: [f64; 4] = [0.263, 0.293, 0.2646, 0.2946];
    /// Cells of the water surface along x and z.
    const CELLS: usize = 44;
    /// How far the water reaches into the walls, so that no light passes beside it.
    const OVERLAP: f64 = 0.01;
    let mut obj = Obj::new("pool");
    cornell_room(&mut obj, LIGHT);
    obj.material("white");
    let (h, w) = (CORNELL_HEIGHT, CORNELL_WIDTH);
    obj.face(&[[0., 0., 0.], [0.5528, 0., 0.], [w, h, 0.], [0., h, 0.]]);
    obj.material("white");
    let (vertices, faces) = icosphere(2, [0.38, 0.05, 0.36], 0.05);
    obj.smooth(&vertices, &faces);
    obj.material("water");
    let vertex = |i: usize| {
        let along =
            |index: usize, extent: f64| -OVERLAP + (extent + 2.0 * OVERLAP) * index as f64 / CELLS as f64;
        let (x, z) = (along(i % (CELLS + 1), w), along(i / (CELLS + 1), CORNELL_DEPTH));
        let (y, slope_x, slope_z) = wave(x, z);
        ([x, y, z], unit([-slope_x, 1.0, -slope_z]))
    };
    let vertices: Vec<_> = (0..(CELLS + 1) * (CELLS + 1)).map(vertex).collect();
    let cell = |i: usize| {
        let a = i % CELLS + i / CELLS * (CELLS + 1);
        let (b, c, d) = (a + 1, a + CELLS + 2, a + CELLS + 1);
        [vec![a, d, c], vec![a, c, b]]
    };
    obj.smooth(&vertices, &(0..CELLS * CELLS).flat_map(cell).collect::<Vec<_>>());
    let mtl = CORNELL_COLOURS.to_owned()
        + &light([272., 192., 64.])
        + "\nnewmtl water\nKd 0 0 0\nKs 1 1 1\nTf 1 1 1\nNi 1.33\nillum 7\n";
    let comment = "A pool in a closed room: a bright net of caustics on the floor and the ball, seen through the waves.";
    let view = "[camera]\nposition = [0.278, 0.5, 0.03]\ntarget = [0.278, 0.05, 0.36]\nfov_x = 60.0\n";
    scene("pool", comment, view, obj, &mtl)
}

/// Height of the water and its slopes along x and z: three crossing waves.
fn wave(x: f64, z: f64) -> (f64, f64, f64) {
    const LEVEL: f64 = 0.16;
    /// Amplitude (m), wave numbers along x and z (rad/m), phase.
    const WAVES: [[f64; 4]; 3] =
        [[0.0025, 55.0, 20.0, 0.3], [0.002, -25.0, 60.0, 1.1], [0.0012, 80.0, -70.0, 2.0]];
    WAVES.iter().fold((LEVEL, 0.0, 0.0), |(y, dx, dz), [amplitude, kx, kz, phase]| {
        let angle = kx * x + kz * z + phase;
        let slope = amplitude * angle.cos();
        (y + amplitude * angle.sin(), dx + slope * kx, dz + slope * kz)
    })
}

fn furnace() -> Vec<(String, String)> {
    let mut obj = Obj::new("furnace");
    obj.material("wall");
    // Unit cube, fronts inside.
    let corner = |i: usize| [(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64];
    for face in [[0, 1, 3, 2], [4, 6, 7, 5], [0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6]] {
        obj.face(&face.map(corner));
    }
    let comment =
        "A closed box that emits 0.5 and reflects half: radiance is 1 in every pixel, 0.5 / (1 - 0.5).";
    let view = "[camera]\nposition = [0.5, 0.5, 0.1]\ntarget = [0.6, 0.4, 1.0]\nfov_x = 80.0\n";
    scene("furnace", comment, view, obj, "newmtl wall\nKd 0.5 0.5 0.5\nKe 0.5 0.5 0.5\nillum 1\n")
}

fn ring() -> Vec<(String, String)> {
    const SEGMENTS: usize = 128;
    const INNER: f64 = 0.1;
    const OUTER: f64 = 0.103;
    const HEIGHT: f64 = 0.06;
    let mut obj = Obj::new("ring");
    obj.material("floor");
    obj.face(&[[-0.5, 0., -0.5], [-0.5, 0., 0.5], [0.5, 0., 0.5], [0.5, 0., -0.5]]);
    obj.material("mirror");
    let direction = |i: usize| {
        let angle = std::f64::consts::TAU * (i % SEGMENTS) as f64 / SEGMENTS as f64;
        [angle.cos(), angle.sin()]
    };
    let at = |radius: f64, y: f64, i: usize| direction(i).map(|c| c * radius).to_vec3(y);
    for (radius, side) in [(INNER, -1.0), (OUTER, 1.0)] {
        let vertices: Vec<_> = (0..2 * SEGMENTS)
            .map(|i| {
                let y = if i < SEGMENTS { 0.0 } else { HEIGHT };
                (at(radius, y, i), at(side, 0.0, i))
            })
            .collect();
        let wall = |i: usize| {
            let (a, b) = (i, (i + 1) % SEGMENTS);
            let outward = vec![a, a + SEGMENTS, b + SEGMENTS, b];
            if side > 0.0 { outward } else { outward.into_iter().rev().collect() }
        };
        obj.smooth(&vertices, &(0..SEGMENTS).map(wall).collect::<Vec<_>>());
    }
    let rim: Vec<_> = (0..2 * SEGMENTS)
        .map(|i| (at(if i < SEGMENTS { INNER } else { OUTER }, HEIGHT, i), [0.0, 1.0, 0.0]))
        .collect();
    let piece = |i: usize| {
        let (a, b) = (i, (i + 1) % SEGMENTS);
        vec![a, b, b + SEGMENTS, a + SEGMENTS]
    };
    obj.smooth(&rim, &(0..SEGMENTS).map(piece).collect::<Vec<_>>());
    // A square light that looks at the middle of the ring from the left and above.
    obj.material("light");
    let (centre, half) = ([-0.35, 0.28, 0.0], 0.01);
    let toward = unit([-centre[0], -centre[1], 0.0]);
    let across = [-toward[1], toward[0], 0.0];
    let corner = |s: f64, t: f64| -> Point {
        std::array::from_fn(|axis| centre[axis] + half * (s * across[axis] + t * [0.0, 0.0, 1.0][axis]))
    };
    obj.face(&[corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)]);
    let mtl = "newmtl floor\nKd 0.7 0.7 0.7\nillum 1\n\nnewmtl mirror\nKd 0 0 0\nKs 0.95 0.93 0.88\nillum 3\n"
        .to_owned() + &light([4000., 4000., 4000.]);
    let comment =
        "A mirror ring on a floor, light from the left: a bright nephroid, the coffee cup's caustic, inside.";
    let view = "[camera]\nposition = [0.0, 0.42, 0.3]\ntarget = [0.0, 0.0, 0.0]\nfov_x = 35.0\n";
    scene("ring", comment, view, obj, &mtl)
}

/// A box between two corners, fronts outward.
fn slab(obj: &mut Obj, low: Point, high: Point) {
    let corner =
        |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
    for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3]] {
        obj.face(&face.map(corner));
    }
}

fn rooms() -> Vec<(String, String)> {
    /// Rooms along x and z, and how wide and high each is.
    const ROOMS: [usize; 2] = [5, 2];
    const WIDTH: f64 = 4.0;
    const HEIGHT: f64 = 2.7;
    /// Half the thickness of a wall.
    const HALF: f64 = 0.05;
    /// Where a door begins and ends along its wall, and its height.
    const DOOR: [f64; 2] = [0.4, 1.3];
    const DOOR_HEIGHT: f64 = 2.0;
    /// Half the width of a lamp.
    const LAMP: f64 = 0.3;
    let mut obj = Obj::new("rooms");
    let [width, depth] = ROOMS.map(|n| n as f64 * WIDTH);
    obj.material("white");
    slab(&mut obj, [-HALF, -0.1, -HALF], [width + HALF, 0., depth + HALF]);
    slab(&mut obj, [-HALF, HEIGHT, -HALF], [width + HALF, HEIGHT + 0.1, depth + HALF]);
    // walls across x, then across z; those inside have a door into every room
    for i in 0..=ROOMS[0] {
        let x = i as f64 * WIDTH;
        obj.material(if i == 0 { "red" } else { "white" });
        if i == 0 || i == ROOMS[0] {
            slab(&mut obj, [x - HALF, 0., -HALF], [x + HALF, HEIGHT, depth + HALF]);
            continue;
        }
        let mut from = -HALF;
        for k in 0..ROOMS[1] {
            let [begin, end] = DOOR.map(|d| k as f64 * WIDTH + d);
            slab(&mut obj, [x - HALF, 0., from], [x + HALF, HEIGHT, begin]);
            slab(&mut obj, [x - HALF, DOOR_HEIGHT, begin], [x + HALF, HEIGHT, end]);
            from = end;
        }
        slab(&mut obj, [x - HALF, 0., from], [x + HALF, HEIGHT, depth + HALF]);
    }
    for k in 0..=ROOMS[1] {
        let z = k as f64 * WIDTH;
        for i in 0..ROOMS[0] {
            obj.material(if k == ROOMS[1] { "green" } else { "white" });
            let (from, to) = (i as f64 * WIDTH + HALF, (i + 1) as f64 * WIDTH - HALF);
            slab(&mut obj, [from, 0., z - HALF], [to, HEIGHT, z + HALF]);
        }
    }
    for (i, k) in (0..ROOMS[0]).flat_map(|i| (0..ROOMS[1]).map(move |k| (i, k))) {
        let [x, z] = [i, k].map(|n| (n as f64 + 0.5) * WIDTH);
        obj.material("white");
        slab(&mut obj, [x + 0.3, 0., z + 0.4], [x + 1.1, 0.75, z + 1.0]);
        obj.material("light");
        let y = HEIGHT - 0.01;
        let [x0, x1, z0, z1] = [x - LAMP, x + LAMP, z - LAMP, z + LAMP];
        obj.face(&[[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]]);
    }
    let comment = "Ten rooms in two rows, joined by doors, a lamp in each: the camera looks into one.";
    let view = "[camera]\nposition = [3.2, 1.6, 4.6]\ntarget = [1.4, 1.0, 7.6]\nfov_x = 70.0\n";
    scene("rooms", comment, view, obj, &(CORNELL_COLOURS.to_owned() + &light([10., 9., 8.])))
}

fn pedestal() -> Vec<(String, String)> {
    let mut obj = Obj::new("pedestal");
    obj.material("white");
    slab(&mut obj, [-0.15, -0.02, -0.15], [0.15, 0., 0.15]);
    obj.material("red");
    slab(&mut obj, [-0.1, 0., -0.06], [-0.02, 0.12, 0.04]);
    obj.material("green");
    let (vertices, faces) = icosphere(3, [0.06, 0.0501, 0.0], 0.05);
    obj.smooth(&vertices, &faces);
    obj.material("light");
    obj.face(&[[-0.4, 0.8, -0.1], [-0.2, 0.8, -0.1], [-0.2, 0.8, 0.1], [-0.4, 0.8, 0.1]]);
    let comment =
        "A block and a ball on a plate under a lamp, nothing around: four fifths of the image are black.";
    let view = "[camera]\nposition = [0.0, 0.35, -0.7]\ntarget = [0.0, 0.03, 0.0]\nfov_x = 42.0\n";
    scene("pedestal", comment, view, obj, &(CORNELL_COLOURS.to_owned() + &light([20., 19., 17.])))
}

/// A pair of coordinates in the floor plane, lifted.
trait Lift {
    fn to_vec3(self, y: f64) -> Point;
}

impl Lift for [f64; 2] {
    fn to_vec3(self, y: f64) -> Point {
        [self[0], y, self[1]]
    }
}

fn unit(v: Point) -> Point {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| c / length)
}

/// A sphere from an icosahedron whose triangles are split in four `levels` times; normals point outward.
fn icosphere(levels: u32, centre: Point, radius: f64) -> (Vec<(Point, Point)>, Vec<Vec<usize>>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points: Vec<Point> = Vec::new();
    for i in 0..3 {
        for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
            let mut p = [0.0; 3];
            (p[i], p[(i + 1) % 3]) = (a, b);
            points.push(unit(p));
        }
    }
    // The faces are the triples of mutual neighbours.
    let near = |a: Point, b: Point| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>() < 1.2;
    let mut faces: Vec<[usize; 3]> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let (p, q, r) = (points[a], points[b], points[c]);
                if near(p, q) && near(q, r) && near(r, p) {
                    let outward: f64 = (0..3)
                        .map(|i| p[i] * (q[(i + 1) % 3] * r[(i + 2) % 3] - q[(i + 2) % 3] * r[(i + 1) % 3]))
                        .sum();
                    faces.push(if outward > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middle_of = std::collections::BTreeMap::new();
        let mut split = Vec::with_capacity(faces.len() * 4);
        for [a, b, c] in faces {
            let mut middle = |i: usize, j: usize| {
                *middle_of.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push(unit(std::array::from_fn(|k| points[i][k] + points[j][k])));
                    points.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            split.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        faces = split;
    }
    let place = |n: Point| (std::array::from_fn(|i| centre[i] + radius * n[i]), n);
    (points.into_iter().map(place).collect(), faces.into_iter().map(|f| f.to_vec()).collect())
}
