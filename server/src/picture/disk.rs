//! The cache on disk: pictures one behind the other in a few large files, the longest unused thrown away first.
//!
//! A file for each picture would be simpler, but making and removing files costs a file system far more than their
//! bytes: with twenty small files a brood it took a fifth of all processor time. So there are segments, which are only
//! appended to and thrown away whole; a picture read from an old one is copied to the newest. Nothing is synced: what
//! a power cut takes or mangles is found by its checksum and rendered again. All calls block.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

use brood_protocol::PictureKey;
use bytes::Bytes;

use super::segment::{self, Entry, RECORD_BYTES};

/// A segment is closed at this share of the cache, so that throwing one away is no great loss ...
const SEGMENTS: u64 = 16;
/// ... and at this size in any case.
const SEGMENT_MOST_BYTES: u64 = 32 << 20;

/// The cache on disk.
#[derive(Debug)]
pub struct Disk {
    root: PathBuf,
    max_bytes: u64,
    segment_bytes: u64,
    index: Mutex<Index>,
    /// Held while something is appended.
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

/// The segment that is being appended to.
#[derive(Debug)]
struct Tail {
    number: u64,
    file: File,
    bytes: u64,
}

impl Disk {
    /// Opens a cache directory, making it where it is missing, and finds what is there.
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
                // Of an older version, whose pictures are rendered again.
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

    /// Whether a picture is there, as far as is known without looking at it.
    pub fn contains(&self, key: PictureKey) -> bool {
        self.lock().places.contains_key(&key)
    }

