//! OpenEXR files: linear radiance, float32, W/(m² sr) per band.
//!
//! One part holds everything. The whole image is R G B without a prefix, so that any reader finds it; the layers
//! are `emission.R` … by the naming convention of the OpenEXR documentation ("Layers and channel names"), which
//! viewers and compositors show as layers. Multi-part files say the same, but older readers see the first part only.
//! Bands for who measures are `S0.550,000000nm` …, W/(m² sr nm): Fichet et al. 2021, An OpenEXR Layout for Spectral Images.

use super::atomic::write_atomically;
use crate::backend::guarded;
use crate::error::{Error, Result};
use crate::film::{Image, Layer, Monochrome, Picture};
use crate::host::{files, memory};
use crate::spectrum::{from_rgb, to_rgb};
use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::attribute::LevelMode;
use exr::meta::header::Header;
use exr::prelude as e;
use exr::prelude::{ReadChannels as _, ReadLayers as _, WritableImage as _};
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

/// Channels of an image.
const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// Bytes that one byte of a file can stand for at most: deflate reaches 1032, the other codecs less. A header that
/// promises more is broken, and must not decide how much memory is asked for.
const EXPANSION_MAX: u64 = 1032;
/// Bytes of memory for a pixel of an image that is read and compared: itself in f32, and its error in f64.
const MEMORY_PER_PIXEL: u64 = (size_of::<crate::spectrum::Bands>() + size_of::<f64>()) as u64;
/// Room for an image that is tiny or empty of anything but its header.
const EXPANSION_SLACK: u64 = 1 << 20;

/// Write a picture, whole and by layer. `comment` says how it was made; it is free text.
pub fn write_picture(path: &Path, picture: &Picture, comment: &str) -> Result<()> {
    write_measured(path, picture, &[], comment)
}

/// Likewise, with what was measured at wavelengths  \[E53\]: images of its size.
pub fn write_measured(path: &Path, picture: &Picture, measured: &[Monochrome], comment: &str) -> Result<()> {
    let mut channels = channels_of("", &picture.whole);
    for (layer, image) in Layer::ALL.iter().zip(&picture.layers) {
        assert_eq!((image.width, image.height), (picture.whole.width, picture.whole.height), "layers fit");
        channels.extend(channels_of(&format!("{}.", layer.name()), image));
    }
    for (layer, image) in &picture.unresolved {
        channels.extend(channels_of(&format!("{}{UNRESOLVED}", layer.name()), image));
    }
    let width = picture.whole.width as usize;
    for Monochrome { lambda, pixels } in measured {
        assert_eq!(pixels.len(), picture.whole.pixels.len(), "bands fit");
        channels.push(channel(&wavelength_name(*lambda), Samples { values: Values::Alone(pixels), width }));
    }
    let attributes = if measured.is_empty() { [None, None] } else { SPECTRAL.map(Some) };
    write(path, &picture.whole, channels, attributes, comment)
}

/// Channel of unpolarised light at a wavelength, nm: Stokes parameter 0, a comma before six digits.
fn wavelength_name(lambda: f64) -> String {
    format!("S0.{}nm", format!("{lambda:.6}").replace('.', ","))
}

/// What a file of such channels says of itself.
const SPECTRAL: [(&str, &str); 2] =
    [("spectralLayoutVersion", "1.0"), ("emissiveUnits", "W.m^-2.sr^-1.nm^-1")];

/// What a layer as the passes found it has after its name.
const UNRESOLVED: &str = "_unresolved.";

/// Write one image without layers.
pub fn write_image(path: &Path, image: &Image, comment: &str) -> Result<()> {
    write(path, image, channels_of("", image), [None, None], comment)
}

/// Values of a channel, written from where they are.
#[derive(Clone, Copy)]
struct Samples<'a> {
    values: Values<'a>,
    width: usize,
}

/// Where they are.
#[derive(Clone, Copy)]
enum Values<'a> {
    /// In an image, which of red, green and blue they are.
    Of(&'a Image, usize),
    /// By themselves.
    Alone(&'a [f32]),
}

impl<'a> WritableSamples<'a> for Samples<'_> {
    type Writer = Samples<'a>;

    fn sample_type(&self) -> e::SampleType {
        e::SampleType::F32
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'a self, _: &Header) -> Self::Writer {
        *self
    }
}

impl SamplesWriter for Samples<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let at = line.location.position;
        let first = at.y() * self.width + at.x();
        let written = match self.values {
            Values::Of(image, band) => line.write_samples(|x| to_rgb(&image.pixels[first + x])[band]),
            Values::Alone(values) => line.write_samples(|x| values[first + x]),
        };
        written.expect("a line is as long as its bytes");
    }
}

fn channels_of<'a>(prefix: &str, image: &'a Image) -> Vec<e::AnyChannel<Samples<'a>>> {
    let samples = |band| Samples { values: Values::Of(image, band), width: image.width as usize };
    let channel = |(band, name): (usize, &&str)| channel(&format!("{prefix}{name}"), samples(band));
    CHANNELS.iter().enumerate().map(channel).collect()
}

fn channel<'a>(name: &str, sample_data: Samples<'a>) -> e::AnyChannel<Samples<'a>> {
    e::AnyChannel {
        name: name.into(),
        sample_data,
        // A hint for lossy codecs; the default is guessed from the name and would differ between layers.
        quantize_linearly: false,
        sampling: e::Vec2(1, 1),
    }
}

