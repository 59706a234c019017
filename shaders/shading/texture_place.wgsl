// Where a texture lies, for texture.wgsl and what stands in its place.

// Texture coordinates of a place on a triangle, and how many units of them a unit of length is, in the mean over directions.
struct TexturePlace {
    uv: vec2<f32>,
    per_unit: f32,
    // How each of them grows along the surface, per unit of length.
    gradient_u: vec3<f32>,
    gradient_v: vec3<f32>,
}
