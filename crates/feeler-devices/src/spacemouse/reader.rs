//! The thread that listens to the daemon, reconnects when it is gone, and keeps the cap's present state.

use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use feeler_haptics::device::DeviceError;
use triple_buffer::{triple_buffer, Input, Output};

use super::options::not_found;
use super::protocol::{hello, request, sensitivity_of_one, Message, Parser, NUMBER_OF_BUTTONS};
use crate::constants::{BUTTON_BITS, DAEMON_ANSWER_WAIT, LOOK_AGAIN, RECONNECT_PAUSE, SOCKET_WAIT, SPACEMOUSE};

pub(super) use super::protocol::Cap;

/// Not known yet.
const UNKNOWN: u32 = u32::MAX;

/// The state of the thread.
#[derive(Debug, Clone, Default)]
struct Kept {
    cap: Cap,
    /// When the cap last moved.
    at: Option<Instant>,
    fault: Option<DeviceError>,
}

/// The daemon's own description.
#[derive(Debug)]
struct Daemon {
    protocol: AtomicU32,
    buttons: AtomicU32,
}

/// The listening thread, seen from the servo.
pub(super) struct Reader {
    kept: Output<Kept>,
    daemon: Arc<Daemon>,
    is_stopped: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    silence: Duration,
}

impl Reader {
    /// Connects to a socket and listens. Errors if nothing answers there. Waits for the daemon's version, at most twice
    /// [`DAEMON_ANSWER_WAIT`].
    pub fn start(socket: PathBuf, silence_s: f64) -> Result<Reader, DeviceError> {
        let stream = connect(&socket).map_err(|error| {
            not_found(format!(
                "no daemon answers at {} ({error}): install spacenavd (package spacenavd), start it, or name its socket in \
                 SPNAV_SOCKET",
                socket.display()
            ))
        })?;
        let (input, kept) = triple_buffer(&Kept::default());
        let daemon = Arc::new(Daemon { protocol: AtomicU32::new(UNKNOWN), buttons: AtomicU32::new(UNKNOWN) });
        let is_stopped = Arc::new(AtomicBool::new(false));
        let mut listener = Listener {
            socket,
            kept: input,
            newest: Kept::default(),
            daemon: daemon.clone(),
            is_stopped: is_stopped.clone(),
        };
        let thread = std::thread::Builder::new()
            .name("feeler-spacemouse".to_string())
            .spawn(move || listener.run(stream))
            .map_err(|error| not_found(format!("no thread to listen with: {error}")))?;
        // An infinite time is as long as the machine runs.
        let silence = Duration::try_from_secs_f64(silence_s).unwrap_or(Duration::MAX);
        let reader = Reader { kept, daemon, is_stopped, thread: Some(thread), silence };
        let started = Instant::now();
        while reader.daemon.buttons.load(Ordering::Acquire) == UNKNOWN && started.elapsed() < 2 * DAEMON_ANSWER_WAIT {
            std::thread::sleep(LOOK_AGAIN);
        }
        Ok(reader)
    }

    /// The protocol that was agreed on, and the number of buttons; as many as fit where the daemon does not say.
    pub fn daemon(&self) -> (u8, u32) {
        let protocol = self.daemon.protocol.load(Ordering::Acquire);
        let buttons = self.daemon.buttons.load(Ordering::Acquire);
        (u8::try_from(protocol).unwrap_or(0), buttons.min(BUTTON_BITS))
    }

    /// The cap and the buttons at a time; at rest after a silence. Never waits.
    pub fn newest(&mut self, at: Instant) -> Result<Cap, DeviceError> {
        let kept = self.kept.read();
        if let Some(fault) = &kept.fault {
            return Err(fault.clone());
        }
        let is_silent = kept.at.is_none_or(|moved| at.saturating_duration_since(moved) > self.silence);
        Ok(if is_silent { Cap { counts: [0; 6], ..kept.cap } } else { kept.cap })
    }

    /// Ends the thread, which sees it within [`SOCKET_WAIT`].
    pub fn stop(&mut self) {
        self.is_stopped.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been printed; there is nothing to do about it here.
            let _ = thread.join();
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.stop();
    }
}

