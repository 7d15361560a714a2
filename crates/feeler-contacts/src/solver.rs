//! The facade of the contact queries of one scene.

use std::sync::Arc;

use feeler_core::scratch_pool::ScratchPool;
use feeler_core::{GoOn, Pose, Result, Scene, Tool};

use crate::contact_plane::{ContactPlane, Contacts};
use crate::containment::find::{containment, Containment};
use crate::escape::escape_probe::is_free_and_outside;
use crate::escape::penetration::{penetration, Penetration};
use crate::footing::find::{footing, Footing};
use crate::footing::manifold::Manifolds;
use crate::point_depth::bodies::Bodies;
use crate::point_depth::of_tool::{depths, PartDepth};
use crate::query::{ContactQuery, ContactScratch};

/// Finds contacts in a scene. Owns the working memory of its queries; any number of threads may ask it at once.
#[derive(Debug)]
pub struct ContactSolver {
    scene: Arc<Scene>,
    pool: Arc<ScratchPool<ContactScratch>>,
    bodies: Arc<Bodies>,
}

impl ContactSolver {
    /// A solver for a scene.
    pub fn new(scene: Arc<Scene>) -> ContactSolver {
        ContactSolver { scene, pool: Arc::default(), bodies: Arc::default() }
    }

    /// A solver for another scene of the same mock-up with the same working memory, as for a scene without some parts.
    pub fn with_scene(&self, scene: Arc<Scene>) -> ContactSolver {
        let bodies =
            if Arc::ptr_eq(scene.mockup(), self.scene.mockup()) { self.bodies.clone() } else { Arc::default() };
        ContactSolver { scene, pool: self.pool.clone(), bodies }
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The contact planes of a tool at a pose: at most [`MOST_PLANES`](crate::MOST_PLANES), deepest first, for
    /// colliding surfaces and for those nearer than `margin` (metres).
    ///
    /// `reference` is a pose where the tool was free, the last one before this: it decides on which side of open
    /// surfaces the tool belongs. Without it the side of the tool's centre of area decides. Closed surfaces have an
    /// inside and need it only if the tool went right through.
    ///
    /// The margin shrinks linearly with the number of deep planes, from all of it at [`FEW_DEEP`](crate::FEW_DEEP) to
    /// nothing at [`MANY_DEEP`](crate::MANY_DEEP); and it is halved while more than a million pairs of triangles are
    /// within it.
    ///
    /// Errors: a margin that is negative, NaN or infinite, and more near pairs than the memory limit of the scene
    /// allows.
    pub fn contacts(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Contacts> {
        self.query().contacts(tool, pose, margin, reference)
    }

    /// The shortest translation found that frees the tool: the shortest over the contact planes of the pose, checked at
    /// the moved pose, and improved with the planes found there. If that does not free the tool, translations along
    /// many directions are tried, ever longer ones, up to the tool's size; and up to the size of both if one of the two
    /// is wholly inside the other without a collision.
    ///
    /// Surfaces nearer than `margin` (metres) count, so that the translation does not run into them. `reference` and
    /// errors as in [`contacts`](Self::contacts).
    pub fn penetration(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Penetration> {
        penetration(&self.query(), tool, pose, margin, reference)
    }

    /// Containment: parts of the mock-up that contain the tool, or one of its connected surfaces, without crossing
    /// them, and parts inside the tool. Closed surfaces have an inside, each wound by its own volume and its nesting;
    /// for open ones it is unknown. Exact except for the rounding of a point's rotation into the tool's frame (for
    /// parts inside the tool) and for cracks, where the majority of three rays decides.
    pub fn containment(&self, tool: &Tool, pose: &Pose) -> Containment {
        containment(&self.scene, tool, pose, GoOn::default())
    }

    /// The depth of the tool in each part that it collides with, or that contains it, or that it contains: how far the
    /// deepest point of one surface lies inside the other part. The deepest first, then by part. Trees of these parts
    /// are made on demand, in time about linear in their triangles, and kept.
    pub fn depths(&self, tool: &Tool, pose: &Pose) -> Vec<PartDepth> {
        depths(&self.scene, &self.bodies, tool, pose, GoOn::default())
    }

    /// Whether there is no collision and no containment.
    pub fn is_free(&self, tool: &Tool, pose: &Pose) -> bool {
        is_free_and_outside((&self.scene, GoOn::default()), tool, pose)
    }

    /// The footing of a plane that [`contacts`](Self::contacts) found for this tool at this pose: one to four points of the tool, in its
    /// own frame, that carry the contact. Where they are held off the plane, so is the tool, for turns up to one degree, as far as the
    /// mock-up's surface reaches. An edge has two, a corner one; a round patch has four around it.
    pub fn footing(&self, tool: &Tool, pose: &Pose, plane: &ContactPlane) -> Footing {
        footing(&self.scene, tool, pose, plane)
    }

    /// The contact manifolds of a free pose: the planes of all surfaces within `margin` (metres), as in
    /// [`contacts`](Self::contacts), each with up to [`MOST_MANIFOLD_POINTS`](crate::MOST_MANIFOLD_POINTS) points of
    /// the tool that carry it. For control loops: it does not look for collisions, and is faster for it. Errors as
    /// `contacts`.
    pub fn manifolds(&self, tool: &Tool, pose: &Pose, margin: f64, out: &mut Manifolds) -> Result<()> {
        self.query().manifolds(tool, pose, margin, out)
    }

    pub(crate) fn query(&self) -> ContactQuery<'_> {
        self.query_while(GoOn::default())
    }

    fn query_while<'a>(&'a self, go_on: GoOn<'a>) -> ContactQuery<'a> {
        ContactQuery { scene: &self.scene, pool: &self.pool, go_on }
    }

    /// The queries that can take long, with a function that is asked every few milliseconds on the calling thread. They stop where
    /// it returns false; it must return false from then on.
    pub fn stoppable<'a>(&'a self, go_on: GoOn<'a>) -> StoppableSolver<'a> {
        StoppableSolver { solver: self, go_on }
    }
}

/// The queries of a solver that can be stopped; see [`ContactSolver::stoppable`]. Each returns
/// [`Error::Cancelled`](feeler_core::Error::Cancelled) if it was stopped.
#[derive(Debug, Clone, Copy)]
pub struct StoppableSolver<'a> {
    solver: &'a ContactSolver,
    go_on: GoOn<'a>,
}

impl StoppableSolver<'_> {
    /// See [`ContactSolver::contacts`].
    pub fn contacts(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Contacts> {
        self.solver.query_while(self.go_on).contacts(tool, pose, margin, reference)
    }

    /// See [`ContactSolver::penetration`].
    pub fn penetration(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Penetration> {
        self.unless_stopped(penetration(&self.solver.query_while(self.go_on), tool, pose, margin, reference)?)
    }

    /// See [`ContactSolver::containment`].
    pub fn containment(&self, tool: &Tool, pose: &Pose) -> Result<Containment> {
        self.unless_stopped(containment(&self.solver.scene, tool, pose, self.go_on))
    }

    /// See [`ContactSolver::depths`].
    pub fn depths(&self, tool: &Tool, pose: &Pose) -> Result<Vec<PartDepth>> {
        self.unless_stopped(depths(&self.solver.scene, &self.solver.bodies, tool, pose, self.go_on))
    }

    /// See [`ContactSolver::is_free`].
    pub fn is_free(&self, tool: &Tool, pose: &Pose) -> Result<bool> {
        self.unless_stopped(is_free_and_outside((&self.solver.scene, self.go_on), tool, pose))
    }

    /// What was found, if the query was not stopped on the way.
    fn unless_stopped<T>(&self, found: T) -> Result<T> {
        self.go_on.check().map(|()| found)
    }
}
