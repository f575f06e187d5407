//! Picture cache on disk: pictures appended to a few large segment files; the least recently used
//! segment is removed first.
//!
//! One file per picture would be simpler, but twenty small files per brood took a fifth of all
//! processor time: creating and removing files costs far more than writing their bytes. Segments
//! are only appended to and removed as a whole; a picture read from an old segment is copied to the
//! newest. Nothing is synced: records lost or damaged by a power cut fail their checksum and are
//! rendered again. All calls block.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

use brood_protocol::PictureKey;
use bytes::Bytes;

use super::segment::{self, Entry, RECORD_BYTES};

/// Folder of the cache in the data directory.
pub const FOLDER: &str = "cache";
/// A segment is closed at 1/16 of the cache, so that removing one loses little ...
const SEGMENTS: u64 = 16;
/// ... and never grows beyond 32 MiB.
const SEGMENT_MOST_BYTES: u64 = 32 << 20;

/// Picture cache on disk.
#[derive(Debug)]
pub struct DiskCache {
    root: PathBuf,
    max_bytes: u64,
    segment_bytes: u64,
    index: Mutex<Index>,
    /// Newest segment; locked while records are appended.
    tail: Mutex<Option<Tail>>,
}

#[derive(Debug, Default)]
struct Index {
    places: HashMap<PictureKey, Place>,
    segments: BTreeMap<u64, Segment>,
    bytes: u64,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    segment: u64,
    entry: Entry,
}

#[derive(Debug, Default)]
struct Segment {
    bytes: u64,
    keys: HashSet<PictureKey>,
}

/// Segment that is being appended to.
#[derive(Debug)]
struct Tail {
    number: u64,
    file: File,
    bytes: u64,
}

/// Counts the pictures in the cache of a data directory that are whole, and those that are damaged.
/// A server renders damaged ones again. Reads the cache only; it may be in use.
///
/// # Errors
/// Error of the file system.
pub fn check_pictures(data: &Path) -> io::Result<(u64, u64)> {
    let (mut whole, mut damaged) = (0, 0);
    let files = match fs::read_dir(data.join(FOLDER)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok((0, 0)),
        files => files?,
    };
    for file in files {
        let path = file?.path();
        if segment::number(&path).is_none() {
            continue;
        }
        let (_, entries) = match segment::scan(&path) {
            // Removed by the server in the meantime.
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            found => found?,
        };
        for (key, entry) in entries {
            match segment::read(&path, key, entry) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => break,
                Ok(None) => damaged += 1,
                Ok(Some(_)) => whole += 1,
                Err(error) => return Err(error),
            }
        }
    }
    Ok((whole, damaged))
}

impl DiskCache {
    /// Opens a cache directory, creating it if missing, and indexes its segments.
    ///
    /// # Errors
    /// Error of the file system.
    pub fn open(root: &Path, max_bytes: u64) -> io::Result<Self> {
        fs::create_dir_all(root)?;
        let mut index = Index::default();
        for file in fs::read_dir(root)? {
            let path = file?.path();
            match segment::number(&path) {
                Some(number) => {
                    let (bytes, entries) = segment::scan(&path)?;
                    index.add(number, bytes, entries);
                }
                // Left by an older version; its pictures are rendered again.
                None if path.is_dir() => fs::remove_dir_all(path)?,
                None => fs::remove_file(path)?,
            }
        }
        let disk = Self {
            root: root.to_owned(),
            max_bytes,
            segment_bytes: (max_bytes / SEGMENTS).min(SEGMENT_MOST_BYTES),
            index: Mutex::new(index),
            tail: Mutex::default(),
        };
        disk.evict();
        Ok(disk)
    }

    /// Returns true if a picture is indexed; the record may still be damaged.
    pub fn contains(&self, key: PictureKey) -> bool {
        self.lock().places.contains_key(&key)
    }

    /// Reads a picture; `None` if it is missing or damaged.
    pub fn read(&self, key: PictureKey) -> Option<Bytes> {
        let (place, old) = {
            let index = self.lock();
            let place = *index.places.get(&key)?;
            let newer = index.segments.range(place.segment + 1..).count();
            (place, newer > index.segments.len() / 2)
        };
        match segment::read(&self.path(place.segment), key, place.entry) {
            Ok(Some(bytes)) => {
                if old {
                    self.write(key, &bytes);
                }
                return Some(bytes);
            }
            Ok(None) => {
                tracing::warn!(%key, "a cached picture is damaged and will be rendered again");
            }
            Err(error) => tracing::warn!(%error, %key, "cannot read a cached picture"),
        }
        self.lock().remove(key, place.segment);
        None
    }

