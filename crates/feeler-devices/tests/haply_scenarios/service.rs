//! A stand-in for the Inverse Service. The judge of the test checks each state that it sends and each command that it
//! receives.

use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use feeler_devices::haply::{Haply, HaplyOptions};
use serde_json::{json, Value};
use tungstenite::{Error, Message, WebSocket};

use super::super::judge;

/// The replies of the stand-in.
#[derive(Clone, PartialEq)]
pub enum Mood {
    Good,
    Silent,
    /// This text instead of a state.
    Says(String),
    Bytes,
    Closes,
    /// As good, 20 ms late.
    Slow,
}

pub struct Shared {
    pub mood: Mood,
    /// The full state. The stand-in decides which of it is sent, and where the arm is before the preset applies.
    pub data: Value,
    pub tells_preset: bool,
    /// Newtons, as they came.
    pub forces: Vec<[f64; 3]>,
    pub profile: Option<String>,
    pub preset: Option<String>,
    pub has_said_goodbye: bool,
    /// By a slow service: answers, and forces that came before the answer to the command before them.
    pub slow: usize,
    pub early: usize,
    has_preset: bool,
    /// The faults of received and sent messages.
    faults: Vec<String>,
    /// The numbers of checked messages: received, sent.
    judged: [usize; 2],
}

/// The stand-in; it serves one client after another until the test ends.
pub struct Service {
    address: String,
    shared: Arc<Mutex<Shared>>,
}

impl Service {
    pub fn start(data: Value) -> Service {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let shared = Arc::new(Mutex::new(Shared {
            mood: Mood::Good,
            data,
            tells_preset: true,
            forces: vec![],
            profile: None,
            preset: None,
            has_said_goodbye: false,
            slow: 0,
            early: 0,
            has_preset: false,
            faults: vec![],
            judged: [0; 2],
        }));
        let its = shared.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                serve(stream.unwrap(), &its);
            }
        });
        Service { address, shared }
    }

    pub fn shared(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap()
    }

    pub fn options(&self) -> HaplyOptions {
        HaplyOptions::default().with_address(self.address.clone())
    }

    pub fn open(&self) -> Haply {
        Haply::open(&self.options()).unwrap()
    }

    /// Moves the arm, metres.
    pub fn move_to(&self, [x, y, z]: [f64; 3]) {
        self.shared().data["inverse3"][0]["state"]["cursor_position"] = json!({"x": x, "y": y, "z": z});
    }

    pub fn last_force(&self) -> Option<[f64; 3]> {
        self.shared().forces.last().copied()
    }

    /// Whether messages were received and sent, and the judge found no fault.
    pub fn check(&self) {
        let shared = self.shared();
        assert!(shared.faults.is_empty(), "{:?}", shared.faults);
        assert!(shared.judged.iter().all(|count| *count > 0), "{:?} messages judged", shared.judged);
    }
}

fn serve(stream: TcpStream, shared: &Mutex<Shared>) {
    let mut socket = tungstenite::accept(stream).unwrap();
    socket.get_ref().set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    tell(&mut socket, shared, true);
    loop {
        match socket.read() {
            Ok(Message::Text(text)) => {
                let wants_all = take(&text, &mut shared.lock().unwrap());
                let waiting = if shared.lock().unwrap().mood == Mood::Slow { dawdle(&mut socket, shared) } else { 0 };
                for _ in 0..=waiting {
                    tell(&mut socket, shared, wants_all);
                }
            }
            Ok(Message::Close(_)) => shared.lock().unwrap().has_said_goodbye = true,
            Ok(_) => {}
            Err(Error::Io(error))
                if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) => {}
            Err(_) => return,
        }
        if shared.lock().unwrap().mood == Mood::Closes {
            let _ = socket.close(None);
            let _ = socket.flush();
            return;
        }
    }
}

/// Lets time pass, and takes the commands that came meanwhile: how many.
fn dawdle(socket: &mut WebSocket<TcpStream>, shared: &Mutex<Shared>) -> usize {
    std::thread::sleep(Duration::from_millis(20));
    let mut waiting = 0;
    socket.get_ref().set_read_timeout(Some(Duration::from_millis(1))).unwrap();
    while let Ok(Message::Text(text)) = socket.read() {
        let mut shared = shared.lock().unwrap();
        take(&text, &mut shared);
        shared.early += usize::from(shared.forces.last().is_some_and(|force| *force != [0.0; 3]));
        waiting += 1;
    }
    socket.get_ref().set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    shared.lock().unwrap().slow += 1;
    waiting
}

