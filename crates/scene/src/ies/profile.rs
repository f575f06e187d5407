//! A photometric profile: candelas over a grid of angles, and what its symmetry says of the directions beyond.

use std::f64::consts::PI;

use glam::DVec3;

use super::error::{IesError, IesErrorKind};
use super::{integral, reader};

/// How the angles of a profile lie in space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Photometry {
    /// Planes share the vertical axis; angles are those of a luminaire that is aimed at the horizon.
    A,
    /// Planes share a horizontal axis; floodlights.
    B,
    /// Planes share the vertical axis, and vertical angles begin straight below; nearly everything else.
    C,
}

/// What is told of horizontal angles that are not in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fold {
    /// The same all round.
    Axial,
    /// Four equal quarters.
    Quarters,
    /// The two sides of the plane from 0 to 180 degrees are mirrored.
    Halves,
    /// The two sides of the plane from 90 to 270 degrees are mirrored.
    Sides,
    /// All are there.
    Whole,
    /// All are there, but 360 is not said again.
    Open,
    /// Types A and B: only one side is there, the other is mirrored.
    Mirrored,
    /// Types A and B: both sides are there.
    Both,
}

/// How much a lamp gives when the luminaire is tilted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tilt {
    /// Whether the lamp is tilted with the luminaire.
    pub follows: bool,
    pub angles: Vec<f64>,
    pub factors: Vec<f64>,
}

/// How strongly a luminaire shines in each direction.
///
/// ```
/// let text = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 60\n0 90\n0\n100 50\n";
/// let profile = brood_scene::IesProfile::parse(text.as_bytes()).unwrap();
/// assert_eq!(profile.candela(glam::DVec3::Z), 100.0);
/// assert!((profile.candela(glam::DVec3::X) - 50.0).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct IesProfile {
    pub(super) photometry: Photometry,
    pub(super) fold: Fold,
    /// Ascending, degrees.
    pub(super) vertical: Vec<f64>,
    pub(super) horizontal: Vec<f64>,
    /// Every factor of the file but the tilt's is in them; all vertical angles of the first horizontal angle, then the next.
    pub(super) candela: Vec<f64>,
    pub(super) tilt: Option<Tilt>,
    pub(super) rated_lumens: Option<f64>,
    pub(super) size_m: [f64; 3],
    pub(super) input_watts: f64,
}

impl IesProfile {
    /// Reads a profile from the bytes of a file.
    ///
    /// # Domain
    /// LM-63 of 1986 to 2019, types A, B and C, `TILT=NONE` and `TILT=INCLUDE`; text beyond ASCII does not matter.
    ///
    /// # Error
    /// The first thing found wrong, with its line; never a panic, and memory in proportion to the bytes.
    ///
    /// # Source
    /// ANSI/IESNA LM-63-02, *Standard File Format for the Electronic Transfer of Photometric Data*.
    pub fn parse(bytes: &[u8]) -> Result<Self, IesError> {
        reader::read(bytes)
    }

    /// Luminous intensity in a direction, bilinear in the angles; 0 beyond those of the file.
    ///
    /// # Units
    /// cd, all factors of the file included but the tilt's.
    ///
    /// # Domain
    /// A unit vector in the frame of the luminaire. z: straight down for type C, where it is aimed for A and B; x: the
    /// horizontal angle 0 for type C, to growing horizontal angles for A and B; y: to 90 degrees for C, upwards for A and B.
    #[must_use]
    pub fn candela(&self, direction: DVec3) -> f64 {
        let DVec3 { x, y, z } = direction;
        let across = |a: f64, b: f64| (a * a + b * b).sqrt();
        let (vertical, horizontal) = match self.photometry {
            Photometry::C => (libm::atan2(across(x, y), z), libm::atan2(y, x)),
            Photometry::B => (libm::atan2(y, z), libm::atan2(x, across(y, z))),
            Photometry::A => (libm::atan2(y, across(x, z)), libm::atan2(x, z)),
        };
        let degrees = 180.0 / PI;
        self.at_angles(vertical * degrees, horizontal * degrees)
    }

    fn at_angles(&self, vertical: f64, horizontal: f64) -> f64 {
        let vertical = match self.photometry {
            Photometry::C => vertical,
            // Only one half of it is there.
            Photometry::A | Photometry::B if self.vertical[0] >= 0.0 => vertical.abs(),
            Photometry::A | Photometry::B => vertical,
        };
        let Some((row, up)) = place(&self.vertical, vertical) else { return 0.0 };
        let horizontal = self.fold.apply(horizontal);
        let last = self.horizontal.len() - 1;
        let (column, next, along) = match self.fold {
            Fold::Axial => (0, 0, 0.0),
            Fold::Open if horizontal > self.horizontal[last] => {
                let gap = 360.0 - self.horizontal[last] + self.horizontal[0];
                (last, 0, (horizontal - self.horizontal[last]) / gap)
            }
            _ => match place(&self.horizontal, horizontal) {
                Some((column, along)) => (column, (column + 1).min(last), along),
                None => return 0.0,
            },
        };
        let at = |column: usize| {
            let column = &self.candela[column * self.vertical.len()..][..self.vertical.len()];
            let above = column[(row + 1).min(column.len() - 1)];
            column[row] + (above - column[row]) * up
        };
        let (here, there) = (at(column), at(next));
        here + (there - here) * along
    }

    /// The flux of the luminaire when it is not tilted: the integral of what [`IesProfile::candela`] tells.
    ///
    /// # Units
    /// lm.
    ///
    /// # Error
    /// None but rounding: the bilinear interpolation is integrated in closed form (docs/maths/lights.md). Against the
    /// reference lumens of five real files of type C 8e-4 (`cargo run -p brood-scene --example ies_lumens`), whose tool
    /// interpolates otherwise; against those in the head of one of type B 9e-3.
    #[must_use]
    pub fn lumens(&self) -> f64 {
        integral::lumens(self) * self.tilt_factor(0.0)
    }

