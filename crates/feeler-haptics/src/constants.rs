//! Every limit and tolerance of this crate: its unit, the reason for its value, and the effect of a change.

/// How far a sunk part may give way, metres: above rounding.
pub const SEAT_SLACK: f64 = 1e-8;

/// How far contact rows keep a seated part off the end of its play, metres: twice as far as a walk does. Smaller: walks end at once.
pub const SEAT_REST: f64 = 2.0 * feeler_world::SEAT_REST;

// Constraint sets.

/// Most planes of a set: see [`MOST_ROWS`].
pub const MOST_PLANES: usize = 64;

/// Most rows of a set: 32 planes of eight points. More: a servo tick takes longer; fewer: planes beyond shorten how far a set is good
/// for.
pub const MOST_ROWS: usize = 256;

/// Programs in a row for one pose, each linear at the last one's: two for turns of a degree, the third for rounding.
pub const SOLVER_ROUNDS: usize = 4;

/// Share of the skin below which a round's motion is the last: the next one's gain would be its square.
pub const SOLVER_STILL_SHARE: f64 = 0.02;

// The proxy.

/// Share of the skin below which a motion is none.
pub const STILL_SHARE: f64 = 1e-4;

/// Share of the least gap that a cast may end before the impact. Larger: motions along a surface are stopped by it; smaller: slower.
pub const CAST_SHARE: f64 = 0.05;

/// Limits for that, metres: a micrometre, and a value above rounding in a mock-up of some metres.
pub const LARGEST_CAST_TOLERANCE: f64 = 1e-6;
pub const LEAST_CAST_TOLERANCE: f64 = 1e-10;

/// Share of the skin that the pair which stopped a motion is left apart.
pub const BACK_OFF_SHARE: f64 = 0.5;

/// Most times that the way back is doubled to get there: from a share of the skin to all of a metre.
pub const BACK_OFF_HALVINGS: usize = 16;

/// Most pairs remembered that stopped a cast.
pub const MOST_BLOCKERS: usize = 32;

/// Share of the clearance that is the skin, where that is less than the option's.
pub const CLEARANCE_SHARE: f64 = 0.5;

/// Bisections of the clearance: to two per cent of it.
pub const SKIN_HALVINGS: usize = 9;

/// Longest way, in skins as asked for, that may be needed to have all rows off by a skin for it to fit: farther off is another place.
pub const MOST_LIFT: f64 = 10.0;

/// Share of the skin by which a motion must lead nearer to the device for another to follow in the same tick.
pub const STUCK_SHARE: f64 = 0.1;

/// Share of the last motion's approach in a tick below which the next motion is left for the next tick. Larger: quicker ticks, and a peg
/// that feels its way into a tight hole takes more of them.
pub const REST_SHARE: f64 = 0.05;

/// Factor by which the longest motion shrinks after one stopped by a known row, and grows after a free one.
pub const TRUST_GROWTH: f64 = 2.0;

/// Share of the skin below which the tool is lifted before it is moved on: from a start that near, arcs are stopped at once.
pub const LIFT_SHARE: f64 = 0.5;

/// Longest turn beside rows: the square root of this many skins over the tool's radius (radians). A point's arc is then
/// off its chord by an eighth of that: a quarter of the skin.
pub const ARC_SKINS: f64 = 2.0;

/// Shortest motion that the proxy is trusted with, in skins: for so little any row holds.
pub const LEAST_TRUST: f64 = 0.5;

/// Share of the skin with which the proxy is tried where contacts hold it from several sides. Smaller: tighter fits are entered.
pub const SQUEEZE_SHARE: f64 = 1.0 / 16.0;

/// How much nearer to the device that must lead, in skins: more than any but a very sharp wedge gives by itself.
pub const SQUEEZE_GAIN: f64 = 4.0;

/// Most ticks between two such tries.
pub const MOST_PATIENCE: u32 = 63;

/// By how much the skin grows a tick, where it may.
pub const SKIN_GROWTH: f64 = 2.0;

/// How far a wider skin may push the tool, in skins: less than [`SQUEEZE_GAIN`], so that it does not push it out of a
/// tight gap.
pub const SKIN_LIFT: f64 = 2.5;

