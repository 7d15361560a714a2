//! `feeler._core.HapticsDevice`, the base of the classes of `feeler.haptics.devices`.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use feeler_devices::{option_range, Options};
use feeler_haptics::device::faulty::{Fault, Faulty};
use feeler_haptics::device::hand::{Hand, HandPath};
use feeler_haptics::device::mouse::Mouse;
use feeler_haptics::device::simulated::{SimulatedDevice, SimulatedOptions};
use feeler_haptics::device::steered::{steered, Steering};
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceLimits, Freedoms};
use feeler_haptics::Coupling;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use crate::arguments::{PoseArgument, PosesArgument};
use crate::errors::raise;
use crate::haptics::{haptics_to_py, numbers_of};
use crate::haptics_own::OwnDevice;
use crate::travel::stays;

/// A device, until a run takes it; the base of the classes of `feeler.haptics.devices`.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct HapticsDevice {
    info: DeviceInfo,
    device: Mutex<Option<Box<dyn Device>>>,
    steering: Option<Mutex<Steering>>,
    /// A driver that was released talks to its device no more.
    is_for_once: bool,
}

/// The Python exception for a device that does not answer.
pub fn device_to_py(error: DeviceError) -> PyErr {
    let class = if matches!(error, DeviceError::Option { .. }) { "OptionError" } else { "DeviceError" };
    raise(class, error.to_string())
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl HapticsDevice {
    fn new(device: Box<dyn Device>, steering: Option<Steering>, is_for_once: bool) -> HapticsDevice {
        let info = device.info().clone();
        HapticsDevice { info, device: Mutex::new(Some(device)), steering: steering.map(Mutex::new), is_for_once }
    }

    /// The device, for a run.
    pub fn take(&self) -> PyResult<Box<dyn Device>> {
        locked(&self.device).take().ok_or_else(|| {
            let what = match self.is_for_once {
                true => "was used in a run, which lets go of it for good: open it again",
                false => "is in use by another run: stop that one first",
            };
            raise("DeviceError", format!("{} {what}", self.info.name))
        })
    }

    /// The device after a run; after one that did not begin, whatever it is.
    pub fn put_back(&self, device: Option<Box<dyn Device>>, was_run: bool) {
        if !(self.is_for_once && was_run) {
            *locked(&self.device) = device;
        }
    }
}

fn fault_of(kind: &str, value: f64) -> PyResult<Fault> {
    Ok(match kind {
        "nan" => Fault::NotANumber,
        "nonsense" => Fault::Nonsense,
        "lost" => Fault::Lost,
        "silent" => Fault::Silent,
        "jump" => Fault::Jump([0.0, 0.0, value]),
        "slow" => Fault::Slow(value),
        _ => {
            return Err(raise(
                "OptionError",
                format!("fault is {kind:?}: choose nan, nonsense, lost, silent, jump or slow"),
            ))
        }
    })
}

fn names_of(freedoms: Freedoms) -> Vec<&'static str> {
    let each = [(freedoms.translation, "translation"), (freedoms.rotation, "rotation")];
    each.into_iter().filter(|(is, _)| *is).map(|(_, name)| name).collect()
}

/// An option of a driver, where it is given.
fn option<'py, T>(options: &Bound<'py, PyDict>, name: &str, to: &mut T) -> PyResult<()>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let Some(value) = options.get_item(name)? else { return Ok(()) };
    options.del_item(name)?;
    let range = option_range(name);
    // Python's truths are numbers, and no lengths, forces or speeds.
    let is_truth = value.is_instance_of::<PyBool>();
    match value.extract() {
        Ok(value) if !(is_truth && range.is_some()) => *to = value,
        _ => {
            let what = format!("{name} is {}: give {}", value.repr()?, range.unwrap_or("a text"));
            return Err(raise("OptionError", what));
        }
    }
    Ok(())
}

