//! Emission: where jotons start, which way and with how much flux, for each kind of light, by its own law [E2] and aimed
//! at the specular bodies [E13], on both sides.
//!
//! Jotons are taken at random from the whole of their Sobol sequences, so that they are independent.

use crate::chi_square::{Cap, Claims, in_square, p_value, seed};
use crate::common::scenes::{Builder, emitter, three_glass_spheres};
use crate::common::{Row, dvec3, row3};
use crate::device::Device;
use glam::{DVec3, Vec3};
use joton::backend::cpu::harness;
use joton::packed::{EmitterKind, Guide, PackedEmitter, PackedScene};
use joton::scene;
use std::f64::consts::{PI, TAU};

const COUNT: u32 = 1 << 18;
/// Jotons a pass, as far as their flux knows.
const EMITTED: u32 = 1000;

/// What leaves an emitter.
struct Start {
    origin: DVec3,
    direction: DVec3,
    /// First band.
    flux: f64,
}

/// Who emits.
const SIDES: [&str; 2] = ["host", "device"];

/// Name of a light, and what puts it there.
type Light = (&'static str, fn(&mut Builder));

/// The scenes by their light; the lamp faces all spheres from everywhere, so that no aimed joton is lost.
const LIGHTS: [Light; 4] = [
    ("triangle", |b| {
        let lamp = b.material(emitter(2.0, 0.0));
        b.triangle([[-0.5, 1.5, -0.5], [0.7, 1.5, -0.3], [-0.2, 1.5, 0.6]].map(DVec3::from), lamp);
    }),
    ("point", |b| b.point_light([0.4, 1.2, -0.3], 3.0)),
    ("spot", |b| {
        b.scene.lights.push(scene::Light::Spot {
            position: DVec3::new(1.0, 1.5, 0.5),
            direction: DVec3::new(-1.0, -1.7, -0.5).normalize(),
            intensity: [2.0; 3],
            angle_inner: f64::acos(0.97),
            angle_outer: f64::acos(0.9),
        });
    }),
    ("sun", |b| {
        let direction = DVec3::new(0.3, -1.0, 0.2).normalize();
        b.scene.lights.push(scene::Light::Sun { direction, irradiance: [2.0; 3] });
    }),
];

/// Numbers of jotons: any of 2³².
fn numbers() -> Vec<u32> {
    (0..COUNT).map(|i| joton::sampling::rng::pcg4d([i, 0xe317, 0, seed()])[0]).collect()
}

/// Jotons of one side; none where nothing is emitted.
fn emit(side: &str, scene: &PackedScene, caustic: bool) -> Option<Vec<Option<Start>>> {
    let numbers = numbers();
    let lit = |s: Start| (s.flux > 0.0).then_some(s);
    if side == "host" {
        let one = |i: u32| {
            let (origin, direction, flux) =
                harness::emit(scene, &Guide::default(), seed(), caustic, i, EMITTED)?;
            let [origin, direction] = [origin, direction].map(Vec3::as_dvec3);
            lit(Start { origin, direction, flux: f64::from(flux[0]) })
        };
        return Some(numbers.into_iter().map(one).collect());
    }
    let context = crate::common::device()?;
    let code = "prepare_emission(); let s = emit(in_u(0u).x);
        out_f(0u, vec4(s.origin, 0.0)); out_f(1u, vec4(s.direction, 0.0)); out_f(2u, vec4(s.flux, 0.0));";
    let inputs: Vec<[Row; 1]> = numbers.into_iter().map(|i| [[i, 0, 0, 0]]).collect();
    let out: Vec<[Row; 3]> = Device::new(context, scene, seed()).run(code, (caustic, EMITTED), &inputs);
    let start = |[o, d, f]: [Row; 3]| lit(Start { origin: dvec3(o), direction: dvec3(d), flux: dvec3(f).x });
    Some(out.into_iter().map(start).collect())
}

fn kind(e: &PackedEmitter) -> EmitterKind {
    [EmitterKind::Triangle, EmitterKind::Point, EmitterKind::Spot, EmitterKind::Sun][e.kind as usize]
}

/// Unit normal of a triangle, axis of the rest.
fn axis(e: &PackedEmitter) -> DVec3 {
    match kind(e) {
        EmitterKind::Triangle => e.e1.as_dvec3().cross(e.e2.as_dvec3()).normalize(),
        EmitterKind::Point => DVec3::Z,
        EmitterKind::Spot | EmitterKind::Sun => e.e1.as_dvec3().normalize(),
    }
}

fn falloff(e: &PackedEmitter, w: DVec3) -> f64 {
    let [inner, outer] = [e.e2.x, e.e2.y].map(f64::from);
    let x = ((outer - 0.5 * (w - axis(e)).length_squared()) / (outer - inner)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Place on a triangle by its two sides.
fn on_triangle(e: &PackedEmitter, p: DVec3) -> [f64; 2] {
    let [e1, e2] = [e.e1, e.e2].map(Vec3::as_dvec3);
    let d = p - e.origin.as_dvec3();
    let n = e1.cross(e2);
    [d.cross(e2).dot(n), e1.cross(d).dot(n)].map(|x| x / n.length_squared())
}

/// A square across a sun's beam.
struct Window {
    corner: DVec3,
    sides: [DVec3; 2],
    width: f64,
}

impl Window {
    /// Around these discs (centre, radius).
    fn around(e: &PackedEmitter, discs: &[(DVec3, f64)]) -> Self {
        let x = axis(e).any_orthonormal_vector();
        let sides = [x, axis(e).cross(x)];
        let least = |s: DVec3| discs.iter().map(|(c, r)| c.dot(s) - r).fold(f64::INFINITY, f64::min);
        let most = |s: DVec3| discs.iter().map(|(c, r)| c.dot(s) + r).fold(f64::NEG_INFINITY, f64::max);
        let width = sides.map(|s| most(s) - least(s)).into_iter().fold(0.0, f64::max);
        Self { corner: sides.map(|s| s * least(s)).into_iter().sum(), sides, width }
    }

    /// Place in the unit square.
    fn place(&self, p: DVec3) -> Option<[f64; 2]> {
        let place = self.sides.map(|s| (p - self.corner).dot(s) / self.width);
        place.iter().all(|x| (0.0..1.0).contains(x)).then_some(place)
    }

    /// A point behind a place in the unit square.
    fn point(&self, [x, y]: [f64; 2]) -> DVec3 {
        self.corner + self.sides[0] * (x * self.width) + self.sides[1] * (y * self.width)
    }
}

/// Cones of the targets as seen from `origin`: axis and 1 − cosine of the half angle.
fn cones(scene: &PackedScene, origin: DVec3) -> Vec<(DVec3, f64)> {
    let cone = |t: &joton::packed::Target| {
        let to = t.center.as_dvec3() - origin;
        let sine2 = f64::from(t.radius).powi(2) / to.length_squared();
        (to.normalize(), sine2 / (1.0 + (1.0 - sine2).sqrt()))
    };
    scene.targets.iter().map(cone).collect()
}

/// pdf_solid_angle of aimed emission, and how near (in 1 − cosine, relative) the nearest edge of a cone is.
fn aimed_pdf(cones: &[(DVec3, f64)], w: DVec3) -> (f64, f64) {
    let total: f64 = cones.iter().map(|c| TAU * c.1).sum();
    let tilt = |a: DVec3| 0.5 * (w - a).length_squared();
    let holding = cones.iter().filter(|c| tilt(c.0) <= c.1).count();
    let edge = cones.iter().map(|c| (tilt(c.0) / c.1 - 1.0).abs()).fold(f64::INFINITY, f64::min);
    (holding as f64 / total, edge)
}

/// pdf_area across the beam of aimed emission, and how near the nearest edge is.
fn aimed_pdf_area(scene: &PackedScene, e: &PackedEmitter, p: DVec3) -> (f64, f64) {
    let total: f64 = scene.targets.iter().map(|t| PI * f64::from(t.radius).powi(2)).sum();
    let away: Vec<f64> = scene
        .targets
        .iter()
        .map(|t| {
            let d = p - t.center.as_dvec3();
            (d - axis(e) * d.dot(axis(e))).length() / f64::from(t.radius)
        })
        .collect();
    let edge = away.iter().map(|a| (a - 1.0).abs()).fold(f64::INFINITY, f64::min);
    (away.iter().filter(|a| **a <= 1.0).count() as f64 / total, edge)
}

/// The flux that a start should have; none where rounding decides which cones hold it.
fn wanted_flux(scene: &PackedScene, e: &PackedEmitter, s: &Start, caustic: bool) -> Option<f64> {
    // places and directions are rounded at 1e-7 of the scene, cones at 1e-6 of their width
    const EDGE: f64 = 1e-3;
    let strength = f64::from(e.strength[0]) / f64::from(EMITTED);
    let flux = match (kind(e), caustic) {
        (EmitterKind::Sun, false) => strength * PI * f64::from(e.e2.x).powi(2),
        (EmitterKind::Sun, true) => {
            let (pdf, edge) = aimed_pdf_area(scene, e, s.origin);
            if edge < EDGE {
                return None;
            }
            strength / pdf
        }
        (kind, caustic) => {
            let n = axis(e);
            let (pdf, edge) = match (caustic, kind) {
                (true, _) => aimed_pdf(&cones(scene, s.origin), s.direction),
                (_, EmitterKind::Triangle) => (s.direction.dot(n) / PI, 1.0),
                (_, EmitterKind::Point) => (1.0 / (4.0 * PI), 1.0),
                _ => (1.0 / (TAU * f64::from(e.e2.y)), 1.0),
            };
            if edge < EDGE {
                return None;
            }
            let sent = match kind {
                EmitterKind::Triangle => f64::from(e.area) * s.direction.dot(n),
                EmitterKind::Point => 1.0,
                _ => falloff(e, s.direction),
            };
            strength * sent / pdf
        }
    };
    Some(flux)
}

/// Flux is strength over density, joton by joton; places and directions have those densities, together and apart.
#[test]
fn jotons_start_by_their_laws() {
    let mut claims = Claims::default();
    for (light, build) in LIGHTS {
        let scene = three_glass_spheres(build);
        let [e] = &scene.emitters[..] else { panic!("{light}: one emitter") };
        for side in SIDES {
            for caustic in [false, true] {
                let Some(starts) = emit(side, &scene, caustic) else { continue };
                let name = format!("{side}, {light}, {}", if caustic { "aimed" } else { "by law" });
                check_flux(&name, &scene, e, &starts, caustic);
                let places = || starts.iter().map(|s| s.as_ref().map(|s| s.origin));
                let directions = || starts.iter().map(|s| s.as_ref().map(|s| s.direction));
                match kind(e) {
                    EmitterKind::Triangle => {
                        let on = places().map(|p| p.map(|p| on_triangle(e, p)));
                        let density = |[b, c]: [f64; 2]| if b + c < 1.0 { 2.0 } else { 0.0 };
                        claims.add(format!("{name}: places"), in_square(on, density));
                    }
                    EmitterKind::Sun => {
                        let sun = (e.origin.as_dvec3(), f64::from(e.e2.x));
                        let targets =
                            scene.targets.iter().map(|t| (t.center.as_dvec3(), f64::from(t.radius)));
                        let discs = if caustic { targets.collect() } else { vec![sun] };
                        let window = Window::around(e, &discs);
                        let on = places().map(|p| window.place(p?));
                        let density = |p: [f64; 2]| {
                            // across the beam alone counts, and the axis passes through the sun's centre
                            let p = window.point(p);
                            let off = p - sun.0;
                            let pdf = if caustic {
                                aimed_pdf_area(&scene, e, p).0
                            } else if (off - axis(e) * off.dot(axis(e))).length() < sun.1 {
                                1.0 / (PI * sun.1 * sun.1)
                            } else {
                                0.0
                            };
                            pdf * window.width * window.width
                        };
                        claims.add(format!("{name}: places"), in_square(on, density));
                        assert!(directions().flatten().all(|d| (d - axis(e)).length() < 1e-6), "{name}");
                    }
                    EmitterKind::Point | EmitterKind::Spot => {
                        let off = |p: DVec3| (p - e.origin.as_dvec3()).length();
                        assert!(places().flatten().all(|p| off(p) < 1e-3), "{name}: jotons start elsewhere");
                    }
                }
                // where an aimed lamp's cones are depends on the place: tested from fixed places below
                if kind(e) == EmitterKind::Sun || caustic && kind(e) == EmitterKind::Triangle {
                    continue;
                }
                let extent = if kind(e) == EmitterKind::Spot { 0.2 } else { 2.0 };
                let cones = cones(&scene, e.origin.as_dvec3());
                let density = |w: DVec3| match (caustic, kind(e)) {
                    (true, EmitterKind::Spot) if falloff(e, w) <= 0.0 => 0.0,
                    (true, _) => aimed_pdf(&cones, w).0,
                    (false, EmitterKind::Triangle) => w.dot(axis(e)).max(0.0) / PI,
                    (false, EmitterKind::Spot) if falloff(e, w) <= 0.0 => 0.0,
                    (false, EmitterKind::Spot) => 1.0 / (TAU * f64::from(e.e2.y)),
                    (false, _) => 1.0 / (4.0 * PI),
                };
                let p = Cap::new(axis(e), extent).test(directions(), density);
                claims.add(format!("{name}: directions"), p);
                if kind(e) == EmitterKind::Triangle {
                    claims.add(format!("{name}: places with directions"), together(e, &starts));
                }
            }
        }
    }
    claims.hold();
}

fn check_flux(name: &str, scene: &PackedScene, e: &PackedEmitter, starts: &[Option<Start>], caustic: bool) {
    // cosines are rounded at 1e-7; over a spot's rim, 0.07 wide, the falloff is up to 21 times as steep
    let rounding = f64::from(e.strength[0]) / f64::from(EMITTED) * 1e-5;
    let mut tested = 0;
    for s in starts.iter().flatten() {
        let Some(wanted) = wanted_flux(scene, e, s, caustic) else { continue };
        tested += 1;
        let off = (s.flux - wanted).abs();
        assert!(off < 1e-4 * wanted + rounding, "{name}: flux {}, not {wanted}", s.flux);
    }
    assert!(tested > starts.len() / 4, "{name}: flux of {tested} jotons");
}

/// Places on a lamp and directions are independent: four bins across each of four uniform numbers.
fn together(e: &PackedEmitter, starts: &[Option<Start>]) -> f64 {
    const ACROSS: usize = 4;
    let mut counts = vec![0.0; ACROSS.pow(4)];
    let cap = Cap::new(axis(e), 1.0);
    for s in starts.iter().flatten() {
        let [b, c] = on_triangle(e, s.origin);
        let Some([t, v]) = cap.place(s.direction) else { continue };
        // sin²θ = 1 − (1 − t²)² is uniform for the cosine law, (b + c)² and c/(b + c) on a triangle
        let uniform = [(b + c).powi(2), c / (b + c), 1.0 - (1.0 - t * t).powi(2), v];
        let bin =
            uniform.iter().fold(0, |at, u| at * ACROSS + ((u * ACROSS as f64) as usize).min(ACROSS - 1));
        counts[bin] += 1.0;
    }
    let expected = starts.len() as f64 / counts.len() as f64;
    p_value(&counts, &vec![expected; counts.len()])
}

/// Directions into overlapping cones, from places near and far.
#[test]
fn aimed_directions_follow_the_mixture_of_cones() {
    let scene = three_glass_spheres(LIGHTS[1].1);
    let size = f64::from((scene.bounds[1] - scene.bounds[0]).length());
    let middle = scene.targets[0].center.as_dvec3();
    let mut claims = Claims::default();
    for (k, from) in [DVec3::new(0.1, 0.25, 0.05), DVec3::new(0.6, 0.3, -0.2), DVec3::new(-0.1, 0.2, 3.0)]
        .into_iter()
        .enumerate()
    {
        let origin = (middle + from * size).as_vec3();
        let cones = cones(&scene, origin.as_dvec3());
        let around = (scene.targets[0].center.as_dvec3() - origin.as_dvec3()).normalize();
        let widest = cones.iter().map(|(a, c)| 0.5 * (*a - around).length_squared() + 4.0 * c);
        let cap = Cap::new(around, widest.fold(0.0, f64::max).min(2.0));
        let density = |w: DVec3| aimed_pdf(&cones, w).0;
        let purpose = 20 + k as u32;
        let pdf_is_right = |w: DVec3, pdf: f64| {
            let (wanted, edge) = aimed_pdf(&cones, w);
            assert!(edge < 1e-3 || (pdf / wanted - 1.0).abs() < 1e-3, "pdf {pdf}, not {wanted}");
            w
        };
        let host = crate::chi_square::draws(purpose, COUNT).map(|u| {
            let (w, pdf) = harness::into_cones(&scene.targets, origin, [u[0], u[1]])?;
            Some(pdf_is_right(w.as_dvec3(), f64::from(pdf)))
        });
        claims.add(format!("host, place {k}"), cap.test(host, density));
        let Some(context) = crate::common::device() else { continue };
        let inputs: Vec<[Row; 1]> =
            crate::chi_square::draws(purpose, COUNT).map(|u| [row3([u[0], u[1], 0.0], 0.0)]).collect();
        let code = format!(
            "let a = aim_at_targets(Beam({}, vec3(0.0, 0.0, 1.0), 0.0), in_f(0u).xy); out_f(0u, vec4(a.direction, f32(a.hits) / a.total));",
            crate::directions::wgsl(origin)
        );
        let out: Vec<[Row; 1]> = Device::new(context, &scene, seed()).run(&code, (true, EMITTED), &inputs);
        let device = out.iter().map(|o| {
            let pdf = f64::from(crate::common::floats(o[0])[3]);
            Some(pdf_is_right(dvec3(o[0]), pdf))
        });
        claims.add(format!("device, place {k}"), cap.test(device, density));
    }
    claims.hold();
}