/// Range of contacts: this many of the longest of the last motions, and this many skins. Larger: more planes, which are
/// merged more coarsely where surfaces are curved; smaller: a fast tool is held back between two sets.
pub const STRIDES: f64 = 2.0;
pub const SKINS_IN_MARGIN: f64 = 20.0;

/// Share of the margin that rows are taken along with the tool before contacts are found anew. Larger: fewer searches, and more motions
/// that a neighbouring facet stops; smaller: more searches a tick.
pub const STRAY_SHARE: f64 = 0.5;

/// Least range of contacts, in requested skins.
pub const LEAST_MARGIN: f64 = 2.0;

/// By how much the longest of the last motions is forgotten a tick.
pub const STRIDE_DECAY: f64 = 0.8;

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
/// Share of a preset's stiffness where neither damping nor largest stiffness of the device is known. More feels harder, and may hum.
pub const UNKNOWN_SHARE: f64 = 0.2;
/// Rate (hertz) that a known or asked stiffness is taken to be for where nothing else is known, and that a device of unknown rate is
/// taken to have: the usual servo loop's. Higher is softer in slow loops.
pub const USUAL_HZ: f64 = 1000.0;
/// Time (seconds) in which a preset's force may go from nothing to the device's largest. Below a few milliseconds it
/// limits no motion of a hand against a spring; above ten, a hard contact begins softly, and the lag makes work
/// for the passivity controller.
pub const FULL_FORCE_IN_S: f64 = 0.004;

// What a device holds.

/// Share of the device's damping that spring and damper of the coupling may use up, by Colgate's bound. The rest is for
/// properties missing in data sheets, and for the soft wall of a workspace ([`WALL_SHARE`]). More is stiffer, and
/// nearer to a limit cycle.
pub const HELD_SHARE: f64 = 0.8;
/// Share of it that the virtual damper may take of that: each newton second a metre of damping takes stiffness away.
pub const VIRTUAL_DAMPING_SHARE: f64 = 0.2;

// The passivity observer and controller.

/// Time constant (seconds) at which energy that the coupling took from the hand for good is forgotten. Longer: losses
/// in one contact pay for energy made in a later one; shorter: the controller damps a little more.
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
pub const LONGEST_TICK_S: f64 = 0.05;
/// How many times longer ticks may be than those that the coupling is limited for before its stiffness goes down; and a session's, also
/// shorter, before its limits are found anew. Smaller: with a clock that jitters both change at every tick.
pub const RATE_SHARE: f64 = 1.5;
/// Time (seconds) over which ticks are averaged to know the rate. Longer, and the first slow ticks shake the hand; shorter, and one late
/// tick makes a wall soft.
pub const RATE_MEMORY_S: f64 = 0.05;
/// The same while a device's reports become faster again. Longer: soft for longer; shorter: uneven reports make the force uneven.
pub const RATE_RETURN_S: f64 = 0.1;
/// Time (seconds) after a silence of a device in which another counts as its rate. Longer: two pauses make a wall soft; shorter: a device
/// that reports every tenth of a second is stiff in between.
pub const SILENCE_MEMORY_S: f64 = 1.0;
/// Speed (metres a second) above which a device is taken to have jumped. Hands move at 3 m/s, and a device of 100 Hz
/// reports ten ticks' motion at once.
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
/// Share of the device's damping that the soft wall's spring may use up, beside [`HELD_SHARE`] of the coupling; of its largest stiffness
/// where the damping is not known.
pub const WALL_SHARE: f64 = 0.15;
/// Share of the device's largest force that the soft wall has at the border, at the most.
pub const WALL_FORCE_SHARE: f64 = 0.5;

/// How far (seconds of its velocity) a rate-controlled device's tool may be ahead of the proxy. Longer, and coming back takes longer;
/// shorter than some ticks, and the tool lags.
pub const LEAD_S: f64 = 0.01;

// The servo side.

/// How far (metres) the tool may move between two sets where nothing is nearer: 1 m/s at 10 sets a second. Larger: longer searches.
pub const FREE_MARGIN: f64 = 0.1;

/// How often in one step the collision side goes on to where the servo side has the proxy. More: the force belongs to contacts that were
/// found nearer; slower where facets are crossed.
pub const MOST_CATCH_UPS: usize = 2;

