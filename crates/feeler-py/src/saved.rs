//! `feeler._core.SavedScene`: a scene in a file.

use std::path::PathBuf;
use std::sync::Arc;

use feeler_core as core;
use feeler_saved as saved;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{raise, to_py};
use crate::pools::Pool;
use crate::reporter::Reporter;
use crate::travel::stays;

/// An opened file. `feeler.open_scene` makes a mock-up and a scene of it.
#[pyclass(frozen, module = "feeler._core")]
pub struct SavedScene {
    opened: saved::SavedScene,
    /// With all parts.
    whole: core::Scene,
}

impl SavedScene {
    pub fn mockup(&self) -> Arc<core::Mockup> {
        Arc::clone(self.opened.scene.mockup())
    }

    /// The scene with all parts.
    pub fn whole(&self) -> &core::Scene {
        &self.whole
    }
}

#[pymethods]
impl SavedScene {
    #[new]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        verify: bool,
        memory_limit: u64,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<SavedScene> {
        let reporter = Reporter::new(progress);
        let opened = py.detach(|| {
            reporter.watch(None, || {
                let tell = |done: f64, stage: &str| reporter.tell(done, stage);
                let options = saved::OpenOptions::default().with_verify(verify).with_memory_limit(memory_limit);
                saved::open(&path, &options.with_progress(&tell))
            })
        });
        reporter.finish()?;
        let opened = opened?.map_err(|error| not_opened(&path, error))?;
        Ok(SavedScene { whole: opened.scene.with_all_parts(), opened })
    }

    /// The hash of the mock-up, 32 hexadecimal digits.
    #[getter]
    fn content_hash(&self) -> String {
        format!("{:032x}", self.opened.content_hash)
    }

    /// As in `Scene`.
    #[getter]
    fn voxel_size(&self) -> f64 {
        self.whole.voxel_size()
    }

    /// As in `Scene`.
    #[getter]
    fn storage(&self) -> &'static str {
        self.whole.storage().name()
    }

    /// As in `Scene`.
    #[getter]
    fn hashing(&self) -> f64 {
        match self.whole.storage() {
            core::Storage::Hashed { level } => level,
            _ => 0.0,
        }
    }

    /// As in `Mockup`.
    #[getter]
    fn part_count(&self) -> usize {
        self.whole.mockup().part_bounds().len()
    }

    /// The parts that were not there when the scene was saved, by number.
    #[getter]
    fn absent_parts(&self) -> Vec<u32> {
        let parts = self.whole.mockup().part_bounds().len() as u32;
        (0..parts).filter(|part| !self.opened.scene.has_part(*part)).collect()
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("SavedScene", "pickle the scene that is opened from it"))
    }

    /// A section of `Scene._save`.
    fn extra<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyBytes>> {
        self.opened.extra(name).map(|bytes| PyBytes::new(py, bytes))
    }
}

/// Saves a scene, with sections of Python's own; the hash of its mock-up.
pub fn save(
    py: Python<'_>,
    scene: &core::Scene,
    pool: Option<&Pool>,
    (path, extras): (PathBuf, Vec<(String, Vec<u8>)>),
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let reporter = Reporter::new(progress);
    let hash = py.detach(|| {
        reporter.watch(pool, || {
            let tell = |done: f64, stage: &str| reporter.tell(done, stage);
            let extras: Vec<saved::Extra<'_>> = extras.iter().map(|(name, bytes)| (&**name, &**bytes)).collect();
            saved::save(&path, scene, &extras, core::Progress::new(&tell))
        })
    });
    reporter.finish()?;
    let hash = hash?.map_err(|error| match error {
        saved::Error::Core(error) => to_py(error),
        error => raise("WriteError", format!("{}: the scene cannot be saved: {error}", path.display())),
    })?;
    Ok(format!("{hash:032x}"))
}

fn not_opened(path: &std::path::Path, error: saved::Error) -> PyErr {
    let class = match &error {
        saved::Error::Core(error) => return to_py(error.clone()),
        saved::Error::Io(error) if error.kind() == std::io::ErrorKind::NotFound => "MissingFileError",
        _ => "LoadError",
    };
    raise(class, format!("{}: the scene cannot be opened: {error}", path.display()))
}
