//! The guarantees of simulated device, mouse and mapping, in simulated time.

use std::f64::consts::TAU;

use feeler_core::geometry::twist::{displaced, displacement, pose_of, rotation_of, times};
use feeler_core::geometry::vectors::{length, scaled};
use feeler_core::{Point, Pose};
use feeler_haptics::device::hand::{Hand, HandPath};
use feeler_haptics::device::mouse::Mouse;
use feeler_haptics::device::simulated::{SimulatedDevice, SimulatedOptions};
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::internals::Mapping;
use feeler_haptics::{Coupling, Twist, Wrench};
use proptest::prelude::*;

const TICK: f64 = 1e-3;

fn pose(turn: Point, place: Point) -> Pose {
    pose_of(&rotation_of(&turn), &place).unwrap()
}

fn push(z: f64) -> Wrench {
    Wrench { force: [0.0, 0.0, z], torque: [0.0; 3] }
}

/// Neither friction nor rounding.
fn smooth() -> SimulatedOptions {
    let mut options = SimulatedOptions::desktop_6dof();
    let limits = &mut options.info.limits;
    (limits.friction_n, limits.rotational_friction_nm) = (0.0, 0.0);
    (limits.resolution_m, limits.rotational_resolution_rad) = (0.0, 0.0);
    options
}

fn height(device: &SimulatedDevice) -> f64 {
    device.true_pose().translation()[2]
}

mod simulated {
    use super::*;

    /// A path that moves and turns at once, for two seconds.
    fn wandering() -> HandPath {
        let key = |k: usize| {
            let t = 0.1 * k as f64;
            (t, pose([0.3 * t.sin(), 0.2 * t, 0.0], [0.02 * (3.0 * t).sin(), 0.01 * t, 0.01 * (5.0 * t).cos()]))
        };
        HandPath::new((0..20).map(key).collect()).unwrap()
    }

    fn told(seed: u64) -> Vec<DeviceState> {
        let options = SimulatedOptions::desktop_6dof()
            .with_pose_delay_s(1e-3)
            .with_force_delay_s(1e-3)
            .with_jitter_s(4e-3)
            .with_seed(seed);
        let mut device = SimulatedDevice::new(options, Some(Hand::firm(wandering()))).unwrap();
        let mut states = Vec::new();
        for tick in 0..1000 {
            let now = 7.0 + tick as f64 * TICK;
            let state = device.read(now).unwrap();
            device.write(&Wrench { force: scaled(state.pose.translation(), -50.0), torque: [0.0; 3] }, now).unwrap();
            states.push(state);
        }
        states
    }

    #[test]
    fn the_same_seed_is_the_same_motion() {
        assert_eq!(told(1), told(1));
        assert_ne!(told(1), told(2));
        let states = told(3);
        assert!(states.windows(2).all(|pair| pair[0].time <= pair[1].time), "time goes back");
    }

    #[test]
    fn how_often_it_is_asked_changes_no_motion() {
        let mut often = SimulatedDevice::new(smooth(), Some(Hand::firm(wandering()))).unwrap();
        let mut seldom = often.clone();
        for tick in 0..=4000 {
            often.read(tick as f64 * 0.25e-3).unwrap();
        }
        for tick in 0..=10 {
            seldom.read(tick as f64 * 0.1).unwrap();
        }
        assert_eq!((often.true_pose(), often.true_twist()), (seldom.true_pose(), seldom.true_twist()));
        assert!(length(often.true_pose().translation()) > 1e-3);
    }

    /// A constant force against viscous and Coulomb friction: `v = (F - f) / b (1 - exp(-b t / m))`.
    #[test]
    fn a_free_handle_obeys_its_friction() {
        let mut options = smooth();
        options.info.limits.friction_n = 0.5;
        let (m, b) = (options.mass_kg, options.info.limits.damping_n_s_per_m);
        let mut device = SimulatedDevice::new(options, None).unwrap();
        device.write(&push(0.4), 0.0).unwrap();
        device.read(0.5).unwrap();
        assert_eq!(height(&device), 0.0, "friction holds it");
        device.write(&push(2.0), 0.5).unwrap();
        for t in [0.05f64, 0.2, 0.8] {
            device.read(0.5 + t).unwrap();
            let expected = (2.0 - 0.5) / b * (1.0 - (-b * t / m).exp());
            let speed = device.true_twist().linear[2];
            assert!((speed - expected).abs() < 2e-3 * expected, "{speed} {expected}");
        }
    }

