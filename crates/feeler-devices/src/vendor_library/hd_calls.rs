//! 3D Systems' OpenHaptics HD API (`libHD`, headers `HD/hdDevice.h`, `hdScheduler.h`, `hdDefines.h`, version 3):
//! millimetres, newtons; x to the right, y up, z towards the user. Errors accumulate until they are read.

use std::ffi::{c_char, c_int, c_uint, c_ulong, c_ushort, c_void, CString};
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::path::Path;
use std::sync::Arc;

use feeler_core::Point;
use feeler_haptics::device::DeviceError;

use super::{functions, text, Wanted};

const LIBHD: Wanted = Wanted {
    device: "3D Systems OpenHaptics",
    names: if cfg!(windows) {
        &["hd.dll"]
    } else if cfg!(target_os = "macos") {
        &["libHD.dylib"]
    } else {
        &["libHD.so", "libHD.so.3.5", "libHD.so.3.4", "libHD.so.3"]
    },
    what_to_do: "install OpenHaptics 3 and the device's driver where the system finds their libraries, or name the file in the option \
                 `library`",
};

// The names and numbers of hdDefines.h.
const HD_SUCCESS: c_uint = 0;
const HD_INVALID_HANDLE: c_uint = 0xffff_ffff;
const HD_FORCE_OUTPUT: c_uint = 0x4000;
const HD_MAX_FORCE_CLAMPING: c_uint = 0x4001;
const HD_CURRENT_FORCE: c_uint = 0x2700;
const HD_CURRENT_BUTTONS: c_uint = 0x2000;
const HD_CALIBRATION_STYLE: c_uint = 0x2555;
const HD_CALIBRATION_OK: c_uint = 0x5000;
const HD_CALIBRATION_NEEDS_UPDATE: c_uint = 0x5001;
const HD_DEVICE_MODEL_TYPE: c_uint = 0x2501;
const HD_DEVICE_VENDOR: c_uint = 0x2503;
const HD_UPDATE_RATE: c_uint = 0x2600;
const HD_CALLBACK_DONE: c_uint = 0;
const HD_CALLBACK_CONTINUE: c_uint = 1;
/// `HD_MAX_SCHEDULER_PRIORITY`: the force is set last in each round of the scheduler.
const LAST_WORD: c_ushort = c_ushort::MAX;
/// Errors that are taken from the pile at once: more than a round makes, and a bound where the pile never ends.
const MOST_ERRORS: usize = 64;

/// Numbers that can be asked for; no parameter has more than 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum HdDoubles {
    /// Three, millimetres a second.
    Velocity = 0x2051,
    /// Sixteen, column by column, millimetres.
    Transform = 0x2052,
    /// Three, radians a second.
    AngularVelocity = 0x2053,
    /// Six, millimetres: the lower corner, the upper corner.
    Workspace = 0x2551,
    /// One, newtons a millimetre.
    Stiffness = 0x2602,
    /// One, newtons.
    MostForce = 0x2603,
}

/// `HDErrorInfo`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
struct ErrorInfo {
    code: c_uint,
    _internal: c_int,
    _device: c_uint,
}

type Callback = unsafe extern "system" fn(*mut c_void) -> c_uint;

functions! {
    Calls {
        hdInitDevice(*const c_char) -> c_uint;
        hdDisableDevice(c_uint);
        hdMakeCurrentDevice(c_uint);
        hdBeginFrame(c_uint);
        hdEndFrame(c_uint);
        hdEnable(c_uint);
        hdDisable(c_uint);
        hdGetDoublev(c_uint, *mut f64);
        hdSetDoublev(c_uint, *const f64);
        hdGetIntegerv(c_uint, *mut c_int);
        hdGetString(c_uint) -> *const c_char;
        hdGetError() -> ErrorInfo;
        hdGetErrorString(c_uint) -> *const c_char;
        hdCheckCalibration() -> c_uint;
        hdUpdateCalibration(c_uint);
        hdStartScheduler();
        hdStopScheduler();
        hdScheduleAsynchronous(Callback, *mut c_void, c_ushort) -> c_ulong;
        hdUnschedule(c_ulong);
    }
}