    /// What the lamp gives when the luminaire's axis is so far from straight down, as a share of what the file says.
    ///
    /// # Units
    /// Degrees; either way of tilting counts alike.
    #[must_use]
    pub fn tilt_factor(&self, degrees: f64) -> f64 {
        let Some(tilt) = &self.tilt else { return 1.0 };
        let degrees = if tilt.follows { degrees.abs() } else { 0.0 };
        let (first, last) = (tilt.angles[0], tilt.angles[tilt.angles.len() - 1]);
        let Some((index, along)) = place(&tilt.angles, degrees.clamp(first, last)) else {
            return 1.0;
        };
        let next = tilt.factors[(index + 1).min(tilt.factors.len() - 1)];
        tilt.factors[index] + (next - tilt.factors[index]) * along
    }

    /// The largest intensity.
    ///
    /// # Units
    /// cd.
    #[must_use]
    pub fn peak_candela(&self) -> f64 {
        self.candela.iter().copied().fold(0.0, f64::max)
    }

    /// How its angles lie in space.
    #[must_use]
    pub fn photometry(&self) -> Photometry {
        self.photometry
    }

    /// What its lamps are said to give; `None` where the file is of absolute photometry.
    ///
    /// # Units
    /// lm.
    #[must_use]
    pub fn rated_lumens(&self) -> Option<f64> {
        self.rated_lumens
    }

    /// Width, length and height of what shines; negative for round shapes, as the format has it.
    ///
    /// # Units
    /// m.
    #[must_use]
    pub fn size_m(&self) -> [f64; 3] {
        self.size_m
    }

    /// Hash of everything that candelas depend on.
    #[must_use]
    pub fn content_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        let tilt = self.tilt.as_ref();
        let follows = tilt.map_or(0, |tilt| 1 + u64::from(tilt.follows));
        let tables = tilt.map_or([[].as_slice(); 2], |tilt| [&tilt.angles, &tilt.factors]);
        hasher.update(&[self.photometry as u8]);
        hasher.update(&follows.to_le_bytes());
        for list in [&self.vertical[..], &self.horizontal, &self.candela, tables[0], tables[1]] {
            hasher.update(&(list.len() as u64).to_le_bytes());
            for number in list {
                hasher.update(&number.to_le_bytes());
            }
        }
        hasher.finalize()
    }

    /// Electric power that it takes.
    ///
    /// # Units
    /// W.
    #[must_use]
    pub fn input_watts(&self) -> f64 {
        self.input_watts
    }
}

impl Photometry {
    pub(super) fn check_vertical(self, angles: &[f64]) -> Result<(), IesErrorKind> {
        let range = match self {
            Self::C => 0.0..=180.0,
            Self::A | Self::B => -90.0..=90.0,
        };
        let inside = angles.iter().all(|angle| range.contains(angle));
        if inside { Ok(()) } else { Err(IesErrorKind::Angles("vertical")) }
    }

    /// What the first and the last horizontal angle say of the others.
    pub(super) fn fold(self, angles: &[f64]) -> Result<Fold, IesErrorKind> {
        let (first, last) = (angles[0], angles[angles.len() - 1]);
        match self {
            Self::C if angles.len() == 1 => Ok(Fold::Axial),
            Self::C if first == 0.0 && last == 90.0 => Ok(Fold::Quarters),
            Self::C if first == 0.0 && last == 180.0 => Ok(Fold::Halves),
            Self::C if first == 90.0 && last == 270.0 => Ok(Fold::Sides),
            Self::C if first == 0.0 && last == 360.0 => Ok(Fold::Whole),
            Self::C if first == 0.0 && last > 180.0 && last < 360.0 => Ok(Fold::Open),
            Self::C => Err(IesErrorKind::Symmetry),
            Self::A | Self::B if first < -90.0 || last > 90.0 => {
                Err(IesErrorKind::Angles("horizontal"))
            }
            Self::A | Self::B if first >= 0.0 => Ok(Fold::Mirrored),
            Self::A | Self::B => Ok(Fold::Both),
        }
    }
}

impl Fold {
    /// The angle of the file that stands for a horizontal angle from -180 to 180 degrees.
    fn apply(self, degrees: f64) -> f64 {
        let turned = if degrees < 0.0 { degrees + 360.0 } else { degrees };
        match self {
            Self::Axial | Self::Both => degrees,
            Self::Mirrored => degrees.abs(),
            Self::Quarters if degrees.abs() > 90.0 => 180.0 - degrees.abs(),
            Self::Quarters | Self::Halves => degrees.abs(),
            Self::Sides if turned < 90.0 => 180.0 - turned,
            Self::Sides if turned > 270.0 => 540.0 - turned,
            Self::Sides | Self::Whole | Self::Open => turned,
        }
    }
}

/// Between which two of the ascending angles an angle is, and how far along; `None` beyond them.
fn place(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    // What is off the last angle by rounding is on it.
    let angle = if angle > last && angle - last < 1e-9 { last } else { angle };
    let angle = if angle < first && first - angle < 1e-9 { first } else { angle };
    if angle.is_nan() || angle < first || angle > last {
        return None;
    }
    let index = angles.partition_point(|other| *other <= angle).saturating_sub(1);
    let Some(next) = angles.get(index + 1) else { return Some((index, 0.0)) };
    Some((index, (angle - angles[index]) / (next - angles[index])))
}
