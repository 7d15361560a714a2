//! Every limit and tolerance of this crate: its unit, why this value, and what moves if it is changed.

/// Angle (radians) below which the series of sine and cosine are exact to the last digit, and their quotients are not.
pub const SMALL_ANGLE: f64 = 1e-4;

// The coupling's own ranges.

/// Largest stiffness (newtons a metre, and newton metres a radian) that is taken for meant: steel parts give way less
/// than devices do long before. More is refused as a slip of units.
pub const LARGEST_STIFFNESS: f64 = 1e7;
/// Largest damping (newton seconds a metre, and newton metre seconds a radian) that is taken for meant.
pub const LARGEST_DAMPING: f64 = 1e5;
/// Largest force (newtons) and torque (newton metres) that is taken for meant. A hand is hurt by less; a device's own
/// bound is lower.
pub const LARGEST_WRENCH: f64 = 1e4;
/// Largest slew (newtons a second, and newton metres a second) that is taken for meant.
pub const LARGEST_SLEW: f64 = 1e8;
/// Stretch (metres) at which a preset's spring is at the device's largest force, before the device's bounds take
/// stiffness away. Less feels harder, where the device can hold it.
pub const FULL_FORCE_AT_M: f64 = 0.002;
/// The same in rotation (radians).
pub const FULL_TORQUE_AT_RAD: f64 = 0.05;
/// Time (seconds) in which a preset's force may go from nothing to the device's largest. Below a few milliseconds it
/// limits nothing that a hand can do against a spring; above ten, a hard contact begins softly, and the lag makes work
/// for the passivity controller.
pub const FULL_FORCE_IN_S: f64 = 0.004;

// What a device holds.

/// Share of the device's damping that spring and damper of the coupling may use up, by Colgate's bound. The rest is for
/// what data sheets do not say, and for the soft wall of a workspace ([`WALL_SHARE`]). More is stiffer, and nearer to a
/// limit cycle.
pub const HELD_SHARE: f64 = 0.8;
/// Share of it that the virtual damper may take of that: each newton second a metre of damping takes stiffness away.
pub const VIRTUAL_DAMPING_SHARE: f64 = 0.2;
/// Largest share of what the device holds in rotation that is left to the spring of translation, where the tool's
/// centre is away from the handle: it turns the handle by its arm. More makes long tools stiffer in translation and
/// softer in rotation.
pub const ARM_SHARE: f64 = 0.5;
/// How many times what an arm uses up at full translational stiffness is set apart for it, as long as that is less than
/// [`ARM_SHARE`]: with 9, a short arm takes a tenth of the translational stiffness. More takes less there, and more of
/// the rotational one.
pub const ARM_ROOM: f64 = 9.0;

// The passivity observer and controller.

/// Time constant (seconds) at which energy that the coupling took from the hand for good is forgotten. Longer, and what
/// was lost in one contact pays for energy made in a later one; shorter, and the controller damps a little more.
pub const SURPLUS_LEAK_S: f64 = 0.1;
/// Time constant (seconds) at which a deficit is forgiven while nothing is touched. Longer, and air feels thick after a
/// contact; shorter, and bouncing off a wall may gain energy.
pub const DEFICIT_LEAK_S: f64 = 0.05;
/// Share of the device's damping that the controller's damping and the virtual damper may reach together. Colgate's
/// bound for a damper without spring is 1.
pub const CONTROLLER_SHARE: f64 = 0.9;
/// Longest delay (ticks) that the observer can account for; a longer one counts as this.
pub const LONGEST_DELAY_TICKS: usize = 64;

// The force loop.

/// Shortest tick (seconds) that is believed: 100 kHz.
pub const SHORTEST_TICK_S: f64 = 1e-5;
/// Longest tick (seconds) that is believed. Force that is held longer than this is not force that answers the hand any
/// more.
pub const LONGEST_TICK_S: f64 = 0.02;
/// Speed (metres a second) above which a device is taken to have jumped. Hands move at 3 m/s, and a device of 100 Hz
/// tells ten ticks' motion at once.
pub const JUMP_SPEED: f64 = 50.0;
/// The same in rotation (radians a second).
pub const JUMP_RATE: f64 = 1000.0;
/// Time (seconds) in which the bound of the force grows to its whole after letting go, and at the start. Shorter kicks;
/// longer lets the hand sink in.
pub const RETURN_S: f64 = 0.2;
/// Poses that a velocity may be found over. More is quieter at rest, and costs its square in time.
pub const VELOCITY_WINDOW: usize = 16;

// Simulated devices.

/// Inner step (seconds) of the physics of a simulated device: a twentieth of a servo tick at 1 kHz. Shorter is nearer
/// to continuous time, and costs in proportion.
pub const INNER_STEP_S: f64 = 5e-5;
/// Longest delay (seconds) of a simulated device, jitter included.
pub const LONGEST_DELAY_S: f64 = 0.05;
/// Commands on their way to a simulated device at the most: 20 kHz over the longest delay.
pub const COMMANDS_ON_THE_WAY: usize = 1024;
/// Longest time (seconds) that a simulated device catches up with; the rest of a pause does not happen for it.
pub const LONGEST_CATCH_UP_S: f64 = 1.0;

// The mouse.

/// Smallest and largest natural frequency (radians a second) of the smoothing of targets.
pub const MOUSE_FREQUENCIES: [f64; 2] = [1.0, 1e3];
/// Natural frequency (radians a second) of the smoothing: targets that come at 60 Hz are smooth at 1 kHz, 50 ms behind
/// the hand. Higher follows faster, and shows the steps of the targets.
pub const MOUSE_FREQUENCY: f64 = 40.0;

// The mapping.

/// Smallest and largest scale from the device's motions to the tool's.
pub const SCALES: [f64; 2] = [1e-3, 1e3];
/// Depth of the soft wall inside the workspace's border, as a share of half the workspace's edge.
pub const WALL_DEPTH: f64 = 0.1;
/// Share of the device's damping that the soft wall's spring may use up, beside [`HELD_SHARE`] of the coupling.
pub const WALL_SHARE: f64 = 0.15;
/// Share of the device's largest force that the soft wall has at the border, at the most.
pub const WALL_FORCE_SHARE: f64 = 0.5;
