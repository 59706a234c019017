//! Mitsuba: a scene file of Mitsuba 3, for its rgb variants, where radiance, reflectance and intensity are plain bands, or for
//! its spectral ones.

use super::bsdf::Bsdfs;
use super::colour::Colour;
use super::pfm::PictureFile;
use super::shapes::Shape;
use super::xml::{colour, escaped, float, list, triple};
use crate::scene::{Light, Scene};
use glam::DVec3;
use std::fmt::Write;

/// Nothing nearer to the eye than this part of the scene's extent is seen: less than f32 tells apart.
const NEAR: f64 = 1e-6;
/// The far plane lies behind everything.
const FAR: f64 = 2.0;

/// The scene file, and the pictures that it names. `meshes` names a file for each shape, in the folder of the scene file.
pub(super) fn text(
    scene: &Scene,
    stem: &str,
    shapes: &[Shape<'_>],
    meshes: &[String],
    emitters: &[String],
) -> (String, Vec<PictureFile>) {
    let mut out = String::from("<!-- written by joton; right-handed, y up; W/(m² sr), linear RGB -->\n");
    let mut line = |text: String| {
        out += &text;
        out.push('\n');
    };
    line("<scene version=\"3.0.0\">".into());
    line("<default name=\"spp\" value=\"64\"/>".into());
    line("<integrator type=\"path\"><integer name=\"max_depth\" value=\"-1\"/></integrator>".into());
    line(sensor(scene));
    let mut defined = None;
    let mut bsdfs = Bsdfs::new(stem);
    for (shape, mesh) in shapes.iter().zip(meshes) {
        let id = escaped(&format!("{} {}", shape.material_index, shape.material));
        // shapes come in the order of their materials
        if defined.replace(shape.material_index) != Some(shape.material_index) {
            line(bsdfs.text(&shape.look, shape.material_index, &id));
        }
        line(self::shape(shape, mesh, &id));
    }
    for emitter in emitters {
        line(emitter.clone());
    }
    line("</scene>".into());
    (out, bsdfs.pictures)
}

fn sensor(scene: &Scene) -> String {
    let camera = &scene.camera;
    let used = scene.mesh.triangles.iter().flat_map(|t| t.vertex);
    let distance = |v: u32| (scene.mesh.positions[v as usize] - camera.position).length();
    let farthest = used.map(distance).fold(0.0, f64::max);
    let fov = 2.0 * camera.tan_half_fov[0].atan().to_degrees();
    let mut out = String::from("<sensor type=\"perspective\">\n<string name=\"fov_axis\" value=\"x\"/>");
    out += &float("fov", fov);
    out += &float("near_clip", NEAR * farthest);
    out += &float("far_clip", FAR * farthest);
    out += &look_at(camera.position, camera.target, camera.up);
    out += "\n<sampler type=\"independent\"><integer name=\"sample_count\" value=\"$spp\"/></sampler>";
    let [width, height] = scene.size;
    let _ = write!(
        out,
        "\n<film type=\"hdrfilm\"><integer name=\"width\" value=\"{width}\"/><integer name=\"height\" \
         value=\"{height}\"/><rfilter type=\"box\"/><string name=\"pixel_format\" value=\"rgb\"/>\
         <string name=\"component_format\" value=\"float32\"/></film>\n</sensor>"
    );
    out
}

fn shape(shape: &Shape<'_>, mesh: &str, id: &str) -> String {
    let emitter = shape.emission.as_ref().map_or(String::new(), |radiance| {
        format!("<emitter type=\"area\">{}</emitter>", colour("radiance", radiance))
    });
    format!(
        "<shape type=\"ply\"><string name=\"filename\" value=\"{}\"/><boolean name=\"face_normals\" value=\"{}\"/>\
         {emitter}<ref id=\"{id}\"/></shape>",
        escaped(mesh),
        shape.normals.is_empty()
    )
}

/// A light, by its number from 0; none where it has no counterpart.
pub(super) fn emitter(scene: &Scene, number: usize, light: &Light) -> Option<String> {
    let stated = scene.spectrum_of_light(number).filter(|_| scene.wavelengths.are_rendered);
    let rgb = |name: &str, bands: &_| colour(name, &Colour::emission(bands, stated));
    if let Light::Point { position, intensity } = light {
        let (position, intensity) = (triple("point", "position", *position), rgb("intensity", intensity));
        return Some(format!("<emitter type=\"point\">{position}{intensity}</emitter>"));
    }
    if let Light::Spot { position, direction, intensity, angle_outer, .. } = light {
        let angle = angle_outer.to_degrees();
        return Some(format!(
            "<emitter type=\"spot\">{}{}{}{}</emitter>",
            look_at(*position, *position + *direction, direction.any_orthogonal_vector()),
            rgb("intensity", intensity),
            float("cutoff_angle", angle),
            float("beam_width", angle)
        ));
    }
    if let Light::Sun { direction, irradiance } = light {
        let direction = triple("vector", "direction", *direction);
        let irradiance = rgb("irradiance", irradiance);
        return Some(format!("<emitter type=\"directional\">{direction}{irradiance}</emitter>"));
    }
    None
}

fn look_at(origin: DVec3, target: DVec3, up: DVec3) -> String {
    let [origin, target, up] = [origin, target, up].map(|v| list(&v.to_array()));
    format!(
        "<transform name=\"to_world\"><lookat origin=\"{origin}\" target=\"{target}\" up=\"{up}\"/></transform>"
    )
}