    #[test]
    fn a_pushed_hand_gives_way_and_comes_back() {
        let hand = Hand::firm(HandPath::constant(Pose::IDENTITY));
        let (k, turning) = (hand.stiffness_n_per_m, hand.rotational_stiffness_nm_per_rad);
        let mut device = SimulatedDevice::new(smooth(), Some(hand)).unwrap();
        device.write(&Wrench { force: [0.0, 0.0, 4.0], torque: [0.3, 0.0, 0.0] }, 0.0).unwrap();
        for tick in 0..3000 {
            device.read(tick as f64 * TICK).unwrap();
        }
        let away = displacement(&Pose::IDENTITY, device.true_pose(), &[0.0; 3]);
        assert!((away.linear[2] - 4.0 / k).abs() < 1e-6, "{away:?}");
        assert!((away.angular[0] - 0.3 / turning).abs() < 1e-6, "{away:?}");
        device.release();
        for tick in 3000..6000 {
            device.read(tick as f64 * TICK).unwrap();
        }
        assert!(height(&device).abs() < 1e-6);
    }

    /// Mass of handle and hand on the hand's spring, hardly damped, swing at their own frequency.
    #[test]
    fn it_swings_as_its_mass_and_spring_have_it() {
        let mut options = smooth();
        options.info.limits.damping_n_s_per_m = 0.0;
        let mass = options.mass_kg + 0.15;
        let hand = Hand { damping_n_s_per_m: 0.0, ..Hand::firm(HandPath::constant(pose([0.0; 3], [0.0, 0.0, 0.01]))) };
        let rest = Hand { path: HandPath::constant(Pose::IDENTITY), ..hand.clone() };
        let mut device = SimulatedDevice::new(options, Some(hand)).unwrap();
        device.read(0.0).unwrap();
        device.set_hand(Some(rest)).unwrap();
        let period = TAU * (mass / 400.0f64).sqrt();
        let mut crossings = Vec::new();
        let mut before = height(&device);
        for step in 1..20_000 {
            let now = step as f64 * 5e-5;
            device.read(now).unwrap();
            let after = height(&device);
            if before > 0.0 && after <= 0.0 {
                crossings.push(now);
            }
            before = after;
        }
        let found = (crossings[4] - crossings[0]) / 4.0;
        assert!((found - period).abs() < 1e-3 * period, "{found} {period}");
    }

    #[test]
    fn poses_are_rounded_and_late() {
        let mut options = SimulatedOptions::desktop_6dof().with_pose_delay_s(3e-3);
        options.info.limits.resolution_m = 1e-4;
        options.info.limits.rotational_resolution_rad = 1e-2;
        let mut device = SimulatedDevice::new(options, Some(Hand::firm(wandering()))).unwrap();
        assert_eq!(device.info().limits.delay_s, 3e-3);
        let mut truth = Vec::new();
        for tick in 0..500 {
            let state = device.read(tick as f64 * TICK).unwrap();
            truth.push(*device.true_pose());
            if tick < 3 {
                continue;
            }
            assert!((state.time - (tick - 3) as f64 * TICK).abs() < 1e-9);
            let off = displacement(&truth[tick - 3], &state.pose, &[0.0; 3]);
            assert!(off.linear.iter().all(|x| x.abs() <= 0.5e-4 + 1e-9), "{off:?}");
            assert!(length(&off.angular) <= 1e-2, "{off:?}");
            for x in state.pose.translation() {
                assert!((x / 1e-4 - (x / 1e-4).round()).abs() < 1e-6, "{x}");
            }
        }
    }

