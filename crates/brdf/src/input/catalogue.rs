//! Catalogue of inputs: their names and numbers.

/// Form of the azimuthal inputs p3..p6, which read the tangential parts of the directions.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Parametrisation {
    /// Tangential parts as they are: polynomial in the directions, without a singularity.
    #[default]
    Smooth,
    /// Normalised tangential parts, as in the paper: pure functions of the azimuths, singular
    /// at the poles.
    Paper,
}

crate::named_enum! {
    /// A scalar that a program may read: of a direction pair, or of a surface point and the lights
    /// around it.
    ///
    /// The inputs up to [`Input::NormalDotHalf`] do not change when wi and wo are exchanged, bit
    /// for bit. The others are read by painted materials only.
    ///
    /// # Source
    /// `P1`..`Q2`: Meyer-Spradow and Loviscach, *Evolutionary Design of BRDFs*, section 3, in the
    /// product form of docs/maths/inputs.md. The inputs from `LogTanHalf` on belong to the extended
    /// dialect.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    #[repr(u8)]
    pub enum Input {
        /// cos_o + cos_i.
        P1 => "p1",
        /// Texture coordinate u, unwrapped.
        U => "u",
        /// Texture coordinate v, unwrapped, upwards.
        V => "v",
        /// cos(phi_o - phi_i), weighted by sin_i sin_o.
        SmoothP3 => "p3",
        /// cos(phi_o + phi_i), weighted by sin_i sin_o.
        SmoothP5 => "p5",
        /// sin(phi_o + phi_i), weighted by sin_i sin_o.
        SmoothP6 => "p6",
        /// p2^2 - p4^2 with the weighted p4.
        SmoothQ1 => "q1",
        /// 2 p2 p4 with the weighted p4.
        SmoothQ2 => "q2",
        /// cos(phi_o - phi_i).
        PaperP3 => "p3.paper",
        /// cos(phi_o + phi_i).
        PaperP5 => "p5.paper",
        /// sin(phi_o + phi_i).
        PaperP6 => "p6.paper",
        /// p2^2 - p4^2.
        PaperQ1 => "q1.paper",
        /// 2 p2 p4.
        PaperQ2 => "q2.paper",
        /// 1/2 ln(tan^2 theta_h + 1e-7).
        LogTanHalf => "lt",
        /// h . wi.
        HalfDotLight => "h.wi",
        /// (cos_o - cos_i)^2 / (4 sin^2 theta_h + 1e-3).
        CosineDifference => "dx",
        /// 2 p2 p4 / (sin^2 theta_h + 1e-3) with the weighted p4.
        MirrorAsymmetry => "qn",
        /// cos_i cos_o.
        CosineProduct => "cos_i*cos_o",
        /// ln(h . wi).
        LogHalfDotLight => "ln(h.wi)",
        /// 1/2 ln(1 - h . wi + 0.002).
        LogHalfAngle => "ln(1-h.wi)/2",
        /// ln(cos_i cos_o).
        LogCosineProduct => "ln(cos_i*cos_o)",
        /// ln(cos_i + cos_o).
        LogCosineSum => "ln(cos_i+cos_o)",
        /// n . h.
        NormalDotHalf => "n.h",
        /// n . e, the cosine to the eye.
        NormalDotEye => "n.e",
        /// Depth of the point: 0 on the near side of the object's bounding sphere, 1 on the far
        /// side.
        Depth => "z",
        /// Length of the gradient of n . e over a pixel, at most 1.
        NormalDotEyeStep => "n.e/px",
        /// Length of the gradient of the depth over a pixel, at most 1.
        DepthStep => "z/px",
        /// cos_o - cos_i, with the direction to the first light as wi.
        P2 => "p2",
        /// sin(phi_o - phi_i), weighted by sin_i sin_o.
        SmoothP4 => "p4",
        /// n . l of light 0.
        Light0Cos => "c.0",
        /// r . l of light 0, where r is the direction to the eye, mirrored.
        Light0Mirror => "m.0",
        /// Share of light 0 that nothing occludes.
        Light0Visibility => "v.0",
        /// Largest channel of the colour of light 0.
        Light0Level => "e.0",
        /// Red of the colour of light 0.
        Light0Red => "e.r.0",
        /// Green of the colour of light 0.
        Light0Green => "e.g.0",
        /// Blue of the colour of light 0.
        Light0Blue => "e.b.0",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light0CosStep => "c/px.0",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light0MirrorStep => "m/px.0",
        /// n . l of light 1.
        Light1Cos => "c.1",
        /// r . l of light 1, where r is the direction to the eye, mirrored.
        Light1Mirror => "m.1",
        /// Share of light 1 that nothing occludes.
        Light1Visibility => "v.1",
        /// Largest channel of the colour of light 1.
        Light1Level => "e.1",
        /// Red of the colour of light 1.
        Light1Red => "e.r.1",
        /// Green of the colour of light 1.
        Light1Green => "e.g.1",
        /// Blue of the colour of light 1.
        Light1Blue => "e.b.1",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light1CosStep => "c/px.1",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light1MirrorStep => "m/px.1",
        /// n . l of light 2.
        Light2Cos => "c.2",
        /// r . l of light 2, where r is the direction to the eye, mirrored.
        Light2Mirror => "m.2",
        /// Share of light 2 that nothing occludes.
        Light2Visibility => "v.2",
        /// Largest channel of the colour of light 2.
        Light2Level => "e.2",
        /// Red of the colour of light 2.
        Light2Red => "e.r.2",
        /// Green of the colour of light 2.
        Light2Green => "e.g.2",
        /// Blue of the colour of light 2.
        Light2Blue => "e.b.2",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light2CosStep => "c/px.2",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light2MirrorStep => "m/px.2",
        /// n . l of light 3.
        Light3Cos => "c.3",
        /// r . l of light 3, where r is the direction to the eye, mirrored.
        Light3Mirror => "m.3",
        /// Share of light 3 that nothing occludes.
        Light3Visibility => "v.3",
        /// Largest channel of the colour of light 3.
        Light3Level => "e.3",
        /// Red of the colour of light 3.
        Light3Red => "e.r.3",
        /// Green of the colour of light 3.
        Light3Green => "e.g.3",
        /// Blue of the colour of light 3.
        Light3Blue => "e.b.3",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light3CosStep => "c/px.3",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light3MirrorStep => "m/px.3",
        /// n . l of light 4.
        Light4Cos => "c.4",
        /// r . l of light 4, where r is the direction to the eye, mirrored.
        Light4Mirror => "m.4",
        /// Share of light 4 that nothing occludes.
        Light4Visibility => "v.4",
        /// Largest channel of the colour of light 4.
        Light4Level => "e.4",
        /// Red of the colour of light 4.
        Light4Red => "e.r.4",
        /// Green of the colour of light 4.
        Light4Green => "e.g.4",
        /// Blue of the colour of light 4.
        Light4Blue => "e.b.4",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light4CosStep => "c/px.4",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light4MirrorStep => "m/px.4",
        /// n . l of light 5.
        Light5Cos => "c.5",
        /// r . l of light 5, where r is the direction to the eye, mirrored.
        Light5Mirror => "m.5",
        /// Share of light 5 that nothing occludes.
        Light5Visibility => "v.5",
        /// Largest channel of the colour of light 5.
        Light5Level => "e.5",
        /// Red of the colour of light 5.
        Light5Red => "e.r.5",
        /// Green of the colour of light 5.
        Light5Green => "e.g.5",
        /// Blue of the colour of light 5.
        Light5Blue => "e.b.5",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light5CosStep => "c/px.5",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light5MirrorStep => "m/px.5",
        /// n . l of light 6.
        Light6Cos => "c.6",
        /// r . l of light 6, where r is the direction to the eye, mirrored.
        Light6Mirror => "m.6",
        /// Share of light 6 that nothing occludes.
        Light6Visibility => "v.6",
        /// Largest channel of the colour of light 6.
        Light6Level => "e.6",
        /// Red of the colour of light 6.
        Light6Red => "e.r.6",
        /// Green of the colour of light 6.
        Light6Green => "e.g.6",
        /// Blue of the colour of light 6.
        Light6Blue => "e.b.6",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light6CosStep => "c/px.6",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light6MirrorStep => "m/px.6",
        /// n . l of light 7.
        Light7Cos => "c.7",
        /// r . l of light 7, where r is the direction to the eye, mirrored.
        Light7Mirror => "m.7",
        /// Share of light 7 that nothing occludes.
        Light7Visibility => "v.7",
        /// Largest channel of the colour of light 7.
        Light7Level => "e.7",
        /// Red of the colour of light 7.
        Light7Red => "e.r.7",
        /// Green of the colour of light 7.
        Light7Green => "e.g.7",
        /// Blue of the colour of light 7.
        Light7Blue => "e.b.7",
        /// Length of the gradient of n . l over a pixel, at most 1.
        Light7CosStep => "c/px.7",
        /// Length of the gradient of r . l over a pixel, at most 1.
        Light7MirrorStep => "m/px.7",
        /// L / (1 + L) of the luminance L that the BRDF of a painted material reflects.
        ReflectedLevel => "l",
        /// L / (1 + L) of the red that it reflects.
        ReflectedRed => "l.r",
        /// L / (1 + L) of the green that it reflects.
        ReflectedGreen => "l.g",
        /// L / (1 + L) of the blue that it reflects.
        ReflectedBlue => "l.b",
        /// Length of the gradient of the level over a pixel, at most 1.
        ReflectedStep => "l/px",
        /// Red of what the mirrored eye ray sees, in display values.
        MirroredRed => "mirrored.r",
        /// Green of what the mirrored eye ray sees.
        MirroredGreen => "mirrored.g",
        /// Blue of what the mirrored eye ray sees.
        MirroredBlue => "mirrored.b",
        /// Length of the mirrored way inside the body, in its radii; 65504 if nothing is seen.
        MirroredLength => "mirrored.d",
        /// Red of what the eye sees through the first way out of a clear body, in display values.
        Way0Red => "way.r.0",
        /// Green through the first way out.
        Way0Green => "way.g.0",
        /// Blue through the first way out.
        Way0Blue => "way.b.0",
        /// Length of the first way inside the body, in its radii; 65504 if nothing is seen.
        Way0Length => "way.d.0",
        /// Share of the first way in the light of both.
        Way0Share => "way.q.0",
        /// Red of what the eye sees through the second way out.
        Way1Red => "way.r.1",
        /// Green through the second way out.
        Way1Green => "way.g.1",
        /// Blue through the second way out.
        Way1Blue => "way.b.1",
        /// Length of the second way inside the body, in its radii; 65504 if nothing is seen.
        Way1Length => "way.d.1",
        /// Red of the first control image of a painted material, in display values times its
        /// opacity.
        Image0Red => "image.r.0",
        /// Green of the first control image, times its opacity.
        Image0Green => "image.g.0",
        /// Blue of the first control image, times its opacity.
        Image0Blue => "image.b.0",
        /// Opacity of the first control image.
        Image0Opacity => "image.a.0",
        /// Red of the second control image, times its opacity.
        Image1Red => "image.r.1",
        /// Green of the second control image, times its opacity.
        Image1Green => "image.g.1",
        /// Blue of the second control image, times its opacity.
        Image1Blue => "image.b.1",
        /// Opacity of the second control image.
        Image1Opacity => "image.a.1",
        /// Red of the third control image, times its opacity.
        Image2Red => "image.r.2",
        /// Green of the third control image, times its opacity.
        Image2Green => "image.g.2",
        /// Blue of the third control image, times its opacity.
        Image2Blue => "image.b.2",
        /// Opacity of the third control image.
        Image2Opacity => "image.a.2",
        /// Red of the fourth control image, times its opacity.
        Image3Red => "image.r.3",
        /// Green of the fourth control image, times its opacity.
        Image3Green => "image.g.3",
        /// Blue of the fourth control image, times its opacity.
        Image3Blue => "image.b.3",
        /// Opacity of the fourth control image.
        Image3Opacity => "image.a.3",
    }
}

