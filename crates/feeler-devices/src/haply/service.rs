//! The connection to the Inverse Service, and the thread that owns it.

use std::io::ErrorKind;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Instant;

use feeler_core::geometry::twist;
use feeler_core::Point;
use feeler_haptics::device::{DeviceError, DeviceInfo};
use tungstenite::client::client_with_config;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

use super::messages::{Commands, State, GRIP_BUTTONS};
use super::options::HaplyOptions;
use super::pace::{Pace, Turn};
use crate::clip::{told_pose, told_twist};
use crate::constants::{
    CONNECT_WAIT, FULL_STATE_PAUSE, INVERSE3_NAME, LARGEST_MESSAGE_BYTES, PRESET_WAIT, SEND_WAIT, SERVICE_WAIT,
};
use crate::exchange::{exchange, DeviceEnd, Measured, ServoEnd};
use crate::figures::{Figures, Said, INVERSE3, MINVERSE};
use crate::machine::raise_priority;
use crate::numbers::check;

fn not_found(why: String) -> DeviceError {
    DeviceError::NotFound { device: INVERSE3_NAME.to_string(), why }
}

/// Connects, asks who is there, and starts the thread.
pub(super) fn start(options: &HaplyOptions) -> Result<ServoEnd, DeviceError> {
    check([("force_n", options.force_n), ("stiffness_n_per_m", options.stiffness_n_per_m)])?;
    let mut socket = connect(&options.address)?;
    let first = first_state(&mut socket)?;
    let Some(device) = first.device(options.device_id.as_deref()) else {
        let which = options.device_id.as_ref().map_or("no Inverse3".to_string(), |id| format!("no Inverse3 {id}"));
        let known = first.device_ids();
        return Err(not_found(format!(
            "the Inverse Service at {} knows {which} (it knows: {}): connect and switch it on",
            options.address,
            if known.is_empty() { "none" } else { &known }
        )));
    };
    let has_grip = first.grip(options.grip_id.as_deref()).is_some_and(|held| held.quaternion.is_some());
    let id = device.device_id.clone();
    let (servo, end) = exchange(info(options, &id, device.is_minverse(), has_grip));
    let mut service = Service {
        socket,
        end,
        options: options.clone(),
        id,
        has_grip,
        rotation: [1.0, 0.0, 0.0, 0.0],
        buttons: 0,
        pace: Pace::new(Instant::now()),
    };
    std::thread::Builder::new()
        .name("feeler-haply".to_string())
        .spawn(move || {
            // A thread without priority works too, with more jitter.
            let _ = raise_priority();
            if let Err(error) = service.run() {
                service.end.tell(Err(error));
            }
        })
        .map_err(|error| not_found(format!("no thread for the connection: {error}")))?;
    Ok(servo)
}

fn info(options: &HaplyOptions, id: &str, is_minverse: bool, has_grip: bool) -> DeviceInfo {
    let figures = if is_minverse { MINVERSE } else { INVERSE3 };
    // A user may ask for the maker's peak, although it cannot be held.
    let force_n = options.force_n.map_or(figures.force_n, |force| force.min(2.0 * figures.force_n));
    let said = Said { stiffness_n_per_m: options.stiffness_n_per_m, ..Said::default() };
    let info = Figures { force_n, ..figures }.info(format!("{INVERSE3_NAME} {id}"), has_grip, false, &said);
    info.with_buttons(if has_grip { GRIP_BUTTONS } else { 0 })
}

fn connect(address: &str) -> Result<WebSocket<TcpStream>, DeviceError> {
    let what_to_do = "install and start Haply's Inverse Service 3.5 or later, or give its address";
    let nobody = |why: &dyn std::fmt::Display| {
        not_found(format!("no Inverse Service answers at {address} ({why}): {what_to_do}"))
    };
    let mut last: Box<dyn std::fmt::Display> = Box::new("the address has no port, or no such host is known");
    // A name may have several addresses: the service often listens at one of 127.0.0.1 and ::1 only.
    for socket in address.to_socket_addrs().map_err(|error| nobody(&error))? {
        match TcpStream::connect_timeout(&socket, CONNECT_WAIT) {
            Ok(stream) => return handshake(stream, address).map_err(|error| nobody(&error)),
            Err(error) => last = Box::new(error),
        }
    }
    Err(nobody(&last))
}

