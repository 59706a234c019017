//! Directions and places: the samplers of both sides against their densities, written anew in f64.

use crate::chi_square::{Cap, Claims, draws, in_square};
use crate::common::scenes::Builder;
use crate::common::{Row, dvec3, floats, row};
use crate::device::Device;
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::backend::cpu::harness::mirror_lobe;
use joton::optics::shading::bsdf::Scatter;
use joton::packed::{PackedMaterial, PackedScene};
use joton::sampling::distributions::{cone, cosine_hemisphere, disc, phong_lobe, sphere, triangle};
use joton::scene::{FacetKind, Facets, Inner, Material};
use std::f64::consts::{PI, TAU};

/// Samples of each law: a deviation of one per cent, root mean square over the bins, is found on the host.
const HOST_COUNT: u32 = 1 << 20;
/// On the device, which runs in software where tests run: two per cent.
const DEVICE_COUNT: u32 = 1 << 18;

/// A law of directions: how each side samples it, and its density.
pub struct Law {
    name: String,
    cap: Cap,
    /// Per solid angle; what is missing to one is outside the cap or below the surface.
    density: Box<dyn Fn(DVec3) -> f64>,
    host: Box<dyn Fn([f32; 4]) -> Option<Vec3>>,
    /// A direction in WGSL, from `u`.
    device: String,
}

/// Where samples below a surface count as none.
fn above(w: DVec3, n: DVec3) -> Option<DVec3> {
    (w.dot(n) > 0.0).then_some(w)
}

/// (e + 1)/2π cosᵉα about an axis.
fn lobe(axis: DVec3, exponent: f64, w: DVec3) -> f64 {
    (exponent + 1.0) / TAU * axis.dot(w).max(0.0).powf(exponent)
}

/// 1 − cosθ within which a lobe of this exponent sends all but e⁻¹² of its light.
fn reach(exponent: f64) -> f64 {
    (12.0 / (exponent + 1.0)).min(2.0)
}

/// Laws about z.
fn plain_laws() -> Vec<Law> {
    let z = DVec3::Z;
    let mut laws = vec![
        Law {
            name: "cosine hemisphere".into(),
            cap: Cap::new(z, 2.0),
            density: Box::new(|w| w.z.max(0.0) / PI),
            host: Box::new(|u| Some(cosine_hemisphere([u[0], u[1]]))),
            device: "sample_cosine_hemisphere(u.xy)".into(),
        },
        Law {
            name: "sphere".into(),
            cap: Cap::new(z, 2.0),
            density: Box::new(|_| 1.0 / (4.0 * PI)),
            host: Box::new(|u| Some(sphere([u[0], u[1]]))),
            device: "sample_cone(u.xy, 2.0)".into(),
        },
    ];
    for size in [0.5, 1e-3f32] {
        let cos_max = 1.0 - f64::from(size);
        laws.push(Law {
            name: format!("cone of {size}"),
            cap: Cap::new(z, 1.5 * f64::from(size)),
            density: Box::new(move |w| if w.z > cos_max { 1.0 / (TAU * (1.0 - cos_max)) } else { 0.0 }),
            host: Box::new(move |u| Some(cone([u[0], u[1]], size))),
            device: format!("sample_cone(u.xy, {size:?})"),
        });
    }
    for exponent in [1.0, 20.0, 300.0, 1e6f32] {
        let e = f64::from(exponent);
        laws.push(Law {
            name: format!("Phong lobe of exponent {exponent}"),
            cap: Cap::new(z, reach(e)),
            density: Box::new(move |w| lobe(z, e, w)),
            host: Box::new(move |u| Some(phong_lobe([u[0], u[1]], exponent))),
            device: format!("sample_phong_lobe(u.xy, {exponent:?})"),
        });
    }
    laws
}