    #[test]
    fn forces_are_late_cut_and_let_go_at_once() {
        let mut device = SimulatedDevice::new(smooth().with_force_delay_s(2e-3), None).unwrap();
        device.write(&push(50.0), 0.0).unwrap();
        device.read(1.95e-3).unwrap();
        assert_eq!(*device.acting(), Wrench::ZERO);
        device.read(2.1e-3).unwrap();
        assert!((device.acting().force[2] - 12.0).abs() < 1e-12, "{:?}", device.acting());
        device.write(&push(1.0), 3e-3).unwrap();
        device.release();
        assert_eq!(*device.acting(), Wrench::ZERO);
        device.read(0.1).unwrap();
        assert_eq!(*device.acting(), Wrench::ZERO);
        // A driver that sends NaN counts as released.
        device.write(&push(3.0), 0.1).unwrap();
        device.read(0.11).unwrap();
        assert!(device.acting().force[2] > 0.0);
        assert!(matches!(device.write(&push(f64::NAN), 0.11), Err(DeviceError::Nonsense { .. })));
        assert_eq!(*device.acting(), Wrench::ZERO);
        // Freedoms without a motor get no force.
        let mut device = SimulatedDevice::desktop_3dof(None).unwrap();
        device.write(&Wrench { force: [1.0, 0.0, 0.0], torque: [1.0, 0.0, 0.0] }, 0.0).unwrap();
        device.read(1e-3).unwrap();
        assert_eq!(*device.acting(), Wrench { force: [1.0, 0.0, 0.0], torque: [0.0; 3] });
    }

    #[test]
    fn odd_times_do_no_harm() {
        let mut device = SimulatedDevice::large_6dof(Some(Hand::firm(wandering()))).unwrap();
        device.read(10.0).unwrap();
        device.read(10.1).unwrap();
        let there = (*device.true_pose(), device.time());
        for now in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 9.0, 10.1] {
            device.read(now).unwrap();
            assert_eq!((*device.true_pose(), device.time()), there, "{now}");
        }
        // After a long pause at most a second is caught up with, and time goes on from there.
        let state = device.read(1e6).unwrap();
        assert!((device.time() - there.1 - 1.0).abs() < 1e-9 && (state.time - 1e6).abs() < 1e-4);
        device.read(1e6 + 0.1).unwrap();
        assert!((device.time() - there.1 - 1.1).abs() < 1e-4);
    }

    #[test]
    fn what_cannot_be_a_device_is_refused() {
        let change: [fn(&mut SimulatedOptions); 7] = [
            |o| o.mass_kg = 0.0,
            |o| o.inertia_kg_m2 = f64::NAN,
            |o| o.info.limits.damping_n_s_per_m = -1.0,
            |o| o.info.limits.force_n = f64::INFINITY,
            |o| o.pose_delay_s = 1.0,
            |o| o.force_delay_s = -1e-3,
            |o| o.jitter_s = f64::NAN,
        ];
        for (case, change) in change.into_iter().enumerate() {
            let mut options = SimulatedOptions::desktop_6dof();
            change(&mut options);
            assert!(SimulatedDevice::new(options, None).is_err(), "{case}");
        }
        let hand = Hand { mass_kg: -1.0, ..Hand::loose(HandPath::constant(Pose::IDENTITY)) };
        assert!(SimulatedDevice::desktop_3dof(Some(hand.clone())).is_err());
        assert!(SimulatedDevice::desktop_3dof(None).unwrap().set_hand(Some(hand)).is_err());
    }
}

mod mouse {
    use super::*;

