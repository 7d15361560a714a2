//! The protocol of spacenavd's socket: events of eight 32-bit numbers in the machine's byte order (protocol 0), and
//! from version 1.0 on also a protocol version, agreed on by four bytes, and answers to requests (protocol 1).

use crate::constants::{LARGEST_COUNTS, LARGEST_EVENT};

/// Bytes of an event, a request or an answer.
pub(super) const EVENT_BYTES: usize = 32;

/// Marks requests, answers and the change of protocol: as float32 it is no number, which a daemon of protocol 0 ignores.
const TAG: u32 = 0x7faa_0000;
const TAG_MASK: u32 = 0xffff_0000;
const CHANGE_PROTOCOL: u32 = TAG | 0x5500;
const CHANGE_PROTOCOL_MASK: u32 = 0xffff_ff00;
/// Asks for the number of buttons of the first device.
pub(super) const NUMBER_OF_BUTTONS: u32 = 0x2003;
/// The newest protocol that is spoken here.
const NEWEST: u32 = 1;

/// The cap and the buttons, as told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Cap {
    /// Counts, the daemon's axes: x right, y up, z away; rotations about them.
    pub counts: [i32; 6],
    /// A bit each.
    pub buttons: u32,
}

/// One thing that the daemon said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Message {
    Motion([i32; 6]),
    Button {
        number: i32,
        is_pressed: bool,
    },
    /// A device has come or gone.
    Device {
        is_added: bool,
    },
    Protocol(u8),
    Answer {
        request: u32,
        data: [i32; 7],
    },
    /// An event that means nothing here, of this daemon or a later one.
    Other,
}

/// A packet that cannot be an event.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Nonsense(pub String);

/// The four bytes that ask for protocol 1.
pub(super) fn hello() -> [u8; 4] {
    (CHANGE_PROTOCOL | NEWEST).to_ne_bytes()
}

/// Sets the sensitivity of a daemon of protocol 0 back to 1: it took [`hello`] for one.
pub(super) fn sensitivity_of_one() -> [u8; 4] {
    1f32.to_ne_bytes()
}

/// A request without data.
pub(super) fn request(number: u32) -> [u8; EVENT_BYTES] {
    let mut bytes = [0; EVENT_BYTES];
    bytes[..4].copy_from_slice(&(TAG | number).to_ne_bytes());
    bytes
}

/// Puts messages together from bytes as they come.
#[derive(Debug, Default)]
pub(super) struct Parser {
    bytes: Vec<u8>,
}

impl Parser {
    /// Takes bytes and passes on each whole message. Errors at the first invalid one; later bytes are out of step.
    pub fn push(&mut self, bytes: &[u8], mut on: impl FnMut(Message)) -> Result<(), Nonsense> {
        self.bytes.extend_from_slice(bytes);
        let mut at = 0;
        while let Some(&first) = self.bytes[at..].first_chunk::<4>() {
            let word = u32::from_ne_bytes(first);
            if word & CHANGE_PROTOCOL_MASK == CHANGE_PROTOCOL {
                on(Message::Protocol((word & 0xff) as u8));
                at += 4;
                continue;
            }
            let Some(event) = self.bytes[at..].first_chunk::<EVENT_BYTES>() else { break };
            on(message(event)?);
            at += EVENT_BYTES;
        }
        self.bytes.drain(..at);
        Ok(())
    }
}

fn message(bytes: &[u8; EVENT_BYTES]) -> Result<Message, Nonsense> {
    let number = |i: usize| i32::from_ne_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]);
    let kind = number(0);
    match kind {
        0 => {
            let counts: [i32; 6] = std::array::from_fn(|i| number(i + 1));
            match counts.iter().find(|count| count.unsigned_abs() > LARGEST_COUNTS.unsigned_abs()) {
                Some(count) => Err(Nonsense(format!("a motion of {count} counts"))),
                None => Ok(Message::Motion(counts)),
            }
        }
        1 | 2 => Ok(Message::Button { number: number(1), is_pressed: kind == 1 }),
        3 => Ok(Message::Device { is_added: number(1) == 0 }),
        4..=LARGEST_EVENT => Ok(Message::Other),
        _ if kind as u32 & TAG_MASK == TAG => {
            Ok(Message::Answer { request: kind as u32 & !TAG_MASK, data: std::array::from_fn(|i| number(i + 1)) })
        }
        _ => Err(Nonsense(format!("an event of kind {kind}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn event(numbers: [i32; 8]) -> Vec<u8> {
        numbers.iter().flat_map(|x| x.to_ne_bytes()).collect()
    }

    fn all(bytes: &[u8]) -> Result<Vec<Message>, Nonsense> {
        let mut messages = vec![];
        Parser::default().push(bytes, |message| messages.push(message))?;
        Ok(messages)
    }

    #[test]
    fn events_are_read_in_any_pieces() {
        let bytes = [
            hello().to_vec(),
            event([0, 1, -2, 3, -4, 5, -6, 8]),
            event([1, 4, 0, 0, 0, 0, 0, 0]),
            event([2, 4, 0, 0, 0, 0, 0, 0]),
            event([3, 1, 0, 0, 0, 0, 0, 0]),
            event([7, 9, 9, 9, 9, 9, 9, 9]),
            request(NUMBER_OF_BUTTONS).to_vec(),
        ]
        .concat();
        let expected = vec![
            Message::Protocol(1),
            Message::Motion([1, -2, 3, -4, 5, -6]),
            Message::Button { number: 4, is_pressed: true },
            Message::Button { number: 4, is_pressed: false },
            Message::Device { is_added: false },
            Message::Other,
            Message::Answer { request: NUMBER_OF_BUTTONS, data: [0; 7] },
        ];
        for piece in [1, 3, 4, 31, 32, 33, bytes.len()] {
            let mut parser = Parser::default();
            let mut messages = vec![];
            for part in bytes.chunks(piece) {
                parser.push(part, |message| messages.push(message)).unwrap();
            }
            assert_eq!(messages, expected, "in pieces of {piece}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(all(&event([-1, 0, 0, 0, 0, 0, 0, 0])).is_err());
        assert!(all(&event([64, 0, 0, 0, 0, 0, 0, 0])).is_err());
        assert!(all(&event([0, i32::MIN, 0, 0, 0, 0, 0, 0])).is_err());
        assert!(all(&event([0, LARGEST_COUNTS + 1, 0, 0, 0, 0, 0, 0])).is_err());
        assert!(all(&event([0, LARGEST_COUNTS, -LARGEST_COUNTS, 0, 0, 0, 0, 0])).is_ok());
    }

    proptest! {
        #[test]
        fn any_bytes_are_messages_or_nonsense_and_never_pile_up(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let mut parser = Parser::default();
            if parser.push(&bytes, |_| ()).is_ok() {
                prop_assert!(parser.bytes.len() < EVENT_BYTES);
            }
        }
    }
}
