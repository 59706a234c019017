//! Dielectrics and shading normals at their limits: indices of 1, 1.0001 and 4, bodies in bodies, normals that are wrong,
//! coarse meshes that pretend to be round.

use crate::build::{Build, Look, clear, glowing, matte, mirror, v};
use crate::harness::{Renderer, everyone, mappers};
use crate::sheet::{Sheet, Stress, sized};
use crate::shoot::{alike, few_jotons, images, seed, shots, shots_of};
use glam::DVec3;
use joton::film::Layer;
use joton::film::stats::Estimate;
use joton::plan::Plan;
use joton::scene::{Light, Material, Scene};

/// The stresses of this file.
pub const STRESSES: &[Stress] = &[
    Stress { name: "index 1 is not there", run: index_one },
    Stress { name: "indices 1.0001 and 4, nested and crossing bodies", run: furnaces },
    Stress { name: "normals: absent, NaN, turned over, across", run: wrong_normals },
    Stress { name: "shading normals and their adjoint", run: adjoint },
    Stress { name: "each part of the adjoint", run: adjoint_parts },
    Stress { name: "caustic of a coarse smooth sphere", run: coarse_caustic },
];

/// Pixels across and down.
const SIZE: u32 = 16;
/// Pixels of a block.
const BLOCK: u32 = 4;

/// A ball of index one in a room with a lamp: the same image as without the ball.
fn index_one(sheet: &mut Sheet) {
    let room = |ball: bool| {
        let mut b = Build::new(v(0., -0.9, 0.), v(0., 0., -0.1), 0.8, SIZE);
        b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &matte([0.7, 0.5, 0.3]));
        b.ceiling(v(0., 0.2, 0.98), 0.4, &glowing([4.0; 3], [0.5; 3]));
        if ball {
            b.sphere(v(0., 0.2, -0.2), 0.5, 3, Look::OutwardSmooth, &clear(1.0));
        }
        b.0
    };
    for who in everyone() {
        let [with, without] = [(true, 1), (false, 2)]
            .map(|(ball, s)| images(&shots(who, &room(ball), seed(s), sized(4, 32)), &Layer::ALL, 1.0));
        alike(sheet, "a ball of index 1 in a room", format!("{who:?}"), &with, &without, BLOCK);
    }
}

/// Clear bodies in a furnace cannot be seen, whatever their indices and however they lie in each other: what a surface
/// reflects and transmits sums to one, and every ray that enters leaves.
fn furnaces(sheet: &mut Sheet) {
    type Ball = (DVec3, f64, f32);
    let middle = v(0., 0., 0.);
    let bodies: [(&str, &[Ball]); 4] = [
        ("index 1.0001", &[(middle, 0.45, 1.0001)]),
        ("index 4", &[(middle, 0.45, 4.0)]),
        ("index 1.33 in 1.5 in 2", &[(middle, 0.5, 2.0), (middle, 0.35, 1.5), (middle, 0.2, 1.33)]),
        ("1.5 and 2 that cross", &[(v(-0.2, 0., 0.), 0.35, 1.5), (v(0.2, 0.1, 0.), 0.35, 2.0)]),
    ];
    for (name, balls) in bodies {
        let mut b = Build::new(v(0., 0.9, 0.), v(0., 0., 0.), 0.6, SIZE);
        b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &glowing([0.5, 0.7, 0.8], [0.5, 0.3, 0.2]));
        for &(center, radius, ior) in balls {
            b.sphere(center, radius, 3, Look::OutwardSmooth, &clear(ior));
        }
        for who in mappers() {
            let pictures = shots(who, &b.0, seed(1), sized(3, 32));
            let whole = Estimate::from_renders(&images(&pictures, &Layer::ALL, 1.0), SIZE)
                .unwrap_or_else(|e| panic!("{e}"));
            let worst = whole.mean[0].iter().map(|m| (m - 1.0).abs()).fold(0.0, f64::max);
            let noise = whole.variance[0].iter().map(|v| v.sqrt()).fold(0.0, f64::max);
            // light that facets trap is cut by the roulette into few and heavy paths: noise
            let limit = 0.02;
            sheet.row(
                format!("{name} in a furnace"),
                format!("{who:?}"),
                format!("{:.2} % ± {:.2} %", 100.0 * worst, 100.0 * noise),
                format!("{} %", 100.0 * limit),
                worst <= limit && noise <= limit,
            );
        }
    }
}