    #[test]
    fn it_is_where_an_exact_solution_has_it() {
        let target = pose([0.0, 0.0, 0.5], [0.1, 0.0, 0.0]);
        let mut mouse = Mouse::new(Pose::IDENTITY).with_frequency(30.0).unwrap();
        mouse.read(0.0).unwrap();
        mouse.set_target(target, 0.0);
        for t in [0.01, 0.05, 0.2] {
            let state = mouse.read(t).unwrap();
            let left = (1.0 + 30.0 * t) * (-30.0 * t).exp();
            let away = displacement(&target, &state.pose, &[0.0; 3]);
            assert!((away.linear[0] + 0.1 * left).abs() < 1e-14, "{away:?}");
            assert!((away.angular[2] + 0.5 * left).abs() < 1e-14, "{away:?}");
            let speed = 900.0 * t * (-30.0 * t).exp();
            let twist = state.twist.unwrap();
            assert!((twist.linear[0] - 0.1 * speed).abs() < 1e-12 && (twist.angular[2] - 0.5 * speed).abs() < 1e-12);
        }
    }

    fn targets() -> impl Strategy<Value = Vec<Pose>> {
        let target = (prop::array::uniform3(-0.5..0.5f64), prop::array::uniform3(-0.1..0.1f64));
        prop::collection::vec(target.prop_map(|(turn, place)| pose(turn, place)), 2..12)
    }

    proptest! {
        /// Targets at 60 Hz, reads at 1 kHz: the twist is the motion's, and neither ever jumps.
        #[test]
        fn pose_and_twist_are_smooth(targets in targets()) {
            let mut mouse = Mouse::new(Pose::IDENTITY);
            let mut before = mouse.read(0.0).unwrap();
            for tick in 1..400usize {
                let now = tick as f64 * TICK;
                if tick % 16 == 0 {
                    mouse.set_target(targets[(tick / 16).min(targets.len() - 1)], now);
                }
                let state = mouse.read(now).unwrap();
                let moved = displacement(&before.pose, &state.pose, &[0.0; 3]) * (1.0 / TICK);
                let mean = (before.twist.unwrap() + state.twist.unwrap()) * 0.5;
                // Trapezium: an error of the third derivative, which is at most some w^3 times the way.
                let off = moved - mean;
                prop_assert!(length(&off.linear) < 40f64.powi(3) * 0.4 * TICK * TICK, "{off:?}");
                prop_assert!(length(&off.angular) < 40f64.powi(3) * 2.0 * TICK * TICK, "{off:?}");
                let change = state.twist.unwrap() - before.twist.unwrap();
                prop_assert!(length(&change.linear) < 40f64.powi(2) * 0.4 * TICK * 2.0, "{change:?}");
                prop_assert!(length(&change.angular) < 40f64.powi(2) * 2.0 * TICK * 2.0, "{change:?}");
                before = state;
            }
            let away = displacement(targets.last().unwrap(), &mouse.read(2.0).unwrap().pose, &[0.0; 3]);
            prop_assert!(away.reach(1.0) < 1e-9, "{away:?}");
        }

        /// A target counts from its own time on, whenever the reads happen.
        #[test]
        fn reads_change_no_motion(targets in targets(), step in 1..40usize) {
            let mut seldom = Mouse::new(Pose::IDENTITY);
            let mut often = Mouse::new(Pose::IDENTITY);
            seldom.read(0.0).unwrap();
            often.read(0.0).unwrap();
            for (k, target) in targets.iter().enumerate() {
                let from = 0.016 * (k + 1) as f64 - 0.005;
                seldom.set_target(*target, from);
                often.set_target(*target, from);
                let end = 0.016 * (k + 1) as f64;
                (0..step).for_each(|i| {
                    often.read(end - 0.016 + 0.016 * i as f64 / step as f64).unwrap();
                });
                let (a, b) = (seldom.read(end).unwrap(), often.read(end).unwrap());
                prop_assert!(displacement(&a.pose, &b.pose, &[0.0; 3]).reach(1.0) < 1e-12);
                prop_assert!((a.twist.unwrap() - b.twist.unwrap()).reach(1.0) < 1e-10);
            }
        }
    }

    #[test]
    fn an_even_motion_is_followed_at_the_lag_that_is_stated() {
        let mut mouse = Mouse::new(Pose::IDENTITY).with_frequency(50.0).unwrap();
        for tick in 0..2000 {
            let now = tick as f64 * TICK;
            mouse.set_target(pose([0.0; 3], [0.2 * now, 0.0, 0.0]), now);
            let x = mouse.read(now).unwrap().pose.translation()[0];
            // A target stands for a tick, and is half a tick old.
            assert!(tick < 500 || (0.2 * (now - 0.04 - 0.5 * TICK) - x).abs() < 1e-5, "{now} {x}");
        }
    }

