// A disc that walls cut: what lies behind their planes does not count. Planes are n, n · v, and all zero where there is none.
// import: camera/strip.wgsl

// Walls of a gather point, the nearer one first.
struct Walls {
    planes: array<vec4<f32>, 2>,
    distances: vec2<f32>,
}

// True for a plane that is a wall to a surface of this normal, not the surface itself.
fn is_steep(plane: vec4<f32>, normal: vec3<f32>) -> bool {
    return abs(dot(plane.xyz, normal)) <= CLIP_STEEP;
}

// With one plane more, turned so that `p` lies before it, if it is among the two nearest and not there yet.
fn with_wall(walls: Walls, plane: vec4<f32>, p: vec3<f32>, r: f32) -> Walls {
    var w = walls;
    let signed = dot(plane.xyz, p) - plane.w;
    let distance = abs(signed);
    let turned = select(-plane, plane, signed >= 0.0);
    let known = dot(turned.xyz, w.planes[0].xyz) > CLIP_SAME && abs(distance - w.distances.x) < CLIP_LIFT * r;
    if known || distance >= w.distances.y {
        return w;
    }
    if distance < w.distances.x {
        w.planes[1] = w.planes[0];
        w.distances.y = w.distances.x;
        w.planes[0] = turned;
        w.distances.x = distance;
    } else {
        w.planes[1] = turned;
        w.distances.y = distance;
    }
    return w;
}

fn no_walls(r: f32) -> Walls {
    return Walls(array<vec4<f32>, 2>(vec4(0.0), vec4(0.0)), vec2(r));
}

// The walls that cut the disc of radius r about a pixel's gather point of this pass. Where the pilot saw another surface
// in the pixel, or this one elsewhere, in a mirror, the neighbours know better.
fn walls_about(pixel: u32, p: vec3<f32>, normal: vec3<f32>, r: f32) -> Walls {
    var walls = no_walls(r);
    let own = clips[held(pixel)];
    if is_steep(own.first, normal) && is_steep(own.second, normal) {
        walls = with_clip(walls, own, p, normal, r);
    }
    if any(walls.planes[0].xyz != vec3(0.0)) {
        return walls;
    }
    let rows = rows_about(pixel);
    let columns = columns_about(pixel);
    for (var y = rows.x; y <= rows.y; y += 1u) {
        for (var x = columns.x; x <= columns.y; x += 1u) {
            walls = with_clip(walls, clips[held(y * pass_info.width + x)], p, normal, r);
        }
    }
    return walls;
}

// With the planes of a pixel's clip that are walls to a surface of this normal.
fn with_clip(walls: Walls, clip: Clip, p: vec3<f32>, normal: vec3<f32>, r: f32) -> Walls {
    var w = walls;
    if any(clip.first.xyz != vec3(0.0)) && is_steep(clip.first, normal) {
        w = with_wall(w, clip.first, p, r);
    }
    if any(clip.second.xyz != vec3(0.0)) && is_steep(clip.second, normal) {
        w = with_wall(w, clip.second, p, r);
    }
    return w;
}

fn is_before(plane: vec4<f32>, p: vec3<f32>) -> bool {
    return dot(plane.xyz, p) >= plane.w;
}
