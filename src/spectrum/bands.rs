//! Bands: the colour channels that light is carried in.
//!
//! Three linear bands (r, g, b) today. Only this file knows how many: image files, scene files and the display go through
//! [`from_rgb`] and [`to_rgb`], everything else through [`Bands`] and [`BANDS`], the kernels through what [`wgsl`] declares.

/// Number of bands that light is carried in.
pub const BANDS: usize = 3;

/// Their names, as files call them.
pub const NAMES: [&str; BANDS] = ["r", "g", "b"];

/// One value per band (radiance, flux, reflectance: the name of the variable says which).
pub type Bands = [f32; BANDS];

/// No light in any band.
pub const BLACK: Bands = [0.0; BANDS];

/// Linear red, green and blue of a file as bands.
pub fn from_rgb(rgb: [f32; 3]) -> Bands {
    rgb
}

/// Bands as linear red, green and blue, for image files and the display.
pub fn to_rgb(bands: &Bands) -> [f32; 3] {
    *bands
}

/// Sum over the bands, in f64.
pub fn sum(b: &Bands) -> f64 {
    b.iter().map(|&x| f64::from(x)).sum()
}

/// Largest band.
pub fn max(b: &Bands) -> f32 {
    b.iter().copied().fold(f32::NEG_INFINITY, f32::max)
}

/// Element-wise product.
pub fn mul(a: &Bands, b: &Bands) -> Bands {
    std::array::from_fn(|i| a[i] * b[i])
}

/// Every band times `s`.
pub fn scale(a: &Bands, s: f32) -> Bands {
    std::array::from_fn(|i| a[i] * s)
}

/// Element-wise sum.
pub fn add(a: &Bands, b: &Bands) -> Bands {
    std::array::from_fn(|i| a[i] + b[i])
}

/// True where no band carries anything.
pub fn is_black(b: &Bands) -> bool {
    b.iter().all(|&x| x <= 0.0)
}

/// The type of bands in WGSL, a vector, and what else depends on how many there are: the largest, and the way into a vector of
/// four, as films are, and back.
pub fn wgsl() -> String {
    let names = &["b.x", "b.y", "b.z", "b.w"][..BANDS];
    let zeros = ", 0.0".repeat(4 - BANDS);
    let all = &"xyzw"[..BANDS];
    let largest = names[1..].iter().fold(names[0].to_string(), |so_far, b| format!("max({so_far}, {b})"));
    format!(
        "alias Bands = vec{BANDS}<f32>;\n\
         const BANDS: u32 = {BANDS}u;\n\
         fn max_band(b: Bands) -> f32 {{ return {largest}; }}\n\
         fn four_of_bands(b: Bands) -> vec4<f32> {{ return vec4(b{zeros}); }}\n\
         fn bands_of_four(v: vec4<f32>) -> Bands {{ return v.{all}; }}\n"
    )
}
