// The surface at a hit: position, normals, side.
// import: shared/intersect.wgsl
// reads  triangles, shading_normals

struct Surface {
    position: vec3<f32>,
    material: u32,
    // Unit geometric normal of the front.
    front: vec3<f32>,
    is_smooth: bool,
    // Unit shading normal of the front.
    shading: vec3<f32>,
    emitter: u32,
}

fn surface_at(hit: Hit) -> Surface {
    let t = triangle_at(hit.triangle);
    let front = normalize(cross(t.e1, t.e2));
    var s = Surface(t.v0 + hit.u * t.e1 + hit.v * t.e2, t.material, front, false, front, t.emitter);
    if HAS_SMOOTH && (t.flags & SMOOTH) != 0u {
        let packed = shading_normals[hit.triangle];
        let n = (1.0 - hit.u - hit.v) * decode_direction(packed.x) + hit.u * decode_direction(packed.y)
            + hit.v * decode_direction(packed.z);
        let length2 = dot(n, n);
        s.is_smooth = true;
        s.shading = select(front, n * inverseSqrt(max(length2, 1e-20)), length2 > 1e-12);
    }
    return s;
}

// Lengths below this share of the coordinates are lost in their rounding: origins are moved off the surface by it.
const OFFSET_SHARE: f32 = 7.62939453125e-6; // 2^-17
// Rounding follows the vertices' coordinates, which may be large where the position's are not.
const OFFSET_SCALE: f32 = 256.0;

// Origin of a ray that leaves position to the side that `normal` points to.
fn offset_origin(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let largest = max(max(abs(position.x), abs(position.y)), max(abs(position.z), OFFSET_SCALE));
    return position + normal * (largest * OFFSET_SHARE);
}
