//! Segment file of the disk cache: a sequence of records, each a picture with its key and a
//! checksum over both.
//!
//! Independent of eviction.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use brood_protocol::PictureKey;
use bytes::Bytes;

/// Bytes of a record besides the picture: checksum, key, length.
pub const RECORD_BYTES: usize = 32 + KEYED_BYTES;
/// Bytes of key and length, which the checksum covers.
const KEYED_BYTES: usize = 36;
const EXTENSION: &str = "pictures";

/// Offset of a record and length of its picture.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    offset: u64,
    length: u32,
}

/// Returns the file name of a segment.
pub fn name(number: u64) -> String {
    format!("{number:08}.{EXTENSION}")
}

/// Returns the number of a segment file; `None` for other files.
pub fn number(path: &Path) -> Option<u64> {
    let number = path.file_stem()?.to_str()?.parse().ok()?;
    (path.file_name()?.to_str()? == name(number)).then_some(number)
}

/// Appends a record to a buffer that starts at file offset `at` minus the buffer's length.
///
/// # Errors
/// [`io::ErrorKind::FileTooLarge`] for a picture of 4 GiB or more.
pub fn push(buffer: &mut Vec<u8>, at: u64, key: PictureKey, picture: &[u8]) -> io::Result<Entry> {
    let length = u32::try_from(picture.len()).map_err(|_| {
        io::Error::new(io::ErrorKind::FileTooLarge, "a picture must be smaller than 4 GiB")
    })?;
    let start = buffer.len();
    buffer.extend_from_slice(&[0; 32]);
    buffer.extend_from_slice(&key.0);
    buffer.extend_from_slice(&length.to_le_bytes());
    buffer.extend_from_slice(picture);
    let checksum = blake3::hash(&buffer[start + 32..]);
    buffer[start..start + 32].copy_from_slice(checksum.as_bytes());
    Ok(Entry { offset: at, length })
}

/// Returns a file's length and its records, from their headers only.
///
/// # Errors
/// Error of the file system.
pub fn scan(path: &Path) -> io::Result<(u64, Vec<(PictureKey, Entry)>)> {
    let file = File::open(path)?;
    let bytes = file.metadata()?.len();
    let mut file = BufReader::with_capacity(RECORD_BYTES, file);
    let mut found = Vec::new();
    let mut offset = 0;
    while offset + RECORD_BYTES as u64 <= bytes {
        let mut head = [0; RECORD_BYTES];
        file.read_exact(&mut head)?;
        let (key, length) = head_of(&head[32..]);
        let end = offset + RECORD_BYTES as u64 + u64::from(length);
        // The last write was incomplete or the length is damaged: later records cannot be found.
        if end > bytes {
            break;
        }
        found.push((key, Entry { offset, length }));
        file.seek_relative(length.into())?;
        offset = end;
    }
    Ok((bytes, found))
}

/// Reads a picture; `None` if its record is damaged.
///
/// # Errors
/// Error of the file system.
pub fn read(path: &Path, key: PictureKey, entry: Entry) -> io::Result<Option<Bytes>> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::Start(entry.offset))?;
    let mut record = vec![0; RECORD_BYTES + entry.length as usize];
    match file.read_exact(&mut record) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        other => other?,
    }
    let sound = blake3::hash(&record[32..]).as_bytes()[..] == record[..32]
        && head_of(&record[32..]) == (key, entry.length);
    Ok(sound.then(|| Bytes::from(record).slice(RECORD_BYTES..)))
}

fn head_of(bytes: &[u8]) -> (PictureKey, u32) {
    let mut key = [0; 32];
    key.copy_from_slice(&bytes[..32]);
    let mut length = [0; 4];
    length.copy_from_slice(&bytes[32..KEYED_BYTES]);
    (PictureKey(key), u32::from_le_bytes(length))
}
