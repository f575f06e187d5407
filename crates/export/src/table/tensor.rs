//! Writer of RGL's container: named arrays of numbers with a table of fields at the beginning.
//!
//! The layout is in the reader, `crates/brdf/src/measured/tensor.rs`. Data begin at multiples of 8
//! bytes.

const MAGIC: &[u8; 12] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
/// Type codes of bytes and of 32-bit floats.
const BYTE: u8 = 1;
const FLOAT32: u8 = 10;
const ALIGNMENT: usize = 8;

/// A named array.
pub(super) struct Field<'a> {
    pub(super) name: &'static str,
    pub(super) shape: Vec<usize>,
    pub(super) data: Data<'a>,
}

/// Elements of an array.
#[derive(Clone, Copy)]
pub(super) enum Data<'a> {
    Bytes(&'a [u8]),
    Floats(&'a [f32]),
}

impl Data<'_> {
    fn length(self) -> usize {
        match self {
            Self::Bytes(bytes) => bytes.len(),
            Self::Floats(floats) => size_of_val(floats),
        }
    }
}

/// Returns a file with these fields. Each has as many elements as its shape says.
pub(super) fn file(fields: &[Field<'_>]) -> Vec<u8> {
    let count = u32::try_from(fields.len()).expect("a file has few fields");
    let head = |field: &Field<'_>| 2 + field.name.len() + 2 + 1 + 8 + 8 * field.shape.len();
    let mut offset = MAGIC.len() + VERSION.len() + 4 + fields.iter().map(head).sum::<usize>();
    let mut bytes = [&MAGIC[..], &VERSION, &count.to_le_bytes()].concat();
    let short = |length: usize| u16::try_from(length).expect("names and shapes are short");
    for field in fields {
        offset = offset.next_multiple_of(ALIGNMENT);
        bytes.extend(short(field.name.len()).to_le_bytes());
        bytes.extend(field.name.as_bytes());
        bytes.extend(short(field.shape.len()).to_le_bytes());
        bytes.push(if matches!(field.data, Data::Bytes(_)) { BYTE } else { FLOAT32 });
        bytes.extend((offset as u64).to_le_bytes());
        bytes.extend(field.shape.iter().flat_map(|size| (*size as u64).to_le_bytes()));
        offset += field.data.length();
    }
    bytes.reserve(offset - bytes.len());
    for field in fields {
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
        match field.data {
            Data::Bytes(data) => bytes.extend(data),
            Data::Floats(data) => bytes.extend(data.iter().flat_map(|value| value.to_le_bytes())),
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_aligned_and_described_at_the_beginning() {
        let bytes = file(&[
            Field { name: "abc", shape: vec![3], data: Data::Bytes(b"xyz") },
            Field { name: "of", shape: vec![1, 2], data: Data::Floats(&[1.0, -2.0]) },
        ]);
        // The head has 12 + 2 + 4 bytes, the entries 24 and 31: data begin at 80 and 88.
        assert_eq!(&bytes[..18], b"tensor_file\0\x01\0\x02\0\0\0");
        assert_eq!(&bytes[18..42], b"\x03\0abc\x01\0\x01\x50\0\0\0\0\0\0\0\x03\0\0\0\0\0\0\0");
        assert_eq!(&bytes[42..57], b"\x02\0of\x02\0\x0a\x58\0\0\0\0\0\0\0");
        assert_eq!(&bytes[80..83], b"xyz");
        assert_eq!(&bytes[88..], [1.0_f32.to_le_bytes(), (-2.0_f32).to_le_bytes()].concat());
    }
}