/// One device that is initialised. Disabled when dropped.
pub(crate) struct OpenHd {
    calls: Calls,
    device: c_uint,
}

impl OpenHd {
    /// Loads the library and initialises a device by the name of its configuration; `None`: the default one.
    pub fn open(library: Option<&Path>, name: Option<&str>) -> Result<OpenHd, DeviceError> {
        let not_found = |why: String| DeviceError::NotFound { device: LIBHD.device.to_string(), why };
        let calls = Calls::of(&LIBHD.load(library)?)?;
        let name = name
            .map(CString::new)
            .transpose()
            .map_err(|_| not_found("a name of a device has no zero in it".to_string()))?;
        // SAFETY: the name ends with a zero, or is null for the default device.
        let device = unsafe { (calls.hdInitDevice)(name.as_ref().map_or(std::ptr::null(), |name| name.as_ptr())) };
        let open = OpenHd { calls, device };
        let error = open.newest_error();
        if device == HD_INVALID_HANDLE || error.is_some() {
            let why = error.unwrap_or_else(|| "the library does not say why".to_string());
            if device == HD_INVALID_HANDLE {
                // Nothing is initialised, so nothing is to be disabled.
                std::mem::forget(open);
            }
            return Err(not_found(format!(
                "no device opened: {why}; connect it, switch it on, and set it up with the maker's Touch Setup"
            )));
        }
        // SAFETY: the device is initialised.
        unsafe {
            (open.calls.hdMakeCurrentDevice)(device);
            (open.calls.hdEnable)(HD_FORCE_OUTPUT);
            (open.calls.hdEnable)(HD_MAX_FORCE_CLAMPING);
        }
        Ok(open)
    }

    /// Maker and model.
    pub fn name(&self) -> String {
        // SAFETY: the device is initialised; the texts are the library's own.
        let [maker, model] =
            [HD_DEVICE_VENDOR, HD_DEVICE_MODEL_TYPE].map(|what| unsafe { text((self.calls.hdGetString)(what)) });
        format!("{maker} {model}").trim().to_string()
    }

    /// Rate of the scheduler, hertz; not above 0 if the device does not report it.
    pub fn rate_hz(&self) -> i32 {
        self.integer(HD_UPDATE_RATE)
    }

    pub fn doubles(&self, what: HdDoubles) -> [f64; 16] {
        let mut numbers = [0.0; 16];
        // SAFETY: the device is initialised, and no parameter of `HdDoubles` has more than 16 numbers.
        unsafe { (self.calls.hdGetDoublev)(what as c_uint, numbers.as_mut_ptr()) };
        numbers
    }

    /// A bit each.
    pub fn buttons(&self) -> u32 {
        self.integer(HD_CURRENT_BUTTONS) as u32
    }

    fn integer(&self, what: c_uint) -> c_int {
        let mut number = 0;
        // SAFETY: the device is initialised, and the parameters that this is called with have one number.
        unsafe { (self.calls.hdGetIntegerv)(what, &mut number) };
        number
    }

    /// Begins a round: all values in it belong to one moment.
    pub fn begin_frame(&self) {
        // SAFETY: the device is initialised.
        unsafe { (self.calls.hdBeginFrame)(self.device) };
    }

    /// Ends a round: its outputs take effect.
    pub fn end_frame(&self) {
        // SAFETY: the device is initialised.
        unsafe { (self.calls.hdEndFrame)(self.device) };
    }

    /// The force on the hand, newtons, the library's axes. In a frame.
    pub fn set_force(&self, force: &Point) {
        // SAFETY: the device is initialised, and the parameter has three numbers.
        unsafe { (self.calls.hdSetDoublev)(HD_CURRENT_FORCE, force.as_ptr()) };
    }