/// Materials of the D lobes: matte, glossy, and mixed in bands that peak apart.
pub fn materials() -> Vec<PackedMaterial> {
    let make = |diffuse, glossy, glossy_exponent| {
        PackedMaterial::new(&Material { glossy, glossy_exponent, ..Material::matte("d", diffuse) })
    };
    let (some, more) = ([0.1, 0.3, 0.5], [0.3, 0.2, 0.1]);
    vec![
        make(some, [0.0; 3], 0.0),
        make(some, more, 5.0),
        make([0.1; 3], [0.8, 0.2, 0.1], 60.0),
        make([0.0; 3], more, 20.0),
        make([0.0; 3], more, 299.0),
    ]
}

/// A surface that is not aligned with anything.
pub const NORMAL: Vec3 = Vec3::new(0.36, -0.48, 0.8);

/// Directions toward the eye: head on, slanting, grazing.
pub fn views() -> [Vec3; 3] {
    let across = NORMAL.any_orthonormal_vector();
    [0.0, 50.0, 87.0f32].map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        (NORMAL * cos + across * sin).normalize()
    })
}

/// Density of the D lobes' samples about [`NORMAL`], below the surface too.
pub fn density_d(m: &PackedMaterial, wo: Vec3, w: DVec3) -> f64 {
    let n = NORMAL.as_dvec3().normalize();
    let [d, g] = [m.diffuse, m.glossy].map(|b| f64::from(b.iter().copied().fold(0.0, f32::max)));
    let mirrored = 2.0 * n * n.dot(wo.as_dvec3()) - wo.as_dvec3();
    (d * w.dot(n).max(0.0) / PI + g * lobe(mirrored.normalize(), f64::from(m.glossy_exponent), w)) / (d + g)
}

/// WGSL of a vector.
pub fn wgsl(v: Vec3) -> String {
    format!("vec3({:?}, {:?}, {:?})", v.x, v.y, v.z)
}

/// Sampling of the D lobes, and of mirrors that are not perfect; directions below the surface are none.
fn surface_laws(materials: &[PackedMaterial], rough: usize) -> Vec<Law> {
    let n = NORMAL.as_dvec3().normalize();
    let mut laws = Vec::new();
    for (view, wo) in views().into_iter().enumerate() {
        let mirrored = (2.0 * n * n.dot(wo.as_dvec3()) - wo.as_dvec3()).normalize();
        for (i, m) in materials.iter().copied().enumerate() {
            let mirror = i >= rough;
            let exponent = f64::from(if mirror { m.specular_exponent } else { m.glossy_exponent });
            let matte = !mirror && m.diffuse[0] > 0.0;
            let cap = Cap::new(mirrored, if matte { 2.0 } else { reach(exponent) });
            let name = if mirror { "mirror lobe" } else { "D lobes" };
            laws.push(Law {
                name: format!("{name} of material {i}, view {view}"),
                cap,
                density: Box::new(move |w| match w.dot(n) > 0.0 {
                    false => 0.0,
                    true if mirror => lobe(mirrored, exponent, w),
                    true => density_d(&m, wo, w),
                }),
                host: if mirror {
                    Box::new(move |u| mirror_lobe(&m, wo, NORMAL, [u[0], u[1]]))
                } else {
                    Box::new(move |u| Scatter::of(&m, wo, NORMAL).sample(wo, NORMAL, u[2], [u[0], u[1]]))
                },
                device: if mirror {
                    let (d, n) = (wgsl(-wo), wgsl(NORMAL));
                    format!(
                        "sample_delta(material_at({i}), LOBE_MIRROR, {d}, {n}, {n}, true, u.xy).direction"
                    )
                } else {
                    format!("sample_scatter(material_at({i}), {}, {}, u.xyz)", wgsl(NORMAL), wgsl(wo))
                },
            });
        }
    }
    laws
}

/// Microfacets, of metal and over a base: those that are followed first.
fn faceted() -> Vec<PackedMaterial> {
    let make = |diffuse, alpha, kind| {
        let facets = Some(Facets { alpha, kind });
        PackedMaterial::new(&Material { glossy: [1.0; 3], facets, ..Material::matte("f", diffuse) })
    };
    let gold = FacetKind::Conductor { eta: [0.2, 0.4, 1.4], k: [3.3, 2.4, 1.9] };
    let mut all: Vec<PackedMaterial> =
        [0.02, 0.08, 0.15, 0.4, 1.0].map(|alpha| make([0.0; 3], alpha, gold)).into();
    all.push(make([0.7, 0.2, 0.1], 0.3, FacetKind::Coat { ior: 1.5, inner: Inner::Even }));
    all
}

