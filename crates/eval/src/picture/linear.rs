//! Linear pictures from EXR files, for those who read numbers off them.

use std::io::Cursor;

use image::{ImageFormat, ImageReader, Limits};

/// A picture's linear red, green and blue, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearPicture {
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
    /// As many as both make; whatever the file holds, infinities and NaN too.
    pub pixels: Vec<[f32; 3]>,
}

/// Why bytes are no linear picture.
#[derive(Debug, thiserror::Error)]
pub enum LinearPictureError {
    /// Another format.
    #[error("this is no EXR file")]
    Kind,
    /// Broken, or too large.
    #[error("the picture cannot be read: {0}")]
    Image(#[from] image::ImageError),
}

/// The numbers of an EXR file of at most so many pixels a side.
///
/// # Error
/// Other formats, broken files and larger pictures, which are told by their head.
pub fn decode_exr(bytes: &[u8], most_px: u32) -> Result<LinearPicture, LinearPictureError> {
    if !matches!(image::guess_format(bytes), Ok(ImageFormat::OpenExr)) {
        return Err(LinearPictureError::Kind);
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::OpenExr);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(most_px), Some(most_px));
    reader.limits(limits);
    let picture = reader.decode()?.into_rgb32f();
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Ok(LinearPicture { width, height, pixels: picture.pixels().map(|pixel| pixel.0).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_is_read_as_it_is_and_nothing_else_is() {
        let numbers = vec![0.5f32, -1.0, 2.0, f32::INFINITY, 8.0, 16.0];
        let picture = image::Rgb32FImage::from_raw(2, 1, numbers).unwrap();
        let mut bytes = Vec::new();
        picture.write_to(&mut Cursor::new(&mut bytes), ImageFormat::OpenExr).unwrap();
        let read = decode_exr(&bytes, 2).unwrap();
        assert_eq!((read.width, read.height), (2, 1));
        assert_eq!(read.pixels, [[0.5, -1.0, 2.0], [f32::INFINITY, 8.0, 16.0]]);
        assert!(matches!(decode_exr(&bytes, 1), Err(LinearPictureError::Image(_))));
        assert!(decode_exr(&bytes[..bytes.len() / 2], 2).is_err());
        assert!(matches!(decode_exr(b"no picture", 2), Err(LinearPictureError::Kind)));
    }
}
