//! The servo side allocates nothing, whatever is touched and however old the constraints are.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use common::*;
use feeler_haptics::internals::{Servo, ServoInput};
use feeler_haptics::{Coupling, Mode, RunnerOptions, SessionOptions, Sides};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    // The thread-local value is gone while a thread ends.
    let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
}

// SAFETY: everything is passed on to the system's allocator; the counting itself allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as the caller promises.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations and releases by this thread.
fn calls_of(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

#[test]
fn ticks_of_the_servo_side_allocate_nothing() {
    assert!(calls_of(|| drop(vec![1])) >= 2, "the counter counts");
    let session = started(plate(), SessionOptions::default());
    let sides = Sides::new(session, Box::new(device(pushing())), &RunnerOptions::default());
    let Sides { mut collision, mut servo, mut watch } = sides.map_err(|refused| refused.error).unwrap();
    let mut modes = Vec::new();
    for k in 0..5000 {
        let now = f64::from(k) * 1e-3;
        // The collision side runs at full rate, slowly, and then not at all; the trace fills up as well.
        if k < 1000 || k < 3000 && k % 100 == 0 {
            collision.tick(now);
        }
        let calls = calls_of(|| {
            servo.tick(now);
            servo.took(1e-4, 1e-5, 0, now);
        });
        assert_eq!(calls, 0, "tick {k}");
        modes.push(watch.view().mode);
    }
    for mode in [Mode::Free, Mode::Contact, Mode::Bound, Mode::Doubt] {
        assert!(modes.contains(&mode), "{mode:?}");
    }
}

#[test]
fn the_servo_alone_allocates_nothing() {
    let options = SessionOptions::default();
    let mut session = started(plate(), options);
    for k in 1..40 {
        session.step(Some(&at([0.0, 0.0, 0.03 - 5e-4 * f64::from(k)], [0.1, 0.1, 0.0])), 1e-3).unwrap();
    }
    let set = *session.constraints().unwrap();
    assert!(!set.rows().is_empty());
    let limits = options.limits(1e-3);
    let mut servo = Servo::new(Coupling::default(), options.driven, &limits, 1000.0, set.metric.centre).unwrap();
    for k in 0..1000 {
        let t = f64::from(k);
        let device = at([1e-5 * t, 0.0, 0.02], [1e-4 * t, 0.05, 0.0]);
        let now = set.time + 1e-3 * t;
        let input = ServoInput { device, device_twist: None, now, dt: 1e-3, in_doubt: k % 100 == 99 };
        let calls = calls_of(|| {
            servo.tick(&set, &input);
        });
        assert_eq!(calls, 0, "tick {k}");
    }
}
