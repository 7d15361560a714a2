//! Every limit and tolerance of this crate: its unit, the reason for its value, and the effect of a change.

use std::time::Duration;

// All driven devices.

/// How long a wrench holds if the servo does not write another. Fifty periods of a servo of 1 kHz: longer than any hiccup of a system
/// that still runs, and so short that a hand feels a knock and no push. Smaller lets go of the force in hiccups.
pub const WATCHDOG: Duration = Duration::from_millis(50);

/// How old the newest pose may be before the device counts as lost. The slowest device here sends a hundred poses in
/// that time.
pub const SILENCE: Duration = Duration::from_millis(100);

/// How long `release` waits for the device's thread to confirm that the force is off. Much more than a round of any of
/// the threads; it limits how long the end of a session takes when a vendor's library hangs.
pub const RELEASE_WAIT: Duration = Duration::from_millis(500);

/// How long `open` waits for the first pose.
pub const FIRST_POSE_WAIT: Duration = Duration::from_secs(3);

/// Pause between two looks at the state of a thread, while opening and releasing.
pub const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// Rounds of a driver's thread between a motion of the handle and the force that answers it, beyond the servo's own tick: half a round
/// until the thread takes the force, on average, and half a round until the servo takes the pose. An estimate: what the device and its
/// connection add is not known. More takes stiffness away.
pub const HANDOVER_ROUNDS: f64 = 1.0;

/// Rate of a usual servo loop, hertz, at which a stiffness that a user knows is held.
pub const USUAL_HZ: f64 = 1000.0;

/// Largest distance of a handle from its origin that is believed, metres. No device reaches a tenth of that.
pub const LARGEST_REACH_M: f64 = 10.0;

/// Largest plausible speed of a handle, metres a second: ten times that of an arm.
pub const LARGEST_SPEED_M_PER_S: f64 = 100.0;

/// Largest rate of turning that is believed, radians a second.
pub const LARGEST_TURN_RAD_PER_S: f64 = 1e3;

/// How far a reported rotation may be from a rotation (sum of squares of R^T R - 1). Devices compute theirs in float32,
/// with errors of 1e-6; larger errors mean a fault.
pub const ROTATION_TOLERANCE: f64 = 1e-3;

// SpaceMouse.

/// The device in errors.
pub const SPACEMOUSE: &str = "SpaceMouse";

/// Where the daemon of most distributions listens.
pub const SPACENAVD_SOCKET: &str = "/var/run/spnav.sock";

/// Counts of full deflection: the values of SpaceMouse devices at their stops (350 for those on USB, about 400 for
/// serial ones), with the daemon's sensitivity of 1.
pub const FULL_DEFLECTION_COUNTS: f64 = 350.0;

/// Counts beyond which a motion is not believed: full deflection with the daemon's sensitivity at a thousand.
pub const LARGEST_COUNTS: i32 = 350_000;

/// Longest difference of two times of reading that moves the pose, seconds. After a longer break the tool does not leap.
pub const LONGEST_STEP_S: f64 = 0.1;

/// How long a read on the daemon's socket waits before the reader looks whether the device is being closed.
pub const SOCKET_WAIT: Duration = Duration::from_millis(100);

/// How long the daemon has to answer a request. The daemon's own library waits 0.3 to 0.4 s.
pub const DAEMON_ANSWER_WAIT: Duration = Duration::from_millis(400);

/// Pause before a lost daemon is tried again.
pub const RECONNECT_PAUSE: Duration = Duration::from_millis(500);

/// Highest event number that the daemon may use in future. Higher ones mean that the bytes are out of step.
pub const LARGEST_EVENT: i32 = 63;

/// Buttons that fit the bits of a state.
pub const BUTTON_BITS: u32 = 32;

/// Rate of events from a SpaceMouse, hertz (USB, 8 ms).
pub const SPACEMOUSE_HZ: f64 = 125.0;

// Haply.

/// The device in errors.
pub const INVERSE3_NAME: &str = "Haply Inverse3";

/// Where the Inverse Service listens.
pub const INVERSE_SERVICE: &str = "localhost:10001";

/// Largest message of the service that is read, bytes. Full states of eight devices have less than 20 kB.
pub const LARGEST_MESSAGE_BYTES: usize = 1 << 20;

/// How long connecting and the handshake may take.
pub const CONNECT_WAIT: Duration = Duration::from_secs(1);

/// How long a read waits for the service before the thread looks whether the force has ended.
pub const SERVICE_WAIT: Duration = Duration::from_millis(10);

/// How long the service may be silent before a command without a force is sent again: it stops telling states when commands stop, and
/// poses of that age are not trusted. Shorter: commands wait at a slow service.
pub const RESEND_WAIT: Duration = SILENCE;

/// The same for a service that stays silent or answers slowly: each wait is twice the one before.
pub const LONGEST_RESEND_WAIT: Duration = Duration::from_secs(1);

/// How long sending may block before the service counts as lost.
pub const SEND_WAIT: Duration = Duration::from_millis(50);

/// How long the service has to confirm the preset before poses are reported without it.
pub const PRESET_WAIT: Duration = Duration::from_millis(500);

/// Pause between two requests for the full state, which has the preset.
pub const FULL_STATE_PAUSE: Duration = Duration::from_millis(50);

// Force Dimension.

/// The device in errors.
pub const FORCE_DIMENSION: &str = "Force Dimension";

/// Rate of the thread that talks to the vendor's library, hertz: as fast as the maker's devices answer on USB. An estimate; a
/// device that is slower makes the library's calls wait.
pub const DHD_HZ: f64 = 4000.0;

// The machine.

/// Priority of real-time threads, of 0 to 99: above all that is ordinary, below the interrupt threads of a real-time kernel at 50.
pub const REALTIME_PRIORITY: u8 = 45;

/// The same of threads that find contacts: below the servo's, so that it never waits for them, and above all that is ordinary.
pub const COLLISION_PRIORITY: u8 = 40;

/// Longest sleep, seconds; a longer request wakes up at that time, before its end.
pub const LONGEST_SLEEP_S: f64 = 3600.0;
