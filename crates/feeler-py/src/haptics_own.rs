//! A device written in Python: the servo thread enters the interpreter only for such a device.

use feeler_core::Pose;
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::Wrench;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arguments::PoseArgument;

/// An object of `feeler.haptics.devices.Own`.
pub struct OwnDevice {
    object: Py<PyAny>,
    info: DeviceInfo,
    /// Its last pose, its buttons then, and when.
    last: Option<(Pose, u32, f64)>,
}

impl OwnDevice {
    pub fn new(object: Py<PyAny>, info: DeviceInfo) -> OwnDevice {
        OwnDevice { object, info, last: None }
    }

    /// Calls Python. What it raises ends the run, as does a pose of another shape; an interpreter that ends answers nothing.
    fn call<T>(&self, work: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>) -> Result<T, DeviceError> {
        let device = || self.info.name.clone();
        match Python::try_attach(|py| work(self.object.bind(py)).map_err(|error| error.to_string())) {
            Some(Ok(value)) => Ok(value),
            Some(Err(why)) => Err(DeviceError::Broken { device: device(), why }),
            None => Err(DeviceError::Lost { device: device(), why: "the interpreter ends".into() }),
        }
    }
}

impl Device for OwnDevice {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        let told = self.call(|object| {
            let told: Option<(Bound<'_, PyAny>, u32)> = object.call_method0("_read")?.extract()?;
            let Some((place, buttons)) = told else { return Ok(None) };
            let is_pose = || place.getattr("shape")?.extract::<(usize, usize)>();
            match place.extract() {
                Ok(PoseArgument(pose)) => Ok(Some(Ok((pose, buttons)))),
                Err(error) if is_pose().is_ok_and(|shape| shape == (4, 4)) => Ok(Some(Err(error.to_string()))),
                Err(error) => Err(error),
            }
        })?;
        if let Some(told) = told {
            let nonsense = |what| DeviceError::Nonsense { device: self.info.name.clone(), what };
            let (pose, buttons) = told.map_err(nonsense)?;
            self.last = Some((pose, buttons, now));
        }
        match self.last {
            Some((pose, buttons, time)) => Ok(DeviceState::new(pose, time).with_buttons(buttons)),
            None => Err(DeviceError::Lost { device: self.info.name.clone(), why: "it has told no pose yet".into() }),
        }
    }

    fn write(&mut self, wrench: &Wrench, _now: f64) -> Result<(), DeviceError> {
        self.call(|object| {
            let array = |vector| PyArray1::from_slice(object.py(), vector);
            object.call_method1("write", (array(&wrench.force), array(&wrench.torque))).map(|_| ())
        })
    }

    /// What it raises is told as Python tells what nobody catches.
    fn release(&mut self) {
        let _ = self.call(|object| {
            if let Err(error) = object.call_method0("release") {
                error.write_unraisable(object.py(), Some(object));
            }
            Ok(())
        });
    }
}