/// A floor and a ball from a file whose normals are faulty: the image is finite, and that of the flat mesh where the
/// loader says that a fault makes a face flat.
fn wrong_normals(sheet: &mut Sheet) {
    let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("{e}"));
    // an octahedron about (0, 0, 1), outward, over a floor
    let mesh = |normals: &str, face: &dyn Fn(usize, [usize; 3]) -> String| {
        let mut text = String::from("mtllib m.mtl\nv 1 0 1\nv -1 0 1\nv 0 1 1\nv 0 -1 1\nv 0 0 2\nv 0 0 0\n");
        text.push_str("v -3 -3 -0.2\nv 3 -3 -0.2\nv 3 3 -0.2\nv -3 3 -0.2\n");
        text.push_str(normals);
        text.push_str("usemtl m\nf 7 8 9 10\n");
        let faces = [[1, 3, 5], [3, 2, 5], [2, 4, 5], [4, 1, 5], [3, 1, 6], [2, 3, 6], [4, 2, 6], [1, 4, 6]];
        faces.iter().enumerate().for_each(|(i, f)| text.push_str(&face(i, *f)));
        text
    };
    let flat = |_: usize, [a, b, c]: [usize; 3]| format!("f {a} {b} {c}\n");
    let all_one = |_: usize, [a, b, c]: [usize; 3]| format!("f {a}//1 {b}//1 {c}//1\n");
    let scene = |name: &str, mesh: &str| -> Scene {
        let at = |file: &str| folder.path().join(file);
        let write = |path, text: &str| std::fs::write(path, text).unwrap_or_else(|e| panic!("{e}"));
        write(at("m.mtl"), "newmtl m\nKd 0.7 0.6 0.5\nillum 1\n");
        write(at(&format!("{name}.obj")), mesh);
        write(
            at(&format!("{name}.toml")),
            &format!(
                "[camera]\nposition = [1.5, -5, 3]\ntarget = [0, 0, 0.7]\nup = [0, 0, 1]\nfov_x = 45\n\
                 [film]\nwidth = {SIZE}\nheight = {SIZE}\n[[mesh]]\nfile = \"{name}.obj\"\n\
                 [[light]]\nkind = \"point\"\nposition = [2, -3, 5]\nintensity = 30\n"
            ),
        );
        joton::scene::load(&at(&format!("{name}.toml"))).unwrap_or_else(|e| panic!("{e}"))
    };
    let passes = sized(3, 32);
    for who in mappers() {
        let shoot = |name: &str, mesh: &str, s: u32| {
            images(&shots(who, &scene(name, mesh), seed(s), passes), &Layer::ALL, 1.0)
        };
        let right = shoot("flat", &mesh("", &flat), 0);
        for (i, (name, normal)) in
            (1..).zip([("NaN", "vn nan nan nan\n"), ("infinite", "vn inf 0 0\n"), ("zero", "vn 0 0 0\n")])
        {
            let seen = shoot(name, &mesh(normal, &all_one), i);
            alike(sheet, &format!("{name} normals are flat"), format!("{who:?}"), &seen, &right, BLOCK);
        }
        // a normal that is right for one face, across or behind for the others; and one too short for f32
        for (name, normal) in
            [("across", "vn 1 1 1\n"), ("tiny", "vn 1e-42 0 1e-42\n"), ("huge", "vn 1e38 -1e38 1e38\n")]
        {
            let pictures = shots(who, &scene(name, &mesh(normal, &all_one)), seed(9), passes);
            let direct = images(&pictures, &[Layer::Direct], 1.0);
            let wrong =
                direct.iter().flat_map(|i| &i.pixels).flatten().filter(|x| !(0.0..=1e3).contains(*x)).count();
            let what = format!("{name} normals: finite, direct light not wild");
            sheet.none(what, format!("{who:?}"), "values", wrong as u64);
        }
    }
}

