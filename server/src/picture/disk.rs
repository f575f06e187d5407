//! The cache on disk: one file a picture with a checksum behind it, the least recently used thrown away first.
//!
//! Nothing is synced: what a power cut takes or mangles is found by its checksum and rendered again. All calls block.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

use brood_protocol::PictureKey;
use bytes::Bytes;

const CHECKSUM_BYTES: usize = 32;

/// The cache on disk.
#[derive(Debug)]
pub struct Disk {
    root: PathBuf,
    max_bytes: u64,
    index: Mutex<Index>,
}

#[derive(Debug, Default)]
struct Index {
    entries: HashMap<PictureKey, Entry>,
    by_use: BTreeMap<u64, PictureKey>,
    bytes: u64,
    clock: u64,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    bytes: u64,
    used: u64,
}

impl Disk {
    /// Opens a cache directory, making it where it is missing, and finds what is there.
    pub fn open(root: &Path, max_bytes: u64) -> io::Result<Self> {
        fs::create_dir_all(root)?;
        let mut found = Vec::new();
        for folder in folders(root)? {
            for file in fs::read_dir(folder)? {
                let file = file?;
                let path = file.path();
                let name = file.file_name();
                match name.to_str().and_then(|name| name.parse::<PictureKey>().ok()) {
                    Some(key) => {
                        let data = file.metadata()?;
                        found.push((data.modified()?, key, data.len()));
                    }
                    // A write that never came to its end.
                    None => fs::remove_file(path)?,
                }
            }
        }
        found.sort();
        let disk = Self { root: root.to_owned(), max_bytes, index: Mutex::default() };
        for (_, key, bytes) in found {
            disk.lock().touch(key, bytes);
        }
        disk.evict();
        Ok(disk)
    }

    /// Whether a picture is there, as far as is known without looking at it.
    pub fn contains(&self, key: PictureKey) -> bool {
        self.lock().entries.contains_key(&key)
    }

    /// Reads a picture; `None` where it is not there or damaged.
    pub fn read(&self, key: PictureKey) -> Option<Bytes> {
        if !self.contains(key) {
            return None;
        }
        let mut bytes = match fs::read(self.path(key)) {
            Ok(bytes) => bytes,
            Err(error) => {
                tracing::warn!(%error, %key, "a cached picture cannot be read");
                self.forget(key);
                return None;
            }
        };
        let body = bytes.len().checked_sub(CHECKSUM_BYTES);
        let sound =
            body.filter(|body| blake3::hash(&bytes[..*body]).as_bytes()[..] == bytes[*body..]);
        let Some(body) = sound else {
            tracing::warn!(%key, "a cached picture is damaged; it will be rendered again");
            self.forget(key);
            return None;
        };
        let length = bytes.len() as u64;
        self.lock().touch(key, length);
        bytes.truncate(body);
        Some(Bytes::from(bytes))
    }

    /// Writes a picture; a failure is logged, and costs another rendering at most.
    pub fn write(&self, key: PictureKey, picture: &[u8]) {
        match self.try_write(key, picture) {
            Ok(bytes) => {
                self.lock().touch(key, bytes);
                self.evict();
            }
            Err(error) => tracing::warn!(%error, %key, "a picture could not be kept on disk"),
        }
    }

    /// Bytes and files that are kept.
    pub fn size(&self) -> (u64, usize) {
        let index = self.lock();
        (index.bytes, index.entries.len())
    }

    fn try_write(&self, key: PictureKey, picture: &[u8]) -> io::Result<u64> {
        let path = self.path(key);
        let folder = path.parent().expect("pictures lie in folders");
        fs::create_dir_all(folder)?;
        let mut bytes = Vec::with_capacity(picture.len() + CHECKSUM_BYTES);
        bytes.extend_from_slice(picture);
        bytes.extend_from_slice(blake3::hash(picture).as_bytes());
        let draft = folder.join(format!("{key}.new"));
        fs::write(&draft, &bytes)?;
        fs::rename(&draft, &path)?;
        Ok(bytes.len() as u64)
    }