crate::named_enum! {
    /// A quantity of a light at a surface point; see the inputs of the same names.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    #[repr(u8)]
    pub enum LightInput {
        /// n . l.
        Cos => "c",
        /// r . l.
        Mirror => "m",
        /// Share of the light that nothing occludes, in [0, 1].
        Visibility => "v",
        /// Largest channel of the colour, in [0, 1].
        Level => "e",
        /// Red of the colour, in [0, 1].
        Red => "e.r",
        /// Green of the colour, in [0, 1].
        Green => "e.g",
        /// Blue of the colour, in [0, 1].
        Blue => "e.b",
        /// Length of the gradient of n . l over a pixel.
        CosStep => "c/px",
        /// Length of the gradient of r . l over a pixel.
        MirrorStep => "m/px",
    }
}

/// Index of the first input of the first light.
const FIRST_OF_LIGHTS: usize = Input::Light0Cos as usize;
/// Index after the last input of the last light.
const END_OF_LIGHTS: usize = FIRST_OF_LIGHTS + Input::LIGHTS * LightInput::ALL.len();
const _: () = assert!(
    Input::Light7MirrorStep as usize + 1 == END_OF_LIGHTS,
    "the inputs of lights follow each other"
);

impl Input {
    /// L / (1 + L) of what the BRDF of a painted material reflects: luminance, red, green, blue.
    pub const REFLECTED: [Self; 4] =
        [Self::ReflectedLevel, Self::ReflectedRed, Self::ReflectedGreen, Self::ReflectedBlue];
    /// Red, green, blue and opacity of the control images of a painted material, in the order of
    /// their first use. A set has them only where they were added.
    pub const IMAGES: [[Self; 4]; 4] = [
        [Self::Image0Red, Self::Image0Green, Self::Image0Blue, Self::Image0Opacity],
        [Self::Image1Red, Self::Image1Green, Self::Image1Blue, Self::Image1Opacity],
        [Self::Image2Red, Self::Image2Green, Self::Image2Blue, Self::Image2Opacity],
        [Self::Image3Red, Self::Image3Green, Self::Image3Blue, Self::Image3Opacity],
    ];
    /// Largest number of lights that painted materials distinguish.
    pub const LIGHTS: usize = 8;
    /// Number of inputs that are symmetric functions of a direction pair: those of BRDFs, the first
    /// in [`Input::ALL`].
    pub const SYMMETRIC: usize = Self::NormalDotHalf as usize + 1;