    #[test]
    fn it_drives_nothing_and_refuses_nonsense() {
        let mut mouse = Mouse::new(Pose::IDENTITY);
        assert!(!mouse.info().driven.translation && !mouse.info().driven.rotation);
        let coupling = Coupling::for_device(mouse.info());
        assert_eq!((coupling.check(), coupling.max_force_n, coupling.max_torque_nm), (Ok(()), 0.0, 0.0));
        mouse.set_buttons(5);
        assert_eq!(mouse.read(1.0).unwrap().buttons, 5);
        assert!(mouse.read(f64::NAN).is_err());
        mouse.set_target(pose([0.0; 3], [1.0, 0.0, 0.0]), f64::NAN);
        assert_eq!(mouse.read(2.0).unwrap().pose, Pose::IDENTITY);
        let there = pose([0.0; 3], [1.0, 0.0, 0.0]);
        mouse.jump(there);
        let state = mouse.read(3.0).unwrap();
        assert_eq!((state.pose, state.twist), (there, Some(Twist::ZERO)));
        for frequency in [0.0, 1e4, f64::NAN] {
            assert!(mouse.clone().with_frequency(frequency).is_err());
        }
    }
}

mod mapping {
    use super::*;

    fn info() -> DeviceInfo {
        SimulatedOptions::desktop_6dof().info
    }

    fn state(pose: Pose, buttons: u32) -> DeviceState {
        DeviceState::new(pose, 0.0).with_buttons(buttons)
    }

    fn vector(most: f64) -> impl Strategy<Value = Point> {
        prop::array::uniform3(-most..most)
    }

    fn is_same(a: &Pose, b: &Pose) -> bool {
        displacement(a, b, &[0.0; 3]).reach(1.0) < 1e-12
    }

