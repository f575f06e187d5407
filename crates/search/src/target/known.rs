//! Pictures of known scenes, read: each with everything that it was made with, and all of them as one target.
//!
//! Owns how bytes of pictures and masks become views, and how views are put together. The same for the command line, the server and its
//! workers. Refuses to know where bytes come from.

use std::sync::Arc;

use brood_eval::{Developed, Gain, LinearPicture, LinearPictureError, decode_linear, picture_size};
use brood_scene::{Exposure, LightAssets, Mesh, Sampling, Scene};

use super::image::{ImageTargetError, ImageView, PixelCounts, PixelFate, View, pooled};
use super::{MeasuredTarget, Samples, TargetError};

/// As pictures that are rendered on the command line.
const SIDE_MOST: u32 = 4096;

/// How a picture was made, and what is to become of it.
#[derive(Debug, Clone)]
pub struct Setting {
    /// How the mesh is seen and lit.
    pub scene: Scene,
    /// What is shown.
    pub mesh: Arc<Mesh>,
    /// What the lights refer to.
    pub assets: LightAssets,
    /// How its pixels were sampled.
    pub sampling: Sampling,
    /// Whether its brightness is not known.
    pub is_gain_unknown: bool,
    /// Whether nothing is fitted to it: it is only compared with what was found.
    pub is_held_out: bool,
}

/// A picture of a known scene.
#[derive(Debug)]
pub struct KnownView {
    /// How it was made.
    pub setting: Setting,
    /// What its pixels say.
    pub view: ImageView,
    /// What the scene's film makes of its radiance.
    pub gain: Gain,
    /// Whether some of its pixels were left out by a mask.
    pub is_masked: bool,
}

/// Why bytes are no picture of their scene.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// No picture.
    #[error(transparent)]
    Picture(LinearPictureError),
    /// No picture either.
    #[error("the mask cannot be read: {0}")]
    Mask(LinearPictureError),
    /// More than is looked at.
    #[error("a picture has at most {SIDE_MOST} x {SIDE_MOST} pixels; this one has {0} x {1}")]
    Large(u32, u32),
    /// A picture, but none that a material can be told from.
    #[error(transparent)]
    Target(#[from] ImageTargetError),
}

impl KnownView {
    /// Most pixels of a side.
    pub const SIDE_MOST: u32 = SIDE_MOST;

    /// Reads a picture and its mask; also what the material reflects at the pixels that say something of it.
    pub fn read(
        setting: Setting,
        picture: &[u8],
        mask: Option<&[u8]>,
    ) -> Result<(Self, Samples), ViewError> {
        let (width, height) = picture_size(picture).map_err(ViewError::Picture)?;
        if width.max(height) > SIDE_MOST {
            return Err(ViewError::Large(width, height));
        }
        let picture = decode_linear(picture, SIDE_MOST).map_err(ViewError::Picture)?;
        let mask = mask.map(|mask| decode_linear(mask, SIDE_MOST)).transpose();
        let mask = mask.map_err(ViewError::Mask)?;
        let view = View {
            mesh: &setting.mesh,
            scene: &setting.scene,
            assets: &setting.assets,
            sampling: setting.sampling,
            picture: &picture,
            mask: mask.as_ref(),
            is_gain_unknown: setting.is_gain_unknown,
        };
        let (view, samples) = ImageView::new(&view)?;
        let gain = gain(&setting.scene, &picture, &view);
        Ok((Self { setting, view, gain, is_masked: mask.is_some() }, samples))
    }

    /// Side in pixels.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.view.set().image().expect("the set is one of a picture").width
    }

    /// The picture as the scene's film shows it.
    #[must_use]
    pub fn shown(&self) -> Developed {
        let side = self.side();
        let pixels = self.view.wanted();
        let rgba = vec![u8::MAX; 4 * pixels.len()];
        let exposure_ev = self.gain.ev;
        let mut shown = Developed { width: side, height: side, rgba, exposure_ev };
        for (pixel, radiance) in pixels.iter().enumerate() {
            #[expect(clippy::cast_possible_truncation, reason = "what is shown has 8 bits")]
            shown.put(pixel, radiance.map(|channel| channel as f32), self.gain);
        }
        shown
    }

    /// Bytes of memory that it takes, about.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.view.set().bytes() + 32 * self.view.wanted().len()
    }
}

/// What the film of a scene makes of a picture's radiance. What was shown already, at an exposure that is not known, is shown as it is.
fn gain(scene: &Scene, picture: &LinearPicture, view: &ImageView) -> Gain {
    let film = scene.film;
    let gain = match film.exposure {
        Exposure::Ev(ev) => Gain::fixed(ev),
        Exposure::Auto if !picture.is_linear => Gain::fixed(0.0),
        Exposure::Auto => {
            let shows =
                |fate: PixelFate| !matches!(fate, PixelFate::Masked | PixelFate::Background);
            let pixels = picture.pixels.iter().zip(view.fates());
            let seen = pixels.filter(|(_, fate)| shows(**fate));
            Gain::automatic(seen.map(|(pixel, _)| pixel[0].max(pixel[1]).max(pixel[2])).collect())
        }
    };
    gain.with_tone(film.tone)
}

/// Pictures of one material.
#[derive(Debug)]
pub struct Pictures {
    /// In the order in which they were given.
    pub views: Vec<KnownView>,
    /// What became of all pixels that could be fitted to.
    pub counts: PixelCounts,
}

/// Why pictures are no target.
#[derive(Debug, thiserror::Error)]
pub enum PicturesError {
    /// One of them is none.
    #[error("{error}")]
    View {
        /// Which, counted from 0.
        index: usize,
        /// Why.
        error: ViewError,
    },
    /// Nothing is left.
    #[error("every picture is held out, and nothing is left to fit")]
    HeldOut,
    /// Too little is left of all of them.
    #[error(transparent)]
    Few(ImageTargetError),
    /// What they show is nothing that could be matched.
    #[error(transparent)]
    Target(#[from] TargetError),
}

impl Pictures {
    /// Puts views together, and says what is fitted and what is held out of those that are not held out as a whole.
    pub fn gather(
        views: impl IntoIterator<Item = Result<(KnownView, Samples), ViewError>>,
    ) -> Result<(Self, MeasuredTarget), PicturesError> {
        let (mut read, mut fitted) = (Vec::new(), Vec::new());
        for (index, view) in views.into_iter().enumerate() {
            let (view, samples) = view.map_err(|error| PicturesError::View { index, error })?;
            if !view.setting.is_held_out {
                fitted.push((index, samples));
            }
            read.push(view);
        }
        if fitted.is_empty() {
            return Err(PicturesError::HeldOut);
        }
        let together = pooled(fitted.iter().map(|(index, samples)| (&read[*index].view, samples)));
        let (samples, counts) = together.map_err(PicturesError::Few)?;
        let target = MeasuredTarget::of_pixels(&samples)?;
        Ok((Self { views: read, counts }, target))
    }

    /// Bytes of memory that they take, about.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.views.iter().map(KnownView::bytes).sum()
    }
}
