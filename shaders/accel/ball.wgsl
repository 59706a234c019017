// Triangles that a ball meets, from the hierarchy that rays use (Ylitie et al. 2017).
// import: scene/scene.wgsl
// import: accel/intersect.wgsl
// reads  scene        counts  steps        tells  traversal_cut

// Those that `look_in_ball` has found.
var<private> in_ball: array<u32, DISC_TRIANGLES>;

// All children lie in positive directions: which of four meet a box, as bits of the group masks.
const ALONG_AXES: u32 = 0x07070707u;

fn four_in_box(
    meta4: u32, x0: u32, x1: u32, y0: u32, y1: u32, z0: u32, z1: u32, scale: vec3<f32>, start: vec3<f32>, reach: f32,
) -> u32 {
    let inner4 = (meta4 & (meta4 << 1u)) & 0x10101010u;
    let inner_mask4 = (inner4 >> 4u) * 0xffu;
    let bit_index4 = (meta4 ^ (ALONG_AXES & inner_mask4)) & 0x1f1f1f1fu;
    let child_bits4 = (meta4 >> 5u) & 0x07070707u;
    let low = max(
        max(bytes(x0) * scale.x + start.x, bytes(y0) * scale.y + start.y), bytes(z0) * scale.z + start.z,
    );
    let high = min(
        min(bytes(x1) * scale.x + start.x, bytes(y1) * scale.y + start.y), bytes(z1) * scale.z + start.z,
    );
    let shift = vec4(0u, 8u, 16u, 24u);
    let bits = ((vec4(child_bits4) >> shift) & vec4(7u)) << ((vec4(bit_index4) >> shift) & vec4(31u));
    let met = select(vec4(0u), bits, (low <= vec4(reach)) & (high >= vec4(-reach)));
    return (met.x | met.y) | (met.z | met.w);
}

// True where a ball's box meets the triangle's bounds, and the ball its plane. Corners are about the ball's centre.
fn is_in_ball(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, across: vec3<f32>, radius: f32) -> bool {
    let low = min(a, min(b, c));
    let high = max(a, max(b, c));
    let height = dot(across, a);
    return all(low < vec3(radius)) && all(high > vec3(-radius)) && height * height < radius * radius * dot(across, across);
}

// Number of triangles whose bounds and planes meet a ball; more than DISC_TRIANGLES where there are more.
fn look_in_ball(center: vec3<f32>, radius: f32) -> u32 {
    var found = 0u;
    var stack: array<vec2<u32>, TRAVERSAL_STACK>;
    var depth = 0u;
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
            let slot = (bit - 24u) ^ (ALONG_AXES & 0xffu);
            let node = node_at(base + countOneBits(mask & ~(0xffffffffu << slot)));
            let n0 = node.w0;
            let n1 = node.w1;
            let n2 = node.w2;
            let n3 = node.w3;
            let n4 = node.w4;
            let exponents = vec3(n0.w, n0.w >> 8u, n0.w >> 16u) & vec3(0xffu);
            let scale = bitcast<vec3<f32>>(exponents << vec3(23u));
            let start = bitcast<vec3<f32>>(n0.xyz) - center;
            let met = four_in_box(n1.z, n2.x, n2.z, n3.x, n3.z, n4.x, n4.z, scale, start, radius)
                | four_in_box(n1.w, n2.y, n2.w, n3.y, n3.w, n4.y, n4.w, scale, start, radius);
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
            let t = triangle_at(index);
            let a = t.v0 - center;
            if is_in_ball(a, a + t.e1, a + t.e2, cross(t.e1, t.e2), radius) {
                if found < DISC_TRIANGLES {
                    in_ball[found] = index;
                }
                found += 1u;
            }
            steps += 1u;
        }
        if found > DISC_TRIANGLES {
            return found;
        }
        if group.y <= 0x00ffffffu {
            if depth == 0u {
                return found;
            }
            depth -= 1u;
            group = stack[min(depth, TRAVERSAL_STACK - 1u)];
        }
    }
    traversal_cut = true;
    return found;
}
