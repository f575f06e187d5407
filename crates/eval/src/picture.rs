//! Encoded pictures and contact sheets.

mod codec;
mod linear;
mod sheet;

pub use codec::{
    EnvironmentFileError, PictureError, decode_environment, decode_png, encode_apng, encode_exr,
    encode_png,
};
pub use linear::{
    DisplayPicture, IMAGE_SIDE_MOST, LinearPicture, LinearPictureError, decode_display,
    decode_image, decode_linear, picture_size,
};
pub use sheet::{SheetCell, centre_px, sheet};