/// Density of the samples of microfacets about [`NORMAL`]: Smith's Λ and GGX by tangents.
fn facet_density(alpha: f64, wo: DVec3, w: DVec3) -> f64 {
    let n = NORMAL.as_dvec3().normalize();
    let tan2 = |cos: f64| 1.0 / (cos * cos) - 1.0;
    let (h, co) = ((wo + w).normalize().dot(n), wo.dot(n));
    let stretched = alpha * h * h * (1.0 + tan2(h) / (alpha * alpha));
    let lambda = ((1.0 + alpha * alpha * tan2(co)).sqrt() - 1.0) / 2.0;
    1.0 / (PI * stretched * stretched) / (4.0 * co * (1.0 + lambda))
}

/// Sampling of microfacets; their materials are numbered from `first`.
fn facet_laws(first: usize) -> Vec<Law> {
    let n = NORMAL.as_dvec3().normalize();
    let mut laws = Vec::new();
    for (view, wo) in views().into_iter().enumerate() {
        let mirrored = (2.0 * n * n.dot(wo.as_dvec3()) - wo.as_dvec3()).normalize();
        for (i, m) in faceted().into_iter().enumerate() {
            let alpha = f64::from(m.alpha);
            let is_followed = m.has_narrow_lobe();
            assert_eq!(is_followed, alpha < 0.081);
            // what of the base and of the coat is sampled, by Fresnel's amplitudes
            let (co, ior) = (wo.as_dvec3().dot(n), f64::from(m.ior));
            let inner = (1.0 - (1.0 - co * co) / (ior * ior)).sqrt();
            let [s, p] = [[co, ior * inner], [ior * co, inner]].map(|[a, b]| ((a - b) / (a + b)).powi(2));
            let base = f64::from(m.diffuse[0]) * (1.0 - 0.5 * (s + p)) * f64::from(m.coat_transmittance);
            let share = if m.diffuse[0] > 0.0 { base / (base + 0.5 * (s + p)) } else { 0.0 };
            let number = first + i;
            let (d, normal, o) = (wgsl(-wo), wgsl(NORMAL), wgsl(wo));
            laws.push(Law {
                name: format!("microfacets of material {i}, view {view}"),
                // the tails are long: a narrow lobe's lie in the rest
                cap: Cap::new(mirrored, (200.0 * alpha * alpha).min(2.0)),
                density: Box::new(move |w| match w.dot(n) > 0.0 {
                    false => 0.0,
                    true => share * w.dot(n) / PI + (1.0 - share) * facet_density(alpha, wo.as_dvec3(), w),
                }),
                host: if is_followed {
                    Box::new(move |u| mirror_lobe(&m, wo, NORMAL, [u[0], u[1]]))
                } else {
                    Box::new(move |u| Scatter::of(&m, wo, NORMAL).sample(wo, NORMAL, u[2], [u[0], u[1]]))
                },
                device: if is_followed {
                    format!("sample_delta(material_at({number}), LOBE_MIRROR, {d}, {normal}, {normal}, true, u.xy).direction")
                } else {
                    format!("sample_scatter(material_at({number}), {normal}, {o}, u.xyz)")
                },
            });
        }
    }
    laws
}

/// All materials, and the number of those that sample a D lobe.
fn all_materials() -> (Vec<PackedMaterial>, usize) {
    let mut all = materials();
    let lobes = all.len();
    let rough = Material { glossy: [0.9; 3], glossy_exponent: 1000.0, ..Material::matte("rough", [0.0; 3]) };
    all.push(PackedMaterial::new(&rough));
    assert!(all[lobes].specular_exponent > 0.0, "lobes this sharp are followed");
    (all, lobes)
}

/// A scene that only serves to fill the bindings.
pub fn any_scene() -> PackedScene {
    let mut b = Builder::new([0., 0., 2.], [0.; 3], [0., 1., 0.], 0.5, 4);
    let matte = b.matte(0.5);
    b.quad([-1., -1., 0.], [2., 0., 0.], [0., 2., 0.], matte);
    b.point_light([0., 0., 1.], 1.0);
    PackedScene::new(&b.scene)
}