    /// Reads a picture; `None` where it is not there or damaged.
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
                tracing::warn!(%key, "a cached picture is damaged; it will be rendered again");
            }
            Err(error) => tracing::warn!(%error, %key, "a cached picture cannot be read"),
        }
        self.lock().forget(key, place.segment);
        None
    }

    /// Writes a picture; a failure is logged, and costs another rendering at most.
    pub fn write(&self, key: PictureKey, picture: &[u8]) {
        self.write_all(&[(key, picture)]);
    }

    /// Writes pictures together.
    pub fn write_all<T: AsRef<[u8]>>(&self, pictures: &[(PictureKey, T)]) {
        if let Err(error) = self.append(pictures) {
            tracing::warn!(%error, "pictures could not be kept on disk");
        }
        self.evict();
    }

    /// Bytes and pictures that are kept.
    pub fn size(&self) -> (u64, usize) {
        let index = self.lock();
        (index.bytes, index.places.len())
    }

    fn append<T: AsRef<[u8]>>(&self, pictures: &[(PictureKey, T)]) -> io::Result<()> {
        let mut tail = self.tail.lock().expect("nothing panics under this lock");
        let room = pictures.iter().map(|(_, picture)| picture.as_ref().len() + RECORD_BYTES);
        let mut records = Vec::with_capacity(room.sum());
        // Taken out: after a failure nobody knows where the file ends, and the next write begins another one.
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
        // Whatever a failed write left under that number is of no use.
        let file = File::create(self.path(number))?;
        Ok(Tail { number, file, bytes: 0 })
    }

    fn evict(&self) {
        loop {
            // Not in a `while let`, which would hold the lock until the end of the body.
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
                tracing::warn!(%error, segment = oldest, "cached pictures cannot be removed");
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
    /// Pictures at the end of a segment; one that is elsewhere already is here from now on.
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

    fn forget(&mut self, key: PictureKey, number: u64) {
        // It may have been written again meanwhile.
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

    /// 168 bytes a picture with its record.
    fn write(disk: &Disk, n: u8) {
        disk.write(key(n), &[n; 100]);
    }

    #[test]
    fn picture_is_read_back_also_after_reopening() {
        let dir = tempfile::tempdir().unwrap();
        let disk = Disk::open(dir.path(), 1 << 20).unwrap();
        assert_eq!(disk.read(key(1)), None);
        disk.write_all(&[(key(1), "picture"), (key(2), ""), (key(1), "again")]);
        assert_eq!(disk.read(key(1)).unwrap(), "again");
        for _ in 0..2 {
            let again = Disk::open(dir.path(), 1 << 20).unwrap();
            assert_eq!(again.read(key(1)).unwrap(), "again");
            assert_eq!(again.read(key(2)).unwrap(), "");
            assert_eq!(again.size().1, 2);
        }
        let later = Disk::open(dir.path(), 1 << 20).unwrap();
        later.write(key(1), b"later");
        assert_eq!(Disk::open(dir.path(), 1 << 20).unwrap().read(key(1)).unwrap(), "later");
        assert_eq!(files(dir.path()).len(), 2, "a segment of the last run is not appended to");
    }

    #[test]
    fn picture_is_gone_when_a_byte_of_it_is_damaged() {
        let dir = tempfile::tempdir().unwrap();
        Disk::open(dir.path(), 1 << 20).unwrap().write(key(1), b"picture");
        let file = files(dir.path()).remove(0);
        let whole = fs::read(&file).unwrap();
        for place in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 1;
            fs::write(&file, bytes).unwrap();
            let disk = Disk::open(dir.path(), 1 << 20).unwrap();
            assert_eq!(disk.read(key(1)), None, "byte {place}");
            assert!(!disk.contains(key(1)));
        }
    }

    #[test]
    fn pictures_before_the_break_are_there_when_a_segment_is_cut_off() {
        let dir = tempfile::tempdir().unwrap();
        let disk = Disk::open(dir.path(), 1 << 20).unwrap();
        (1..4).for_each(|n| write(&disk, n));
        let file = files(dir.path()).remove(0);
        let whole = fs::read(&file).unwrap();
        for length in 0..whole.len() {
            fs::write(&file, &whole[..length]).unwrap();
            let disk = Disk::open(dir.path(), 1 << 20).unwrap();
            assert_eq!(disk.size().1, length / 168, "{length} bytes");
            assert_eq!(disk.read(key(1)).is_some(), length >= 168);
        }
    }

    #[test]
    fn longest_unused_pictures_go_when_the_bound_is_reached() {
        let dir = tempfile::tempdir().unwrap();
        let disk = Disk::open(dir.path(), 4 * 168).unwrap();
        (0..4).for_each(|n| write(&disk, n));
        disk.read(key(0)).unwrap();
        assert_eq!(disk.size(), (4 * 168, 4), "its first copy is gone");
        write(&disk, 4);
        let there: Vec<_> = (0..5).map(|n| disk.contains(key(n))).collect();
        assert_eq!(there, [true, false, true, true, true]);
        assert_eq!(files(dir.path()).len(), 4);
        let smaller = Disk::open(dir.path(), 168).unwrap();
        assert_eq!(smaller.size(), (168, 1));
        assert!(smaller.contains(key(4)));
        smaller.write(key(5), &[5; 1000]);
        assert_eq!(smaller.size(), (0, 0), "what is larger than the cache is not kept");
    }

    #[test]
    fn files_of_another_layout_are_removed_when_opened() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("ab/cd")).unwrap();
        fs::write(dir.path().join("ab/cd/picture"), b"old").unwrap();
        fs::write(dir.path().join("stray"), b"old").unwrap();
        Disk::open(dir.path(), 1 << 20).unwrap();
        assert!(files(dir.path()).is_empty());
    }

    #[test]
    fn pictures_are_kept_again_after_the_folder_was_lost() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("cache");
        let disk = Disk::open(&root, 16 * 168).unwrap();
        write(&disk, 1);
        fs::remove_dir_all(&root).unwrap();
        assert_eq!(disk.read(key(1)), None);
        write(&disk, 2);
        assert_eq!(disk.read(key(2)).unwrap(), [2; 100].as_slice());
    }
}