    proptest! {
        /// The twist is the motion's, and the hand's power is the tool's over the scale: all six freedoms by one
        /// factor.
        #[test]
        fn wrenches_go_back_as_motions_come(
            base in (vector(1.5), vector(10.0)), handle in (vector(1.5), vector(0.03)),
            tool in (vector(1.5), vector(1.0)), centre in vector(3.0),
            motion in (vector(0.3), vector(2.0)), force in vector(3.0), torque in vector(0.05), scale in 0.5..20.0f64,
        ) {
            let mut mapping = Mapping::new(&info(), scale, &pose(base.0, base.1), None, centre).unwrap();
            let handle = pose(handle.0, handle.1);
            mapping.update(&state(handle, 0)).unwrap();
            // The tool at any place, rotated against the handle.
            let tool = pose(tool.0, tool.1);
            mapping.set_tool(&tool);
            let twist = Twist { linear: motion.0, angular: motion.1 };
            let mapped = mapping.update(&state(handle, 0).with_twist(twist)).unwrap();
            prop_assert!(is_same(&mapped.world_from_tool, &tool));
            let found = mapped.twist.unwrap();
            let wrench = Wrench { force, torque };
            let (in_world, at_hand) = (wrench.power(&found), mapping.wrench_on_hand(&wrench).power(&twist));
            prop_assert!((in_world - scale * at_hand).abs() < 1e-9, "{in_world} {at_hand}");
            prop_assert!((length(&mapping.wrench_on_hand(&wrench).force) - length(&force)).abs() < 1e-12);

            let h = 1e-6;
            let mut at = |by: f64| {
                let there = displaced(&handle, &(twist * by), &[0.0; 3]).unwrap();
                mapping.update(&state(there, 0)).unwrap().world_from_tool
            };
            let moved = displacement(&at(-h), &at(h), &centre) * (0.5 / h);
            prop_assert!((moved - found).reach(1.0) < 1e-6 * (1.0 + found.reach(1.0)), "{moved:?} {found:?}");
        }

        /// Held, the tool stays; let go, it goes on from there, about the world's axes as the hand goes about the
        /// device's.
        #[test]
        fn a_clutch_moves_the_hand_and_not_the_tool(
            base in (vector(1.5), vector(1.0)), a in (vector(1.0), vector(0.03)), b in (vector(1.0), vector(0.03)),
            by in (vector(0.02), vector(0.5)), scale in 0.5..20.0f64,
        ) {
            let base = pose(base.0, base.1);
            let mut mapping = Mapping::new(&info(), scale, &base, Some(1), [0.0; 3]).unwrap();
            let (a, b) = (pose(a.0, a.1), pose(b.0, b.1));
            let before = mapping.update(&state(a, 0)).unwrap();
            // The hand has already moved when the button is first told: the tool stays where it was.
            for handle in [b, a, b] {
                let twist = Some(Twist { linear: [1.0; 3], angular: [1.0; 3] });
                let held = mapping.update(&state(handle, 2).with_twist(twist)).unwrap();
                prop_assert!(held.is_clutched && held.twist == Some(Twist::ZERO));
                prop_assert_eq!(held.world_from_tool, before.world_from_tool);
                prop_assert_eq!(mapping.wrench_on_hand(&push(5.0)), Wrench::ZERO);
            }
            let after = mapping.update(&state(b, 0)).unwrap();
            prop_assert!(!after.is_clutched && is_same(&after.world_from_tool, &before.world_from_tool));
            let by = Twist { linear: by.0, angular: by.1 };
            let moved = mapping.update(&state(displaced(&b, &by, &[0.0; 3]).unwrap(), 0)).unwrap();
            let found = displacement(&before.world_from_tool, &moved.world_from_tool, &[0.0; 3]);
            let expected = Twist {
                linear: scaled(&times(base.rotation(), &by.linear), scale),
                angular: times(base.rotation(), &by.angular),
            };
            prop_assert!((found - expected).reach(1.0) < 1e-11, "{found:?} {expected:?}");
        }

        /// Always within the device's limits; zero for freedoms without a motor.
        #[test]
        fn never_above_the_bound(
            force in vector(100.0), torque in vector(10.0), place in vector(0.2), scale in 0.01..20.0f64,
        ) {
            for options in [SimulatedOptions::desktop_3dof(), SimulatedOptions::desktop_6dof()] {
                let limits = options.info.limits;
                let mut mapping = Mapping::new(&options.info, scale, &Pose::IDENTITY, None, [0.0; 3]).unwrap();
                mapping.update(&state(pose([0.0; 3], place), 0)).unwrap();
                let found = mapping.wrench_on_hand(&Wrench { force, torque });
                prop_assert!(length(&found.force) <= limits.force_n * (1.0 + 1e-12));
                prop_assert!(length(&found.torque) <= limits.torque_nm * (1.0 + 1e-12));
            }
            let mut mapping = Mapping::new(Mouse::new(Pose::IDENTITY).info(), scale, &Pose::IDENTITY, None, [0.0; 3]).unwrap();
            mapping.update(&state(pose([0.0; 3], place), 0)).unwrap();
            prop_assert_eq!(mapping.wrench_on_hand(&Wrench { force, torque }), Wrench::ZERO);
        }
    }

    #[test]
    fn buttons_have_edges() {
        let mut mapping = Mapping::new(&info(), 1.0, &Pose::IDENTITY, None, [0.0; 3]).unwrap();
        let mut edges = |buttons| {
            let mapped = mapping.update(&state(Pose::IDENTITY, buttons)).unwrap();
            (mapped.held, mapped.pressed, mapped.released)
        };
        assert_eq!(edges(0b01), (0b01, 0b01, 0));
        assert_eq!(edges(0b01), (0b01, 0, 0));
        assert_eq!(edges(0b10), (0b10, 0b10, 0b01));
        assert_eq!(edges(0), (0, 0, 0b10));
    }

