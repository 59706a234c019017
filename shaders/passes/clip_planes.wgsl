// Clip: the planes of the walls that cut a gather point's disc. Light from behind a wall must not reach the disc's middle,
// though the surface goes on there: a partition that stands on a floor. The pilot sends a few rays along the surface; what
// they meet at a steep angle within the disc are walls. Passes keep to the gather point's side of the nearest two.
// reads  scene, map_info, gather_points, edges (1: cut, 2: other surfaces near)   writes  clips, status
// import: camera/strip.wgsl
// import: sampling/sampling.wgsl
// import: accel/intersect.wgsl
// import: maps/clip_planes.wgsl
// import: paths/gather_point.wgsl

@group(1) @binding(0) var<uniform> map_info: MapInfo;
@group(1) @binding(1) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(2) var<storage, read> edges: array<u32>;
@group(1) @binding(3) var<storage, read_write> clips: array<Clip>;
@group(1) @binding(4) var<storage, read_write> status: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let pixel = strip_pixel(linear_index(id, groups));
    if pixel == NO_PIXEL {
        return;
    }
    var clip = Clip(vec4(0.0), vec4(0.0));
    if edges[held(pixel)] != 0u {
        let point = gather_points[held(pixel)];
        let normal = decode_direction(point.normal);
        let frame = basis(normal);
        // the pixel's other gather points lie about this one
        let footprint = pixel_footprint(point, pass_info.camera.pixel_angle);
        let r = map_info.radius + footprint;
        let origin = point.position + normal * (CLIP_LIFT * r);
        var walls = no_walls(r);
        for (var i = 0u; i < CLIP_RAYS; i += 1u) {
            let around = unit_circle(f32(i) / f32(CLIP_RAYS));
            let direction = frame[0] * around.x + frame[1] * around.y;
            let hit = traverse(origin, direction, r * CLIP_REACH, false);
            if hit.triangle == MISS {
                continue;
            }
            let t = triangle_at(hit.triangle);
            // light goes through glass
            if (t.flags & CLEAR) != 0u {
                continue;
            }
            let front = normalize(cross(t.e1, t.e2));
            let plane = vec4(front, dot(front, t.v0));
            if is_steep(plane, normal) {
                walls = with_wall(walls, plane, point.position, r);
            }
        }
        clip = Clip(walls.planes[0], walls.planes[1]);
        if traversal_cut {
            atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
        }
    }
    clips[held(pixel)] = clip;
}
