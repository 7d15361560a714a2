//! The facade of the contact queries of one scene.

use std::sync::Arc;

use feeler_core::scratch_pool::ScratchPool;
use feeler_core::{Pose, Result, Scene, Tool};

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

    /// The contact planes of a tool at a pose: at most [`MOST_PLANES`](crate::MOST_PLANES), deepest first, for surfaces that meet and
    /// for those nearer than `margin` (metres).
    ///
    /// `reference` is a pose where the tool was free, the last one before this: it tells on which side of open surfaces the
    /// tool belongs. Without it the side of the tool's centre of area counts. Closed surfaces have an inside and need it only
    /// where the tool went right through.
    ///
    /// The margin shrinks linearly with the number of deep planes, from all of it at [`FEW_DEEP`](crate::FEW_DEEP) to nothing at
    /// [`MANY_DEEP`](crate::MANY_DEEP); and it is halved while more than a million pairs of triangles are within it.
    ///
    /// Errors: a margin that is negative, NaN or infinite, and more near pairs than the memory limit of the scene allows.
    pub fn contacts(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Contacts> {
        self.query().contacts(tool, pose, margin, reference)
    }

    /// The shortest translation found that frees the tool: the shortest over the contact planes of the pose, checked at the moved
    /// pose, and sought again with the planes found there. Where that does not free the tool, translations along many directions are
    /// tried, ever longer ones, up to the tool's size; and up to the size of both where the tool meets nothing since one of the two
    /// is wholly inside the other.
    ///
    /// Surfaces nearer than `margin` (metres) count, so that the translation does not run into them. `reference` and errors as in
    /// [`contacts`](Self::contacts).
    pub fn penetration(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Penetration> {
        penetration(&self.query(), tool, pose, margin, reference)
    }

    /// What is inside what: parts of the mock-up that hold the tool, or one of its connected surfaces, though these do not cross them,
    /// and parts that the tool holds. Closed surfaces have an inside, each wound as its own volume and its place within others say; of
    /// open ones it is unknown. Exact but for the rounding of a point's turn into the tool's frame (of what the tool holds) and for
    /// cracks, where most of three rays decide.
    pub fn containment(&self, tool: &Tool, pose: &Pose) -> Containment {
        containment(&self.scene, tool, pose)
    }

    /// How deep the tool is in each part that it meets or that holds it, or that it holds: the farthest that a point of one surface is inside
    /// the other part. The deepest first, then by part. Trees of these parts are made when first needed, in time about linear in their
    /// triangles, and kept.
    pub fn depths(&self, tool: &Tool, pose: &Pose) -> Vec<PartDepth> {
        depths(&self.scene, &self.bodies, tool, pose)
    }

    /// Whether no triangles meet and nothing is inside anything.
    pub fn is_free(&self, tool: &Tool, pose: &Pose) -> bool {
        is_free_and_outside(&self.scene, tool, pose)
    }

    /// The footing of a plane that [`contacts`](Self::contacts) found for this tool at this pose: one to four points of the tool, in its
    /// own frame, that carry the contact. Where they are held off the plane, so is the tool, for turns up to one degree, as far as the
    /// mock-up's surface reaches. An edge has two, a corner one; a round patch has four around it.
    pub fn footing(&self, tool: &Tool, pose: &Pose, plane: &ContactPlane) -> Footing {
        footing(&self.scene, tool, pose, plane)
    }

    /// The contact manifolds of a free pose: the planes of all that is within `margin` (metres), as [`contacts`](Self::contacts) has
    /// them, each with up to [`MOST_MANIFOLD_POINTS`](crate::MOST_MANIFOLD_POINTS) points of the tool that it carries. For control
    /// loops: it asks nothing of what meets, and is the faster for it. Errors as `contacts`.
    pub fn manifolds(&self, tool: &Tool, pose: &Pose, margin: f64, out: &mut Manifolds) -> Result<()> {
        self.query().manifolds(tool, pose, margin, out)
    }

    pub(crate) fn query(&self) -> ContactQuery<'_> {
        ContactQuery { scene: &self.scene, pool: &self.pool }
    }
}
