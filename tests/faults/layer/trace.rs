//! Trace of all changes to the files of a data directory, and the directory that a power cut would
//! leave.
//!
//! Contents are on the disk once their file was synced; names, once their folder was. What came
//! later may be on the disk or not: contents in any order and in parts, names in their order.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Written as a whole or not at all.
const SECTOR_BYTES: u64 = 512;

/// Records of the library, in their order.
pub struct Trace {
    root: PathBuf,
    records: Vec<Record>,
}

struct Record {
    change: Change,
    path: PathBuf,
    at: u64,
    content: Vec<u8>,
    /// Length of the trace with this record.
    end: u64,
}

#[derive(Debug, Clone, Copy)]
enum Change {
    Written,
    Resized,
    Synced,
    Created,
    Renamed,
    Removed,
}

/// Content of a file.
#[derive(Default)]
struct Content {
    on_disk: Vec<u8>,
    /// Indices of the records since the last sync.
    later: Vec<usize>,
}

/// Names of files; the values are indices of contents.
type Names = BTreeMap<PathBuf, usize>;

/// Changes of names that are not on the disk.
enum Rename {
    Add(PathBuf, usize),
    Move(PathBuf, PathBuf),
    Remove(PathBuf),
}

impl Trace {
    pub(super) fn read(file: &Path, root: &Path) -> Self {
        let bytes = fs::read(file).unwrap();
        let mut records = Vec::new();
        let mut rest = bytes.as_slice();
        let mut take = |count: u64| {
            let (taken, later) = rest.split_at(usize::try_from(count).unwrap());
            rest = later;
            taken
        };
        let mut end = 0;
        while end < bytes.len() as u64 {
            let mut number = || u64::from_ne_bytes(take(8).try_into().unwrap());
            let [kind, at, name, count] = std::array::from_fn(|_| number());
            let change = match kind {
                0 => Change::Written,
                1 => Change::Resized,
                2 => Change::Synced,
                3 => Change::Created,
                4 => Change::Renamed,
                5 => Change::Removed,
                other => panic!("record {other} in the trace"),
            };
            let path = PathBuf::from(std::str::from_utf8(take(name)).unwrap());
            let content = take(count).to_vec();
            end += 32 + name + count;
            records.push(Record { change, path, at, content, end });
        }
        Self { root: root.to_owned(), records }
    }

    /// Number of records.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Length of the trace with its first records.
    pub fn end(&self, records: usize) -> u64 {
        self.records[..records].last().map_or(0, |record| record.end)
    }

    /// Writes the files that are left if the power is cut after this many records. `draw` returns a
    /// random number below its argument.
    pub fn cut(&self, records: usize, into: &Path, mut draw: impl FnMut(u64) -> u64) {
        let (mut contents, mut live, mut on_disk) = (Vec::new(), Names::new(), Names::new());
        let mut later: Vec<Rename> = Vec::new();
        for (index, record) in self.records[..records].iter().enumerate() {
            let path = &record.path;
            match record.change {
                Change::Written | Change::Resized => {
                    let content: &mut Content = &mut contents[live[path]];
                    content.later.push(index);
                }
                Change::Synced if path.is_dir() || path == &self.root => {
                    later.drain(..).for_each(|rename| rename.apply(&mut on_disk));
                }
                Change::Synced => {
                    let content = &mut contents[live[path]];
                    for index in std::mem::take(&mut content.later) {
                        self.apply(index, 0..u64::MAX, &mut content.on_disk);
                    }
                }
                Change::Created => {
                    live.insert(path.clone(), contents.len());
                    later.push(Rename::Add(path.clone(), contents.len()));
                    contents.push(Content::default());
                }
                Change::Renamed => {
                    let to = PathBuf::from(std::str::from_utf8(&record.content).unwrap());
                    let moved = live.remove(path).unwrap();
                    live.insert(to.clone(), moved);
                    later.push(Rename::Move(path.clone(), to));
                }
                Change::Removed => {
                    live.remove(path);
                    later.push(Rename::Remove(path.clone()));
                }
            }
        }
        let kept = draw(later.len() as u64 + 1) as usize;
        later.drain(..kept).for_each(|rename| rename.apply(&mut on_disk));
        for (path, content) in on_disk {
            let content: &mut Content = &mut contents[content];
            for index in std::mem::take(&mut content.later) {
                self.apply_in_part(index, &mut content.on_disk, &mut draw);
            }
            let to = into.join(path.strip_prefix(&self.root).unwrap());
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::write(to, &content.on_disk).unwrap();
        }
    }

    /// Applies the part of a record that lies in this range of the file.
    fn apply(&self, index: usize, range: Range<u64>, bytes: &mut Vec<u8>) {
        let Record { change, at, content, .. } = &self.records[index];
        if let Change::Resized = change {
            return bytes.resize(usize::try_from(*at).unwrap(), 0);
        }
        let from = range.start.max(*at);
        let to = range.end.min(at + content.len() as u64);
        let (start, end) = (from as usize, to as usize);
        if bytes.len() < end {
            bytes.resize(end, 0);
        }
        bytes[start..end].copy_from_slice(&content[(from - at) as usize..(to - at) as usize]);
    }

    /// Applies a record, parts of it, or nothing.
    fn apply_in_part(&self, index: usize, bytes: &mut Vec<u8>, draw: &mut impl FnMut(u64) -> u64) {
        let Record { change, at, content, .. } = &self.records[index];
        match (draw(3), change) {
            (0, _) => {}
            (1, Change::Written) => {
                let mut from = *at;
                let end = at + content.len() as u64;
                while from < end {
                    let to = end.min((from / SECTOR_BYTES + 1) * SECTOR_BYTES);
                    if draw(2) == 0 {
                        self.apply(index, from..to, bytes);
                    }
                    from = to;
                }
            }
            _ => self.apply(index, 0..u64::MAX, bytes),
        }
    }
}

impl Rename {
    fn apply(self, names: &mut Names) {
        match self {
            Self::Add(path, content) => {
                names.insert(path, content);
            }
            // The new name of a file whose old one is unknown was synced without it.
            Self::Move(from, to) => {
                if let Some(content) = names.remove(&from) {
                    names.insert(to, content);
                }
            }
            Self::Remove(path) => {
                names.remove(&path);
            }
        }
    }
}
