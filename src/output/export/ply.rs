//! PLY: a mesh in binary, little-endian (Turk 1994, "The PLY Polygon File Format").

use super::shapes::Shape;

/// Corners of a face.
const CORNERS: u8 = 3;

/// The file's bytes: positions, normals where the shape is smooth, texture coordinates where a picture
/// lies on it, triangles.
pub(super) fn bytes(shape: &Shape<'_>) -> Vec<u8> {
    let smooth = !shape.normals.is_empty();
    let mut properties = vec!["x", "y", "z"];
    properties.extend(if smooth { &["nx", "ny", "nz"][..] } else { &[] });
    properties.extend(if shape.uvs.is_empty() { &[][..] } else { &["u", "v"] });
    let mut head =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", shape.positions.len());
    for name in properties {
        head += &format!("property float {name}\n");
    }
    head += &format!("element face {}\n", shape.triangles.len());
    head += "property list uchar int vertex_indices\nend_header\n";
    let mut bytes = head.into_bytes();
    for (i, position) in shape.positions.iter().enumerate() {
        let normal = shape.normals.get(i).map(|n| n.to_array());
        let uv = shape.uvs.get(i).into_iter().flatten().copied();
        for x in position.to_array().into_iter().chain(normal.into_iter().flatten()).chain(uv) {
            bytes.extend(x.to_le_bytes());
        }
    }
    for triangle in &shape.triangles {
        bytes.push(CORNERS);
        bytes.extend(triangle.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}
