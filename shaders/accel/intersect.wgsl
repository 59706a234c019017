// Rays against the compressed wide BVH (Ylitie et al. 2017) and its triangles (Möller & Trumbore 1997).
// import: scene/scene.wgsl
// import: accel/crossing.wgsl
// import: accel/cutout.wgsl
// import: scene/features.wgsl
// reads  scene        counts  steps: loop iterations of this invocation        tells  traversal_cut

struct Hit {
    triangle: u32,
    t: f32,
    u: f32,
    v: f32,
}

const MISS: u32 = 0xffffffffu;
// Smallest divisor of a ray's direction.
const TINY: f32 = 1e-20;

var<private> steps: u32;
// The driver ended the loop of a traversal early: what it found may be wrong.
var<private> traversal_cut: bool;

fn bytes(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(0xffu));
}

// Which of four children the ray meets, as bits of the group masks.
fn four_children(
    meta4: u32, oct_inv4: u32, x0: u32, x1: u32, y0: u32, y1: u32, z0: u32, z1: u32,
    scale: vec3<f32>, start: vec3<f32>, t_max: f32,
) -> u32 {
    let inner4 = (meta4 & (meta4 << 1u)) & 0x10101010u;
    let inner_mask4 = (inner4 >> 4u) * 0xffu;
    let bit_index4 = (meta4 ^ (oct_inv4 & inner_mask4)) & 0x1f1f1f1fu;
    let child_bits4 = (meta4 >> 5u) & 0x07070707u;
    let near = max(
        max(bytes(x0) * scale.x + start.x, bytes(y0) * scale.y + start.y),
        max(bytes(z0) * scale.z + start.z, vec4(0.0)),
    );
    let far = min(
        min(bytes(x1) * scale.x + start.x, bytes(y1) * scale.y + start.y),
        min(bytes(z1) * scale.z + start.z, vec4(t_max)),
    );
    let shift = vec4(0u, 8u, 16u, 24u);
    let bits = ((vec4(child_bits4) >> shift) & vec4(7u)) << ((vec4(bit_index4) >> shift) & vec4(31u));
    // a hair of slack for the rounding of the quantised planes
    let met = select(vec4(0u), bits, near <= far * 1.0000004);
    return (met.x | met.y) | (met.z | met.w);
}

