// Media: which bodies light is in on its way, what they leave of it [E44], and which of them meet at a boundary [E45]. Four numbers of
// bodies, a byte each, the one that counts lowest. no_media.wgsl stands in place of this where no body's inside matters. Twin: src/optics/media.rs.
// import: scene/features.wgsl
// import: scene/scene.wgsl
// reads  scene

const BODY_BITS: u32 = 8u;
const BODY_MASK: u32 = 0xffu;
// Light comes from beyond the scene.
const AFAR: f32 = 1e30;

// Word 0: where the camera is, the first word of where the emitters are, and 1 where some body has a priority. Then of each body its
// material and its rank.
fn media_word(at: u32) -> vec4<u32> {
    return heap_word(scene_info.media + at);
}

// The bodies that camera paths start in …
fn inside_of_camera() -> u32 {
    if !HAS_MEDIA {
        return 0u;
    }
    return media_word(0u).x;
}

// … and those that the jotons of an emitter do.
fn inside_of_emitter(number: u32) -> u32 {
    if !HAS_MEDIA {
        return 0u;
    }
    let first = media_word(0u).y;
    return select(0u, media_word(first + number / 4u)[number % 4u], first > 0u);
}

// The number of the body that a surface bounds; 0 where it is none.
fn body_of(m: PackedMaterial) -> u32 {
    return select(0u, m.flag_bits >> BODY_SHIFT, HAS_MEDIA);
}

fn has_priorities() -> bool {
    return media_word(0u).z != 0u;
}

// In one more body, before those that do not come before it by their priority; of too many the last falls out.
fn with_body(inside: u32, body: u32) -> u32 {
    let rank = media_word(body).y;
    var place = 0u;
    for (var at = 0u; at < 32u; at += BODY_BITS) {
        let other = (inside >> at) & BODY_MASK;
        if other != 0u && media_word(other).y < rank {
            place = at + BODY_BITS;
        }
    }
    if place == 32u {
        return inside;
    }
    let below = (1u << place) - 1u;
    return (inside & below) | (body << place) | ((inside & ~below) << BODY_BITS);
}

// Where the first body of a number stands: its lowest bit; 32 where none does.
fn place_of_body(inside: u32, body: u32) -> u32 {
    var place = 32u;
    for (var at = 0u; at < 32u; at += BODY_BITS) {
        place = select(place, at, place == 32u && ((inside >> at) & BODY_MASK) == body);
    }
    return place;
}

fn without_body(inside: u32, body: u32) -> u32 {
    let place = place_of_body(inside, body);
    if place == 32u {
        return inside;
    }
    let below = (1u << place) - 1u;
    return (inside & below) | ((inside >> BODY_BITS) & ~below);
}

// The bodies before a surface, where light that took itself to be in `inside` meets it: at the back of a boundary it is in its body,
// without priorities in nothing else there.
fn inside_before(inside: u32, m: PackedMaterial, from_front: bool) -> u32 {
    let body = body_of(m);
    if body == 0u || from_front || place_of_body(inside, body) < 32u {
        return inside;
    }
    return with_body(select(without_body(inside, inside & BODY_MASK), inside, has_priorities()), body);
}

// … and those beyond it.
fn inside_beyond(before: u32, m: PackedMaterial, from_front: bool) -> u32 {
    let body = body_of(m);
    if body == 0u {
        return before;
    }
    if from_front {
        return with_body(before, body);
    }
    return without_body(before, body);
}

struct Medium {
    ior: f32,
    iors: Bands,
    disperses: bool,
}

fn medium_of(body: u32) -> Medium {
    if body == 0u {
        return Medium(1.0, Bands(1.0), false);
    }
    let m = material_at(media_word(body).x);
    return Medium(m.ior, m.iors, (m.flag_bits & DISPERSIVE) != 0u);
}

// True where the medium stays: priorities say so.
fn is_no_boundary(m: PackedMaterial, before: u32, beyond: u32) -> bool {
    return body_of(m) != 0u && has_priorities() && (before & BODY_MASK) == (beyond & BODY_MASK);
}

// A boundary as it is between the media that meet at it. Where the medium stays it is none: a pane of the index of air.
fn boundary_between(m: PackedMaterial, from_front: bool, before: u32, beyond: u32) -> PackedMaterial {
    // what of a boundary is opaque is what it says
    if body_of(m) == 0u || !has_priorities() || (HAS_MIXTURES && (m.flag_bits & DIELECTRIC) == 0u) {
        return m;
    }
    var boundary = m;
    boundary.flag_bits &= ~DISPERSIVE;
    let here = before & BODY_MASK;
    let there = beyond & BODY_MASK;
    if here == there {
        boundary.flag_bits = (boundary.flag_bits & ~FACETS) | THIN;
        boundary.ior = 1.0;
        boundary.iors = Bands(1.0);
        boundary.specular = Bands(0.0);
        boundary.transmission = Bands(1.0);
        return boundary;
    }
    let front = medium_of(select(there, here, from_front));
    let back = medium_of(select(here, there, from_front));
    boundary.ior = back.ior / front.ior;
    boundary.iors = back.iors / front.iors;
    // nothing bends at facets where the index stays
    boundary.flag_bits &= select(~FACETS, 0xffffffffu, abs(boundary.ior - 1.0) > SAME_INDEX);
    boundary.flag_bits |= select(0u, DISPERSIVE, (front.disperses || back.disperses) && any(abs(boundary.iors - boundary.iors.x) > Bands(SAME_INDEX)));
    return boundary;
}

// What is left of light after a distance in these bodies, per band.
fn transmittance(inside: u32, distance: f32) -> Bands {
    let body = inside & BODY_MASK;
    if !HAS_MEDIA || body == 0u {
        return Bands(1.0);
    }
    return exp(-distance * material_at(media_word(body).x).extinction);
}
