//! Photometric profile: intensity on a grid of angles, extended by symmetry to all directions.

use std::f64::consts::PI;

use glam::DVec3;

use super::error::IesErrorKind;

/// Coordinate system of a profile's angles (LM-63 photometric type).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Photometry {
    /// Planes share the vertical axis; angles are relative to an aim at the horizon.
    A,
    /// Planes share a horizontal axis; used for floodlights.
    B,
    /// Planes share the vertical axis; vertical angles start straight down. The most common type.
    C,
}

/// Symmetry that extends the horizontal angles of the file to the full circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Symmetry {
    /// Type C: rotational symmetry.
    Axial,
    /// Type C: four mirrored quadrants, 0 to 90 degrees given.
    Quadrants,
    /// Type C: mirrored at the plane of 0 and 180 degrees.
    About0,
    /// Type C: mirrored at the plane of 90 and 270 degrees.
    About90,
    /// Type C: no symmetry, 0 to 360 degrees given.
    Full,
    /// Type C: no symmetry; the angle 360, equal to 0, is omitted.
    FullOpen,
    /// Types A and B: one side given, the other mirrored.
    Mirrored,
    /// Types A and B: both sides given.
    BothSides,
}

/// Factors of lamp output by tilt of the luminaire.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tilt {
    /// True if the lamp tilts with the luminaire.
    pub follows: bool,
    /// Ascending, degrees.
    pub angles: Vec<f64>,
    pub factors: Vec<f64>,
}

/// Luminous intensity of a luminaire in each direction.
///
/// ```
/// let text = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 60\n0 90\n0\n100 50\n";
/// let profile = brood_light::IesProfile::parse(text.as_bytes()).unwrap();
/// assert_eq!(profile.candela(glam::DVec3::Z), 100.0);
/// assert!((profile.candela(glam::DVec3::X) - 50.0).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct IesProfile {
    pub(super) photometry: Photometry,
    pub(super) symmetry: Symmetry,
    /// Ascending, degrees.
    pub(super) vertical: Vec<f64>,
    pub(super) horizontal: Vec<f64>,
    /// Intensities with all factors of the file applied except the tilt: all vertical angles of the
    /// first horizontal angle, then of the next.
    pub(super) candela: Vec<f64>,
    pub(super) tilt: Option<Tilt>,
    pub(super) rated_lumens: Option<f64>,
    pub(super) size_m: [f64; 3],
    pub(super) input_watts: f64,
}

