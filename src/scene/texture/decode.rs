//! Decode: from a picture file to its texels. PNG, JPEG, BMP, TGA, Radiance HDR and OpenEXR.

use super::{Bitmap, PictureFile, Texels, f16};
use crate::host::guard::guarded;
use crate::host::{files, memory};
use crate::{Error, Result};
use exr::prelude as e;
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

/// Texels across and down, at most.
const SIDE_MOST: u32 = 16_384;
/// Bytes of memory that a texel takes while it is read, at most: as the file has it, and as it is kept …
const MEMORY_PER_TEXEL: u64 = 32;
/// … where it has 8 bits a channel.
const MEMORY_PER_TEXEL_OF_BYTES: u64 = 12;
/// What a file begins with that is OpenEXR.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// A picture as its file has it.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    pub(super) bitmap: Arc<Bitmap>,
    /// Some of it is outside of the range from 0 to 1.
    pub(super) is_wide: bool,
    /// Its half floats are numbers of a file of 16 bits, which may be encoded as those of 8 bits are.
    pub(super) may_be_encoded: bool,
}

/// Reads a picture.
///
/// # Errors
/// [`Error::Io`] where it cannot be read, is no picture, or is too large.
pub(super) fn read(path: &Path) -> Result<Picture> {
    let bytes = files::read(path)?;
    let fail = |what: String| Error::io(path, "read", what);
    let check = |[width, height]: [u32; 2], texel: u64| {
        if width == 0 || height == 0 || width.max(height) > SIDE_MOST {
            let what = format!("it has {width} × {height} texels; make it 1 to {SIDE_MOST} across and down");
            return Err(fail(what));
        }
        let need = u64::from(width) * u64::from(height) * texel;
        match memory::allowed() {
            Some(left) if need > left => Err(fail(format!(
                "its {width} × {height} texels take {need} bytes of memory, {left} are left; make it smaller, free some or \
                 allow more (--memory)"
            ))),
            _ => Ok(()),
        }
    };
    let mut picture = if bytes.starts_with(&EXR_MAGIC) {
        check(exr_size(&bytes).map_err(fail)?, MEMORY_PER_TEXEL)?;
        exr(&bytes).map_err(fail)?
    } else {
        let mut decoder = Decoder::of(path, &bytes).map_err(fail)?;
        check(decoder.size, if decoder.is_of_bytes { MEMORY_PER_TEXEL_OF_BYTES } else { MEMORY_PER_TEXEL })?;
        kept(decoder.decode().map_err(fail)?)
    };
    // nobody else has it yet
    let bitmap = Arc::make_mut(&mut picture.bitmap);
    bitmap.file = Some(Arc::new(PictureFile { path: path.to_owned(), size: bitmap.size }));
    Ok(picture)
}

/// Says why a picture cannot be read, and what to do.
fn unreadable(what: &str) -> String {
    format!("it is no picture that can be read ({what}); give PNG, JPEG, BMP, TGA, HDR or EXR")
}

/// A decoder of the crate `image`, which knows how large the picture is before it reads it.
struct Decoder<'a> {
    size: [u32; 2],
    /// Each channel has 8 bits.
    is_of_bytes: bool,
    decode: Option<Box<dyn FnOnce() -> Result<DynamicImage, String> + 'a>>,
}

impl<'a> Decoder<'a> {
    fn of(path: &Path, bytes: &'a [u8]) -> Result<Self, String> {
        // TGA has no mark to know it by
        let format = image::guess_format(bytes).or_else(|_| ImageFormat::from_path(path));
        let format = format.map_err(|e| unreadable(&e.to_string()))?;
        let made = guarded(move || {
            let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
            let mut limits = Limits::default();
            // a side that is too long is refused by its size
            limits.max_alloc = Some(u64::from(SIDE_MOST) * u64::from(SIDE_MOST) * MEMORY_PER_TEXEL);
            reader.limits(limits);
            reader.into_decoder().map_err(|e| unreadable(&e.to_string())).map(|decoder| {
                let (width, height) = decoder.dimensions();
                let colour = decoder.color_type();
                let is_of_bytes = colour.bytes_per_pixel() == colour.channel_count();
                let decode =
                    move || DynamicImage::from_decoder(decoder).map_err(|e| unreadable(&e.to_string()));
                Decoder { size: [width, height], is_of_bytes, decode: Some(Box::new(decode)) }
            })
        });
        made.map_err(|words| unreadable(&words))?
    }