    /// Inputs of BRDFs, which do not change when the directions are exchanged.
    pub fn symmetric() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().take(Self::SYMMETRIC)
    }

    /// Returns an input of a light.
    ///
    /// # Panics
    /// If `light` is not below [`Input::LIGHTS`].
    #[must_use]
    pub fn of_light(light: usize, quantity: LightInput) -> Self {
        assert!(light < Self::LIGHTS, "painted materials distinguish {} lights", Self::LIGHTS);
        Self::ALL[FIRST_OF_LIGHTS + light * LightInput::ALL.len() + quantity as usize]
    }

    /// Inputs of clear bodies: the colours that mirrored and refracted rays see. A set has them
    /// only where they were added.
    pub fn of_glass() -> impl Iterator<Item = Self> {
        let glass = Self::MirroredRed as usize..=Self::Way1Length as usize;
        Self::ALL[glass].iter().copied()
    }

    /// True for an input of control images.
    #[must_use]
    pub fn is_of_image(self) -> bool {
        Self::IMAGES.as_flattened().contains(&self)
    }

    /// Returns the light and the quantity of an input of lights; `None` for the others.
    #[must_use]
    pub fn light(self) -> Option<(usize, LightInput)> {
        let in_order = self.index() < END_OF_LIGHTS;
        let place = self.index().checked_sub(FIRST_OF_LIGHTS).filter(|_| in_order)?;
        let count = LightInput::ALL.len();
        Some((place / count, LightInput::ALL[place % count]))
    }

    /// Position in [`Input::ALL`]; also the bit in an [`InputMask`](super::InputMask) and the
    /// number in packed words.
    #[inline]
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// Returns the input with this index, or `None` if there is none.
    #[must_use]
    pub fn from_index(index: usize) -> Option<Self> {
        Self::ALL.get(index).copied()
    }
}

/// Lights for which a painted material is lowered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Lighting {
    /// Number of lights, at most [`Input::LIGHTS`].
    pub lights: usize,
    /// True if the visibility of a light can be below 1.
    pub has_shadows: bool,
}
