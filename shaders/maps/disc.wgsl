// A disc's true area: its triangles clipped by the walls that stand on it, summed in closed form [E31].
// import: scene/features.wgsl
// import: scene/scene.wgsl
// import: sampling/sampling.wgsl
// import: accel/ball.wgsl
// import: shading/material.wgsl
// import: shading/lobes.wgsl
// import: maps/walls.wgsl

// What a disc is about, and to whom it belongs.
struct DiscPlace {
    position: vec3<f32>,
    // Unit geometric normal of the side that is looked at, and of the triangle's front.
    normal: vec3<f32>,
    front: vec3<f32>,
}

struct TrueDisc {
    radius: f32,
    // Of the surface before the walls.
    area: f32,
    // Planes about the disc's middle: unit normal, and how far along it the plane lies, at most 0; all zero where there is none.
    first: vec4<f32>,
    second: vec4<f32>,
}

// A triangle about the disc's middle, with its unit front normal.
struct NearTriangle {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    normal: vec3<f32>,
}

fn near_triangle(index: u32, center: vec3<f32>) -> NearTriangle {
    let t = triangle_at(index);
    let a = t.v0 - center;
    return NearTriangle(a, a + t.e1, a + t.e2, normalize(cross(t.e1, t.e2)));
}

fn height_over(half_space: vec4<f32>, p: vec3<f32>) -> f32 {
    return dot(half_space.xyz, p) - half_space.w;
}

// Lines that bound what counts of a triangle: its edges, the walls …
const LINES: u32 = 5u;
// … and the edges of another triangle in its plane.
const LINES_SHARED: u32 = 8u;
// Sine of an angle between lines that are parallel but for rounding.
const PARALLEL: f32 = 1e-4;

// Where a half space ends in the plane of a triangle: what is kept is n · (x, y) ≥ c for the line (n, c), n a unit vector. A half
// space that holds all of the plane, or none of it, has n = 0.
fn line_in_plane(half_space: vec4<f32>, frame: mat3x3<f32>, height: f32) -> vec3<f32> {
    let n = vec2(dot(half_space.xyz, frame[0]), dot(half_space.xyz, frame[1]));
    let c = half_space.w - height * dot(half_space.xyz, frame[2]);
    let size = length(n);
    return select(vec3(0.0, 0.0, c), vec3(n, c) / size, size > 1e-6);
}

// The half space on a triangle's side of its edge from a to b.
fn inward(t: NearTriangle, a: vec3<f32>, b: vec3<f32>) -> vec4<f32> {
    let n = cross(t.normal, b - a);
    return vec4(n, dot(n, a));
}

// What another line keeps of a stretch of line number k; number j. Of two that are the same the one of the lower number is the boundary.
fn kept_stretch(stretch: vec2<f32>, line: vec3<f32>, other: vec3<f32>, k: u32, j: u32) -> vec2<f32> {
    let slope = dot(other.xy, vec2(-line.y, line.x));
    let facing = dot(other.xy, line.xy);
    let at = (other.z - line.z * facing) / slope;
    var s = stretch;
    s.x = select(s.x, max(s.x, at), slope > PARALLEL);
    s.y = select(s.y, min(s.y, at), slope < -PARALLEL);
    let is_before = line.z > other.z || (line.z == other.z && k <= j);
    let is_kept = select(select(other.z <= 0.0, -line.z >= other.z, facing < -0.5), is_before, facing > 0.5);
    return select(s, vec2(1.0, 0.0), abs(slope) <= PARALLEL && !is_kept);
}

// Twice the area up to a point of a line at distance `near` of a circle's middle, from the foot of the perpendicular: a triangle
// up to the circle, a sector beyond.
fn fan_part(near: f32, at: f32, half_chord: f32, radius_squared: f32) -> f32 {
    let s = abs(at);
    let beyond = max(s - half_chord, 0.0);
    let sector = radius_squared * atan2(near * beyond, near * near + half_chord * s);
    return sign(at) * (near * min(s, half_chord) + select(0.0, sector, beyond > 0.0));
}

// Twice the area between a stretch of a line and a circle's middle, within the circle; negative where the middle lies beyond the line.
fn fan(line: vec3<f32>, stretch: vec2<f32>, radius_squared: f32) -> f32 {
    let near = abs(line.z);
    let half_chord = sqrt(max(radius_squared - near * near, 0.0));
    let twice = fan_part(near, stretch.y, half_chord, radius_squared) - fan_part(near, stretch.x, half_chord, radius_squared);
    return select(0.0, -sign(line.z) * twice, stretch.y > stretch.x);
}