fn handshake(stream: TcpStream, address: &str) -> Result<WebSocket<TcpStream>, String> {
    let timed = |stream: &TcpStream, read| {
        stream.set_read_timeout(Some(read))?;
        stream.set_write_timeout(Some(SEND_WAIT))?;
        stream.set_nodelay(true)
    };
    timed(&stream, CONNECT_WAIT).map_err(|error| error.to_string())?;
    let config = WebSocketConfig::default()
        .max_message_size(Some(LARGEST_MESSAGE_BYTES))
        .max_frame_size(Some(LARGEST_MESSAGE_BYTES))
        .write_buffer_size(0);
    let (socket, _) =
        client_with_config(format!("ws://{address}/"), stream, Some(config)).map_err(|error| error.to_string())?;
    timed(socket.get_ref(), SERVICE_WAIT).map_err(|error| error.to_string())?;
    Ok(socket)
}

/// The state that the service tells as soon as it is connected to.
fn first_state(socket: &mut WebSocket<TcpStream>) -> Result<State, DeviceError> {
    let started = Instant::now();
    while started.elapsed() < CONNECT_WAIT {
        match receive(socket)? {
            Received::State(state) => return Ok(*state),
            Received::Nonsense(what) => return Err(DeviceError::Nonsense { device: INVERSE3_NAME.to_string(), what }),
            Received::Nothing => {}
        }
    }
    Err(not_found("the service tells no state: it needs to be the Inverse Service 3.5 or later".to_string()))
}

enum Received {
    State(Box<State>),
    /// A message that cannot be; the connection lives.
    Nonsense(String),
    Nothing,
}

/// Waits for a message, at most [`SERVICE_WAIT`]. Errors when the connection is broken.
fn receive(socket: &mut WebSocket<TcpStream>) -> Result<Received, DeviceError> {
    let lost = |why: String| DeviceError::Lost { device: INVERSE3_NAME.to_string(), why };
    let nonsense = |what: String| DeviceError::Nonsense { device: INVERSE3_NAME.to_string(), what };
    match socket.read() {
        Ok(Message::Text(text)) => Ok(match serde_json::from_str(&text) {
            Ok(state) => Received::State(Box::new(state)),
            Err(error) => Received::Nonsense(format!("a message that is no state ({error})")),
        }),
        Ok(Message::Binary(_)) => Ok(Received::Nonsense("a binary message".to_string())),
        Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)) => Ok(Received::Nothing),
        Ok(Message::Close(_)) | Err(Error::ConnectionClosed | Error::AlreadyClosed) => {
            Err(lost("the service closed the connection; open the device again".to_string()))
        }
        Err(Error::Io(error))
            if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted) =>
        {
            Ok(Received::Nothing)
        }
        Err(Error::Io(error)) => Err(lost(error.to_string())),
        Err(error) => Err(nonsense(error.to_string())),
    }
}

struct Service {
    socket: WebSocket<TcpStream>,
    end: DeviceEnd,
    options: HaplyOptions,
    id: String,
    has_grip: bool,
    /// The grip's last rotation (w, x, y, z), and its buttons.
    rotation: [f64; 4],
    buttons: u32,
    pace: Pace,
}

impl Service {
    /// Talks until released, or until the connection breaks.
    fn run(&mut self) -> Result<(), DeviceError> {
        self.send(&Commands::force(&self.id.clone(), &[0.0; 3]).introducing(&self.options.clone()))?;
        self.pace.sent(false, Instant::now());
        self.settle()?;
        while !self.end.is_released() {
            match self.receive() {
                Ok(Received::State(state)) => {
                    let measured = self.measured(&state);
                    match measured {
                        Ok(None) => {}
                        Ok(Some(measured)) => self.end.tell(Ok(measured)),
                        Err(error) => self.end.tell(Err(error)),
                    }
                }
                Ok(Received::Nonsense(what)) => {
                    self.end.tell(Err(DeviceError::Nonsense { device: self.end.name().to_string(), what }));
                }
                Ok(Received::Nothing) => {}
                Err(error) => {
                    // What is broken may still take a last word; whether it does cannot be known.
                    let _ = self.send_force(&[0.0; 3]);
                    return Err(error);
                }
            }
            let now = Instant::now();
            let force = self.end.wrench(now).force;
            match self.pace.turn(force != [0.0; 3], now) {
                Turn::Force => self.send_force(&force)?,
                Turn::Nothing => self.send_force(&[0.0; 3])?,
                Turn::Wait => {}
            }
        }
        self.send_force(&[0.0; 3])?;
        // The force is off; that the goodbye arrives as well does not matter.
        let _ = self.socket.close(None);
        let _ = self.socket.flush();
        Ok(())
    }

