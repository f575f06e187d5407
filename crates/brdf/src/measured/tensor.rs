//! Container of RGL's `.bsdf` files: named arrays of numbers with a table of fields at the
//! beginning.
//!
//! Owns the layout and its validation; independent of the meaning of the arrays.

/// First bytes of a file.
const MAGIC: &[u8; 12] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
/// Largest number of fields; bounds the work for a damaged file. Materials have far fewer.
const MAX_FIELDS: u32 = 256;
const MAX_DIMENSIONS: u16 = 16;
/// Type code of 32-bit floats.
const FLOAT32: u8 = 10;
/// Bytes of an element by type code: u8, i8, u16, i16, u32, i32, u64, i64, f16, f32, f64 from 1 on.
const ELEMENT_BYTES: [usize; 12] = [0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

/// Error of reading a container or one of its fields.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TensorError {
    /// The file does not begin with the magic word.
    #[error("it does not begin with \"tensor_file\"")]
    Magic,
    /// The version is not supported.
    #[error("its version must be 1.0, got {0}.{1}")]
    Version(u8, u8),
    /// The file ends before the end of a field or of the table.
    #[error("it ends within {0}")]
    Truncated(String),
    /// The table of fields is not valid.
    #[error("its table of fields is damaged: {0}")]
    Table(String),
    /// A field is missing.
    #[error("it has no field {0}")]
    Missing(&'static str),
    /// A field has another type.
    #[error("its field {0} does not hold 32-bit floats")]
    NotFloat(&'static str),
    /// A field has another shape.
    #[error("its field {name} is {found}, not {wanted}")]
    Shape {
        /// The field.
        name: &'static str,
        /// Shape in the file.
        found: String,
        /// The required shape.
        wanted: String,
    },
    /// An entry is not finite.
    #[error("entry {entry} of its field {name} is not a finite number")]
    NotFinite {
        /// The field.
        name: &'static str,
        /// Index from 0.
        entry: usize,
    },
}

/// An opened container.
pub(super) struct Tensors<'a> {
    fields: Vec<Field<'a>>,
}

struct Field<'a> {
    name: &'a str,
    kind: u8,
    shape: Vec<usize>,
    bytes: &'a [u8],
}

impl<'a> Tensors<'a> {
    /// Reads the table of fields and checks that every field lies within the bytes.
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, TensorError> {
        let mut head = Cursor { bytes, at: 0, what: "its head".to_owned() };
        // A truncated magic word is reported as truncated, not as another format.
        if !MAGIC.starts_with(&bytes[..bytes.len().min(MAGIC.len())]) {
            return Err(TensorError::Magic);
        }
        head.take(MAGIC.len())?;
        let version = head.array::<2>()?;
        if version != VERSION {
            return Err(TensorError::Version(version[0], version[1]));
        }
        let count = u32::from_le_bytes(head.array()?);
        if count > MAX_FIELDS {
            return Err(TensorError::Table(format!("{count} fields")));
        }
        let fields: Result<Vec<_>, _> = (0..count).map(|_| head.field()).collect();
        Ok(Self { fields: fields? })
    }

    /// Shape of a field, or `None` if there is no such field.
    pub(super) fn shape(&self, name: &str) -> Option<&[usize]> {
        self.find(name).map(|field| field.shape.as_slice())
    }

    /// First byte of a field of bytes.
    pub(super) fn byte(&self, name: &'static str) -> Result<u8, TensorError> {
        let field = self.find(name).ok_or(TensorError::Missing(name))?;
        let byte = field.bytes.first().copied().filter(|_| field.kind == 1);
        byte.ok_or_else(|| TensorError::Shape {
            name,
            found: sizes(&field.shape),
            wanted: "one byte".to_owned(),
        })
    }

