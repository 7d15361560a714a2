//! Options of casts, one by one and along a path.

use super::impact::Touching;
use crate::geometry::bounds::Point;
use crate::progress::{GoOn, Progress};

/// The tolerance unless another is given, metres.
const TOLERANCE_M: f64 = 1e-6;

/// Options of [`Scene::cast`](crate::Scene::cast) and [`Scene::cast_along`](crate::Scene::cast_along).
///
/// ```
/// use feeler_core::{CastOptions, Touching};
///
/// let options = CastOptions::default().with_tolerance(1e-5).with_touching(Touching::Free);
/// # let _ = options;
/// ```
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct CastOptions<'a> {
    /// How far before the impact the pose given may lie, as a distance of the two triangles, metres; 1e-6 by default. A tool that
    /// passes by nearer than that may count as one that hits. With [`Touching::Free`] it is also how far the two triangles at the
    /// impact may overlap.
    pub tolerance: f64,
    /// Whether a contact ends the cast; [`Touching::Ends`] by default.
    pub touching: Touching,
    /// Directions along which tool and mock-up are probably apart, as the normals of contact planes: units, world, from the mock-up
    /// to the tool. The cast need not follow pairs of triangles that one of these holds apart all the way: the answer is the same
    /// within the tolerance, and along surfaces it comes much sooner. The first sixteen are tried.
    pub directions: &'a [Point],
    /// Asked every few milliseconds, and may stop the cast.
    pub go_on: GoOn<'a>,
}

impl Default for CastOptions<'_> {
    fn default() -> Self {
        CastOptions { tolerance: TOLERANCE_M, touching: Touching::Ends, directions: &[], go_on: GoOn::default() }
    }
}

impl<'a> CastOptions<'a> {
    crate::setters! {
        with_tolerance: tolerance: f64,
        with_touching: touching: Touching,
        with_directions: directions: &'a [Point],
    }

    /// Asks a function every few milliseconds. The cast stops with [`Error::Cancelled`](crate::Error::Cancelled) where it returns
    /// false.
    #[must_use]
    pub fn with_go_on(mut self, go_on: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.go_on = GoOn::new(go_on);
        self
    }
}

/// Options of [`Scene::check_path`](crate::Scene::check_path) and [`Scene::check_legs`](crate::Scene::check_legs).
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct PathOptions<'a> {
    /// As [`CastOptions::tolerance`].
    pub tolerance: f64,
    /// As [`CastOptions::touching`].
    pub touching: Touching,
    /// Reports the progress after every few thousand segments, and may stop the check.
    pub progress: Progress<'a>,
    /// Asked every few milliseconds on each thread, and may stop the check.
    pub go_on: GoOn<'a>,
}

impl Default for PathOptions<'_> {
    fn default() -> Self {
        PathOptions {
            tolerance: TOLERANCE_M,
            touching: Touching::Ends,
            progress: Progress::default(),
            go_on: GoOn::default(),
        }
    }
}

impl<'a> PathOptions<'a> {
    crate::setters! {
        with_tolerance: tolerance: f64,
        with_touching: touching: Touching,
    }

    /// Calls a function with the share done (0 to 1) and the stage. The check stops with
    /// [`Error::Cancelled`](crate::Error::Cancelled) where it returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }

    /// Asks a function every few milliseconds on each thread. The check stops with
    /// [`Error::Cancelled`](crate::Error::Cancelled) where it returns false.
    #[must_use]
    pub fn with_go_on(mut self, go_on: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.go_on = GoOn::new(go_on);
        self
    }
}