    /// Waits until the service says that it took the preset: positions before that have another origin. Without its word for
    /// [`PRESET_WAIT`] they are taken all the same.
    fn settle(&mut self) -> Result<(), DeviceError> {
        let started = Instant::now();
        let mut asked = started;
        while self.options.preset.is_some() && started.elapsed() < PRESET_WAIT && !self.end.is_released() {
            if let Received::State(state) = self.receive()? {
                if state.device(Some(&self.id)).and_then(|device| device.preset()) == self.options.preset.as_deref() {
                    break;
                }
            }
            if self.pace.turn(false, Instant::now()) == Turn::Wait {
                continue;
            }
            let id = self.id.clone();
            let commands = Commands::force(&id, &[0.0; 3]);
            if asked.elapsed() > FULL_STATE_PAUSE {
                asked = Instant::now();
                self.send(&commands.asking_for_all())?;
            } else {
                self.send(&commands)?;
            }
            self.pace.sent(false, Instant::now());
        }
        Ok(())
    }

    /// The device's entry in a state; `None` without one.
    fn measured(&mut self, state: &State) -> Result<Option<Measured>, DeviceError> {
        let Some(device) = state.device(Some(&self.id)) else { return Ok(None) };
        let Some(position) = device.position() else { return Ok(None) };
        let name = self.end.name();
        if device.is_uncalibrated() {
            return Err(DeviceError::Nonsense {
                device: name.to_string(),
                what: "positions, for it is not calibrated: put the arm into its rest and wait for its light"
                    .to_string(),
            });
        }
        if let Some(held) = state.grip(self.options.grip_id.as_deref()).filter(|_| self.has_grip) {
            self.buttons = held.buttons;
            if let Some(quaternion) = held.quaternion {
                let norm = quaternion.iter().map(|part| part * part).sum::<f64>().sqrt();
                if !(0.9..=1.1).contains(&norm) {
                    let what = format!("a rotation of {quaternion:?}, which is no unit quaternion");
                    return Err(DeviceError::Nonsense { device: name.to_string(), what });
                }
                self.rotation = quaternion;
            }
        }
        let pose = told_pose(name, &twist::rotation_of_quaternion(&self.rotation), &position)?;
        // A grip tells no rate of turning, so with one the whole velocity is left to be found from the poses.
        let twist = device.velocity().filter(|_| !self.has_grip).map(|twist| told_twist(name, twist)).transpose()?;
        Ok(Some(Measured { pose, twist, buttons: self.buttons, at: Instant::now() }))
    }

    /// Waits for a message, as [`receive`], and notes that the service spoke.
    fn receive(&mut self) -> Result<Received, DeviceError> {
        let received = receive(&mut self.socket)?;
        if !matches!(received, Received::Nothing) {
            self.pace.heard(Instant::now());
        }
        Ok(received)
    }

    fn send_force(&mut self, force: &Point) -> Result<(), DeviceError> {
        let id = self.id.clone();
        self.send(&Commands::force(&id, force))?;
        self.pace.sent(*force != [0.0; 3], Instant::now());
        Ok(())
    }

    fn send(&mut self, commands: &Commands) -> Result<(), DeviceError> {
        let json = commands.json().map_err(|error| self.end.lost(error))?;
        self.socket
            .send(Message::text(json))
            .map_err(|error| self.end.lost(format!("it does not take commands ({error})")))
    }
}
