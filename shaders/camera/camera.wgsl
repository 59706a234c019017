// The camera: a pinhole; row 0 is the top. Twin: src/packed/camera.rs.
// import: sampling/rng.wgsl
// reads  pass_info

struct CameraRay {
    origin: vec3<f32>,
    // Unit.
    direction: vec3<f32>,
    // Its length before that, from the eye.
    travelled: f32,
}

// The ray through a place in a pixel. It starts at the eye or, where that is far away, on a plane before the scene: there
// a ray that set out at the eye would have lost its digits.
fn camera_ray(pixel: u32, jitter: vec2<f32>) -> CameraRay {
    let x = (f32(pixel % pass_info.width) + jitter.x) / f32(pass_info.width);
    let y = (f32(pixel / pass_info.width) + jitter.y) / f32(pass_info.height);
    let camera = pass_info.camera;
    let across = (2.0 * x - 1.0) * camera.right + (1.0 - 2.0 * y) * camera.up;
    let along = camera.forward + across;
    return CameraRay(camera.start + across * camera.ahead, normalize(along), camera.ahead * length(along));
}

// Width of what a path of this length from the eye sees of a texture at once: the passes of a pixel see all of it [E37].
fn seen_width(path_length: f32) -> f32 {
    return TEXTURE_PIXELS * path_length * pass_info.camera.pixel_angle;
}

// Ray `number` of a pixel, drawn by a stream of random numbers; box filter one pixel wide.
fn sample_camera(pixel: u32, number: u32, seed: u32, stream: u32) -> CameraRay {
    return camera_ray(pixel, sobol2(number, sequence_seed(seed, pixel, stream)));
}