/// Answers once; the full state has the configuration too.
fn tell(socket: &mut WebSocket<TcpStream>, shared: &Mutex<Shared>, is_full: bool) {
    let message = {
        let mut shared = shared.lock().unwrap();
        match &shared.mood {
            Mood::Good | Mood::Slow => {
                let state = state(&shared, is_full);
                shared.judged[1] += 1;
                shared.faults.extend(judge::fault_of_state(&state));
                Message::text(state.to_string())
            }
            Mood::Says(text) => Message::text(text.clone()),
            Mood::Bytes => Message::binary(vec![0xff; 64]),
            Mood::Silent | Mood::Closes => return,
        }
    };
    // The next read notices a client that has left.
    let _ = socket.send(message);
}

fn state(shared: &Shared, is_full: bool) -> Value {
    let mut data = shared.data.clone();
    for device in data.get_mut("inverse3").and_then(Value::as_array_mut).into_iter().flatten() {
        if !shared.has_preset {
            // Its origin is in the base still.
            device["state"]["cursor_position"] = json!({"x": 0.0, "y": -0.12, "z": 0.15});
        }
        if is_full {
            let preset = if shared.has_preset && shared.tells_preset { "arm_front_centered" } else { "defaults" };
            device["config"]["preset"] = preset.into();
        } else {
            device.as_object_mut().unwrap().remove("config");
        }
    }
    data
}

/// Checks a message with the judge and keeps the faults found. True if the message asks for the full state.
fn take(text: &str, shared: &mut Shared) -> bool {
    shared.judged[0] += 1;
    let message: Value = match serde_json::from_str(text) {
        Ok(message) => message,
        Err(error) => {
            shared.faults.push(format!("no JSON: {error}: {text}"));
            return false;
        }
    };
    shared.faults.extend(judge::fault_of_command(&message));
    if let Some(profile) = message["session"]["configure"]["profile"]["name"].as_str() {
        shared.profile = Some(profile.to_string());
    }
    for device in message["inverse3"].as_array().into_iter().flatten() {
        if let Some(preset) = device["configure"]["preset"]["preset"].as_str() {
            shared.preset = Some(preset.to_string());
            shared.has_preset = true;
        }
        let force = &device["commands"]["set_cursor_force"];
        let [x, y, z] = ["x", "y", "z"].map(|axis| force["vector"][axis].as_f64());
        match (x, y, z) {
            (Some(x), Some(y), Some(z)) if device["device_id"] == "04C3" && force["execute"] == true => {
                shared.forces.push([x, y, z]);
            }
            _ => shared.faults.push(format!("no force for the arm: {device}")),
        }
    }
    message["session"].get("force_render_full_state").is_some()
}

/// The full state of an arm alone, with all fields that the maker's types require.
pub fn inverse3() -> Value {
    json!({
        "inverse3": [{
            "device_id": "04C3",
            "config": {
                "type": "inverse3",
                "device_info": {
                    "id": "04C3",
                    "major_version": 7,
                    "minor_version": 1,
                    "device_type": "inverse3",
                    "uuid": "",
                },
                "port": "COM3",
                "extended_device_id": "",
                "extended_firmware_version": "",
                "gravity_compensation": {"enabled": true, "scaling_factor": 1.0},
                "handedness": "right",
                "torque_scaling": {"enabled": true},
                "preset": "defaults",
            },
            "state": {
                "cursor_position": {"x": 0.01, "y": 0.02, "z": 0.03},
                "cursor_velocity": {"x": 0.1, "y": 0.2, "z": 0.3},
                "mode": "idle",
            },
            "status": {"calibrated": true, "in_use": false, "power_supply": true, "ready": true, "started": true},
        }],
    })
}

/// With a grip that is turned by half a radian about z.
pub fn with_grip() -> Value {
    let mut data = inverse3();
    data["wireless_verse_grip"] = json!([{
        "device_id": "1102",
        "config": {
            "port": "COM4",
            "type": "wireless_verse_grip",
            "major_version": 3,
            "minor_version": 0,
            "hardware_version": 1,
        },
        "state": {
            "orientation": {"w": 0.9689124, "x": 0.0, "y": 0.0, "z": 0.24740396},
            "buttons": {"a": true, "b": false, "c": true},
        },
        "status": {"ready": true, "connected": true, "awake": true},
    }]);
    data
}