    fn decode(&mut self) -> Result<DynamicImage, String> {
        let decode = self.decode.take().ok_or_else(|| unreadable("it was read before"))?;
        guarded(decode).map_err(|words| unreadable(&words))?
    }
}

/// Texels as they are kept: bytes as bytes, what is finer in half floats.
fn kept(image: DynamicImage) -> Picture {
    let size = [image.width(), image.height()];
    let of = |texels, is_wide, may_be_encoded| Picture {
        bitmap: Arc::new(Bitmap::new(size, texels)),
        is_wide,
        may_be_encoded,
    };
    let sample = image.color();
    if sample.bytes_per_pixel() == sample.channel_count() {
        let texels = image.into_rgba8().into_raw().as_chunks::<4>().0.to_vec();
        return of(Texels::Bytes(texels), false, false);
    }
    let is_float = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let mut is_wide = false;
    let floats = image.into_rgba32f().into_raw();
    let texels = floats.as_chunks::<4>().0.iter().map(|t| halves(*t, &mut is_wide)).collect();
    of(Texels::Halves(texels), is_wide, !is_float)
}

/// A texel in half floats, from 0 on.
fn halves(texel: [f32; 4], is_wide: &mut bool) -> [f16; 4] {
    texel.map(|x| {
        // nothing is made of what is no number
        let kept = if x.is_nan() { 0.0 } else { x.clamp(0.0, f32::from(f16::MAX)) };
        *is_wide |= !(0.0..=1.0).contains(&x);
        f16::from_f32(kept)
    })
}

/// How large the first part of an OpenEXR file is that has red, green and blue.
fn exr_size(bytes: &[u8]) -> Result<[u32; 2], String> {
    let read = || exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false);
    let meta = guarded(|| read().map_err(|x| x.to_string())).and_then(|read| read);
    let meta = meta.map_err(|what| unreadable(&what))?;
    let has_rgb = |header: &&exr::meta::header::Header| {
        let has = |c: &str| header.channels.find_index_of_channel(&e::Text::from(c)).is_some();
        !header.deep && ["R", "G", "B"].into_iter().all(has)
    };
    let header =
        meta.headers.iter().find(has_rgb).ok_or("it has no channels R, G and B; save it with these")?;
    if header.channels.list.iter().any(|channel| channel.sampling != e::Vec2(1, 1)) {
        return Err("its channels are subsampled; save it with full resolution in R, G and B".into());
    }
    let side = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
    Ok([side(header.layer_size.width()), side(header.layer_size.height())])
}

fn exr(bytes: &[u8]) -> Result<Picture, String> {
    struct Pixels {
        width: usize,
        texels: Vec<[f16; 4]>,
        is_wide: bool,
    }
    let reading = e::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size: e::Vec2<usize>, _: &_| Pixels {
                width: size.width(),
                texels: vec![[f16::ZERO; 4]; size.area()],
                is_wide: false,
            },
            |pixels: &mut Pixels, at: e::Vec2<usize>, (r, g, b, a): (f32, f32, f32, f32)| {
                let texel = halves([r, g, b, a], &mut pixels.is_wide);
                if let Some(place) = pixels.texels.get_mut(at.y() * pixels.width + at.x()) {
                    *place = texel;
                }
            },
        )
        .first_valid_layer()
        .all_attributes();
    let read = guarded(|| reading.from_buffered(Cursor::new(bytes)).map_err(|x| x.to_string()));
    let image = read.and_then(|read| read).map_err(|what| unreadable(&what))?;
    let size = [image.layer_data.size.width() as u32, image.layer_data.size.height() as u32];
    let pixels = image.layer_data.channel_data.pixels;
    let bitmap = Arc::new(Bitmap::new(size, Texels::Halves(pixels.texels)));
    Ok(Picture { bitmap, is_wide: pixels.is_wide, may_be_encoded: false })
}
