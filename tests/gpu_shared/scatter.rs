//! shading/bsdf.wgsl: which normal counts, and where specular events send light.

use crate::common::scenes::{Builder, glass};
use crate::common::{Row, Snippet, dvec3, floats, random, random_direction, row3, vec3};
use crate::device_or_return;
use glam::Vec3;
use joton::backend::gpu::harness::Harness;
use joton::packed::{PackedMaterial, PackedScene};
use joton::plan::{Plan, Settings};
use joton::scene::Material;

const SCATTER: &[&str] = &["scene/features.wgsl", "scene/scene.wgsl", "shading/bsdf.wgsl"];

/// A scene that only serves to fill the bindings.
pub fn with_materials<'a>(
    context: &'a joton::backend::gpu::Context,
    materials: &[PackedMaterial],
) -> Harness<'a> {
    let mut b = Builder::new([0., 0., 2.], [0.; 3], [0., 1., 0.], 0.5, 4);
    let matte = b.matte(0.5);
    b.material(glass(1.5));
    b.quad([-1., -1., 0.], [2., 0., 0.], [0., 2., 0.], matte);
    b.point_light([0., 0., 1.], 1.0);
    let packed = PackedScene::new(&b.scene);
    let plan = Plan::new(&packed, Settings::default());
    let mut harness = Harness::with_scene(context, &packed, &plan).unwrap_or_else(|e| panic!("{e}"));
    harness.scene("materials", materials);
    harness
}

fn harness(context: &joton::backend::gpu::Context) -> Harness<'_> {
    let rough =
        Material { glossy: [0.9; 3], glossy_exponent: 2000.0, ..Material::matte("rough mirror", [0.0; 3]) };
    let pane = Material { thin: true, ..glass(1.5) };
    let materials: Vec<PackedMaterial> =
        [Material::matte("m", [0.5; 3]), glass(1.5), crate::common::scenes::mirror(0.9), rough, pane]
            .iter()
            .map(PackedMaterial::new)
            .collect();
    assert!(materials[3].specular_exponent > 0.0, "lobes this sharp are followed");
    with_materials(context, &materials)
}

#[test]
fn the_normal_that_counts_is_on_the_side_of_the_ray() {
    let context = device_or_return!();
    let inputs: Vec<[Row; 3]> = (0..4000)
        .map(|i| {
            let front = random_direction(10, i);
            let direction = random_direction(11, i);
            let shading = (front + random_direction(12, i) * (random(13, i)[0] * 1.2)).normalize();
            [row3(front, (i % 4 != 0) as u32 as f32), row3(direction, 0.0), row3(shading, 0.0)]
        })
        .collect();
    let code = "let front = in_f(0u).xyz; let d = in_f(1u).xyz;
        let s = Surface(vec3(0.0), 0u, front, in_f(0u).w > 0.5, in_f(2u).xyz, NO_EMITTER, 0.0,
            TexturePlace(vec2(0.0), 0.0, vec3(0.0), vec3(0.0)), false);
        let geometric = front * select(-1.0, 1.0, dot(d, front) < 0.0);
        out_f(0u, vec4(facing_normal(s, d, geometric), 0.0));";
    let out: Vec<[Row; 1]> = Snippet::new(SCATTER, code).run_in(context, &mut harness(context), &[], &inputs);
    let mut kinds = [0; 3];
    for (i, [o]) in inputs.iter().zip(out) {
        let (front, d, shading) = (vec3(i[0]), vec3(i[1]), vec3(i[2]));
        let (d64, s64) = (d.as_dvec3(), shading.as_dvec3());
        if (d64.dot(s64)).abs() < 1e-6 || d64.dot(front.as_dvec3()).abs() < 1e-6 {
            continue;
        }
        let from_front = d.dot(front) < 0.0;
        let geometric = if from_front { front } else { -front };
        let turned = if from_front { shading } else { -shading };
        let is_smooth = floats(i[0])[3] > 0.5;
        let (kind, wanted) = match (is_smooth, d.dot(turned) < 0.0) {
            (true, true) => (0, turned),
            (true, false) => (1, geometric),
            (false, _) => (2, geometric),
        };
        kinds[kind] += 1;
        assert_eq!(vec3(o), wanted);
        assert!(vec3(o).dot(d) < 0.0);
    }
    assert!(kinds.iter().all(|&k| k > 100), "every case is met: {kinds:?}");
}