/// A parallelogram with shading normals at its corners.
fn tilted(b: &mut Build, corner: DVec3, [x, y]: [DVec3; 2], normals: [DVec3; 4], material: &Material) {
    let p = [corner, corner + x, corner + x + y, corner + y];
    b.smooth([p[0], p[1], p[2]], Some([normals[0], normals[1], normals[2]]), material);
    b.smooth([p[0], p[2], p[3]], Some([normals[0], normals[2], normals[3]]), material);
}

/// The same, its normals tilted one way here and another there.
fn both_ways(b: &mut Build, corner: DVec3, [x, y]: [DVec3; 2], by: DVec3, material: &Material) {
    let n = x.cross(y).normalize();
    tilted(b, corner, [x, y], [n + by, n - by * 0.5, n + by * 0.3, n + by.cross(n)], material);
}

/// A wall and a floor whose normals are tilted: jotons that bounce off them see what paths from the eye see.
fn adjoint(sheet: &mut Sheet) {
    let glossy = Material { glossy: [0.3; 3], glossy_exponent: 10.0, ..matte([0.4, 0.5, 0.3]) };
    // eye paths that a tilted mirror would send below its surface are turned back by its geometry, and no joton follows
    // them: less of a tilt
    for (name, surface, tilt) in
        [("matte", matte([0.8, 0.6, 0.4]), 1.0), ("glossy", glossy, 1.0), ("mirror", mirror([0.9; 3]), 0.1)]
    {
        let mut b = Build::new(v(0.1, -0.95, 0.3), v(0., 0.2, -0.5), 0.8, SIZE);
        // a room whose floor and back wall are tilted: no surface lies before another, which discs would see as one
        let wall = matte([0.6; 3]);
        let [x, y, z] = [v(2., 0., 0.), v(0., 2., 0.), v(0., 0., 2.)];
        b.quad(v(-1., -1., -1.), y, z, &wall);
        b.quad(v(1., -1., -1.), z, y, &wall);
        b.quad(v(-1., -1., -1.), z, x, &wall);
        b.quad(v(-1., -1., 1.), y, x, &wall);
        both_ways(&mut b, v(-1., -1., -1.), [x, y], v(0.25, 0.15, 0.) * tilt, &surface);
        both_ways(&mut b, v(-1., 1., -1.), [x, z], v(0.2, 0., 0.2) * tilt, &surface);
        // large: a path tracer finds it behind a mirror, too
        b.ceiling(v(0., 0., 0.97), 0.7, &glowing([2.0; 3], [0.5; 3]));
        let reference = shots(Renderer::PathTracer, &b.0, seed(9), sized(24, 256));
        for who in mappers() {
            // pixels are large here, and discs of the caustic map, which follow them, lose light at edges
            let narrow = |plan: &mut Plan| {
                few_jotons(plan);
                plan.caustic.base *= 0.1;
            };
            let seen = shots_of(who, &b.0, seed(1), sized(6, 64), &narrow);
            let [a, r] = [&seen, &reference].map(|p| images(p, &Layer::ALL, 1.0));
            alike(sheet, &format!("{name}, against the path tracer"), format!("{who:?}"), &a, &r, BLOCK);
        }
    }
}