/// Options of a driver out of Python's; errors for one that it does not have.
fn options_of(name: &str, given: &Bound<'_, PyDict>) -> PyResult<Options> {
    let mut options = Options::default();
    match name {
        "spacemouse" => {
            let to = &mut options.spacemouse;
            option(given, "socket", &mut to.socket)?;
            option(given, "speed_m_per_s", &mut to.speed_m_per_s)?;
            option(given, "turn_rad_per_s", &mut to.turn_rad_per_s)?;
            option(given, "full_deflection_counts", &mut to.full_deflection_counts)?;
            option(given, "dead_zone", &mut to.dead_zone)?;
            option(given, "reach_m", &mut to.reach_m)?;
            option(given, "silence_s", &mut to.silence_s)?;
        }
        "haply" => {
            let to = &mut options.haply;
            option(given, "address", &mut to.address)?;
            option(given, "device_id", &mut to.device_id)?;
            option(given, "grip_id", &mut to.grip_id)?;
            option(given, "preset", &mut to.preset)?;
            option(given, "force_n", &mut to.force_n)?;
            option(given, "stiffness_n_per_m", &mut to.stiffness_n_per_m)?;
        }
        "dhd" => {
            let to = &mut options.dhd;
            option::<Option<PathBuf>>(given, "library", &mut to.library)?;
            option(given, "force_n", &mut to.force_n)?;
            option(given, "torque_nm", &mut to.torque_nm)?;
            option(given, "stiffness_n_per_m", &mut to.stiffness_n_per_m)?;
        }
        "openhaptics" => {
            let to = &mut options.openhaptics;
            option::<Option<PathBuf>>(given, "library", &mut to.library)?;
            option(given, "device", &mut to.device)?;
            option(given, "force_n", &mut to.force_n)?;
            option(given, "stiffness_n_per_m", &mut to.stiffness_n_per_m)?;
        }
        // `open` says which names there are.
        _ => return Ok(options),
    }
    match given.keys().get_item(0) {
        Ok(other) => Err(raise("OptionError", format!("the device {name} has no option {other}"))),
        Err(_) => Ok(options),
    }
}