// Area within a ball of the part of a triangle that lies before the walls; and of this what lies in another triangle of its plane, too,
// where `count` is LINES_SHARED.
fn area_in_ball(t: NearTriangle, disc: TrueDisc, other: NearTriangle, count: u32) -> f32 {
    let height = dot(t.normal, t.a);
    let radius_squared = disc.radius * disc.radius - height * height;
    if radius_squared <= 0.0 {
        return 0.0;
    }
    let frame = basis(t.normal);
    let ab = line_in_plane(inward(t, t.a, t.b), frame, height);
    let bc = line_in_plane(inward(t, t.b, t.c), frame, height);
    let ca = line_in_plane(inward(t, t.c, t.a), frame, height);
    let first = line_in_plane(disc.first, frame, height);
    let second = line_in_plane(disc.second, frame, height);
    var shared_ab = vec3(0.0);
    var shared_bc = vec3(0.0);
    var shared_ca = vec3(0.0);
    if HAS_CONTACTS && count == LINES_SHARED {
        shared_ab = line_in_plane(inward(other, other.a, other.b), frame, height);
        shared_bc = line_in_plane(inward(other, other.b, other.c), frame, height);
        shared_ca = line_in_plane(inward(other, other.c, other.a), frame, height);
    }
    var twice = 0.0;
    for (var k = 0u; k < count; k += 1u) {
        var line = select(select(ca, bc, k == 1u), ab, k == 0u);
        line = select(line, select(second, first, k == 3u), k > 2u);
        var stretch = vec2(-1e30, 1e30);
        if HAS_CONTACTS {
            line = select(line, select(select(shared_ca, shared_bc, k == 6u), shared_ab, k == 5u), k > 4u);
            stretch = kept_stretch(stretch, line, shared_ab, k, 5u);
            stretch = kept_stretch(stretch, line, shared_bc, k, 6u);
            stretch = kept_stretch(stretch, line, shared_ca, k, 7u);
        }
        stretch = kept_stretch(stretch, line, ab, k, 0u);
        stretch = kept_stretch(stretch, line, bc, k, 1u);
        stretch = kept_stretch(stretch, line, ca, k, 2u);
        stretch = kept_stretch(stretch, line, first, k, 3u);
        stretch = kept_stretch(stretch, line, second, k, 4u);
        if any(line.xy != vec2(0.0)) {
            twice += fan(line, stretch, radius_squared);
        }
        steps += 1u;
    }
    return max(0.5 * twice, 0.0);
}

// Area of a disc that has its walls, over the triangles found: what jotons that count there can lie on. Where faces lie in one
// place, light falls on one of them: what a triangle shares with an earlier one in its plane is taken off, exact where no three
// share it.
fn surface_area(place: DiscPlace, disc: TrueDisc, found: u32) -> f32 {
    var area = 0.0;
    var i = 0u;
    // the triangle itself, then earlier ones
    var j = 0u;
    while i < found {
        steps += 1u;
        let t = near_triangle(in_ball[i], place.position);
        let other = near_triangle(in_ball[j], place.position);
        let facing = dot(t.normal, place.front);
        let height = abs(dot(t.normal, t.a));
        let share = select(GATHER_SHEET_SHARE, GATHER_PLANE_SHARE, facing > 0.0);
        let is_surface = abs(facing) > GATHER_NORMAL_COS && height < share * disc.radius && takes_jotons(in_ball[i]);
        let is_in_plane = abs(dot(other.normal, t.normal)) > ONE_PLANE && abs(dot(other.a - t.a, t.normal)) < ONE_SURFACE;
        if is_surface && (i == j || is_in_plane && takes_jotons(in_ball[j])) {
            area += select(-1.0, 1.0, i == j) * area_in_ball(t, disc, other, select(LINES_SHARED, LINES, i == j));
        }
        if HAS_CONTACTS && j > 0u {
            j -= 1u;
        } else {
            i += 1u;
            j = i;
        }
    }
    return area;
}

fn takes_jotons(triangle: u32) -> bool {
    return does_scatter(material_at(triangle_at(triangle).material));
}

fn whole_disc(radius: f32) -> TrueDisc {
    return TrueDisc(radius, PI * radius * radius, vec4(0.0), vec4(0.0));
}

// The disc of this radius over the triangles found.
fn measured_disc(place: DiscPlace, radius: f32, found: u32) -> TrueDisc {
    // the nearest wall, then the nearest that does not stand behind it: in whatever order they come
    var first = no_standing_wall();
    var second = no_standing_wall();
    for (var k = 0u; k < 2u * found; k += 1u) {
        steps += 1u;
        let t = near_triangle(in_ball[select(k, k - found, k >= found)], place.position);
        let wall = standing_wall(t.a, t.b, t.c, t.normal, place.normal, radius);
        if k < found && wall.distance < first.distance {
            first = wall;
        }
        if k >= found && wall.distance < second.distance && !is_behind(wall, first, DISC_WALL_SLACK * radius) {
            second = wall;
        }
    }
    var disc = TrueDisc(radius, 0.0, first.plane, second.plane);
    disc.area = surface_area(place, disc, found);
    return disc;
}

// The disc about a place; a smaller one where its ball holds very many triangles, or next to nothing is left of it. Where `whole`,
// the largest of the radius and its half in which no wall and no edge is; else one of radius 0.
fn true_disc(place: DiscPlace, radius: f32, whole: bool) -> TrueDisc {
    var disc = whole_disc(select(radius, 0.0, whole));
    var r = radius;
    for (var k = 0u; k <= select(DISC_HALVINGS, 1u, whole); k += 1u) {
        let found = look_in_ball(place.position, r);
        if found <= DISC_TRIANGLES {
            var measured = measured_disc(place, r, found);
            let circle = PI * r * r;
            let is_circle = abs(measured.area - circle) < DISC_WHOLE * circle && all(measured.first.xyz == vec3(0.0));
            let is_enough = measured.area >= DISC_AREA_LEAST * circle;
            if select(is_enough, is_circle, whole) {
                return measured;
            }
            measured.area = DISC_AREA_LEAST * circle;
            if !whole {
                disc = measured;
            }
        }
        r *= 0.5;
    }
    return disc;
}