    #[test]
    fn a_soft_wall_pushes_back_before_the_border() {
        // 80 mm half the edge along x, so from 72 mm on.
        let mut mapping =
            Mapping::new(&info(), 3.0, &pose([0.0, 0.0, 1.0], [5.0, 0.0, 0.0]), Some(0), [0.0; 3]).unwrap();
        let mut wall = |place: Point, buttons| {
            mapping.update(&state(pose([0.0; 3], place), buttons)).unwrap();
            mapping.wrench_on_hand(&Wrench::ZERO)
        };
        for inside in [[0.0; 3], [0.0719, -0.0539, 0.0539]] {
            assert_eq!(wall(inside, 0), Wrench::ZERO, "{inside:?}");
        }
        let (a, b) = (wall([0.074, 0.0, 0.0], 0), wall([0.078, 0.0, 0.0], 0));
        assert!(a.force[0] < 0.0 && (b.force[0] - 3.0 * a.force[0]).abs() < 1e-12, "{a:?} {b:?}");
        assert_eq!((b.force[1], b.force[2], b.torque), (0.0, 0.0, [0.0; 3]));
        // Within Colgate's bound beside the coupling, which takes 0.8 of it.
        let limits = info().limits;
        assert!(-b.force[0] / 0.006 <= 0.2 * limits.damping_n_s_per_m / limits.hold_s(1000.0));
        assert!(wall([-0.078, 0.0, 0.0], 0).force[0] > 0.0 && wall([0.0, 0.0, -0.059], 0).force[2] > 0.0);
        // Also while the hand re-indexes; far outside it is bounded.
        assert_eq!(wall([0.078, 0.0, 0.0], 1), b);
        assert!((length(&wall([9.0, 0.0, 0.0], 0).force) - 0.5 * limits.force_n).abs() < 1e-12);
    }

    /// Motions five times as large are five times as stiff at the hand, which may not be more than it holds.
    #[test]
    fn a_scale_takes_stiffness_away() {
        let limited = |scale: f64| {
            let mapping = Mapping::new(&info(), scale, &Pose::IDENTITY, None, [0.0; 3]).unwrap();
            let wanted = Coupling::default()
                .with_stiffness_n_per_m(1e6)
                .with_rotational_stiffness_nm_per_rad(1e6)
                .with_max_torque_nm(100.0)
                .with_damping_n_s_per_m(0.0)
                .with_rotational_damping_nm_s_per_rad(0.0);
            wanted.limited(&mapping.info_in_world(), 1000.0).0
        };
        let plain = limited(1.0);
        for scale in [0.2, 5.0] {
            let found = limited(scale);
            // Stiffness at the hand: force over the hand's way, and torque over the scale.
            assert!((found.stiffness_n_per_m * scale / plain.stiffness_n_per_m - 1.0).abs() < 1e-9);
            let at_hand = found.rotational_stiffness_nm_per_rad / scale;
            assert!((at_hand / plain.rotational_stiffness_nm_per_rad - 1.0).abs() < 1e-9);
            assert!((found.max_torque_nm / scale - info().limits.torque_nm).abs() < 1e-12);
        }
    }

    #[test]
    fn what_cannot_be_a_mapping_is_refused() {
        for scale in [0.0, -1.0, 1e6, f64::NAN] {
            assert!(Mapping::new(&info(), scale, &Pose::IDENTITY, None, [0.0; 3]).is_err(), "{scale}");
        }
        for (button, is_good) in [(0, true), (1, true), (2, false), (40, false)] {
            assert_eq!(
                Mapping::new(&info(), 1.0, &Pose::IDENTITY, Some(button), [0.0; 3]).is_ok(),
                is_good,
                "{button}"
            );
        }
        let mapping = Mapping::new(&info(), 1.0, &Pose::IDENTITY, None, [0.0; 3]).unwrap();
        assert_eq!(mapping.wrench_on_hand(&push(f64::NAN)), Wrench::ZERO);
        assert_eq!(mapping.wrench_on_hand(&push(f64::INFINITY)), Wrench::ZERO);
    }
}
