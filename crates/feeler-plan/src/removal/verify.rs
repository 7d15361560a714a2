//! Whether a way is free, leg by leg, with the same allowances and finer steps.

use feeler_core::Pose;

use crate::blocked::Tally;
use crate::error::Result;
use feeler_world::{Care, Span, Surroundings};

/// A way out that is free.
#[derive(Debug)]
pub struct Verified {
    /// From the start until it is out.
    pub poses: Vec<Pose>,
    /// The same in shares along which the same pairs are seated.
    pub spans: Vec<Span>,
}

/// The way, if all of it is free and it ends out.
pub fn verified(around: &Surroundings, poses: Vec<Pose>, tally: &mut Tally) -> Result<Option<Verified>> {
    let mut seated = around.seated_at_start();
    let mut spans = Vec::new();
    for pair in poses.windows(2) {
        let walk = around.walk_in_spans(&seated, (&pair[0], &pair[1]), Care::VERIFY, &mut |span| spans.push(span))?;
        tally.walked(around, &walk);
        if walk.stop.is_some() {
            return Ok(None);
        }
        seated = walk.seated;
    }
    let Some(last) = poses.last().filter(|last| around.is_out(last)) else { return Ok(None) };
    if spans.is_empty() {
        spans.push(Span { seated, from: *last, to: *last });
    }
    Ok(Some(Verified { poses, spans }))
}