fn largest(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// The nearest hit before t_limit, or any.
fn traverse(origin: vec3<f32>, direction: vec3<f32>, t_limit: f32, any_hit: bool) -> Hit {
    return trace_ray(origin, direction, t_limit, 0.0, any_hit, origin + direction * t_limit);
}

// The nearest hit of a ray that starts at a surface or at the eye; see trace_ray for t_back.
fn nearest_hit(origin: vec3<f32>, direction: vec3<f32>, t_back: f32) -> Hit {
    return trace_ray(origin, direction, 1e30, t_back, false, vec3(0.0));
}

// True where something lies between two points that are lifted off their surfaces; direction and distance from one to the
// other.
fn is_occluded(origin: vec3<f32>, direction: vec3<f32>, distance: f32, end: vec3<f32>) -> bool {
    return trace_ray(origin, direction, distance, 0.0, true, end).triangle != MISS;
}

// Back faces nearer than t_back are not met: a ray that leaves a body starts a little inside of it. Where it is negative: front faces
// nearer than that, of one that it enters. A ray for any hit ends at
// the point `end`, t_limit away but for rounding.
fn trace_ray(
    origin: vec3<f32>, direction: vec3<f32>, t_limit: f32, t_back: f32, any_hit: bool, end: vec3<f32>,
) -> Hit {
    var hit = Hit(MISS, t_limit, 0.0, 0.0);
    // how far rounding may move hit.t, and what was hit
    var hit_error = 0.0;
    var face = Face(vec3(0.0), 0.0, vec3(0.0), 0u);
    var stack: array<vec2<u32>, TRAVERSAL_STACK>;
    var depth = 0u;
    let safe = select(direction, select(vec3(-TINY), vec3(TINY), direction >= vec3(0.0)), abs(direction) < vec3(TINY));
    let inverse = 1.0 / safe;
    let negative = safe < vec3(0.0);
    let octant = select(0x04040404u, 0u, negative.x) | select(0x02020202u, 0u, negative.y)
        | select(0x01010101u, 0u, negative.z);
    var group = vec2(0u, 0x80000000u);
    loop {
        var leaf = vec2(0u);
        if group.y > 0x00ffffffu {
            let mask = group.y;
            let bit = firstLeadingBit(mask);
            let base = group.x;
            group.y = mask & ~(1u << bit);
            if group.y > 0x00ffffffu {
                stack[min(depth, TRAVERSAL_STACK - 1u)] = group;
                depth += 1u;
            }
            let slot = (bit - 24u) ^ (octant & 0xffu);
            let node = node_at(base + countOneBits(mask & ~(0xffffffffu << slot)));
            let n0 = node.w0;
            let n1 = node.w1;
            let n2 = node.w2;
            let n3 = node.w3;
            let n4 = node.w4;
            let exponents = vec3(n0.w, n0.w >> 8u, n0.w >> 16u) & vec3(0xffu);
            let scale = bitcast<vec3<f32>>(exponents << vec3(23u)) * inverse;
            let start = (bitcast<vec3<f32>>(n0.xyz) - origin) * inverse;
            let x_near = select(n2.xy, n2.zw, negative.x);
            let x_far = select(n2.zw, n2.xy, negative.x);
            let y_near = select(n3.xy, n3.zw, negative.y);
            let y_far = select(n3.zw, n3.xy, negative.y);
            let z_near = select(n4.xy, n4.zw, negative.z);
            let z_far = select(n4.zw, n4.xy, negative.z);
            let met = four_children(n1.z, octant, x_near.x, x_far.x, y_near.x, y_far.x, z_near.x, z_far.x, scale, start, hit.t + hit_error)
                | four_children(n1.w, octant, x_near.y, x_far.y, y_near.y, y_far.y, z_near.y, z_far.y, scale, start, hit.t + hit_error);
            group = vec2(n1.x, (met & 0xff000000u) | (n0.w >> 24u));
            leaf = vec2(n1.y, met & 0x00ffffffu);
            steps += 1u;
        } else {
            group = vec2(0u);
        }
        while leaf.y != 0u {
            let bit = firstLeadingBit(leaf.y);
            leaf.y &= ~(1u << bit);
            let index = leaf.x + bit;
            let corners = triangle_at(index);
            let v0 = corners.v0;
            let e1 = corners.e1;
            let e2 = corners.e2;
            let p = cross(direction, e2);
            let det = dot(e1, p);
            let inv_det = 1.0 / det;
            let s = origin - v0;
            let u = dot(s, p) * inv_det;
            let q = cross(s, e1);
            let v = dot(direction, q) * inv_det;
            let t = dot(e2, q) * inv_det;
            let rounding = EDGE_ROUNDING * largest(s) * abs(inv_det);
            let long_1 = largest(e1);
            let long_2 = largest(e2);
            let slack_u = min(EDGE_SLACK + rounding * long_2, EDGE_SLACK_MAX);
            let slack_v = min(EDGE_SLACK + rounding * long_1, EDGE_SLACK_MAX);
            let is_inside = u >= -slack_u && v >= -slack_v && u + v <= 1.0 + max(slack_u, slack_v)
                && t > select(select(0.0, t_back, det < 0.0), max(0.0, select(-t_back, t_back, det < 0.0)), HAS_MEDIA);
            if any_hit {
                let error = rounding * long_1 * long_2 + t_limit * END_ROUNDING;
                // where rounded distances do not tell, the end tells on which side of the plane it is
                let is_near_end = abs(t - t_limit) < error;
                let is_before = select((t < t_limit), (dot(v0 - end, cross(e1, e2)) * det > 0.0), is_near_end);
                if is_inside && is_before && !(HAS_CUTOUTS && goes_through(index, corners, vec2(u, v), origin, direction)) {
                    hit = Hit(index, t, u, v);
                }
            } else if HAS_CONTACTS {
                let error = rounding * long_1 * long_2;
                let candidate = face_of(corners);
                let is_near = abs(t - hit.t) <= error + hit_error;
                let near = origin + direction * hit.t;
                let is_lower = index < hit.triangle;
                if is_inside && select((t < hit.t), is_met_first(candidate, face, is_lower, near, direction), is_near)
                    && !(HAS_CUTOUTS && goes_through(index, corners, vec2(u, v), origin, direction)) {
                    hit = Hit(index, t, u, v);
                    hit_error = error;
                    face = candidate;
                }
            } else if is_inside && t < hit.t
                && !(HAS_CUTOUTS && goes_through(index, corners, vec2(u, v), origin, direction)) {
                hit = Hit(index, t, u, v);
            }
            steps += 1u;
        }
        if leaf.y != 0u {
            traversal_cut = true;
        }
        if any_hit && hit.triangle != MISS {
            break;
        }
        if group.y <= 0x00ffffffu {
            if depth == 0u {
                break;
            }
            depth -= 1u;
            group = stack[min(depth, TRAVERSAL_STACK - 1u)];
        }
    }
    // an end by itself leaves nothing to visit
    if (group.y > 0x00ffffffu || depth != 0u) && !(any_hit && hit.triangle != MISS) {
        traversal_cut = true;
    }
    return hit;
}
