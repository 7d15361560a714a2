//! Shared helpers of the driver tests.
#![allow(dead_code, reason = "each test file uses a part")]

use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Waits until a condition returns a value. Threads and processes need some time; only a defect uses up all of it.
pub fn eventually<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(started.elapsed() < Duration::from_secs(60), "waited in vain for: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A temporary folder, removed when dropped.
pub struct Folder {
    pub path: PathBuf,
}

impl Folder {
    pub fn new(name: &str) -> Folder {
        static COUNT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("feeler-{name}-{}-{count}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder { path }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A library that is still loaded cannot be removed everywhere.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}