/// Share of a set's margin that the proxy may move between two sets: the rest is for the arcs of turning points.
pub const BOUND_SHARE: f64 = 0.95;

/// Age (seconds) from which on constraints are not trusted, and the force is let go: some collision ticks at 10 Hz.
pub const OLDEST_SET_S: f64 = 0.5;

/// Changes of the proxy's pose (metres, radians) that do not count as motion: a hundredth of the skin.
pub const PROXY_RESOLUTION_M: f64 = 2e-7;
pub const PROXY_RESOLUTION_RAD: f64 = 2e-6;

// Threads.

/// Age (seconds) of a device's state from which on it counts as silent, and the force is let go. Shorter: a hiccup of its connection
/// drops the force; longer: an old force pushes on.
pub const SILENT_S: f64 = 0.05;

/// The same in periods of the device, if it reports a rate and they are longer: one of 20 Hz is not silent between two
/// states.
pub const SILENT_PERIODS: f64 = 3.0;

/// How long (seconds) the collision thread rests where there is nothing new: a fifth of a servo tick at 1 kHz, so that news do not wait.
pub const COLLISION_REST_S: f64 = 2e-4;

/// How often (seconds) contacts are found again without new input, so that a set's age shows that the thread lives.
pub const COLLISION_REFRESH_S: f64 = 1e-3;

/// How often (seconds) the threads hand their counts over. Shorter: time of the servo thread; longer: older tables.
pub const STATISTICS_PERIOD_S: f64 = 0.1;

/// Longest duration that is counted, nanoseconds: ten seconds.
pub const LONGEST_COUNTED_NS: u64 = 10_000_000_000;

/// Significant digits of counted durations. A third costs eight times the memory, and time to hand it over.
pub const HISTOGRAM_DIGITS: u8 = 2;

/// Ticks that a rate is known after: a tenth of a second at 1 kHz. Fewer: one late tick at the start looks like a slow machine.
pub const TICKS_FOR_A_RATE: u64 = 100;

/// Ticks that a trace has room for until they are taken: four seconds at 1 kHz.
pub const TRACE_TICKS: usize = 4096;

/// Planes that a view has: six hold a body with six freedoms.
pub const VIEW_PLANES: usize = 6;

// Force shading.

/// Largest bend (radians) of a side of the tessellation: tessellators stop at 0.5 by default. Larger: chamfers of 30 degrees are felt
/// round; smaller: tubes of few sides are felt with their facets.
pub const LARGEST_SMOOTH_BEND: f64 = 0.51;

/// Bend (radians) that is none. Larger: finely curved surfaces count as one flat face; smaller: rounding of flat faces is a bend.
pub const FLAT_BEND: f64 = 1e-4;

/// How many times larger or smaller the next bend of a curved surface may be. Larger: two real edges beside each other are felt round;
/// smaller: curves that are cut unevenly are felt with their facets.
pub const BEND_LIKENESS: f64 = 4.0;

/// Least cosine between two sides that a surface bends over one after the other: triangles of equal sides have 0.5. Larger: these are
/// felt with their facets; smaller: a bend along a surface is taken for one across it.
pub const PARALLEL_COSINE: f64 = 0.4;

/// Most triangles of one flat facet visited to find its border. More: finer facets are recognised; slower.
pub const LARGEST_FLAT_WALK: usize = 16;

/// Most triangles around a corner. More: the pole of a finer ball is whole; slower.
pub const LARGEST_FAN: usize = 64;

/// How many times wider than the facet beside it a facet may be to count as bent like it. Larger: a flat face is felt round beside a
/// fillet; smaller: unevenly cut surfaces are felt with their facets.
pub const LIKE_WIDTHS: f64 = 4.0;

/// Share of a triangle's corner below which a point is on the side across from it. Larger: real edges are as wide as that; smaller:
/// rounding decides.
pub const EDGE_SHARE: f64 = 1e-6;

/// Planes of a set that are shaded, the nearest ones. More: a crowded contact takes longer; fewer: some facets are felt there.
pub const MOST_SHADED: usize = 8;

/// Largest turn (radians) of a force by shading: the facets of both surfaces at half their largest bend. Larger: a mesh with bad normals
/// turns the force more.
pub const LARGEST_SHADING_TURN: f64 = 0.3;

