//! PNG files: 8-bit sRGB, dithered, from linear radiance through the display transform.

use super::atomic::write_atomically;
use super::display::Display;
use crate::error::{Error, Result};
use crate::film::Image;
use std::path::Path;

/// Write an image as it is shown by `display`.
pub fn write_image(path: &Path, image: &Image, display: &Display) -> Result<()> {
    write_srgb(path, image.width, image.height, &quantise(image.width, &display.apply(image)))
}

/// Write rows of 8-bit sRGB-encoded pixels.
pub(super) fn write_srgb(path: &Path, width: u32, height: u32, pixels: &[[u8; 3]]) -> Result<()> {
    if pixels.is_empty() {
        return Err(Error::io(path, "write", "the image has no pixels"));
    }
    write_atomically(path, |sink| {
        let mut encoder = png::Encoder::new(sink, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let software = concat!("joton ", env!("CARGO_PKG_VERSION"));
        encoder.add_text_chunk("Software".into(), software.into()).map_err(|x| x.to_string())?;
        let mut writer = encoder.write_header().map_err(|x| x.to_string())?;
        writer.write_image_data(pixels.as_flattened()).map_err(|x| x.to_string())?;
        writer.finish().map_err(|x| x.to_string())
    })
}

/// Screen values 0 … 1 to 0 … 255, row by row. Rounded up or down by a fixed pattern whose mean is right: smooth
/// gradients show no bands, and black and white stay exact.
pub fn quantise(width: u32, pixels: &[[f32; 3]]) -> Vec<[u8; 3]> {
    (0u32..)
        .zip(pixels)
        .map(|(i, pixel)| {
            let threshold = interleaved_gradient_noise(i % width.max(1), i / width.max(1));
            pixel.map(|v| (f64::from(v.clamp(0.0, 1.0)) * 255.0 + threshold).floor() as u8)
        })
        .collect()
}

/// A value in [0, 1) for each pixel; every 3×3 neighbourhood spreads evenly over that range.
/// Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014.
fn interleaved_gradient_noise(x: u32, y: u32) -> f64 {
    let phase = (0.067_110_56 * f64::from(x) + 0.005_837_15 * f64::from(y)).fract();
    (52.982_918_9 * phase).fract()
}