    /// Shape and values of a field of finite floats with `D` dimensions.
    pub(super) fn floats<const D: usize>(
        &self,
        name: &'static str,
    ) -> Result<([usize; D], Vec<f32>), TensorError> {
        let field = self.find(name).ok_or(TensorError::Missing(name))?;
        if field.kind != FLOAT32 {
            return Err(TensorError::NotFloat(name));
        }
        let shape = field.shape.as_slice().try_into().map_err(|_| TensorError::Shape {
            name,
            found: sizes(&field.shape),
            wanted: format!("of {D} dimensions"),
        })?;
        let numbers = field.bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        let numbers: Vec<f32> = numbers.collect();
        match numbers.iter().position(|number| !number.is_finite()) {
            Some(entry) => Err(TensorError::NotFinite { name, entry }),
            None => Ok((shape, numbers)),
        }
    }

    /// As [`Self::floats`], for a field of a known shape.
    pub(super) fn shaped<const D: usize>(
        &self,
        name: &'static str,
        wanted: [usize; D],
    ) -> Result<Vec<f32>, TensorError> {
        let (shape, numbers) = self.floats::<D>(name)?;
        if shape == wanted {
            return Ok(numbers);
        }
        Err(TensorError::Shape { name, found: sizes(&shape), wanted: sizes(&wanted) })
    }

    fn find(&self, name: &str) -> Option<&Field<'a>> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// Read position, with the name of the current part for errors.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    what: String,
}

impl<'a> Cursor<'a> {
    /// Reads an entry of the table: length and characters of the name, number of dimensions, type
    /// code, offset of the data from the start of the file, sizes.
    fn field(&mut self) -> Result<Field<'a>, TensorError> {
        self.what = "its table of fields".to_owned();
        let length = u16::from_le_bytes(self.array()?);
        let name = std::str::from_utf8(self.take(usize::from(length))?)
            .map_err(|_| TensorError::Table("a name is not UTF-8".to_owned()))?;
        let dimensions = u16::from_le_bytes(self.array()?);
        let damaged = |what: &str| TensorError::Table(format!("{} {what}", short(name)));
        if dimensions > MAX_DIMENSIONS {
            return Err(damaged("has too many dimensions"));
        }
        let [kind] = self.array()?;
        let element = ELEMENT_BYTES.get(usize::from(kind)).copied().filter(|bytes| *bytes > 0);
        let element = element.ok_or_else(|| damaged("has an unknown type"))?;
        let offset = u64::from_le_bytes(self.array()?);
        let mut shape = Vec::new();
        for _ in 0..dimensions {
            shape.push(u64::from_le_bytes(self.array()?));
        }
        let within = |number: u64| usize::try_from(number).ok();
        let too_large = || TensorError::Truncated(format!("the field {}", short(name)));
        let shape: Option<Vec<usize>> = shape.into_iter().map(within).collect();
        let shape = shape.ok_or_else(too_large)?;
        let length = shape.iter().try_fold(element, |bytes, size| bytes.checked_mul(*size));
        let range = within(offset)
            .zip(length)
            .and_then(|(from, length)| self.bytes.get(from..from.checked_add(length)?));
        Ok(Field { name, kind, shape, bytes: range.ok_or_else(too_large)? })
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], TensorError> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        let taken = taken.ok_or_else(|| TensorError::Truncated(self.what.clone()))?;
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], TensorError> {
        let taken = self.take(N)?;
        Ok(taken.try_into().expect("as many bytes as were asked for"))
    }
}

/// First 32 characters of a name from a file.
fn short(name: &str) -> String {
    name.chars().take(32).collect()
}

