//! Walks that end a given distance before the impact.

use std::sync::Arc;

use feeler_core::{Motion, Pose};

use crate::error::Result;
use crate::seats::Seated;
use crate::surroundings::Surroundings;
use crate::walk::{Care, Walk};

impl Surroundings {
    /// A [walk](Self::walk) that ends `off` metres before the impact, or at its start if that is nearer, so that the next walk starts free.
    /// A walk that a seat stops ends at that seat. `tolerance`: of the casts, metres.
    pub fn stop_short(
        &self,
        seated: &Arc<Seated>,
        (from, to): (&Pose, &Pose),
        tolerance: f64,
        off: f64,
    ) -> Result<Walk> {
        let care = Care { beside: &[], tolerance, finer: 1.0 };
        let walk = self.walk(seated, (from, to), care)?;
        let Some(stop) = walk.stop.filter(|stop| !stop.is_seat) else { return Ok(walk) };
        let motion = Motion::new(&self.tool, from, to);
        let mut back = off / motion.longest_way();
        while back < walk.fraction {
            let fraction = walk.fraction - back;
            let before = self.walk(seated, (from, &motion.at(fraction)), care)?;
            if before.stop.is_none() {
                return Ok(Walk { fraction, stop: Some(stop), ..before });
            }
            back *= 2.0;
        }
        Ok(Walk { pose: *from, fraction: 0.0, seated: seated.clone(), stop: Some(stop), casts: walk.casts })
    }
}