/// Mirror, reflection and refraction: directions, and the scale of radiance. The kernels' lobes are 5, 6 and 7.
#[test]
fn specular_events_mirror_and_refract() {
    let context = device_or_return!();
    let mut inputs: Vec<[Row; 3]> = Vec::new();
    for (material, event) in [(2u32, 0u32), (1, 1), (1, 2), (3, 0)] {
        for i in 0..1000 {
            let n = random_direction(14, i);
            let d = random_direction(15, i);
            let d = if d.dot(n) > 0.0 { -d } else { d };
            let [u, v, ..] = random(16, i);
            inputs.push([
                row3(d, (material * 16 + event) as f32),
                row3(n, (i % 2) as f32),
                row3(Vec3::new(u, v, 0.0), 0.0),
            ]);
        }
    }
    let code = "let me = u32(in_f(0u).w); let n = in_f(1u).xyz; let front = in_f(1u).w > 0.5;
        let s = sample_delta(material_at(me / 16u), LOBE_MIRROR + me % 16u, in_f(0u).xyz, n, n, front, in_f(2u).xy);
        out_f(0u, vec4(s.direction, s.radiance_scale));
        out_u(1u, vec4(select(0u, 1u, s.weight.x > 0.0),
            bitcast<u32>(dielectric_reflectance(material_at(me / 16u), n, in_f(0u).xyz, front).x), 0u, 0u));";
    let out: Vec<[Row; 2]> = Snippet::new(SCATTER, code).run_in(context, &mut harness(context), &[], &inputs);
    let mut below = 0;
    for (i, [o, flags]) in inputs.iter().zip(out) {
        let (d, n) = (dvec3(i[0]), dvec3(i[1]));
        let code = floats(i[0])[3] as u32;
        let (material, event) = (code / 16, code % 16);
        let from_front = floats(i[1])[3] > 0.5;
        let (got, scale, alive) = (dvec3(o), floats(o)[3], flags[0] == 1);
        let mirrored = d - 2.0 * d.dot(n) * n;
        let eta_it = if from_front { 1.0 / 1.5 } else { 1.5 };
        if material == 1 {
            let cos = -d.dot(n);
            let k = 1.0 - eta_it * eta_it * (1.0 - cos * cos);
            let reflectance = f32::from_bits(flags[1]);
            assert_eq!(k < -1e-5, reflectance == 1.0 && k < 1e-5 && k < -1e-5, "total where Snell says so");
            if event == 2 {
                assert!((f64::from(scale) - eta_it * eta_it).abs() < 1e-6);
                if k.abs() > 1e-5 {
                    assert_eq!(alive, k > 0.0);
                    let wanted = d * eta_it + n * (eta_it * cos - k.max(0.0).sqrt());
                    assert!(!alive || (got - wanted).length() < 1e-5, "{got} against {wanted}");
                }
                continue;
            }
        }
        assert_eq!(scale, 1.0);
        if material == 3 {
            // a lobe of exponent 2000 about the mirror direction; what falls below the surface dies
            let z = f64::from(floats(i[2])[0]).powf(1.0 / 2001.0);
            assert!((got.dot(mirrored) - z).abs() < 1e-5, "{} against {z}", got.dot(mirrored));
            assert_eq!(alive, got.dot(n) > 0.0, "{got} about {n}");
            below += usize::from(!alive);
        } else {
            assert!(alive && (got - mirrored).length() < 1e-6, "{got} against {mirrored}");
        }
    }
    assert!(below > 0, "no lobe dipped below the surface");
}

/// A thin pane lets light go straight on, scales nothing and reflects 2R/(1+R), the same from both sides; R by Fresnel's sines
/// and tangents.
#[test]
fn panes_bend_nothing() {
    let context = device_or_return!();
    let inputs: Vec<[Row; 2]> = (0..2000)
        .map(|i| {
            let n = random_direction(17, i);
            let d = random_direction(18, i);
            let d = if d.dot(n) > 0.0 { -d } else { d };
            [row3(d, (i % 2) as f32), row3(n, 0.0)]
        })
        .collect();
    let code = "let d = in_f(0u).xyz; let n = in_f(1u).xyz; let front = in_f(0u).w > 0.5;
        let s = sample_delta(material_at(4), LOBE_TRANSMISSION, d, n, n, front, vec2(0.5));
        out_f(0u, vec4(s.direction, s.radiance_scale));
        out_f(1u, vec4(dielectric_reflectance(material_at(4), n, d, front).x, s.weight.x, 0.0, 0.0));";
    let out: Vec<[Row; 2]> = Snippet::new(SCATTER, code).run_in(context, &mut harness(context), &[], &inputs);
    let mut sides = [0; 2];
    for (i, [o, more]) in inputs.iter().zip(out) {
        let (d, n, angle_cos) = (dvec3(i[0]), dvec3(i[1]), -dvec3(i[0]).dot(dvec3(i[1])));
        if angle_cos < 1e-2 {
            continue;
        }
        sides[floats(i[0])[3] as usize] += 1;
        let (angle, inside) = (angle_cos.min(1.0).acos(), (angle_cos.min(1.0).acos().sin() / 1.5).asin());
        let face = ((angle - inside).sin() / (angle + inside).sin()).powi(2)
            + ((angle - inside).tan() / (angle + inside).tan()).powi(2);
        let face = if angle < 1e-3 { 0.04 } else { face / 2.0 };
        let [reflectance, alive, ..] = floats(more);
        assert!((dvec3(o) - d).length() < 1e-5, "{d} on {n}: {}", dvec3(o));
        assert_eq!((floats(o)[3], alive), (1.0, 1.0));
        assert!((f64::from(reflectance) - 2.0 * face / (1.0 + face)).abs() < 1e-4, "{angle}: {reflectance}");
    }
    assert!(sides.iter().all(|&n| n > 900), "{sides:?}");
}