fn connect(socket: &Path) -> std::io::Result<UnixStream> {
    let stream = UnixStream::connect(socket)?;
    stream.set_read_timeout(Some(SOCKET_WAIT))?;
    stream.set_write_timeout(Some(SOCKET_WAIT))?;
    Ok(stream)
}

struct Listener {
    socket: PathBuf,
    kept: Input<Kept>,
    newest: Kept,
    daemon: Arc<Daemon>,
    is_stopped: Arc<AtomicBool>,
}

impl Listener {
    fn run(&mut self, first: UnixStream) {
        let mut stream = Some(first);
        while !self.is_stopped.load(Ordering::Acquire) {
            let fault = match stream.take().map_or_else(|| connect(&self.socket), Ok) {
                Ok(stream) => self.listen(stream),
                Err(error) => Some(self.lost(error)),
            };
            if let Some(fault) = fault {
                // The cap counts as at rest, and the buttons as not pressed, until the daemon is heard again.
                self.keep(Kept { fault: Some(fault), ..Kept::default() });
                self.pause();
            }
        }
    }

    /// Listens until the connection breaks, and says why; or until told to stop.
    fn listen(&mut self, mut stream: UnixStream) -> Option<DeviceError> {
        let mut parser = Parser::default();
        let mut protocol = None;
        let asked = Instant::now();
        if let Err(error) = stream.write_all(&hello()) {
            return Some(self.lost(error));
        }
        self.keep(Kept::default());
        let mut bytes = [0; 1024];
        while !self.is_stopped.load(Ordering::Acquire) {
            let read = match stream.read(&mut bytes) {
                Ok(0) => return Some(self.lost("spacenavd closed the connection")),
                Ok(read) => read,
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) =>
                {
                    0
                }
                Err(error) => return Some(self.lost(error)),
            };
            let mut answers = Ok(());
            let parsed = parser.push(&bytes[..read], |message| match message {
                Message::Protocol(version) => {
                    protocol = Some(version);
                    self.daemon.protocol.store(version.into(), Ordering::Release);
                    if version > 0 {
                        answers = stream.write_all(&request(NUMBER_OF_BUTTONS));
                    }
                }
                other => self.take(other),
            });
            if let Err(nonsense) = parsed {
                return Some(DeviceError::Nonsense { device: SPACEMOUSE.to_string(), what: nonsense.0 });
            }
            if protocol.is_none() && asked.elapsed() > DAEMON_ANSWER_WAIT {
                protocol = Some(0);
                self.daemon.protocol.store(0, Ordering::Release);
                answers = stream.write_all(&sensitivity_of_one());
            }
            if let Err(error) = answers {
                return Some(self.lost(error));
            }
        }
        None
    }

    fn take(&mut self, message: Message) {
        let mut next = self.newest.clone();
        match message {
            Message::Motion(counts) => {
                next.cap.counts = counts;
                next.at = Some(Instant::now());
            }
            Message::Button { number, is_pressed } => {
                // Buttons that do not fit the bits are left out.
                let bit = u32::try_from(number).ok().filter(|bit| *bit < BUTTON_BITS).map_or(0, |bit| 1 << bit);
                next.cap.buttons = if is_pressed { next.cap.buttons | bit } else { next.cap.buttons & !bit };
            }
            Message::Device { is_added: false } => next = Kept::default(),
            Message::Answer { request: NUMBER_OF_BUTTONS, data } => {
                let buttons = if data[6] == 0 { u32::try_from(data[0]).unwrap_or(BUTTON_BITS) } else { BUTTON_BITS };
                self.daemon.buttons.store(buttons.min(BUTTON_BITS), Ordering::Release);
                return;
            }
            Message::Device { .. } | Message::Answer { .. } | Message::Protocol(_) | Message::Other => return,
        }
        self.keep(next);
    }

    fn keep(&mut self, next: Kept) {
        self.newest = next.clone();
        self.kept.write(next);
    }

    fn pause(&self) {
        let started = Instant::now();
        while started.elapsed() < RECONNECT_PAUSE && !self.is_stopped.load(Ordering::Acquire) {
            std::thread::sleep(LOOK_AGAIN);
        }
    }

    fn lost(&self, why: impl ToString) -> DeviceError {
        DeviceError::Lost { device: SPACEMOUSE.to_string(), why: why.to_string() }
    }
}
