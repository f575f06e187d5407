//! CSV of direction pairs: the columns wix, wiy, wiz, wox, woy, woz, and optionally u, v.
//! Independent of what is evaluated.

use std::fmt;

use brood_brdf::{DirectionError, DirectionPair};
use glam::{DVec2, DVec3};

/// One row of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Directions to the light and to the eye.
    pub pair: DirectionPair,
    /// Texture position; 0 without the columns u and v.
    pub uv: DVec2,
}

/// Error in a file of pairs. Rows count from 1 after the header.
#[derive(Debug, Clone, PartialEq)]
pub enum PairsError {
    /// A required column is missing, or a column occurs twice.
    Column(&'static str),
    /// A row lacks a field, or the field is not a finite number.
    Number(usize, &'static str),
    /// A vector of a row is not a unit direction.
    Direction(usize, &'static str, DirectionError),
}

impl fmt::Display for PairsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Column(name) => write!(f, "the header must have the column {name} once"),
            Self::Number(row, name) => write!(f, "row {row}: {name} is not a finite number"),
            Self::Direction(row, name, error) => write!(f, "row {row}: {name}: {error}"),
        }
    }
}

impl std::error::Error for PairsError {}

const COLUMNS: [&str; 6] = ["wix", "wiy", "wiz", "wox", "woy", "woz"];

/// Reads all rows; fails at the first bad one.
pub fn parse(text: &str) -> Result<Vec<Row>, PairsError> {
    let text = text.trim_start_matches('\u{feff}');
    // Lines starting with # before the header are comments.
    let mut lines = text.lines().filter(|l| !l.trim().is_empty() && !l.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').map(field).collect();
    let mut places = [0; COLUMNS.len()];
    for (place, name) in places.iter_mut().zip(COLUMNS) {
        *place = find(&header, name)?.ok_or(PairsError::Column(name))?;
    }
    let uv = [("u", find(&header, "u")?), ("v", find(&header, "v")?)];
    lines.zip(1..).map(|(line, number)| row(line, number, &places, &uv)).collect()
}

/// Returns the index of a column; an error if it occurs twice.
fn find(header: &[&str], name: &'static str) -> Result<Option<usize>, PairsError> {
    let mut found = header.iter().enumerate().filter(|(_, column)| **column == name);
    let first = found.next().map(|(place, _)| place);
    if found.next().is_some() { Err(PairsError::Column(name)) } else { Ok(first) }
}

/// Reads one row. `places` and `uv` are the indices of the columns.
fn row(
    line: &str,
    number: usize,
    places: &[usize; 6],
    uv: &[(&'static str, Option<usize>); 2],
) -> Result<Row, PairsError> {
    let fields: Vec<&str> = line.split(',').map(field).collect();
    let read = |place: usize, name: &'static str| {
        let value = fields.get(place).and_then(|text| text.parse::<f64>().ok());
        value.filter(|value| value.is_finite()).ok_or(PairsError::Number(number, name))
    };
    let mut values = [0.0; 6];
    for ((value, place), name) in values.iter_mut().zip(places).zip(COLUMNS) {
        *value = read(*place, name)?;
    }
    let texture = |(name, place): (&'static str, Option<usize>)| {
        place.map_or(Ok(0.0), |place| read(place, name))
    };
    let [wix, wiy, wiz, wox, woy, woz] = values;
    let (wi, wo) = (DVec3::new(wix, wiy, wiz), DVec3::new(wox, woy, woz));
    let at = |name| move |error| PairsError::Direction(number, name, error);
    // Each direction is paired with itself first, so that the error names the bad one.
    DirectionPair::new(wi, wi).map_err(at("wi"))?;
    DirectionPair::new(wo, wo).map_err(at("wo"))?;
    let pair = DirectionPair::new(wi, wo).map_err(at("wi, wo"))?;
    Ok(Row { pair, uv: DVec2::new(texture(uv[0])?, texture(uv[1])?) })
}

/// Returns a field without surrounding spaces and quotes.
fn field(text: &str) -> &str {
    let text = text.trim();
    text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "wix,wiy,wiz,wox,woy,woz";

    #[test]
    fn columns_are_found_by_name_and_others_ignored() {
        let text = "# from a goniometer\nr,woz,woy,wox,\"wiz\",wiy,wix,v\n9,1,0,0,0.8,0,0.6,0.25\n";
        let rows = parse(text).unwrap();
        assert_eq!(rows.len(), 1);
        assert_eq!(rows[0].uv, DVec2::new(0.0, 0.25));
        assert!((rows[0].pair.wi() - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        assert_eq!(rows[0].pair.wo(), DVec3::Z);
    }

    #[test]
    fn bad_row_is_rejected_with_its_number() {
        let check = |row: &str, expected: &str| {
            let text = format!("{HEADER}\n0,0,1,0,0,1\n{row}\n");
            let error = parse(&text).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        };
        check("0,0,1,0,0,1.0011", "row 2: wo: the length of the direction must be 1");
        check("0,0,0.99,0,0,1", "row 2: wi: ");
        check("0,0,1,0,0", "row 2: woz");
        check("0,0,1,x,0,1", "row 2: wox");
        check("0,nan,1,0,0,1", "row 2: wiy");
    }

    #[test]
    fn file_is_rejected_when_a_column_is_missing_or_repeated() {
        assert_eq!(parse(""), Err(PairsError::Column("wix")));
        assert_eq!(parse("wix,wiy,wiz,wox,woy\n"), Err(PairsError::Column("woz")));
        assert_eq!(parse("wix,wiy,wiz,wox,woy,woz,wix\n"), Err(PairsError::Column("wix")));
        assert_eq!(parse(HEADER), Ok(Vec::new()));
    }
}