fn write(
    path: &Path,
    size: &Image,
    channels: Vec<e::AnyChannel<Samples<'_>>>,
    [of_file, of_layer]: [Option<(&str, &str)>; 2],
    comment: &str,
) -> Result<()> {
    if size.pixels.is_empty() {
        return Err(Error::io(path, "write", "the image has no pixels"));
    }
    // Text in EXR is bytes of no stated encoding; ASCII is what every reader shows alike.
    let text = |s: &str| e::Text::new_or_none(s.replace(|c: char| !c.is_ascii() || c == '\0', "?"));
    let attribute =
        |(name, value): (&str, &str)| (e::Text::from(name), e::AttributeValue::Text(value.into()));
    let attributes = e::LayerAttributes {
        software_name: text(concat!("joton ", env!("CARGO_PKG_VERSION"))),
        comments: if comment.is_empty() { None } else { text(comment) },
        // maps of one entry have one order
        other: of_layer.into_iter().map(attribute).collect(),
        ..Default::default()
    };
    let encoding = e::Encoding {
        // Lossless, and what all readers have. 16 rows together compress better than one.
        compression: e::Compression::ZIP16,
        blocks: e::Blocks::ScanLines,
        line_order: e::LineOrder::Increasing,
    };
    let layer = e::Layer::new(
        (size.width as usize, size.height as usize),
        attributes,
        encoding,
        e::AnyChannels::sort(channels.into()),
    );
    let mut file = e::Image::from_layer(layer);
    file.attributes.other.extend(of_file.map(attribute));
    write_atomically(path, |sink| file.write().non_parallel().to_buffered(sink).map_err(|x| x.to_string()))
}

/// Read the R G B of an EXR file (half, float or uint), from its first part that has them; alpha and other
/// channels are left aside.
pub fn read_image(path: &Path) -> Result<Image> {
    let (file, meta) = files::open(path)?;
    read_from(file, meta.len()).map_err(|what| Error::io(path, "read", what))
}

/// Likewise from a reader of so many bytes.
fn read_from(file: impl Read + Seek, length: u64) -> Result<Image, String> {
    let mut reader = BufReader::new(Patient(file));
    check_header(&mut reader, length, memory::available())?;
    reader.rewind().map_err(|x| x.to_string())?;
    let reading = e::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Image::new(size.width() as u32, size.height() as u32),
            |image: &mut Image, at, (r, g, b): (f32, f32, f32)| {
                let pixel = at.y() * image.width as usize + at.x();
                image.pixels[pixel] = from_rgb([r, g, b]);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel();
    // of some damage the decoder panics
    let image = guarded(|| reading.from_buffered(reader).map_err(|x| x.to_string())).and_then(|read| read);
    let image = image.map_err(|what| format!("it is cut or damaged ({what}); write it anew"))?;
    Ok(image.layer_data.channel_data.pixels)
}

/// Asks again where the system was interrupted: the decoder forgets a byte then.
struct Patient<R>(R);

impl<R: Read> Read for Patient<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.0.read(into) {
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                done => return done,
            }
        }
    }
}

impl<R: Seek> Seek for Patient<R> {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

/// Refuse what cannot be read before any pixel is: with the reason in words that help.
fn check_header(
    reader: &mut BufReader<impl Read + Seek>,
    length: u64,
    memory_left: Option<u64>,
) -> Result<(), String> {
    let meta = guarded(|| exr::meta::MetaData::read_from_buffered(reader, false).map_err(|x| x.to_string()));
    let unreadable = |what| format!("it is not a readable OpenEXR file ({what}); name one that is whole");
    let meta = meta.and_then(|read| read).map_err(unreadable)?;
    let has_rgb = |header: &exr::meta::header::Header| {
        !header.deep
            && CHANNELS.iter().all(|c| header.channels.find_index_of_channel(&e::Text::from(*c)).is_some())
    };
    let Some(header) = meta.headers.iter().find(|header| has_rgb(header)) else {
        let names: Vec<String> = meta
            .headers
            .iter()
            .flat_map(|h| &h.channels.list)
            .map(|channel| channel.name.to_string())
            .collect();
        return Err(format!("no part of it has the channels R, G and B; it has {}", names.join(", ")));
    };
    if header.channels.list.iter().any(|channel| channel.sampling != e::Vec2(1, 1)) {
        return Err("its channels are subsampled; save it with full resolution in R, G and B".into());
    }
    let [width, height] = [header.layer_size.width() as u64, header.layer_size.height() as u64];
    let pixels = width.saturating_mul(height);
    if pixels.saturating_mul(header.channels.bytes_per_pixel as u64)
        > length.saturating_mul(EXPANSION_MAX).saturating_add(EXPANSION_SLACK)
    {
        return Err(format!(
            "its header promises {width}x{height} pixels, more than {length} bytes can hold"
        ));
    }
    let need = pixels.saturating_mul(MEMORY_PER_PIXEL);
    if memory_left.is_some_and(|left| need > left) {
        let left = memory_left.unwrap_or(0);
        return Err(format!("{width}x{height} pixels take {need} bytes of memory, {left} are left"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// A system that gives a few bytes at a time, and is interrupted, gives the same picture; a file that ends early, wherever that is, none.
    #[test]
    fn short_reads_are_gone_on_with_and_short_files_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.exr");
        let mut image = Image::new(9, 5);
        for (i, band) in image.pixels.as_flattened_mut().iter_mut().enumerate() {
            *band = i as f32;
        }
        write_image(&path, &image, "numbers").expect("written");
        let bytes = std::fs::read(&path).expect("a file");
        let length = bytes.len() as u64;
        let stuttering =
            |length: usize| files::Stuttering { reader: Cursor::new(&bytes[..length]), reads: 0 };
        let found = read_from(stuttering(bytes.len()), length).expect("read");
        assert_eq!(found.pixels, image.pixels);
        for cut in 0..bytes.len() {
            let e = read_from(stuttering(cut), length).expect_err("it is cut");
            assert!(e.contains("whole") || e.contains("write it anew"), "{cut} bytes: {e}");
        }
    }
}
