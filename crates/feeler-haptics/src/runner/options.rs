//! The options of a run.

use std::fmt;
use std::sync::Arc;

use feeler_core::Pose;

use crate::error::{Error, Result};

/// A thread of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThreadKind {
    /// The one with the device.
    Servo,
    /// The one with the proxy.
    Collision,
}

/// How the device is put into the world; see [`Mapping`](crate::device::mapping::Mapping).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct MappingOptions {
    /// How far the tool moves for a metre of the handle.
    pub scale: f64,
    /// Which way the device's axes point in the world; and, where it is absolute, where the tool's frame is while the handle is at the
    /// origin of its own, not turned.
    pub world_from_device: Pose,
    /// Whether the handle's place is the tool's from the first tick on. Else the tool stays where it is when the run or the session
    /// starts, and follows the handle's motions from there.
    pub is_absolute: bool,
    /// Number of the button (0 is the first) that lets the handle move without the tool.
    pub clutch_button: Option<u32>,
}

impl Default for MappingOptions {
    fn default() -> MappingOptions {
        MappingOptions { scale: 1.0, world_from_device: Pose::IDENTITY, is_absolute: false, clutch_button: None }
    }
}

impl MappingOptions {
    feeler_core::setters! {
        with_scale: scale: f64,
        with_world_from_device: world_from_device: Pose,
        with_is_absolute: is_absolute: bool,
        with_clutch_button: clutch_button: impl Into<Option<u32>>,
    }
}

/// Called by each thread before its first tick.
pub type OnThreadStart = Arc<dyn Fn(ThreadKind) + Send + Sync>;

/// Calls its argument, once.
pub type AroundWork = Arc<dyn Fn(&mut (dyn FnMut() + Send)) + Send + Sync>;

/// How a session is to run.
#[derive(Clone)]
#[non_exhaustive]
pub struct RunnerOptions {
    /// Of the servo thread, hertz: 50 to 100000.
    pub rate_hz: f64,
    /// Of the collision thread, hertz; `None`: as fast as it can, as long as there is something new.
    pub collision_hz: Option<f64>,
    /// Of the device.
    pub mapping: MappingOptions,
    /// Called by each thread before its first tick, to set its priority.
    pub on_thread_start: OnThreadStart,
    /// What a grip or a new scene takes is done within this, on the collision thread: where the caller has threads for such work, it
    /// hands it to them.
    pub around_work: AroundWork,
}

impl Default for RunnerOptions {
    fn default() -> RunnerOptions {
        RunnerOptions {
            rate_hz: 1000.0,
            collision_hz: None,
            mapping: MappingOptions::default(),
            on_thread_start: Arc::new(|_| ()),
            around_work: Arc::new(|work| work()),
        }
    }
}

impl RunnerOptions {
    /// Has each thread call a function before its first tick, to set its priority.
    #[must_use]
    pub fn with_on_thread_start(mut self, call: impl Fn(ThreadKind) + Send + Sync + 'static) -> Self {
        self.on_thread_start = Arc::new(call);
        self
    }

    /// Has the collision thread do within a function what a grip or a new scene takes.
    #[must_use]
    pub fn with_around_work(mut self, call: impl Fn(&mut (dyn FnMut() + Send)) + Send + Sync + 'static) -> Self {
        self.around_work = Arc::new(call);
        self
    }

    feeler_core::setters! {
        with_rate_hz: rate_hz: f64,
        with_collision_hz: collision_hz: impl Into<Option<f64>>,
        with_mapping: mapping: MappingOptions,
    }
}

impl RunnerOptions {
    /// Errors where a rate is out of its range; what the mapping may be depends on the device.
    pub fn check(&self) -> Result<()> {
        if !(50.0..=1e5).contains(&self.rate_hz) {
            return Err(Error::Option { what: "rate_hz", value: self.rate_hz, range: "between 50 and 100000 Hz" });
        }
        match self.collision_hz {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                Err(Error::Option { what: "collision_hz", value, range: "positive (hertz)" })
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Debug for RunnerOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RunnerOptions")
            .field("rate_hz", &self.rate_hz)
            .field("collision_hz", &self.collision_hz)
            .field("mapping", &self.mapping)
            .finish_non_exhaustive()
    }
}