impl IesProfile {
    /// Returns the luminous intensity in a direction: bilinear between the angles of the file, 0
    /// outside their range.
    ///
    /// # Units
    /// cd, with all factors of the file applied except the tilt.
    ///
    /// # Domain
    /// A unit vector in the frame of the luminaire, which is left-handed. z is straight down for
    /// type C and the aim for A and B; x is the horizontal angle 0 for C and growing horizontal
    /// angles for A and B, on the right of the aim; y is the horizontal angle 90 for C and up for A
    /// and B. Horizontal angles thus turn counterclockwise seen from above for type C, clockwise
    /// for A and B.
    ///
    /// # Source
    /// ANSI/IESNA LM-63-02, section 3, *Horizontal angles*.
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
            // Only one half is given; the other is mirrored.
            Photometry::A | Photometry::B if self.vertical[0] >= 0.0 => vertical.abs(),
            Photometry::A | Photometry::B => vertical,
        };
        let Some((row, up)) = interval(&self.vertical, vertical) else { return 0.0 };
        let horizontal = self.symmetry.map_angle(horizontal);
        let last = self.horizontal.len() - 1;
        let (column, next, along) = match self.symmetry {
            Symmetry::Axial => (0, 0, 0.0),
            Symmetry::FullOpen if horizontal > self.horizontal[last] => {
                let gap = 360.0 - self.horizontal[last] + self.horizontal[0];
                (last, 0, (horizontal - self.horizontal[last]) / gap)
            }
            _ => match interval(&self.horizontal, horizontal) {
                Some((column, along)) => (column, (column + 1).min(last), along),
                None => return 0.0,
            },
        };
        let at = |column: usize| {
            let column = &self.candela[column * self.vertical.len()..][..self.vertical.len()];
            let above = column[(row + 1).min(column.len() - 1)];
            column[row] + (above - column[row]) * up
        };
        let (a, b) = (at(column), at(next));
        a + (b - a) * along
    }

    /// Returns the factor of lamp output at an angle between the luminaire's axis and straight
    /// down.
    ///
    /// # Units
    /// Degrees; the sign is ignored.
    #[must_use]
    pub fn tilt_factor(&self, degrees: f64) -> f64 {
        let Some(tilt) = &self.tilt else { return 1.0 };
        let degrees = if tilt.follows { degrees.abs() } else { 0.0 };
        let (first, last) = (tilt.angles[0], tilt.angles[tilt.angles.len() - 1]);
        let Some((index, along)) = interval(&tilt.angles, degrees.clamp(first, last)) else {
            return 1.0;
        };
        let next = tilt.factors[(index + 1).min(tilt.factors.len() - 1)];
        tilt.factors[index] + (next - tilt.factors[index]) * along
    }

    /// Returns the largest intensity.
    ///
    /// # Units
    /// cd.
    #[must_use]
    pub fn peak_candela(&self) -> f64 {
        self.candela.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the photometric type.
    #[must_use]
    pub fn photometry(&self) -> Photometry {
        self.photometry
    }

    /// Returns the rated flux of all lamps; `None` for absolute photometry.
    ///
    /// # Units
    /// lm.
    #[must_use]
    pub fn rated_lumens(&self) -> Option<f64> {
        self.rated_lumens
    }

    /// Returns width, length and height of the luminous opening; negative for round shapes, as in
    /// the file.
    ///
    /// # Units
    /// m.
    #[must_use]
    pub fn size_m(&self) -> [f64; 3] {
        self.size_m
    }

    /// Returns a hash of everything that intensities depend on.
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

    /// Returns the electric input power.
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

    /// Returns the symmetry implied by the first and the last horizontal angle.
    pub(super) fn symmetry(self, angles: &[f64]) -> Result<Symmetry, IesErrorKind> {
        let (first, last) = (angles[0], angles[angles.len() - 1]);
        match self {
            Self::C if angles.len() == 1 => Ok(Symmetry::Axial),
            Self::C if first == 0.0 && last == 90.0 => Ok(Symmetry::Quadrants),
            Self::C if first == 0.0 && last == 180.0 => Ok(Symmetry::About0),
            Self::C if first == 90.0 && last == 270.0 => Ok(Symmetry::About90),
            Self::C if first == 0.0 && last == 360.0 => Ok(Symmetry::Full),
            Self::C if first == 0.0 && last > 180.0 && last < 360.0 => Ok(Symmetry::FullOpen),
            Self::C => Err(IesErrorKind::Symmetry),
            Self::A | Self::B if first < -90.0 || last > 90.0 => {
                Err(IesErrorKind::Angles("horizontal"))
            }
            Self::A | Self::B if first >= 0.0 => Ok(Symmetry::Mirrored),
            Self::A | Self::B => Ok(Symmetry::BothSides),
        }
    }
}

impl Symmetry {
    /// Maps a horizontal angle from -180 to 180 degrees to the angle of the file that represents
    /// it.
    fn map_angle(self, degrees: f64) -> f64 {
        let full = if degrees < 0.0 { degrees + 360.0 } else { degrees };
        match self {
            Self::Axial | Self::BothSides => degrees,
            Self::Mirrored => degrees.abs(),
            Self::Quadrants if degrees.abs() > 90.0 => 180.0 - degrees.abs(),
            Self::Quadrants | Self::About0 => degrees.abs(),
            Self::About90 if full < 90.0 => 180.0 - full,
            Self::About90 if full > 270.0 => 540.0 - full,
            Self::About90 | Self::Full | Self::FullOpen => full,
        }
    }
}

/// Returns the interval of the ascending angles that contains an angle, and the fraction along it;
/// `None` outside their range.
fn interval(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    // An angle outside the range by rounding counts as its end.
    let angle = if angle > last && angle - last < 1e-9 { last } else { angle };
    let angle = if angle < first && first - angle < 1e-9 { first } else { angle };
    if angle.is_nan() || angle < first || angle > last {
        return None;
    }
    let index = angles.partition_point(|other| *other <= angle).saturating_sub(1);
    let Some(next) = angles.get(index + 1) else { return Some((index, 0.0)) };
    Some((index, (angle - angles[index]) / (next - angles[index])))
}
