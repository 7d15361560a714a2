//! The collision side: takes the newest target, moves the proxy, and passes on its contacts. It has no thread or clock
//! of its own.

use std::sync::mpsc::SyncSender;
use std::sync::Arc;

use feeler_core::{Pose, Scene};
use feeler_world::Release;
use triple_buffer::{Input, Output};

use super::exchange::{Handed, Target};
use crate::constants::STATISTICS_PERIOD_S;
use crate::coupling::Coupling;
use crate::error::{Error, Result};
use crate::session::{Session, Start};
use crate::statistics::CollisionRecord;

/// The answer to a command.
pub(super) enum Answer {
    Done,
    Started(Start),
}

/// Requests to the collision side, carried out between two ticks.
pub(super) enum Wish {
    Start(Pose),
    Grip(Vec<u32>),
    Release(Release),
    Scene(Arc<Scene>),
}

/// A wish, and where its answer goes.
pub(super) struct Command {
    pub wish: Wish,
    pub reply: SyncSender<Result<Answer>>,
}

/// The collision side of a run: moves the proxy, finds its contacts, hands them over. Has no thread of its own.
#[derive(Debug)]
pub struct CollisionSide {
    session: Session,
    /// The session's own, when the device has gone.
    coupling: Coupling,
    targets: Output<Target>,
    sets: Input<Handed>,
    record: CollisionRecord,
    records: Input<CollisionRecord>,
    recorded: f64,
    start: u64,
    start_pose: Pose,
    is_settled: bool,
    last_error: Option<Error>,
}

impl CollisionSide {
    pub(super) fn new(
        session: Session,
        coupling: Coupling,
        start_pose: Pose,
        targets: Output<Target>,
        sets: Input<Handed>,
        records: Input<CollisionRecord>,
    ) -> CollisionSide {
        CollisionSide {
            session,
            coupling,
            targets,
            sets,
            record: CollisionRecord::default(),
            records,
            recorded: f64::NEG_INFINITY,
            start: 0,
            start_pose,
            is_settled: false,
            last_error: None,
        }
    }

    /// Whether there is a new target, or the proxy is still on its way to the last one.
    pub fn has_news(&self) -> bool {
        !self.is_settled || self.targets.updated()
    }

    /// One tick: moves the proxy towards the newest target, finds the contacts there, and passes them on. Failures are
    /// counted, and the last set stays: it grows old, and the servo side releases the force.
    pub fn tick(&mut self, now: f64) {
        let target = *self.targets.read();
        let is_of_now = target.number > 0 && target.start == self.start;
        let Some(pose) = self.session.pose().copied() else { return };
        match self.session.track(if is_of_now { &target.pose } else { &pose }, now) {
            Ok(_) => {
                let advance = self.session.last_advance();
                self.record.rounds += advance.rounds as u64;
                self.record.stopped += advance.stopped as u64;
                self.is_settled = self.session.pose() == Some(&pose);
                self.hand_over();
            }
            Err(error) => {
                self.record.errors += 1;
                self.last_error = Some(error);
                self.is_settled = true;
            }
        }
        let first = if self.record.sets <= 1 { now } else { self.record.span[0] };
        self.record.span = [first, now];
    }

    /// Counts how long the last tick took, seconds.
    pub fn took(&mut self, seconds: f64, now: f64) {
        self.record.tick.record(seconds);
        if now - self.recorded >= STATISTICS_PERIOD_S {
            self.recorded = now;
            self.publish_record();
        }
    }

    pub(super) fn publish_record(&mut self) {
        self.records.input_buffer_mut().copy_from(&self.record);
        self.records.publish();
    }

    /// The newest set, written in place.
    fn hand_over(&mut self) {
        let handed = self.sets.input_buffer_mut();
        handed.has_proxy = match self.session.constraints() {
            Some(set) => {
                handed.set = *set;
                true
            }
            None => false,
        };
        (handed.start, handed.start_pose) = (self.start, self.start_pose);
        self.sets.publish();
        self.record.sets += 1;
    }

    pub(super) fn apply(&mut self, wish: Wish) -> Result<Answer> {
        let answer = match wish {
            Wish::Start(pose) => {
                let start = self.session.start(&pose)?;
                self.start += 1;
                self.start_pose = pose;
                Answer::Started(start)
            }
            Wish::Scene(scene) => Answer::Started(self.session.set_scene(scene)?),
            Wish::Grip(parts) => self.session.grip(&parts).map(|()| Answer::Done)?,
            Wish::Release(to) => self.session.release(to).map(|()| Answer::Done)?,
        };
        self.is_settled = false;
        Ok(answer)
    }

    /// The session as it is.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Why the last search that failed did.
    pub fn last_error(&self) -> Option<&Error> {
        self.last_error.as_ref()
    }

    /// The session again, to be stepped or run.
    pub(super) fn into_session(mut self) -> Session {
        self.publish_record();
        self.session.set_coupling(self.coupling);
        self.session.resume();
        self.session
    }
}
