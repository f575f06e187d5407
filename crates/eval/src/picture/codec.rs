//! PNG and EXR codecs, and decoding of environment maps.

use std::error::Error as _;
use std::io::{Cursor, ErrorKind};

use brood_light::{EnvironmentError, EnvironmentMap};
use exr::meta::BlockDescription;
use exr::meta::MetaData;
use exr::meta::header::Header;
use image::error::DecodingError;
use image::{ImageBuffer, ImageError, ImageFormat, ImageReader, Limits, Rgba};

use crate::RadianceImage;

/// Error of a picture that cannot be encoded or decoded.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The bytes are not a PNG, or a broken one.
    #[error("the PNG cannot be read: {0}")]
    Png(#[from] png::DecodingError),
    /// The PNG is not of the kind that [`encode_png`] writes.
    #[error("the PNG must have 8-bit RGBA pixels")]
    Kind,
    /// The EXR encoder failed.
    #[error("the picture cannot be encoded as EXR: {0}")]
    Exr(#[from] ImageError),
}

/// Most bytes of the header of a Radiance HDR file.
const HDR_HEADER_BYTES: usize = 64 << 10;

/// Most bytes of the pixels that an EXR file stores together, with all their channels. Four
/// channels of 8192 pixels in 256 lines take 32 MiB.
const EXR_BLOCK_BYTES: u64 = 64 << 20;

/// Checks what the decoders do not bound: the header of a Radiance HDR file, of which every line is
/// kept, and the blocks of an EXR file, which are decoded with all channels.
///
/// # Errors
/// Returns a decoding error if an empty line is missing from the first 64 KiB of an HDR file, or a
/// block takes more than 64 MiB.
pub(super) fn check_header(bytes: &[u8], format: ImageFormat) -> Result<(), ImageError> {
    let refuse =
        |reason: String| Err(ImageError::Decoding(DecodingError::new(format.into(), reason)));
    match format {
        ImageFormat::Hdr => {
            let head = &bytes[..bytes.len().min(HDR_HEADER_BYTES)];
            if head.windows(2).any(|two| two == b"\n\n") {
                return Ok(());
            }
            refuse("the header must end with an empty line within 64 KiB".to_owned())
        }
        ImageFormat::OpenExr => match MetaData::read_from_buffered(bytes, false) {
            Err(error) => refuse(error.to_string()),
            Ok(meta) if meta.headers.iter().all(|part| block_bytes(part) <= EXR_BLOCK_BYTES) => {
                Ok(())
            }
            Ok(_) => {
                refuse("a block of pixels with all channels takes more than 64 MiB".to_owned())
            }
        },
        _ => Ok(()),
    }
}

/// Returns the words of a decoder, without the name of the format, which the sender knows.
pub(super) fn image_words(error: &ImageError) -> String {
    match error {
        ImageError::IoError(error) if error.kind() == ErrorKind::UnexpectedEof => {
            "the file ends early".to_owned()
        }
        ImageError::Decoding(decoding) => {
            decoding.source().map_or_else(|| decoding.to_string(), ToString::to_string)
        }
        other => other.to_string(),
    }
}

/// Bytes of a block of an EXR file.
fn block_bytes(part: &Header) -> u64 {
    let pixels = match part.blocks {
        BlockDescription::Tiles(tiles) => [tiles.tile_size.width(), tiles.tile_size.height()],
        BlockDescription::ScanLines => {
            [part.compression.scan_lines_per_block(), part.layer_size.width()]
        }
    };
    let factors = pixels.into_iter().chain([part.channels.bytes_per_pixel]);
    factors.fold(1, |product: u64, factor| product.saturating_mul(factor as u64))
}

/// Error of bytes that cannot be read as an environment map.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentFileError {
    /// The file is neither a Radiance HDR nor an EXR file.
    #[error("the picture of an environment must be a Radiance HDR or EXR file")]
    Kind,
    /// The file is broken or too large.
    #[error("the picture of the environment cannot be read: {}", image_words(.0))]
    Image(#[from] ImageError),
    /// The pixels are not a valid environment.
    #[error(transparent)]
    Environment(#[from] EnvironmentError),
}

/// Decodes an environment map from the bytes of a Radiance HDR or EXR file.
///
/// # Units
/// Those of the file: linear red, green and blue with the primaries of sRGB.
///
/// # Domain
/// At most 8192 x 8192 pixels. Negative numbers and NaN become 0, infinity becomes the largest
/// number.
///
/// # Errors
/// Returns an [`EnvironmentFileError`] for other formats, broken files and invalid environments.
pub fn decode_environment(bytes: &[u8]) -> Result<EnvironmentMap, EnvironmentFileError> {
    let format = image::guess_format(bytes).map_err(|_| EnvironmentFileError::Kind)?;
    if !matches!(format, ImageFormat::Hdr | ImageFormat::OpenExr) {
        return Err(EnvironmentFileError::Kind);
    }
    check_header(bytes, format)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(8192), Some(8192));
    reader.limits(limits);
    let picture = reader.decode()?.into_rgb32f();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    // NaN is not above 0.
    let radiance = |value: f32| if value > 0.0 { value.min(f32::MAX) } else { 0.0 };
    let pixels = picture.pixels().map(|pixel| pixel.0.map(radiance)).collect();
    drop(picture);
    Ok(EnvironmentMap::new(width, height, pixels)?)
}

/// Encodes an 8-bit sRGB PNG with alpha. The same pixels give the same bytes.
///
/// # Panics
/// If `rgba` is not `4 * width * height` long.
#[must_use]
pub fn encode_png(width: u32, height: u32, rgba: &[u8]) -> Vec<u8> {
    encode(width, height, &[rgba], None)
}

/// Encodes an endless animated PNG of 8-bit sRGB frames, each shown for `delay_ms`. The same pixels
/// give the same bytes.
///
/// # Panics
/// If there is no frame, or one is not `4 * width * height` long.
#[must_use]
pub fn encode_apng(width: u32, height: u32, frames: &[Vec<u8>], delay_ms: u16) -> Vec<u8> {
    encode(width, height, frames, Some(delay_ms))
}

fn encode(width: u32, height: u32, frames: &[impl AsRef<[u8]>], delay_ms: Option<u16>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(frames.first().map_or(0, |f| f.as_ref().len() / 2));
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    // Fast with the Up filter: 10 to 30 times the speed of the balanced setting at 1.5 times the
    // bytes.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Up);
    if let Some(delay_ms) = delay_ms {
        let count = u32::try_from(frames.len()).expect("an animation has few frames");
        encoder.set_animated(count, 0).expect("there is a frame");
        encoder.set_frame_delay(delay_ms, 1000).expect("it is animated");
        // Each frame replaces the one before, alpha included.
        encoder.set_blend_op(png::BlendOp::Source).expect("it is animated");
    }
    let mut writer = encoder.write_header().expect("writing to memory does not fail");
    for frame in frames {
        writer.write_image_data(frame.as_ref()).expect("rgba is 4 * width * height long");
    }
    writer.finish().expect("writing to memory does not fail");
    bytes
}

/// Decodes a PNG that [`encode_png`] wrote and returns width, height and RGBA.
///
/// # Errors
/// Returns [`PictureError::Png`] if the PNG cannot be read, [`PictureError::Kind`] if it is not
/// 8-bit RGBA.
pub fn decode_png(bytes: &[u8]) -> Result<(u32, u32, Vec<u8>), PictureError> {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info()?;
    let (color, depth) = reader.output_color_type();
    if (color, depth) != (png::ColorType::Rgba, png::BitDepth::Eight) {
        return Err(PictureError::Kind);
    }
    let mut rgba = vec![0; reader.output_buffer_size().ok_or(PictureError::Kind)?];
    let info = reader.next_frame(&mut rgba)?;
    rgba.truncate(info.buffer_size());
    Ok((info.width, info.height, rgba))
}

/// Encodes linear radiance as 32-bit float EXR, colour premultiplied by alpha as the format
/// requires.
///
/// # Errors
/// Returns [`PictureError::Exr`] if the encoder fails.
pub fn encode_exr(image: &RadianceImage) -> Result<Vec<u8>, PictureError> {
    let pixels = image.premultiplied().iter().zip(image.coverage());
    let samples: Vec<f32> =
        pixels.flat_map(|([red, green, blue], alpha)| [*red, *green, *blue, *alpha]).collect();
    let buffer = ImageBuffer::<Rgba<f32>, _>::from_raw(image.width(), image.height(), samples)
        .expect("one radiance for each pixel");
    let mut bytes = Cursor::new(Vec::new());
    image::DynamicImage::ImageRgba32F(buffer).write_to(&mut bytes, ImageFormat::OpenExr)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_round_trips_to_the_same_pixels() {
        let rgba: Vec<u8> = (0..4 * 7 * 5).map(|k| (k * 37 % 256) as u8).collect();
        let bytes = encode_png(7, 5, &rgba);
        assert_eq!(decode_png(&bytes).unwrap(), (7, 5, rgba));
        assert!(decode_png(&bytes[..40]).is_err());
    }

    #[test]
    fn animated_png_stores_its_frames_and_their_delay() {
        let frames: Vec<Vec<u8>> = (0..3u32)
            .map(|k| (0..4 * 6 * 2).map(|at| ((at * 37 + k * 91) % 256) as u8).collect())
            .collect();
        let bytes = encode_apng(6, 2, &frames, 125);
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
        let control = reader.info().animation_control().copied().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
        for frame in &frames {
            let mut rgba = vec![0; 4 * 6 * 2];
            reader.next_frame(&mut rgba).unwrap();
            assert_eq!(rgba, *frame);
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (125, 1000));
        }
    }

    #[test]
    fn environment_is_decoded_from_exr_and_hdr_only() {
        let pixels = vec![0.5f32, 1.0, 2.0, 4.0, 8.0, 16.0];
        let picture = image::Rgb32FImage::from_raw(2, 1, pixels).unwrap();
        for format in [ImageFormat::OpenExr, ImageFormat::Hdr] {
            let mut bytes = Vec::new();
            picture.write_to(&mut Cursor::new(&mut bytes), format).unwrap();
            let map = decode_environment(&bytes).unwrap();
            // The left half of the picture is to the left when looking along -z.
            assert_eq!(map.radiance(glam::DVec3::NEG_X), [0.5, 1.0, 2.0]);
            assert_eq!(map.radiance(glam::DVec3::X), [4.0, 8.0, 16.0]);
            for length in [bytes.len() / 2, bytes.len() - 1] {
                let error = decode_environment(&bytes[..length]).unwrap_err().to_string();
                let words = error.strip_prefix("the picture of the environment cannot be read: ");
                let known = [
                    "the file ends early",
                    "the header must end with an empty line within 64 KiB",
                    "invalid: reference to missing bytes",
                ];
                assert!(words.is_some_and(|words| known.contains(&words)), "{error}");
            }
        }
        let png = encode_png(1, 1, &[0; 4]);
        assert!(matches!(decode_environment(&png), Err(EnvironmentFileError::Kind)));
        assert!(matches!(decode_environment(b""), Err(EnvironmentFileError::Kind)));
    }

    #[test]
    fn exr_file_with_thousands_of_channels_is_refused() {
        // Blocks of 16 lines of 1024 pixels: 72 MiB. The pixels are missing.
        let mut bytes = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            let length = u32::try_from(value.len()).unwrap().to_le_bytes();
            bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &length, value].concat());
        };
        let channel =
            |name: String| [name.as_bytes(), b"\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0"].concat();
        let names = ["B", "G", "R"].map(str::to_owned).into_iter();
        let names = names.chain((0..1150).map(|number| format!("c{number:04}")));
        let channels = [names.flat_map(channel).collect(), vec![0]].concat();
        let window = [0_i32, 0, 1023, 15].map(i32::to_le_bytes).concat();
        attribute("channels", "chlist", &channels);
        attribute("compression", "compression", &[3]);
        attribute("dataWindow", "box2i", &window);
        attribute("displayWindow", "box2i", &window);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1_f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1_f32.to_le_bytes());
        bytes.push(0);
        let refused = [
            decode_environment(&bytes).unwrap_err().to_string(),
            crate::decode_linear(&bytes, 1024).unwrap_err().to_string(),
            crate::picture_size(&bytes).unwrap_err().to_string(),
        ];
        for error in refused {
            assert!(error.contains("takes more than 64 MiB"), "{error}");
        }
    }

    #[test]
    fn hdr_header_without_an_end_is_refused() {
        let mut bytes = b"#?RADIANCE\n".to_vec();
        bytes.extend(b"KEY=value\n".repeat(1 << 20));
        let error = decode_environment(&bytes).unwrap_err().to_string();
        assert!(error.contains("within 64 KiB"), "{error}");
        let error = crate::picture_size(&bytes).unwrap_err().to_string();
        assert!(error.contains("within 64 KiB"), "{error}");
    }
}
