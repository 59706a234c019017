// The camera: a pinhole; row 0 is the top.

// Unit direction through a place in a pixel.
fn camera_direction(pixel: u32, jitter: vec2<f32>) -> vec3<f32> {
    let x = (f32(pixel % pass_info.width) + jitter.x) / f32(pass_info.width);
    let y = (f32(pixel / pass_info.width) + jitter.y) / f32(pass_info.height);
    return normalize(pass_info.forward + (2.0 * x - 1.0) * pass_info.right + (1.0 - 2.0 * y) * pass_info.up);
}