    /// Whether the device knows where it is; calibrates it where that needs no hand. In a frame.
    pub fn is_calibrated(&self) -> bool {
        // SAFETY: the device is initialised.
        match unsafe { (self.calls.hdCheckCalibration)() } {
            HD_CALIBRATION_OK => true,
            HD_CALIBRATION_NEEDS_UPDATE => {
                let style = self.integer(HD_CALIBRATION_STYLE);
                // SAFETY: the device is initialised, and the style is one that it has.
                unsafe { (self.calls.hdUpdateCalibration)(style as c_uint) };
                false
            }
            _ => false,
        }
    }

    /// The newest error, and the pile is empty.
    pub fn newest_error(&self) -> Option<String> {
        let mut newest = None;
        for _ in 0..MOST_ERRORS {
            // SAFETY: takes nothing.
            let error = unsafe { (self.calls.hdGetError)() };
            if error.code == HD_SUCCESS {
                break;
            }
            // SAFETY: the text is the library's own.
            let said = || unsafe { text((self.calls.hdGetErrorString)(error.code)) };
            newest.get_or_insert_with(|| format!("{} (error {:#06x})", said(), error.code));
        }
        newest
    }
}

impl Drop for OpenHd {
    fn drop(&mut self) {
        // SAFETY: the device is initialised, and nothing calls after this.
        unsafe {
            (self.calls.hdMakeCurrentDevice)(self.device);
            (self.calls.hdDisable)(HD_FORCE_OUTPUT);
            (self.calls.hdDisableDevice)(self.device);
        }
    }
}

/// The scheduler's callback, called as long as it returns true.
type Job = Box<dyn FnMut() -> bool + Send>;

/// A job in the library's scheduler, whose thread it starts.
pub(crate) struct Scheduled {
    open: Arc<OpenHd>,
    handle: c_ulong,
}

impl Scheduled {
    pub fn start(open: Arc<OpenHd>, job: Job) -> Scheduled {
        let job: *mut Job = Box::into_raw(Box::new(job));
        // SAFETY: the job belongs to the scheduler from here on; `run_job` frees it at its end.
        let handle = unsafe { (open.calls.hdScheduleAsynchronous)(run_job, job.cast(), LAST_WORD) };
        // SAFETY: takes nothing.
        unsafe { (open.calls.hdStartScheduler)() };
        Scheduled { open, handle }
    }

    /// Stops the scheduler's thread. `has_ended`: the job gave false, so the scheduler knows it no more; otherwise it is taken from the
    /// scheduler, and since it may be running still, its memory is left to it.
    pub fn stop(self, has_ended: bool) {
        // SAFETY: the device is initialised, and the handle is of this scheduler.
        unsafe {
            if !has_ended {
                (self.open.calls.hdUnschedule)(self.handle);
            }
            (self.open.calls.hdStopScheduler)();
        }
    }
}

/// One round of a job, and the end of it when it gives false. A panic must not go through the library: it ends the job as well.
///
/// # Safety
///
/// The pointer is to a [`Job`] made by [`Box::into_raw`] that nothing else uses, and it is not passed again after `HD_CALLBACK_DONE`.
unsafe extern "system" fn run_job(job: *mut c_void) -> c_uint {
    let job = job.cast::<Job>();
    // SAFETY: by the caller's promise.
    let goes_on = catch_unwind(AssertUnwindSafe(|| unsafe { (*job)() })).unwrap_or(false);
    if goes_on {
        return HD_CALLBACK_CONTINUE;
    }
    // SAFETY: by the caller's promise, this is the last that is done with it.
    let dropped = catch_unwind(AssertUnwindSafe(|| drop(unsafe { Box::from_raw(job) })));
    debug_assert!(dropped.is_ok());
    HD_CALLBACK_DONE
}