fn sizes(shape: &[usize]) -> String {
    if shape.is_empty() {
        return "a single number".to_owned();
    }
    let words: Vec<String> = shape.iter().map(usize::to_string).collect();
    words.join(" x ")
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A field to be written, as floats or as bytes.
    pub(in crate::measured) struct Written {
        pub(in crate::measured) name: &'static str,
        pub(in crate::measured) shape: Vec<usize>,
        pub(in crate::measured) numbers: Vec<f32>,
        pub(in crate::measured) bytes: bool,
    }

    /// Writes a container with these fields.
    pub(in crate::measured) fn file(fields: &[Written]) -> Vec<u8> {
        let head = |field: &Written| 2 + field.name.len() + 2 + 1 + 8 + 8 * field.shape.len();
        let mut offset = 18 + fields.iter().map(head).sum::<usize>();
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION);
        bytes.extend((fields.len() as u32).to_le_bytes());
        for field in fields {
            bytes.extend((field.name.len() as u16).to_le_bytes());
            bytes.extend(field.name.as_bytes());
            bytes.extend((field.shape.len() as u16).to_le_bytes());
            bytes.push(if field.bytes { 1 } else { FLOAT32 });
            bytes.extend((offset as u64).to_le_bytes());
            for size in &field.shape {
                bytes.extend((*size as u64).to_le_bytes());
            }
            offset += field.numbers.len() * if field.bytes { 1 } else { 4 };
        }
        for field in fields {
            for number in &field.numbers {
                if field.bytes {
                    bytes.push(*number as u8);
                } else {
                    bytes.extend(number.to_le_bytes());
                }
            }
        }
        bytes
    }

    fn two() -> Vec<u8> {
        let numbers = (0..6).map(|k| k as f32).collect();
        file(&[
            Written { name: "first", shape: vec![2, 3], numbers, bytes: false },
            Written { name: "flag", shape: vec![1], numbers: vec![7.0], bytes: true },
        ])
    }

    #[test]
    fn fields_are_found_by_name_with_their_shapes() {
        let bytes = two();
        let tensors = Tensors::open(&bytes).unwrap();
        let (shape, numbers) = tensors.floats::<2>("first").unwrap();
        assert_eq!((shape, numbers), ([2, 3], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
        assert_eq!(tensors.byte("flag"), Ok(7));
        assert_eq!(tensors.shape("none"), None);
        assert!(tensors.shaped("first", [2, 3]).is_ok());
    }

    #[test]
    fn errors_name_what_is_wrong() {
        let bytes = two();
        let tensors = Tensors::open(&bytes).unwrap();
        let told = |error: TensorError| error.to_string();
        assert_eq!(told(tensors.floats::<2>("ndf").unwrap_err()), "it has no field ndf");
        let error = told(tensors.shaped("first", [3, 2]).unwrap_err());
        assert_eq!(error, "its field first is 2 x 3, not 3 x 2");
        let error = told(tensors.floats::<1>("first").unwrap_err());
        assert_eq!(error, "its field first is 2 x 3, not of 1 dimensions");
        let error = told(tensors.floats::<1>("flag").unwrap_err());
        assert_eq!(error, "its field flag does not hold 32-bit floats");
        assert!(told(tensors.byte("first").unwrap_err()).contains("not one byte"));
        let refused = |bytes: &[u8]| told(Tensors::open(bytes).err().unwrap());
        assert!(refused(b"PNG is another thing").contains("does not begin with"));
        let mut other = bytes.clone();
        other[13] = 1;
        assert!(refused(&other).contains("must be 1.0, got 1.1"));
        let mut other = bytes;
        other[17] = 1;
        assert!(refused(&other).contains("16777218 fields"));
        let bad = Written {
            name: "bad",
            shape: vec![2],
            numbers: vec![0.0, f32::INFINITY],
            bytes: false,
        };
        let bytes = file(&[bad]);
        let error = told(Tensors::open(&bytes).unwrap().floats::<1>("bad").unwrap_err());
        assert_eq!(error, "entry 1 of its field bad is not a finite number");
    }

    #[test]
    fn files_are_rejected_when_truncated_anywhere() {
        let bytes = two();
        for length in 0..bytes.len() {
            let error = Tensors::open(&bytes[..length]).err().unwrap();
            assert!(matches!(error, TensorError::Truncated(_)), "{length}: {error}");
        }
    }

    proptest! {
        #[test]
                fn changed_bytes_are_read_or_rejected(
            changes in prop::collection::vec((0_usize..1000, any::<u8>()), 1..4),
        ) {
            let mut bytes = two();
            for (at, value) in changes {
                let length = bytes.len();
                bytes[at % length] = value;
            }
            if let Ok(tensors) = Tensors::open(&bytes) {
                let _ = tensors.floats::<2>("first");
                let _ = tensors.byte("flag");
            }
        }
    }
}
