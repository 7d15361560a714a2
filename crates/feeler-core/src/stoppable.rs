//! Queries that can be stopped while they run. Queries for many poses, casts and building an index take the request in their options.

use crate::collide::narrow::Filters;
use crate::collide::query::Collision;
use crate::distance::gap::Gap;
use crate::distance::query::check_distance;
use crate::distance::wanted::Goal;
use crate::error::{Error, Result};
use crate::geometry::pose::Pose;
use crate::progress::GoOn;
use crate::scene::Scene;
use crate::tool::moving_tool::Tool;

/// The queries of a scene that can be stopped; see [`Scene::stoppable`]. Each returns [`Error::Cancelled`] if it was stopped.
#[derive(Debug, Clone, Copy)]
pub struct StoppableScene<'a> {
    scene: &'a Scene,
    go_on: GoOn<'a>,
}

impl Scene {
    /// The queries that can take long, with a function that is asked every few milliseconds on the calling thread. They stop where
    /// it returns false; it must return false from then on. Short queries never ask.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// use std::time::{Duration, Instant};
    ///
    /// let end = Instant::now() + Duration::from_secs(2);
    /// let has_time = || Instant::now() < end;
    /// let all = scene.stoppable(GoOn::new(&has_time)).near_pairs(&tool, &Pose::IDENTITY, f64::INFINITY)?;
    /// assert_eq!(all.len(), 8);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn stoppable<'a>(&'a self, go_on: GoOn<'a>) -> StoppableScene<'a> {
        StoppableScene { scene: self, go_on }
    }
}

impl StoppableScene<'_> {
    /// See [`Scene::collide`].
    pub fn collide(&self, tool: &Tool, pose: &Pose) -> Result<Collision> {
        self.collide_filtered(tool, pose, Filters::default())
    }

    /// See [`Scene::collide_filtered`].
    pub fn collide_filtered(&self, tool: &Tool, pose: &Pose, filters: Filters) -> Result<Collision> {
        let mut collision = Collision::default();
        self.collide_into(tool, pose, filters, &mut collision)?;
        Ok(collision)
    }

    /// See [`Scene::collide_into`].
    pub fn collide_into(&self, tool: &Tool, pose: &Pose, filters: Filters, out: &mut Collision) -> Result<()> {
        self.scene.collide_while((tool, pose), filters, self.go_on, out)
    }

    /// See [`Scene::near_pairs`].
    pub fn near_pairs(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        self.gaps((tool, pose), Goal::Pairs, within)
    }

    /// See [`Scene::clearance`].
    pub fn clearance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        self.gaps((tool, pose), Goal::Parts, within)
    }

    /// See [`Scene::nearest`].
    pub fn nearest(&self, tool: &Tool, pose: &Pose, k: usize, within: f64) -> Result<Vec<Gap>> {
        if k == 0 {
            return Err(Error::NoneAsked { what: "k" });
        }
        self.gaps((tool, pose), Goal::Nearest(k), within)
    }

    /// See [`Scene::distance`].
    pub fn distance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Option<Gap>> {
        check_distance("within", within)?;
        self.scene.closest_while((tool, pose), within, self.go_on)
    }

    fn gaps(&self, at: (&Tool, &Pose), goal: Goal, within: f64) -> Result<Vec<Gap>> {
        check_distance("within", within)?;
        self.scene.gaps_while(at, goal, within, self.go_on)
    }
}