/// Rows of random numbers as inputs of a snippet.
pub fn inputs(purpose: u32, count: u32) -> Vec<[Row; 1]> {
    draws(purpose, count).map(|u| [row(u)]).collect()
}

#[test]
fn host_directions_follow_their_laws() {
    let mut claims = Claims::default();
    for law in plain_laws() {
        let samples = draws(10, HOST_COUNT).map(|u| (law.host)(u).map(Vec3::as_dvec3));
        claims.add(&law.name, law.cap.test(samples, &law.density));
    }
    let (materials, lobes) = all_materials();
    let n = NORMAL.as_dvec3();
    for law in surface_laws(&materials, lobes).into_iter().chain(facet_laws(0)) {
        let samples = draws(11, HOST_COUNT).map(|u| (law.host)(u).and_then(|w| above(w.as_dvec3(), n)));
        claims.add(&law.name, law.cap.test(samples, &law.density));
    }
    claims.hold();
}

#[test]
fn device_directions_follow_their_laws() {
    let context = device_or_return!();
    let mut device = Device::new(context, &any_scene(), 0);
    let (materials, lobes) = all_materials();
    device.materials(&[materials.clone(), faceted()].concat());
    let inputs = inputs(12, DEVICE_COUNT);
    let mut claims = Claims::default();
    let n = NORMAL.as_dvec3();
    let laws = plain_laws().into_iter().map(|l| (l, false));
    let on_surfaces = surface_laws(&materials, lobes).into_iter().chain(facet_laws(materials.len()));
    for (law, surface) in laws.chain(on_surfaces.map(|l| (l, true))) {
        let code = format!("let u = in_f(0u); out_f(0u, vec4({}, 0.0));", law.device);
        let out: Vec<[Row; 1]> = device.run(&code, (false, 1), &inputs);
        let samples = out.iter().map(|o| dvec3(o[0])).map(|w| if surface { above(w, n) } else { Some(w) });
        claims.add(&law.name, law.cap.test(samples, &law.density));
    }
    claims.hold();
}

/// A place of the square [−1, 1]² as one of the unit square.
fn centred(p: [f64; 2]) -> [f64; 2] {
    p.map(|x| 0.5 + 0.5 * x)
}

fn in_triangle([b, c]: [f64; 2]) -> f64 {
    if b + c < 1.0 { 2.0 } else { 0.0 }
}

/// Per area of the unit square that holds a disc of radius one half.
fn in_disc(p: [f64; 2]) -> f64 {
    let [x, y] = p.map(|x| 2.0 * x - 1.0);
    if x * x + y * y < 1.0 { 4.0 / PI } else { 0.0 }
}

#[test]
fn places_are_uniform_by_area() {
    let mut claims = Claims::default();
    let wide = |p: [f32; 2]| p.map(f64::from);
    let host = |f: fn([f32; 2]) -> [f32; 2]| draws(13, HOST_COUNT).map(move |u| wide(f([u[0], u[1]])));
    claims.add("triangle, host", in_square(host(triangle).map(Some), in_triangle));
    claims.add("disc, host", in_square(host(disc).map(centred).map(Some), in_disc));
    if let Some(context) = crate::common::device() {
        let code = "let u = in_f(0u).xy; out_f(0u, vec4(sample_triangle(u), sample_disc(u)));";
        let mut device = Device::new(context, &any_scene(), 0);
        let out: Vec<[Row; 1]> = device.run(code, (false, 1), &inputs(14, DEVICE_COUNT));
        let places: Vec<[f64; 4]> = out.iter().map(|o| floats(o[0]).map(f64::from)).collect();
        let pair = |k: usize| places.iter().map(move |p| [p[k], p[k + 1]]);
        claims.add("triangle, device", in_square(pair(0).map(Some), in_triangle));
        claims.add("disc, device", in_square(pair(2).map(centred).map(Some), in_disc));
    }
    claims.hold();
}