/// How much faster than the tool's the contact's normal may turn: where a pin fits a bore, by radius over play. Larger: the noise of the
/// facets is felt in fits.
pub const LARGEST_GAIN: f64 = 8.0;

/// Curvature (one over metres) that counts as flat: a radius of a kilometre. Larger: large curved surfaces count as
/// flat.
pub const LEAST_CURVATURE: f64 = 1e-3;

/// Share of an edge's length that it has at least along a surface that it touches. Smaller: an edge that stands on a surface counts as
/// lying on it; larger: an askew one touches with a point.
pub const LEAST_SLOPE: f64 = 0.5;

/// Largest height (metres) of an arc over its facet: tessellators keep to less. Larger: a lid with bevelled sides is felt round; smaller:
/// large radii that are cut coarsely are felt with their facets.
pub const LARGEST_BULGE_M: f64 = 5e-4;

/// Mean height of an arc over its chord, as a share of the largest: that of a parabola. Another value: a facet is felt harder or softer as
/// a whole.
pub const MEAN_OF_ARC: f64 = 2.0 / 3.0;

/// Stretch of the spring, in heights of the smooth surface over its facets, from which on all of the force is turned. Smaller: the first
/// touch of coarse facets is stiffer, by a third of its inverse; larger: light touches feel facets.
pub const SHADING_RAMP: f64 = 1.5;

/// How much shading may give beside its potential before it fades, and over how much it does, as a share of the force times the height
/// of the smooth surface over its facets. Larger: closed motions may gain more at first; smaller: coarse facets are felt.
pub const SHADING_CREDIT: f64 = 0.4;

/// How much it may have given, likewise, where nothing is touched. Larger: closed motions gain more until it fades; smaller: one that is
/// not certain turns shading off in the next ones.
pub const SHADING_DEBT: f64 = 0.05;

/// How much it may give in all, likewise: its potential is that much below the facets' where these stand out most, and the credit.
/// Smaller: touches at the rims of facets feel facets.
pub const SHADING_LOAN: f64 = 1.2;

/// How fast (shares a second) shading fades and comes back. Larger: felt as a jump; smaller: it gives more before it has faded.
pub const SHADING_FADE_RATE: f64 = 50.0;

/// How fast a shaded force may turn by itself (radians a second), beside what its spring and the device turn: 1 % a tick at 1 kHz. Larger:
/// contacts that are not certain are felt as a buzz; smaller: the force stays behind the surface.
pub const SHADING_TURN_RATE: f64 = 10.0;

/// Way of the device (metres) for a turn of one radian beside that: the least radius that the force follows at once. Smaller: contacts
/// that are not certain are rough; larger: small fillets are felt late.
pub const SHADING_REACH_M: f64 = 5e-3;

/// The most that a guide draws the hand with, newtons. A device of 8 N has four times as much left for contacts. Larger: it is
/// harder to leave the way.
pub const GUIDE_FORCE_N: f64 = 1.5;

/// Of its spring: all of its force at 25 mm. It is far below what any device holds stably at a few hundred hertz.
pub const GUIDE_STIFFNESS_N_PER_M: f64 = 60.0;

/// Of its damper, by a velocity that is the mean of the last [`GUIDE_VELOCITY_S`]. Larger: slower, and rough where the encoders are.
pub const GUIDE_DAMPING_NS_PER_M: f64 = 1.0;

/// Seconds over which the velocity is a mean. Shorter: encoder steps are felt; longer: the damping comes late.
pub const GUIDE_VELOCITY_S: f64 = 0.01;

/// Seconds in which it grows to its whole, and goes. Shorter kicks.
pub const GUIDE_RISE_S: f64 = 0.15;

/// The most that its force changes, newtons a second. Less than the spring needs at its own frequency, and the handle swings about
/// the place for ever: a bound on the rate comes late.
pub const GUIDE_SLEW_N_PER_S: f64 = 200.0;

/// A guide ends if its place was not set for this long (seconds). Shorter: it ends when the caller is late once; longer: it pulls to
/// a place that is out of date.
pub const OLDEST_GUIDE_S: f64 = 0.1;
