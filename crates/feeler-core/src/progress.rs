//! How long work reports its progress, and how it is stopped.

use std::fmt;

use crate::error::{Error, Result};

/// Given the share done and the stage; answers whether to go on.
type Listener<'a> = dyn Fn(f64, &str) -> bool + Sync + 'a;

/// Reports the progress of long work, and may stop it. The default listens to nothing and never stops.
///
/// Options of long work have `with_progress`, which takes the function itself.
#[derive(Clone, Copy, Default)]
pub struct Progress<'a>(Option<&'a Listener<'a>>);

impl<'a> Progress<'a> {
    /// Calls a function with the share done (0 to 1) and the stage, now and then. Work stops where it returns false.
    pub fn new(function: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Progress<'a> {
        Progress(Some(function))
    }

    /// Reports the share done and the stage. Whether to go on.
    pub fn tell(&self, done: f64, stage: &str) -> bool {
        self.0.is_none_or(|function| function(done, stage))
    }

    /// Reports as [`tell`](Self::tell). An error where the work is to stop.
    pub(crate) fn report(&self, done: f64, stage: &str) -> Result<()> {
        if self.tell(done, stage) {
            Ok(())
        } else {
            Err(Error::Cancelled)
        }
    }
}

impl fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Progress(..)" } else { "Progress" })
    }
}

/// Asks whether long work goes on. The default always does.
#[derive(Clone, Copy, Default)]
pub struct GoOn<'a>(Option<&'a (dyn Fn() -> bool + Sync)>);

impl<'a> GoOn<'a> {
    /// Asks a function every few milliseconds. Work stops where it returns false.
    pub fn new(function: &'a (dyn Fn() -> bool + Sync)) -> GoOn<'a> {
        GoOn(Some(function))
    }

    /// The function to ask.
    pub fn function(&self) -> &'a (dyn Fn() -> bool + Sync) {
        self.0.unwrap_or(&|| true)
    }
}

impl fmt::Debug for GoOn<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "GoOn(..)" } else { "GoOn" })
    }
}

/// Options of queries for many poses.
///
/// ```
/// use feeler_core::BatchOptions;
///
/// let progress = |share: f64, stage: &str| {
///     println!("{stage}: {:.0} %", 100.0 * share);
///     true // go on
/// };
/// let options = BatchOptions::default().with_progress(&progress);
/// # let _ = options;
/// ```
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct BatchOptions<'a> {
    /// Reports the progress after every few thousand poses, and may stop the query.
    pub progress: Progress<'a>,
}

impl<'a> BatchOptions<'a> {
    /// Calls a function with the share done (0 to 1) and the stage. The query stops with [`Error::Cancelled`] where it returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }
}
