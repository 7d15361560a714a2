//! When a command may be sent. A service answers one command after the other: commands that are sent ahead of its answers
//! wait there, and their forces act when they are old.

use std::time::{Duration, Instant};

use crate::constants::{LONGEST_RESEND_WAIT, RESEND_WAIT};

/// What to send now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turn {
    /// The newest force: nothing sent waits for its answer.
    Force,
    /// No force: the service is silent, or the force has just ended.
    Nothing,
    /// No command.
    Wait,
}

/// The commands on their way. Times are passed in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    /// Commands without an answer.
    pending: u32,
    /// When the service last spoke, and when it was last spoken to.
    heard: Instant,
    sent: Instant,
    /// How long it may be silent before it is spoken to again.
    wait: Duration,
    /// Whether the last command had a force.
    pushes: bool,
}

impl Pace {
    pub fn new(now: Instant) -> Pace {
        Pace { pending: 0, heard: now, sent: now, wait: RESEND_WAIT, pushes: false }
    }

    /// The service has spoken.
    pub fn heard(&mut self, now: Instant) {
        let between = now.saturating_duration_since(self.heard);
        // Twice the present time of an answer, so that a slow service does not count as silent.
        self.wait = (2 * between).clamp(RESEND_WAIT, LONGEST_RESEND_WAIT);
        self.pending = self.pending.saturating_sub(1);
        self.heard = now;
    }

    /// What to send, if the newest force is one (`is_force`) or none.
    pub fn turn(&self, is_force: bool, now: Instant) -> Turn {
        let is_silent = now.saturating_duration_since(self.heard.max(self.sent)) > self.wait;
        match () {
            () if self.pending == 0 => Turn::Force,
            // Zero force is sent at once, and so is a force to a service that may have lost the last one.
            () if is_silent || self.pushes && !is_force => Turn::Nothing,
            () => Turn::Wait,
        }
    }

    /// A command was sent, with a force or none.
    pub fn sent(&mut self, is_force: bool, now: Instant) {
        if now.saturating_duration_since(self.heard.max(self.sent)) > self.wait {
            // What a silent service was sent before is taken for lost.
            (self.pending, self.wait) = (0, (2 * self.wait).min(LONGEST_RESEND_WAIT));
        }
        self.pending += 1;
        (self.sent, self.pushes) = (now, is_force);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A service that answers one command after the other in a time, looked at every 10 ms at the latest: how old the
    /// oldest force is when it acts, and how many commands have been sent, in two seconds.
    fn against(answers_in: Duration) -> (Duration, u32) {
        let start = Instant::now();
        let (mut pace, mut queue, mut oldest, mut sent) = (Pace::new(start), Vec::new(), Duration::ZERO, 0);
        let mut busy_until: Option<Instant> = None;
        let mut looked = start;
        for ms in 0..2000 {
            let now = start + Duration::from_millis(ms);
            let mut speaks = false;
            if busy_until.is_some_and(|until| until <= now) {
                (busy_until, speaks) = (None, true);
            }
            if speaks {
                pace.heard(now);
            }
            if speaks || now >= looked + Duration::from_millis(10) {
                looked = now;
                let turn = pace.turn(true, now);
                if turn != Turn::Wait {
                    pace.sent(turn == Turn::Force, now);
                    queue.push((now, turn == Turn::Force));
                    sent += 1;
                }
            }
            if busy_until.is_none() && !queue.is_empty() {
                let (made, pushes) = queue.remove(0);
                busy_until = Some(now + answers_in);
                if pushes {
                    oldest = oldest.max(now - made);
                }
            }
        }
        (oldest, sent)
    }

    #[test]
    fn no_force_waits_behind_another() {
        for ms in [1, 5, 20, 60, 150, 300] {
            let (oldest, sent) = against(Duration::from_millis(ms));
            assert!(oldest <= Duration::from_millis(ms), "{ms} ms: {oldest:?} old");
            assert!(u64::from(sent) * ms >= 1500, "{ms} ms: {sent} commands");
        }
    }

    #[test]
    fn a_silent_service_is_asked_again_without_a_force_and_less_and_less_often() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        pace.sent(true, start);
        let mut turns = Vec::new();
        for ms in (10..3000).step_by(10) {
            let now = start + Duration::from_millis(ms);
            match pace.turn(true, now) {
                Turn::Wait => {}
                turn => {
                    turns.push(turn);
                    pace.sent(turn == Turn::Force, now);
                }
            }
        }
        assert!(turns.iter().all(|turn| *turn == Turn::Nothing) && (3..6).contains(&turns.len()), "{turns:?}");
        pace.heard(start + Duration::from_secs(3));
        assert_eq!(pace.turn(true, start + Duration::from_secs(3)), Turn::Force);
    }

    #[test]
    fn an_end_of_force_does_not_wait() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        pace.sent(true, start);
        assert_eq!((pace.turn(true, start), pace.turn(false, start)), (Turn::Wait, Turn::Nothing));
        pace.sent(false, start);
        assert_eq!(pace.turn(false, start), Turn::Wait);
    }
}
