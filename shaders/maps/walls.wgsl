// Walls: triangles that stand on a disc. What lies behind their planes does not count there [E31].

// A triangle that stands on a disc, about its middle.
struct StandingWall {
    // Unit normal, turned so that the middle lies before the plane, and how far along it the plane lies; zero where there is none.
    plane: vec4<f32>,
    // The ends of the line on which it stands, and how far that line is.
    foot_a: vec3<f32>,
    foot_b: vec3<f32>,
    distance: f32,
}

fn no_standing_wall() -> StandingWall {
    return StandingWall(vec4(0.0), vec3(0.0), vec3(0.0), 1e30);
}

// Where the edge from a to b goes through a plane at height 0 of both; in .w whether it does.
fn through_edge(a: vec3<f32>, b: vec3<f32>, height_a: f32, height_b: f32) -> vec4<f32> {
    let passes = (height_a < 0.0) != (height_b < 0.0);
    return vec4(a + (b - a) * (height_a / (height_a - height_b)), select(0.0, 1.0, passes));
}

// A triangle as a wall: where a plane a little above the surface meets it within the radius. Glass is a wall, too: light on its
// other side has come another way.
fn standing_wall(
    a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, normal: vec3<f32>, surface_normal: vec3<f32>, radius: f32,
) -> StandingWall {
    let lift = CLIP_LIFT * radius;
    let h = vec3(dot(a, surface_normal), dot(b, surface_normal), dot(c, surface_normal)) - lift;
    let ab = through_edge(a, b, h.x, h.y);
    let bc = through_edge(b, c, h.y, h.z);
    let ca = through_edge(c, a, h.z, h.x);
    if abs(dot(normal, surface_normal)) > GATHER_NORMAL_COS || ab.w + bc.w + ca.w < 2.0 {
        return no_standing_wall();
    }
    let start = select(bc.xyz, ab.xyz, ab.w > 0.0) - surface_normal * lift;
    let end = select(bc.xyz, ca.xyz, ca.w > 0.0) - surface_normal * lift;
    let along = end - start;
    let t = clamp(-dot(start, along) / max(dot(along, along), 1e-37), 0.0, 1.0);
    let distance = length(start + along * t);
    if distance >= radius {
        return no_standing_wall();
    }
    let offset = dot(normal, a);
    let turn = select(1.0, -1.0, offset > 0.0);
    return StandingWall(vec4(normal, offset) * turn, start, end, distance);
}

// True where a wall stands wholly behind another one, or in its plane.
fn is_behind(wall: StandingWall, other: StandingWall, slack: f32) -> bool {
    let a = dot(other.plane.xyz, wall.foot_a) - other.plane.w;
    let b = dot(other.plane.xyz, wall.foot_b) - other.plane.w;
    return a < slack && b < slack;
}