    fn evict(&self) {
        loop {
            let key = {
                let index = self.lock();
                if index.bytes <= self.max_bytes {
                    return;
                }
                match index.by_use.first_key_value() {
                    Some((_, key)) => *key,
                    None => return,
                }
            };
            self.forget(key);
        }
    }

    fn forget(&self, key: PictureKey) {
        self.lock().remove(key);
        if let Err(error) = fs::remove_file(self.path(key))
            && error.kind() != io::ErrorKind::NotFound
        {
            tracing::warn!(%error, %key, "a cached picture cannot be removed");
        }
    }

    fn path(&self, key: PictureKey) -> PathBuf {
        let name = key.to_string();
        self.root.join(&name[..2]).join(&name[2..4]).join(name)
    }

    fn lock(&self) -> MutexGuard<'_, Index> {
        self.index.lock().expect("nothing panics under this lock")
    }
}

impl Index {
    fn touch(&mut self, key: PictureKey, bytes: u64) {
        self.remove(key);
        self.clock += 1;
        self.entries.insert(key, Entry { bytes, used: self.clock });
        self.by_use.insert(self.clock, key);
        self.bytes += bytes;
    }

    fn remove(&mut self, key: PictureKey) {
        if let Some(entry) = self.entries.remove(&key) {
            self.by_use.remove(&entry.used);
            self.bytes -= entry.bytes;
        }
    }
}

fn folders(root: &Path) -> io::Result<Vec<PathBuf>> {
    let mut folders = Vec::new();
    for first in fs::read_dir(root)? {
        let first = first?;
        if first.file_type()?.is_dir() {
            for second in fs::read_dir(first.path())? {
                let second = second?;
                if second.file_type()?.is_dir() {
                    folders.push(second.path());
                }
            }
        }
    }
    Ok(folders)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(n: u8) -> PictureKey {
        PictureKey([n; 32])
    }

    #[test]
    fn picture_is_read_back_also_after_reopening() {
        let dir = tempfile::tempdir().unwrap();
        let disk = Disk::open(dir.path(), 1 << 20).unwrap();
        assert_eq!(disk.read(key(1)), None);
        disk.write(key(1), b"picture");
        assert_eq!(disk.read(key(1)).unwrap(), "picture");
        let again = Disk::open(dir.path(), 1 << 20).unwrap();
        assert_eq!(again.read(key(1)).unwrap(), "picture");
        assert_eq!(again.size(), (39, 1));
    }

    #[test]
    fn picture_is_gone_when_its_file_is_damaged() {
        let dir = tempfile::tempdir().unwrap();
        let disk = Disk::open(dir.path(), 1 << 20).unwrap();
        disk.write(key(1), b"picture");
        let path = disk.path(key(1));
        let mut bytes = fs::read(&path).unwrap();
        bytes[2] ^= 1;
        fs::write(&path, bytes).unwrap();
        assert_eq!(disk.read(key(1)), None);
        assert!(!path.exists() && !disk.contains(key(1)));
        disk.write(key(2), b"picture");
        fs::write(disk.path(key(2)), b"").unwrap();
        assert_eq!(disk.read(key(2)), None);
    }

    #[test]
    fn least_recently_used_pictures_go_when_the_bound_is_reached() {
        let dir = tempfile::tempdir().unwrap();
        let disk = Disk::open(dir.path(), 3 * 132).unwrap();
        for n in 0..3 {
            disk.write(key(n), &[n; 100]);
        }
        disk.read(key(0)).unwrap();
        disk.write(key(3), &[3; 100]);
        let there: Vec<_> = (0..4).map(|n| disk.contains(key(n))).collect();
        assert_eq!(there, [true, false, true, true]);
        assert!(!disk.path(key(1)).exists());
        let smaller = Disk::open(dir.path(), 132).unwrap();
        assert_eq!(smaller.size(), (132, 1));
    }

    #[test]
    fn unfinished_files_are_removed_when_opened() {
        let dir = tempfile::tempdir().unwrap();
        let disk = Disk::open(dir.path(), 1 << 20).unwrap();
        disk.write(key(1), b"picture");
        let draft = disk.path(key(1)).with_extension("new");
        fs::write(&draft, b"half").unwrap();
        Disk::open(dir.path(), 1 << 20).unwrap();
        assert!(!draft.exists());
    }
}
