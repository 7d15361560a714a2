//! Contacts along a path: the last free pose is the reference of the next query.

use feeler_core::{GoOn, Pose, Result, Tool};

use crate::contact_plane::Contacts;
use crate::solver::ContactSolver;

/// Remembers the last pose at which nothing met, as the reference for open surfaces.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactTracker {
    last_free: Option<Pose>,
}

impl ContactTracker {
    /// A tracker without a free pose yet: until there is one, the side of the tool's centre of area counts.
    pub fn new() -> ContactTracker {
        ContactTracker::default()
    }

    /// The last pose at which nothing met.
    pub fn last_free(&self) -> Option<&Pose> {
        self.last_free.as_ref()
    }

    /// Sets the last free pose, or forgets it.
    pub fn set_last_free(&mut self, pose: Option<Pose>) {
        self.last_free = pose;
    }

    /// [`ContactSolver::contacts`] with the last free pose as reference; a pose without a collision becomes the next
    /// one.
    pub fn contacts(&mut self, solver: &ContactSolver, tool: &Tool, pose: &Pose, margin: f64) -> Result<Contacts> {
        self.contacts_while(solver, tool, pose, margin, GoOn::default())
    }

    /// The same, as a query that can be stopped ([`ContactSolver::stoppable`]).
    pub fn contacts_while(
        &mut self,
        solver: &ContactSolver,
        tool: &Tool,
        pose: &Pose,
        margin: f64,
        go_on: GoOn<'_>,
    ) -> Result<Contacts> {
        let contacts = solver.stoppable(go_on).contacts(tool, pose, margin, self.last_free.as_ref())?;
        if !contacts.is_meeting {
            self.last_free = Some(*pose);
        }
        Ok(contacts)
    }
}
