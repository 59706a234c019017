// The camera: a pinhole; row 0 is the top. Twin: src/packed/camera.rs.
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
    let across = (2.0 * x - 1.0) * pass_info.right + (1.0 - 2.0 * y) * pass_info.up;
    let along = pass_info.forward + across;
    return CameraRay(pass_info.eye + across * pass_info.eye_ahead, normalize(along), pass_info.eye_ahead * length(along));
}
