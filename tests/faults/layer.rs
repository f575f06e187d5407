//! Library that is loaded into the server under test (`layer/layer.c`): it lets calls fail, traces
//! changes of files and moves the clock. This is the test's side of it.

mod trace;

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use brood_tests::ServerOptions;
use tempfile::TempDir;

pub use trace::Trace;

/// Call that fails; the numbers are those of the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// Writing fails.
    WriteFails = 1,
    /// Writing finds the disk full.
    DiskFull = 2,
    /// Half of the bytes are written.
    WriteShort = 3,
    /// Flushing to the disk fails.
    SyncFails = 4,
    /// Reading fails.
    ReadFails = 5,
    /// Changing the length of a file fails.
    ResizeFails = 6,
}

/// Every [`Fault`].
pub const FAULTS: [Fault; 6] = [
    Fault::WriteFails,
    Fault::DiskFull,
    Fault::WriteShort,
    Fault::SyncFails,
    Fault::ReadFails,
    Fault::ResizeFails,
];

// Places of the fields of `struct control`.
const FAULT: u64 = 0;
const FAILED: u64 = 32;
const SECONDS: u64 = 40;
const CONTROL_BYTES: u64 = 48;

/// Built library with the file that controls it.
pub struct Layer {
    folder: TempDir,
    control: File,
}

impl Layer {
    /// Compiles the library. The C compiler is the one that links Rust programs.
    pub fn build() -> Self {
        let folder = TempDir::new().unwrap();
        let control = File::options()
            .read(true)
            .write(true)
            .create_new(true)
            .open(folder.path().join("control"))
            .unwrap();
        control.set_len(CONTROL_BYTES).unwrap();
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("faults/layer/layer.c");
        let compiled = Command::new("cc")
            .args(["-shared", "-fPIC", "-O2", "-o"])
            .args([&folder.path().join("layer.so"), &source])
            .args(["-ldl", "-lpthread"])
            .output()
            .unwrap();
        assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
        Self { folder, control }
    }

    /// Adds the library to a server on this data directory.
    pub fn options(&self, data: &Path) -> ServerOptions {
        let environment = vec![
            ("LD_PRELOAD", self.file("layer.so")),
            ("BROOD_FAULT_DATA", data.canonicalize().unwrap()),
            ("BROOD_FAULT_CONTROL", self.file("control")),
        ];
        ServerOptions { environment, ..ServerOptions::default() }
    }

    /// As [`Layer::options`], with a trace of all changes.
    pub fn traced_options(&self, data: &Path) -> ServerOptions {
        let mut options = self.options(data);
        options.environment.push(("BROOD_FAULT_TRACE", self.file("trace")));
        options
    }

    /// Lets calls fail: `count` of them, from the `first` on, counted from 1.
    pub fn arm(&self, fault: Fault, first: u64, count: u64) {
        let fields = [0, first, count, 0, 0].map(u64::to_ne_bytes);
        self.control.write_all_at(fields.as_flattened(), FAULT).unwrap();
        self.control.write_all_at(&(fault as u64).to_ne_bytes(), FAULT).unwrap();
    }

    /// Lets all calls succeed again; returns the number of calls that have failed.
    pub fn disarm(&self) -> u64 {
        self.control.write_all_at(&0_u64.to_ne_bytes(), FAULT).unwrap();
        let mut failed = [0; 8];
        self.control.read_exact_at(&mut failed, FAILED).unwrap();
        u64::from_ne_bytes(failed)
    }

    /// Moves the time of day of the server and its workers, relative to the machine's.
    pub fn move_clock(&self, seconds: i64) {
        self.control.write_all_at(&seconds.to_ne_bytes(), SECONDS).unwrap();
    }

    /// Returns the length of the trace: what is acknowledged now was done before.
    pub fn traced_bytes(&self) -> u64 {
        std::fs::metadata(self.file("trace")).unwrap().len()
    }

    /// Reads the trace so far.
    pub fn trace(&self, data: &Path) -> Trace {
        Trace::read(&self.file("trace"), &data.canonicalize().unwrap())
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}
