//! Bands: the colour channels that light is carried in.
//!
//! Three linear bands (r, g, b) today. Only the image file and the display may assume three;
//! everything else goes through [`Bands`] and [`BANDS`].

/// Number of bands that light is carried in.
pub const BANDS: usize = 3;

/// One value per band (radiance, flux, reflectance: the name of the variable says which).
pub type Bands = [f32; BANDS];

/// No light in any band.
pub const BLACK: Bands = [0.0; BANDS];

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
