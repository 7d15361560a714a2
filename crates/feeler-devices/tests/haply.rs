//! The Haply driver against a stand-in for the Inverse Service, whose messages are judged by code here. `make
//! test-haply` runs the same scenarios, judged by the types of the maker's crate, which needs OpenSSL's headers.

mod common;
mod haply_scenarios;

/// Checks messages.
mod judge {
    use serde_json::{json, Value};

    /// The fault of a command: it must be a force for the arm, and the first ones must have an introduction and requests.
    pub fn fault_of_command(message: &Value) -> Option<String> {
        let arm = &message["inverse3"][0];
        let [x, y, z] = ["x", "y", "z"].map(|axis| &arm["commands"]["set_cursor_force"]["vector"][axis]);
        let set_cursor_force = json!({"vector": {"x": x, "y": y, "z": z}, "execute": true});
        let mut expected =
            json!({"inverse3": [{"device_id": "04C3", "commands": {"set_cursor_force": set_cursor_force}}]});
        if arm.get("configure").is_some() {
            expected["inverse3"][0]["configure"] = json!({"preset": {"preset": "arm_front_centered"}});
        }
        if let Some(session) = message.get("session") {
            expected["session"]["force_render_full_state"] = json!({});
            if session.get("configure").is_some() {
                expected["session"]["configure"] = json!({"profile": {"name": "feeler"}});
            }
        }
        let are_numbers = [x, y, z].iter().all(|part| part.is_number());
        (*message != expected || !are_numbers).then(|| format!("{message} instead of {expected}"))
    }

    /// The stand-in's messages; only the maker can confirm that the service sends them like this.
    pub fn fault_of_state(_state: &Value) -> Option<String> {
        None
    }

    #[test]
    fn what_is_no_command_of_ours_is_a_fault() {
        let command = r#"{"session":{"force_render_full_state":{}},"inverse3":[{"device_id":"04C3",
            "commands":{"set_cursor_force":{"vector":{"x":1.0,"y":-2.0,"z":0.5},"execute":true}}}]}"#;
        let judged = |text: &str| fault_of_command(&serde_json::from_str(text).unwrap());
        assert_eq!(judged(command), None);
        let breaks = [("04C3", "04C4"), ("execute", "perform"), ("true", "false"), ("1.0", "null"), ("\"x\"", "\"w\"")];
        for (from, to) in breaks {
            assert!(judged(&command.replace(from, to)).is_some(), "{from} -> {to}");
        }
    }
}