    /// Writes a picture. A failure is only logged: the picture can be rendered again.
    pub fn write(&self, key: PictureKey, picture: &[u8]) {
        self.write_all(&[(key, picture)]);
    }

    /// Writes several pictures at once.
    pub fn write_all<T: AsRef<[u8]>>(&self, pictures: &[(PictureKey, T)]) {
        if let Err(error) = self.append(pictures) {
            tracing::warn!(%error, "cannot write pictures to the cache");
        }
        self.evict();
    }

    /// Size in bytes and number of pictures.
    pub fn size(&self) -> (u64, usize) {
        let index = self.lock();
        (index.bytes, index.places.len())
    }

    fn append<T: AsRef<[u8]>>(&self, pictures: &[(PictureKey, T)]) -> io::Result<()> {
        let mut tail = self.tail.lock().expect("nothing panics under this lock");
        let capacity = pictures.iter().map(|(_, picture)| picture.as_ref().len() + RECORD_BYTES);
        let mut records = Vec::with_capacity(capacity.sum());
        // Taken out: after a failed write the end of the file is unknown, so the next write begins
        // a new segment.
        let mut open = match tail.take() {
            Some(open) if open.bytes < self.segment_bytes => open,
            _ => self.next_segment()?,
        };
        let mut entries = Vec::with_capacity(pictures.len());
        for (key, picture) in pictures {
            let at = open.bytes + records.len() as u64;
            entries.push((*key, segment::push(&mut records, at, *key, picture.as_ref())?));
        }
        open.file.write_all(&records)?;
        open.bytes += records.len() as u64;
        self.lock().add(open.number, records.len() as u64, entries);
        *tail = Some(open);
        Ok(())
    }

    fn next_segment(&self) -> io::Result<Tail> {
        fs::create_dir_all(&self.root)?;
        let number = self.lock().segments.last_key_value().map_or(0, |(last, _)| last + 1);
        // Truncates what a failed write may have left under this number.
        let file = File::create(self.path(number))?;
        Ok(Tail { number, file, bytes: 0 })
    }

    fn evict(&self) {
        loop {
            // Not a `while let`, which would hold the lock until the end of the body.
            let dropped = self.lock().drop_oldest_beyond(self.max_bytes);
            let Some(oldest) = dropped else { return };
            let mut tail = self.tail.lock().expect("nothing panics under this lock");
            if tail.as_ref().is_some_and(|tail| tail.number == oldest) {
                *tail = None;
            }
            drop(tail);
            if let Err(error) = fs::remove_file(self.path(oldest))
                && error.kind() != io::ErrorKind::NotFound
            {
                tracing::warn!(%error, segment = oldest, "cannot remove a cache segment");
            }
        }
    }

    fn path(&self, number: u64) -> PathBuf {
        self.root.join(segment::name(number))
    }

    fn lock(&self) -> MutexGuard<'_, Index> {
        self.index.lock().expect("nothing panics under this lock")
    }
}

impl Index {
    /// Adds records at the end of a segment; they replace records of the same keys in older
    /// segments.
    fn add(&mut self, number: u64, bytes: u64, entries: Vec<(PictureKey, Entry)>) {
        self.bytes += bytes;
        for (key, entry) in entries {
            let before = self.places.get(&key).map(|place| place.segment);
            if before.is_some_and(|before| before > number) {
                continue;
            }
            if let Some(segment) = before.and_then(|before| self.segments.get_mut(&before)) {
                segment.keys.remove(&key);
            }
            self.places.insert(key, Place { segment: number, entry });
            self.segments.entry(number).or_default().keys.insert(key);
        }
        self.segments.entry(number).or_default().bytes += bytes;
    }

    fn remove(&mut self, key: PictureKey, number: u64) {
        // The picture may have been written again meanwhile.
        if self.places.get(&key).is_some_and(|place| place.segment == number) {
            self.places.remove(&key);
            if let Some(segment) = self.segments.get_mut(&number) {
                segment.keys.remove(&key);
            }
        }
    }

