//! Stand-ins for makers' libraries, compiled by the tests.
#![allow(dead_code, reason = "each test file uses a part")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use super::common::Folder;
use feeler_devices::dhd::{Dhd, DhdOptions};
use feeler_devices::openhaptics::{OpenHaptics, OpenHapticsOptions};
use feeler_haptics::device::DeviceError;
use libloading::{library_filename, Library};

/// A stub's file, compiled once for all tests.
pub fn compiled(name: &str, is_too_old: bool) -> PathBuf {
    static DONE: Mutex<Vec<(PathBuf, Folder)>> = Mutex::new(vec![]);
    let mut done = DONE.lock().unwrap();
    let file = library_filename(if is_too_old { format!("{name}_too_old") } else { name.to_string() });
    if let Some((path, _)) = done.iter().find(|(path, _)| path.file_name() == Some(&file)) {
        return path.clone();
    }
    let folder = Folder::new("stub");
    let path = folder.path.join(&file);
    let mut rustc = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    rustc.args([
        "--edition",
        "2021",
        "--crate-type",
        "cdylib",
        "--crate-name",
        name,
        "-C",
        "panic=abort",
        "-A",
        "warnings",
    ]);
    rustc.args(["--check-cfg", "cfg(too_old)"]).args(if is_too_old { &["--cfg", "too_old"][..] } else { &[] });
    rustc
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(format!("{name}.rs")))
        .arg("-o")
        .arg(&path);
    let output = rustc.output().expect("rustc compiles the stub");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    done.push((path.clone(), folder));
    path
}

/// A copy of a stub for one test, so that tests do not share cells.
pub struct Stub {
    pub path: PathBuf,
    library: Library,
    _folder: Folder,
}

impl Stub {
    pub fn new(name: &str) -> Stub {
        let folder = Folder::new("vendor");
        let path = folder.path.join(library_filename(name));
        std::fs::copy(compiled(name, false), &path).unwrap();
        // SAFETY: the library was compiled from the stub above.
        let library = unsafe { Library::new(&path) }.unwrap();
        Stub { path, library, _folder: folder }
    }

    pub fn set(&self, cell: u32, value: f64) {
        // SAFETY: the function has this type in tests/fixtures/cells.rs.
        unsafe { self.library.get::<extern "C" fn(u32, f64)>("stub_set").unwrap()(cell, value) }
    }

    pub fn get(&self, cell: u32) -> f64 {
        // SAFETY: the function has this type in tests/fixtures/cells.rs.
        unsafe { self.library.get::<extern "C" fn(u32) -> f64>("stub_get").unwrap()(cell) }
    }

    pub fn many<const N: usize>(&self, first: u32) -> [f64; N] {
        std::array::from_fn(|i| self.get(first + i as u32))
    }

    pub fn open_dhd(&self) -> Result<Dhd, DeviceError> {
        Dhd::open(&DhdOptions::default().with_library(self.path.clone()))
    }

    pub fn open_hd(&self) -> Result<OpenHaptics, DeviceError> {
        OpenHaptics::open(&OpenHapticsOptions::default().with_library(self.path.clone()))
    }
}
