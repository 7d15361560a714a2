//! The messages of the service, as far as needed: states in, commands out. `make test-haply` checks both with the types
//! of the maker's crate.

use feeler_core::Point;
use feeler_haptics::Twist;
use serde::{Deserialize, Serialize};

use super::options::HaplyOptions;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Vector {
    x: f32,
    y: f32,
    z: f32,
}

impl Vector {
    pub fn point(&self) -> Point {
        [self.x.into(), self.y.into(), self.z.into()]
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
struct Quaternion {
    w: f32,
    x: f32,
    y: f32,
    z: f32,
}

/// One message of the service.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct State {
    #[serde(default)]
    inverse3: Vec<Inverse3>,
    #[serde(default)]
    verse_grip: Vec<Grip>,
    #[serde(default)]
    wireless_verse_grip: Vec<Grip>,
    #[serde(default)]
    custom_verse_grip: Vec<Grip>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Inverse3 {
    pub device_id: String,
    #[serde(default)]
    config: Option<Config>,
    #[serde(default)]
    state: Cursor,
    #[serde(default)]
    status: Status,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Config {
    #[serde(default, rename = "type")]
    kind: Option<serde_json::Value>,
    #[serde(default)]
    preset: Option<String>,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
struct Cursor {
    #[serde(default)]
    cursor_position: Option<Vector>,
    #[serde(default)]
    cursor_velocity: Option<Vector>,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
struct Status {
    #[serde(default)]
    calibrated: Option<bool>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
struct Grip {
    device_id: String,
    #[serde(default)]
    state: GripState,
}

#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
struct GripState {
    #[serde(default)]
    orientation: Option<Quaternion>,
    /// Of a VerseGrip on a wire.
    #[serde(default)]
    button: Option<bool>,
    #[serde(default)]
    buttons: Option<Buttons>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(default)]
struct Buttons {
    a: bool,
    b: bool,
    c: bool,
    d: bool,
    e: bool,
    f: bool,
}

/// The grip's readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Held {
    /// Of the grip (w, x, y, z), as received.
    pub quaternion: Option<[f64; 4]>,
    /// A bit each, from `a` on.
    pub buttons: u32,
}

/// Number of buttons of a grip: `a` to `f`.
pub(super) const GRIP_BUTTONS: u32 = 6;

impl State {
    /// The Inverse3 with an id, or the first.
    pub fn device(&self, id: Option<&str>) -> Option<&Inverse3> {
        self.inverse3.iter().find(|device| id.is_none_or(|id| device.device_id == id))
    }

    /// Names of all of them, for errors.
    pub fn device_ids(&self) -> String {
        self.inverse3.iter().map(|device| device.device_id.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// The grip with an id, or the first one with a rotation: custom ones first, which the service may list as wireless
    /// ones as well.
    pub fn grip(&self, id: Option<&str>) -> Option<Held> {
        let grip = self.custom_verse_grip.iter().chain(&self.wireless_verse_grip).chain(&self.verse_grip).find(
            |grip| match id {
                Some(id) => grip.device_id == id,
                None => grip.state.orientation.is_some(),
            },
        )?;
        let Buttons { a, b, c, d, e, f } = grip.state.buttons.unwrap_or_default();
        let bits = [a | grip.state.button.unwrap_or(false), b, c, d, e, f];
        Some(Held {
            quaternion: grip.state.orientation.map(|q| [q.w.into(), q.x.into(), q.y.into(), q.z.into()]),
            buttons: bits.iter().enumerate().map(|(i, is_pressed)| u32::from(*is_pressed) << i).sum(),
        })
    }
}

impl Inverse3 {
    /// Where the cursor is, metres.
    pub fn position(&self) -> Option<Point> {
        self.state.cursor_position.map(|position| position.point())
    }

    /// Its velocity; it has no rotation of its own.
    pub fn velocity(&self) -> Option<Twist> {
        self.state.cursor_velocity.map(|velocity| Twist { linear: velocity.point(), angular: [0.0; 3] })
    }

    /// The preset in use by the service.
    pub fn preset(&self) -> Option<&str> {
        self.config.as_ref()?.preset.as_deref()
    }

    /// Whether it is the smaller Minverse: by name, or by the number that older services give.
    pub fn is_minverse(&self) -> bool {
        let kind = self.config.as_ref().and_then(|config| config.kind.as_ref());
        kind.is_some_and(|kind| kind == "minverse" || kind == 6)
    }

    /// Whether it reports that it is not calibrated.
    pub fn is_uncalibrated(&self) -> bool {
        self.status.calibrated == Some(false)
    }
}

/// One message to the service.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Commands<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    session: Option<Session>,
    inverse3: [DeviceCommands<'a>; 1],
}

#[derive(Debug, Clone, Default, PartialEq, Serialize)]
struct Session {
    #[serde(skip_serializing_if = "Option::is_none")]
    force_render_full_state: Option<Nothing>,
    #[serde(skip_serializing_if = "Option::is_none")]
    configure: Option<SessionConfigure>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
struct Nothing {}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct SessionConfigure {
    profile: Profile,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Profile {
    name: &'static str,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct DeviceCommands<'a> {
    device_id: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    configure: Option<Configure<'a>>,
    commands: Force,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Configure<'a> {
    preset: Preset<'a>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Preset<'a> {
    preset: &'a str,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Force {
    set_cursor_force: SetForce,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct SetForce {
    vector: Vector,
    execute: bool,
}

impl<'a> Commands<'a> {
    /// A force on the cursor, newtons.
    pub fn force(device_id: &'a str, force: &Point) -> Commands<'a> {
        let [x, y, z] = force.map(|part| part as f32);
        let set_cursor_force = SetForce { vector: Vector { x, y, z }, execute: true };
        Commands {
            session: None,
            inverse3: [DeviceCommands { device_id, configure: None, commands: Force { set_cursor_force } }],
        }
    }

    /// The first message of a session: who this is, and the preset.
    pub fn introducing(mut self, options: &'a HaplyOptions) -> Commands<'a> {
        let configure = Some(SessionConfigure { profile: Profile { name: "feeler" } });
        self.session = Some(Session { force_render_full_state: Some(Nothing {}), configure });
        self.inverse3[0].configure = options.preset.as_deref().map(|preset| Configure { preset: Preset { preset } });
        self
    }

    /// Asks for the full state too, which says the preset.
    pub fn asking_for_all(mut self) -> Commands<'a> {
        self.session.get_or_insert_default().force_render_full_state = Some(Nothing {});
        self
    }

    /// As the service reads it.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self)
    }
}
