// The surface at a hit: position, normals, side.
// import: accel/intersect.wgsl
// import: accel/lift.wgsl
// import: shading/texture.wgsl
// reads  scene

struct Surface {
    position: vec3<f32>,
    material: u32,
    // Unit geometric normal of the front.
    front: vec3<f32>,
    is_smooth: bool,
    // Unit shading normal of the front.
    shading: vec3<f32>,
    emitter: u32,
    // How far off its plane f32 may put the position.
    lift: f32,
    // Where a texture lies on it.
    texture: TexturePlace,
    // It bounds a body, and priorities decide what is in it.
    is_nested: bool,
}

fn surface_at(hit: Hit) -> Surface {
    let t = triangle_at(hit.triangle);
    let front = normalize(cross(t.e1, t.e2));
    let lift = lift_of(front, abs(t.v0) + abs(t.e1) + abs(t.e2));
    let nowhere = TexturePlace(vec2(0.0), 0.0, vec3(0.0), vec3(0.0));
    var s = Surface(t.v0 + hit.u * t.e1 + hit.v * t.e2, t.material, front, false, front, t.emitter, lift, nowhere, false);
    s.is_nested = HAS_MEDIA && (t.flags & NESTED) != 0u;
    if (HAS_TEXTURES && (t.flags & TEXTURED) != 0u) || (HAS_CUTOUTS && (t.flags & CUT) != 0u) {
        s.texture = texture_place(hit.triangle, t, vec2(hit.u, hit.v));
    }
    if HAS_SMOOTH && (t.flags & SMOOTH) != 0u {
        let packed = normals_at(hit.triangle);
        let n = (1.0 - hit.u - hit.v) * decode_direction(packed.x) + hit.u * decode_direction(packed.y)
            + hit.v * decode_direction(packed.z);
        let length2 = dot(n, n);
        s.is_smooth = true;
        s.shading = select(front, n * inverseSqrt(max(length2, 1e-20)), length2 > 1e-12);
    }
    return s;
}

// Where a ray starts, and below which distance back faces are not met [E27].
struct Departure {
    origin: vec3<f32>,
    t_back: f32,
}

// A ray that leaves a surface in a direction, having come from its front or its back. A ray out of a body starts on its
// inner side, where it still meets the front of what touches the body.
fn departure(s: Surface, direction: vec3<f32>, from_front: bool) -> Departure {
    let cosine = dot(direction, s.front);
    if HAS_MEDIA && s.is_nested {
        // before its front, whose like is not met again on the way in: so others in one place with it are passed, too [E45]
        return Departure(s.position + s.front * s.lift, select(0.0, 2.0 * s.lift / cosine, cosine < 0.0));
    }
    if !from_front && cosine > 0.0 {
        return Departure(s.position - s.front * s.lift, 2.0 * s.lift / cosine);
    }
    return Departure(s.position + s.front * select(-s.lift, s.lift, cosine >= 0.0), 0.0);
}