/// A floor whose normals are all tilted toward a wall, in light from one side: each part of the factor [E11] is far from one
/// there, and nothing makes up for it. Jotons that meet the floor last, that it scatters, that it mirrors.
fn adjoint_parts(sheet: &mut Sheet) {
    /// Where the light goes and the eye looks.
    #[derive(PartialEq)]
    enum Way {
        /// A spot, the wall, the floor, the eye.
        Stored,
        /// A spot, the floor, the wall, the eye.
        Scattered,
        /// A lamp, the floor, the wall, the eye.
        Mirrored,
    }
    let glossy = Material { glossy: [0.3; 3], glossy_exponent: 10.0, ..matte([0.4, 0.5, 0.3]) };
    for (name, way, surface, layer) in [
        ("stored on a matte floor", Way::Stored, &matte([0.8, 0.6, 0.4]), Layer::Diffuse),
        ("stored on a glossy floor", Way::Stored, &glossy, Layer::Diffuse),
        ("scattered by a matte floor", Way::Scattered, &matte([0.8, 0.6, 0.4]), Layer::Diffuse),
        ("scattered by a glossy floor", Way::Scattered, &glossy, Layer::Diffuse),
        ("mirrored by a floor", Way::Mirrored, &mirror([0.9; 3]), Layer::Caustic),
    ] {
        let (eye, target, tan_half_fov) = match way {
            Way::Stored => (v(-0.2, 0., 2.5), v(0.1, 0., 0.), 0.2),
            _ => (v(-1.5, 0., 1.), v(1., 0., 0.8), 0.15),
        };
        let mut b = Build::new(eye, target, tan_half_fov, SIZE);
        let [x, y, z] = [v(2., 0., 0.), v(0., 2., 0.), v(0., 0., 2.)];
        let normals = [0.25, 0.3, 0.35, 0.3].map(|tilt| v(tilt, 0.1, 1.));
        tilted(&mut b, v(-1., -1., 0.), [x, y], normals, surface);
        b.quad(v(1., -1., 0.), z, y, &matte([0.6; 3]));
        let mut spot = |position: DVec3, at: DVec3| {
            b.light(Light::Spot {
                position,
                direction: (at - position).normalize(),
                intensity: [3.0; 3],
                angle_inner: f64::acos(0.98),
                angle_outer: f64::acos(0.94),
            });
        };
        match way {
            Way::Stored => spot(v(-0.5, 0., 1.3), v(1., 0., 1.1)),
            Way::Scattered => spot(v(-0.8, 0., 1.5), v(0., 0., 0.)),
            Way::Mirrored => b.ceiling(v(-0.4, 0., 1.7), 0.5, &glowing([2.0; 3], [0.0; 3])),
        }
        let reference = shots(Renderer::PathTracer, &b.0, seed(9), sized(24, 256));
        for who in mappers() {
            let seen = shots(who, &b.0, seed(1), sized(6, 64));
            let [a, r] = [&seen, &reference].map(|p| images(p, &[layer], 1.0));
            alike(sheet, &format!("{name}, against the path tracer"), format!("{who:?}"), &a, &r, BLOCK);
        }
    }
}

/// The caustic of a ball of few facets with smooth normals: as bright, block by block, as the path tracer's.
fn coarse_caustic(sheet: &mut Sheet) {
    for level in sized(&[1][..], &[1, 2, 3]) {
        let mut b = Build::new(v(0., -0.01, 3.2), v(0., 0., 0.), 0.28, SIZE);
        b.floor(v(0., 0., -0.7), 1.6, &matte([0.8; 3]));
        b.sphere(v(0.5, 0., 0.), 0.4, *level, Look::OutwardSmooth, &clear(1.5));
        // a lamp that is large from the ball: found by chance, yet its caustic has a shape
        b.quad(v(2.5, -1., -0.2), v(0., 2., 0.), v(0., 0., 2.), &glowing([2.0; 3], [0.0; 3]));
        let at = b.0.mesh.triangles.len() - 2;
        let [p, q, r] = b.0.mesh.triangles[at].vertex.map(|i| b.0.mesh.positions[i as usize]);
        if (q - p).cross(r - p).x > 0.0 {
            // it shines toward the ball
            b.0.mesh.triangles[at..].iter_mut().for_each(|t| t.vertex.swap(1, 2));
        }
        let reference = shots(Renderer::PathTracer, &b.0, seed(9), sized(48, 512));
        for who in mappers() {
            let seen = shots(who, &b.0, seed(1), sized(6, 64));
            let [a, r] = [&seen, &reference].map(|p| images(p, &[Layer::Caustic], 1.0));
            let facets = 20 << (2 * level);
            alike(
                sheet,
                &format!("{facets} facets, against the path tracer"),
                format!("{who:?}"),
                &a,
                &r,
                BLOCK,
            );
        }
    }
}
