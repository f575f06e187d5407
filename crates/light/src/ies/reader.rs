//! Parser of IES files: lines up to `TILT=`, then a stream of numbers.

use super::error::{IesError, IesErrorKind};
use super::profile::{IesProfile, Photometry, Tilt};

/// Largest number of vertical or of horizontal angles; real files have a few hundred.
const ANGLES_MAX: f64 = 10_000.0;
/// Largest magnitude of a number; no measurement is larger.
const NUMBER_MAX: f64 = 1e12;
const METRES_PER_FOOT: f64 = 0.3048;

/// Stream of numbers; line ends only separate them.
struct Numbers<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    /// Line of the last number.
    line: usize,
    /// True if the file's edition of the standard has a ballast-lamp photometric factor.
    has_lamp_factor: bool,
}

impl Numbers<'_> {
    fn next(&mut self, what: &'static str) -> Result<f64, IesError> {
        let Some((line, word)) = self.words.next() else {
            return Err(IesError { line: self.line, kind: IesErrorKind::Ends(what) });
        };
        self.line = line;
        let number = word.parse().ok().filter(|number: &f64| number.abs() <= NUMBER_MAX);
        number.ok_or_else(|| {
            let text = word.chars().take(32).collect();
            IesError { line, kind: IesErrorKind::Number { what, text } }
        })
    }

    /// Reads a number and checks it with `is_valid`.
    fn valid(
        &mut self,
        what: &'static str,
        is_valid: impl FnOnce(f64) -> bool,
    ) -> Result<f64, IesError> {
        let value = self.next(what)?;
        let error = IesError { line: self.line, kind: IesErrorKind::Value { what, value } };
        if is_valid(value) { Ok(value) } else { Err(error) }
    }

    fn not_negative(&mut self, what: &'static str) -> Result<f64, IesError> {
        self.valid(what, |value| value >= 0.0)
    }

    fn count(&mut self, what: &'static str) -> Result<usize, IesError> {
        let whole = |value: f64| (1.0..=ANGLES_MAX).contains(&value) && value.fract() == 0.0;
        // Exact: the value is a whole number.
        Ok(self.valid(what, whole)? as usize)
    }

    fn list(&mut self, what: &'static str, count: usize) -> Result<Vec<f64>, IesError> {
        (0..count).map(|_| self.next(what)).collect()
    }

    fn ascending(&mut self, what: &'static str, count: usize) -> Result<Vec<f64>, IesError> {
        let angles = self.list(what, count)?;
        if !angles.is_sorted_by(|a, b| a < b) {
            return Err(IesError { line: self.line, kind: IesErrorKind::Angles(what) });
        }
        Ok(angles)
    }
}

impl IesProfile {
    /// Reads a profile from the bytes of a file.
    ///
    /// # Domain
    /// LM-63 of 1986 to 2019, types A, B and C, `TILT=NONE` and `TILT=INCLUDE`. Text outside ASCII
    /// is allowed. Never panics; memory is proportional to the length of `bytes`.
    ///
    /// # Errors
    /// Returns the first [`IesError`] found, with its line.
    ///
    /// # Source
    /// ANSI/IESNA LM-63-02, *Standard File Format for the Electronic Transfer of Photometric Data*.
    pub fn parse(bytes: &[u8]) -> Result<Self, IesError> {
        read(bytes)
    }
}

fn read(bytes: &[u8]) -> Result<IesProfile, IesError> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = (1usize..).zip(text.lines());
    let tilt = lines.by_ref().find_map(|(line, text)| {
        let word = text.trim_start_matches('\u{feff}').trim().strip_prefix("TILT=");
        word.map(|word| (line, word.trim()))
    });
    let Some((line, tilt)) = tilt else {
        let line = text.lines().count().max(1);
        return Err(IesError { line, kind: IesErrorKind::NoTilt });
    };
    let words = lines.flat_map(|(line, text)| {
        let words = text.split(|c: char| c == ',' || c.is_whitespace());
        words.filter(|word| !word.is_empty()).map(move |word| (line, word))
    });
    let first = text.lines().next().unwrap_or_default().trim_start_matches('\u{feff}').trim();
    // Files of the 1986 edition have no edition line.
    let edition = first.starts_with("IES");
    let has_lamp_factor = !edition || first == "IESNA91" || first.ends_with("1995");
    let mut numbers = Numbers { words: Box::new(words), line, has_lamp_factor };
    let tilt = match tilt {
        "NONE" => None,
        "INCLUDE" => Some(read_tilt(&mut numbers)?),
        _ => return Err(IesError { line, kind: IesErrorKind::TiltFile }),
    };
    read_body(&mut numbers, tilt)
}

fn read_tilt(numbers: &mut Numbers<'_>) -> Result<Tilt, IesError> {
    let known = |value| [1.0, 2.0, 3.0].contains(&value);
    let geometry = numbers.valid("the lamp-to-luminaire geometry", known)?;
    let count = numbers.count("the number of tilt angles")?;
    let angles = numbers.ascending("tilt", count)?;
    let factors: Result<Vec<f64>, _> =
        (0..count).map(|_| numbers.not_negative("a tilt factor")).collect();
    // With geometry 2 the lamp stays level when the luminaire tilts.
    Ok(Tilt { follows: geometry != 2.0, angles, factors: factors? })
}

fn read_body(numbers: &mut Numbers<'_>, tilt: Option<Tilt>) -> Result<IesProfile, IesError> {
    let lamps = numbers.not_negative("the number of lamps")?;
    let lumens_per_lamp = numbers.next("the lumens of a lamp")?;
    let multiplier = numbers.not_negative("the candela multiplier")?;
    let vertical_count = numbers.count("the number of vertical angles")?;
    let horizontal_count = numbers.count("the number of horizontal angles")?;
    let known = |value| [1.0, 2.0, 3.0].contains(&value);
    let photometry = match numbers.valid("the photometric type", known)? {
        1.0 => Photometry::C,
        2.0 => Photometry::B,
        _ => Photometry::A,
    };
    let feet = numbers.valid("the type of units", |value| [1.0, 2.0].contains(&value))? == 1.0;
    let metres = if feet { METRES_PER_FOOT } else { 1.0 };
    let mut size_m = [0.0; 3];
    for length in &mut size_m {
        *length = numbers.next("a length of the luminaire")? * metres;
    }
    let ballast = numbers.not_negative("the ballast factor")?;
    // Reserved since 2002; since 2019 a code of the file's origin, such as 1.1.
    let lamp_factor = numbers.not_negative("the ballast-lamp photometric factor")?;
    let lamp_factor = if numbers.has_lamp_factor { lamp_factor } else { 1.0 };
    let input_watts = numbers.next("the input watts")?;
    let vertical = numbers.ascending("vertical", vertical_count)?;
    photometry.check_vertical(&vertical).map_err(|kind| IesError { line: numbers.line, kind })?;
    let horizontal = numbers.ascending("horizontal", horizontal_count)?;
    let symmetry =
        photometry.symmetry(&horizontal).map_err(|kind| IesError { line: numbers.line, kind })?;
    let factor = multiplier * ballast * lamp_factor;
    let mut candela = Vec::new();
    for _ in 0..horizontal_count {
        for _ in 0..vertical_count {
            candela.push(numbers.not_negative("a candela value")? * factor);
        }
    }
    Ok(IesProfile {
        photometry,
        symmetry,
        vertical,
        horizontal,
        candela,
        tilt,
        rated_lumens: (lumens_per_lamp >= 0.0).then_some(lamps * lumens_per_lamp),
        size_m,
        input_watts,
    })
}
