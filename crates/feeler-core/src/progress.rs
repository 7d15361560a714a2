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

/// Asks whether long work goes on. The default always does. A function that returned false must return false from then on.
#[derive(Clone, Copy, Default)]
pub struct GoOn<'a>(Option<&'a (dyn Fn() -> bool + Sync)>);

impl<'a> GoOn<'a> {
    /// Asks a function every few milliseconds. Work stops where it returns false.
    pub fn new(function: &'a (dyn Fn() -> bool + Sync)) -> GoOn<'a> {
        GoOn(Some(function))
    }

    /// Whether the work goes on.
    pub fn goes_on(&self) -> bool {
        self.0.is_none_or(|function| function())
    }

    /// An error where the work is to stop.
    pub fn check(&self) -> Result<()> {
        if self.goes_on() {
            Ok(())
        } else {
            Err(Error::Cancelled)
        }
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

/// How building an index reports, and how it is stopped.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Control<'a> {
    /// Told of each stage.
    pub progress: Progress<'a>,
    /// Asked on all threads while a stage runs.
    pub go_on: GoOn<'a>,
}

/// Asks a [`GoOn`] once every so many steps of a loop, so that a step costs an addition and a comparison.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Pace<'a> {
    go_on: GoOn<'a>,
    every: u32,
    steps: u32,
    is_stopped: bool,
}

impl<'a> Pace<'a> {
    /// Asks after every `every` steps. Choose it so that they take a few milliseconds.
    pub fn new(go_on: GoOn<'a>, every: u32) -> Pace<'a> {
        Pace { go_on, every, steps: 0, is_stopped: false }
    }

    /// Counts a step. Whether the loop must stop.
    #[inline(always)]
    pub fn step(&mut self) -> bool {
        self.steps += 1;
        self.steps >= self.every && self.ask()
    }

    /// Whether a step found that the loop must stop.
    #[inline(always)]
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// Asks now. Whether the loop must stop.
    #[cold]
    #[inline(never)]
    pub fn ask(&mut self) -> bool {
        self.steps = 0;
        self.is_stopped = self.is_stopped || !self.go_on.goes_on();
        self.is_stopped
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
    /// Asked every few milliseconds on each thread, and may stop the query.
    pub go_on: GoOn<'a>,
}

impl<'a> BatchOptions<'a> {
    /// Calls a function with the share done (0 to 1) and the stage. The query stops with [`Error::Cancelled`] where it returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }

    /// Asks a function every few milliseconds. The query stops with [`Error::Cancelled`] where it returns false.
    #[must_use]
    pub fn with_go_on(mut self, go_on: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.go_on = GoOn::new(go_on);
        self
    }
}