#[pymethods]
impl HapticsDevice {
    /// A simulated device in a hand that follows a path, or in none.
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "the Python class beside it has names and defaults for all")]
    fn simulated(
        preset: &str,
        times: Option<Vec<f64>>,
        poses: Option<PosesArgument>,
        grip: &str,
        delays: [f64; 3],
        seed: u64,
        fault: Option<(String, f64, f64, f64)>,
    ) -> PyResult<HapticsDevice> {
        let mut options = match preset {
            "desktop_3dof" => SimulatedOptions::desktop_3dof(),
            "desktop_6dof" => SimulatedOptions::desktop_6dof(),
            "large_6dof" => SimulatedOptions::large_6dof(),
            _ => {
                let what = format!("preset is {preset:?}: choose desktop_3dof, desktop_6dof or large_6dof");
                return Err(raise("OptionError", what));
            }
        };
        [options.pose_delay_s, options.force_delay_s, options.jitter_s] = delays;
        options.seed = seed;
        let hand = match (times, poses) {
            (Some(times), Some(poses)) => {
                if times.len() != poses.0.len() {
                    let what = format!("a hand has {} times and {} poses", times.len(), poses.0.len());
                    return Err(raise("OptionError", what));
                }
                let path = HandPath::new(times.into_iter().zip(poses.0).collect()).map_err(haptics_to_py)?;
                Some(match grip {
                    "firm" => Hand::firm(path),
                    "loose" => Hand::loose(path),
                    _ => return Err(raise("OptionError", format!("grip is {grip:?}: choose firm or loose"))),
                })
            }
            _ => None,
        };
        let device = SimulatedDevice::new(options, hand).map_err(haptics_to_py)?;
        let device: Box<dyn Device> = match fault {
            None => Box::new(device),
            Some((kind, value, from, until)) => {
                Box::new(Faulty::new(device, fault_of(&kind, value)?, from, until).map_err(haptics_to_py)?)
            }
        };
        Ok(HapticsDevice::new(device, None, false))
    }

    /// A device that goes where it is told to.
    #[staticmethod]
    fn mouse(pose: PoseArgument, frequency: f64) -> PyResult<HapticsDevice> {
        let mouse = Mouse::new(pose.0).with_frequency(frequency).map_err(haptics_to_py)?;
        let (device, steering) = steered(mouse, pose.0);
        Ok(HapticsDevice::new(Box::new(device), Some(steering), false))
    }

    /// A device by the name of its driver.
    #[staticmethod]
    fn open(py: Python<'_>, name: &str, options: &Bound<'_, PyDict>) -> PyResult<HapticsDevice> {
        let options = options_of(name, options)?;
        let device = py.detach(|| feeler_devices::open(name, &options)).map_err(device_to_py)?;
        Ok(HapticsDevice::new(device, None, true))
    }

    /// A device that is an object with `_read`, `write` and `release`. Drives what it has force or torque for.
    #[staticmethod]
    fn own(
        object: Py<PyAny>,
        name: String,
        senses_rotation: bool,
        workspace: [f64; 3],
        buttons: u32,
        limits: [f64; 12],
    ) -> PyResult<HapticsDevice> {
        let [force_n, torque_nm, stiffness_n_per_m, rotational_stiffness_nm_per_rad, damping_n_s_per_m, more @ ..] =
            limits;
        let [rotational_damping_nm_s_per_rad, friction_n, rotational_friction_nm, resolution_m, more @ ..] = more;
        let [rotational_resolution_rad, rate_hz, delay_s] = more;
        let limits = DeviceLimits::default()
            .with_force_n(force_n)
            .with_torque_nm(torque_nm)
            .with_stiffness_n_per_m(stiffness_n_per_m)
            .with_rotational_stiffness_nm_per_rad(rotational_stiffness_nm_per_rad)
            .with_damping_n_s_per_m(damping_n_s_per_m)
            .with_rotational_damping_nm_s_per_rad(rotational_damping_nm_s_per_rad)
            .with_friction_n(friction_n)
            .with_rotational_friction_nm(rotational_friction_nm)
            .with_resolution_m(resolution_m)
            .with_rotational_resolution_rad(rotational_resolution_rad)
            .with_rate_hz(rate_hz)
            .with_delay_s(delay_s);
        limits.check().map_err(haptics_to_py)?;
        let sensed = Freedoms { translation: true, rotation: senses_rotation };
        let driven = Freedoms { translation: force_n > 0.0, rotation: senses_rotation && torque_nm > 0.0 };
        let info = DeviceInfo::new(name)
            .with_sensed(sensed)
            .with_driven(driven)
            .with_workspace(workspace)
            .with_limits(limits)
            .with_buttons(buttons);
        Ok(HapticsDevice::new(Box::new(OwnDevice::new(object, info)), None, false))
    }

    /// Names of drivers, with what each is for.
    #[staticmethod]
    fn drivers() -> Vec<(&'static str, &'static str)> {
        feeler_devices::DRIVERS.to_vec()
    }

    /// Where to go from now on. Errors of a device that cannot be steered.
    fn set_target(&self, pose: PoseArgument) -> PyResult<()> {
        self.steer(|steering, pose| steering.set_target(pose), pose.0)
    }

    /// Which buttons are held from now on, a bit each.
    fn set_buttons(&self, buttons: u32) -> PyResult<()> {
        self.steer(Steering::set_buttons, buttons)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.info.name
    }

    #[getter]
    fn sensed(&self) -> Vec<&'static str> {
        names_of(self.info.sensed)
    }

    #[getter]
    fn driven(&self) -> Vec<&'static str> {
        names_of(self.info.driven)
    }

    /// Half the edges of the box that the handle can reach, metres.
    #[getter]
    fn workspace(&self) -> [f64; 3] {
        self.info.workspace
    }

    #[getter]
    fn button_count(&self) -> u32 {
        self.info.buttons
    }

    /// What it can do and hold, by name.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let limits = &self.info.limits;
        let dict = PyDict::new(py);
        for (name, value) in [
            ("force_n", limits.force_n),
            ("torque_nm", limits.torque_nm),
            ("stiffness_n_per_m", limits.stiffness_n_per_m),
            ("rotational_stiffness_nm_per_rad", limits.rotational_stiffness_nm_per_rad),
            ("damping_n_s_per_m", limits.damping_n_s_per_m),
            ("rotational_damping_nm_s_per_rad", limits.rotational_damping_nm_s_per_rad),
            ("friction_n", limits.friction_n),
            ("rotational_friction_nm", limits.rotational_friction_nm),
            ("resolution_m", limits.resolution_m),
            ("rotational_resolution_rad", limits.rotational_resolution_rad),
            ("rate_hz", limits.rate_hz),
            ("delay_s", limits.delay_s),
        ] {
            dict.set_item(name, value)?;
        }
        Ok(dict)
    }

    /// The stiffest coupling of use that it holds.
    fn coupling(&self) -> [f64; 8] {
        numbers_of(&Coupling::for_device(&self.info))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("HapticsDevice", "open it where it is used"))
    }
}

impl HapticsDevice {
    fn steer<T>(&self, how: impl FnOnce(&mut Steering, T), to: T) -> PyResult<()> {
        match &self.steering {
            Some(steering) => how(&mut locked(steering), to),
            None => return Err(raise("DeviceError", format!("{} is not steered by a program", self.info.name))),
        }
        Ok(())
    }
}
