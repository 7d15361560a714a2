//! Whether messages between a client and Haply's Inverse Service are what the maker's own crate reads and writes.

use haply::device_model::{ServiceData, ServiceMsg};
use serde_json::{json, Value};

/// What is wrong with a message to the service: it must be of the crate's type, and the same when the crate writes it again.
pub fn fault_of_command(ours: &Value) -> Option<String> {
    let Some(fields) = ours.as_object() else { return Some(format!("no object: {ours}")) };
    // The crate leaves empty lists out when it writes, and wants them, and a session, when it reads.
    let mut whole = fields.clone();
    for (key, empty) in [("session", json!({})), ("verse_grip", json!([])), ("wireless_verse_grip", json!([]))] {
        whole.entry(key).or_insert(empty);
    }
    let message: ServiceMsg = match serde_json::from_value(whole.into()) {
        Ok(message) => message,
        Err(error) => return Some(format!("not the maker's message: {error}: {ours}")),
    };
    let mut theirs = match serde_json::to_string(&message).and_then(|text| serde_json::from_str::<Value>(&text)) {
        Ok(theirs) => theirs,
        Err(error) => return Some(format!("the maker's crate does not write it again: {error}: {ours}")),
    };
    if let (None, Some(fields)) = (ours.get("session"), theirs.as_object_mut()) {
        fields.remove("session");
    }
    (theirs != *ours).then(|| format!("the maker's crate reads {theirs} in {ours}"))
}

/// What is wrong with a message of the service: it must be of the crate's type, and all of it must be there when the crate
/// writes it again. The crate then says what is missing, too (`null`).
pub fn fault_of_state(state: &Value) -> Option<String> {
    let data: ServiceData = match serde_json::from_value(state.clone()) {
        Ok(data) => data,
        Err(error) => return Some(format!("not the maker's state: {error}: {state}")),
    };
    // By way of text, where a float32 is as short as it was.
    match serde_json::to_string(&data).and_then(|text| serde_json::from_str::<Value>(&text)) {
        Ok(theirs) => is_part(state, &theirs).err().map(|what| format!("the maker's crate does not know {what}")),
        Err(error) => Some(format!("the maker's crate does not write it again: {error}: {state}")),
    }
}

/// Whether all of a value is in another one; if not, what is not.
fn is_part(part: &Value, whole: &Value) -> Result<(), String> {
    match (part, whole) {
        (Value::Object(parts), Value::Object(fields)) => parts.iter().try_for_each(|(key, value)| {
            let field = fields.get(key).ok_or_else(|| format!("{key}: {value}"))?;
            is_part(value, field).map_err(|what| format!("{key}: {what}"))
        }),
        (Value::Array(parts), Value::Array(values)) if parts.len() == values.len() => {
            parts.iter().zip(values).try_for_each(|(part, value)| is_part(part, value))
        }
        _ if part == whole => Ok(()),
        _ => Err(format!("{part} (it reads {whole})")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMMAND: &str = r#"{"inverse3":[{"device_id":"04C3",
        "configure":{"preset":{"preset":"arm_front_centered"}},
        "commands":{"set_cursor_force":{"vector":{"x":0.1,"y":-2.0,"z":0.5},"execute":true}}}]}"#;
    const STATE: &str = r#"{"inverse3":[{"device_id":"04C3",
        "state":{"cursor_position":{"x":0.1,"y":0.2,"z":0.3},"mode":"idle"},
        "status":{"calibrated":true,"in_use":false,"power_supply":true,"ready":true,"started":true}}]}"#;

    fn is_faulty(judge: fn(&Value) -> Option<String>, text: &str) -> bool {
        judge(&serde_json::from_str(text).unwrap()).is_some()
    }

    #[test]
    fn other_commands_are_faults() {
        assert_eq!(fault_of_command(&serde_json::from_str(COMMAND).unwrap()), None);
        let breaks = [
            ("device_id", "id"),
            ("configure", "config"),
            ("set_cursor_force", "set_force"),
            ("\"x\"", "\"u\""),
            ("0.1", "\"0.1\""),
            ("\"execute\":true", "\"execute\":1"),
            (",\"execute\":true", ""),
            ("\"inverse3\"", "\"inverse4\":1,\"inverse3\""),
        ];
        for (from, to) in breaks {
            assert!(is_faulty(fault_of_command, &COMMAND.replace(from, to)), "{from} -> {to}");
        }
        assert!(is_faulty(fault_of_command, "[]"));
    }

    #[test]
    fn other_states_are_faults() {
        assert_eq!(fault_of_state(&serde_json::from_str(STATE).unwrap()), None);
        let breaks = [
            ("device_id", "id"),
            ("cursor_position", "position"),
            ("\"z\"", "\"w\""),
            ("\"idle\"", "\"busy\""),
            ("calibrated", "is_calibrated"),
            ("\"inverse3\"", "\"grips\":[],\"inverse3\""),
        ];
        for (from, to) in breaks {
            assert!(is_faulty(fault_of_state, &STATE.replace(from, to)), "{from} -> {to}");
        }
    }
}
