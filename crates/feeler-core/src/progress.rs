//! Progress and interruption of long work.

use crate::error::{Error, Result};

/// Told the share done (0 to 1) and the stage, now and then, from the calling thread; answers whether to go on. `&|_, _| true`
/// takes no notice.
pub type Progress<'a> = &'a (dyn Fn(f64, &str) -> bool + Sync);

/// Tells the progress function; an error when it asks to stop.
pub(crate) fn report(progress: Progress<'_>, done: f64, stage: &str) -> Result<()> {
    if progress(done, stage) {
        Ok(())
    } else {
        Err(Error::Cancelled)
    }
}