    fn drop_oldest_beyond(&mut self, max_bytes: u64) -> Option<u64> {
        if self.bytes <= max_bytes {
            return None;
        }
        let (oldest, segment) = self.segments.pop_first()?;
        self.bytes -= segment.bytes;
        for key in &segment.keys {
            self.places.remove(key);
        }
        Some(oldest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(n: u8) -> PictureKey {
        PictureKey([n; 32])
    }

    fn files(dir: &Path) -> Vec<PathBuf> {
        fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).collect()
    }

    /// Writes a picture of 168 bytes including its record header.
    fn write(disk: &DiskCache, n: u8) {
        disk.write(key(n), &[n; 100]);
    }

    #[test]
    fn picture_is_read_back_after_reopening() {
        let dir = tempfile::tempdir().unwrap();
        let disk = DiskCache::open(dir.path(), 1 << 20).unwrap();
        assert_eq!(disk.read(key(1)), None);
        disk.write_all(&[(key(1), "picture"), (key(2), ""), (key(1), "again")]);
        assert_eq!(disk.read(key(1)).unwrap(), "again");
        for _ in 0..2 {
            let again = DiskCache::open(dir.path(), 1 << 20).unwrap();
            assert_eq!(again.read(key(1)).unwrap(), "again");
            assert_eq!(again.read(key(2)).unwrap(), "");
            assert_eq!(again.size().1, 2);
        }
        let later = DiskCache::open(dir.path(), 1 << 20).unwrap();
        later.write(key(1), b"later");
        assert_eq!(DiskCache::open(dir.path(), 1 << 20).unwrap().read(key(1)).unwrap(), "later");
        assert_eq!(files(dir.path()).len(), 2, "a segment of an earlier run is not appended to");
    }

    #[test]
    fn picture_is_dropped_when_one_of_its_bytes_is_damaged() {
        let dir = tempfile::tempdir().unwrap();
        DiskCache::open(dir.path(), 1 << 20).unwrap().write(key(1), b"picture");
        let file = files(dir.path()).remove(0);
        let whole = fs::read(&file).unwrap();
        for place in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 1;
            fs::write(&file, bytes).unwrap();
            let disk = DiskCache::open(dir.path(), 1 << 20).unwrap();
            assert_eq!(disk.read(key(1)), None, "byte {place}");
            assert!(!disk.contains(key(1)));
        }
    }

    #[test]
    fn complete_records_are_read_when_a_segment_is_truncated() {
        let dir = tempfile::tempdir().unwrap();
        let disk = DiskCache::open(dir.path(), 1 << 20).unwrap();
        (1..4).for_each(|n| write(&disk, n));
        let file = files(dir.path()).remove(0);
        let whole = fs::read(&file).unwrap();
        for length in 0..whole.len() {
            fs::write(&file, &whole[..length]).unwrap();
            let disk = DiskCache::open(dir.path(), 1 << 20).unwrap();
            assert_eq!(disk.size().1, length / 168, "{length} bytes");
            assert_eq!(disk.read(key(1)).is_some(), length >= 168);
        }
    }

    #[test]
    fn least_recently_used_pictures_are_removed_when_the_cache_is_full() {
        let dir = tempfile::tempdir().unwrap();
        let disk = DiskCache::open(dir.path(), 4 * 168).unwrap();
        (0..4).for_each(|n| write(&disk, n));
        disk.read(key(0)).unwrap();
        assert_eq!(disk.size(), (4 * 168, 4), "its first copy is removed");
        write(&disk, 4);
        let there: Vec<_> = (0..5).map(|n| disk.contains(key(n))).collect();
        assert_eq!(there, [true, false, true, true, true]);
        assert_eq!(files(dir.path()).len(), 4);
        let smaller = DiskCache::open(dir.path(), 168).unwrap();
        assert_eq!(smaller.size(), (168, 1));
        assert!(smaller.contains(key(4)));
        smaller.write(key(5), &[5; 1000]);
        assert_eq!(smaller.size(), (0, 0), "a picture larger than the cache is not kept");
    }

    #[test]
    fn files_of_another_layout_are_removed_when_opened() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("ab/cd")).unwrap();
        fs::write(dir.path().join("ab/cd/picture"), b"old").unwrap();
        fs::write(dir.path().join("stray"), b"old").unwrap();
        DiskCache::open(dir.path(), 1 << 20).unwrap();
        assert!(files(dir.path()).is_empty());
    }

    #[test]
    fn pictures_are_written_again_after_the_folder_was_removed() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("cache");
        let disk = DiskCache::open(&root, 16 * 168).unwrap();
        write(&disk, 1);
        fs::remove_dir_all(&root).unwrap();
        assert_eq!(disk.read(key(1)), None);
        write(&disk, 2);
        assert_eq!(disk.read(key(2)).unwrap(), [2; 100].as_slice());
    }
}
