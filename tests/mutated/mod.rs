//! Files as they come from bad disks and careless hands.

use proptest::prelude::*;

/// Bytes with some changed, some taken out, some put in, or cut.
pub fn mutated(bytes: &[u8], changes: &[(usize, u8, u8)]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for &(at, kind, byte) in changes {
        if bytes.is_empty() {
            break;
        }
        let at = at % bytes.len();
        match kind % 5 {
            0 => bytes[at] = byte,
            1 => {
                bytes.remove(at);
            }
            2 => bytes.insert(at, byte),
            3 => drop(bytes.splice(at..at, *b"99999999999999999999")),
            _ => bytes.truncate(at),
        }
    }
    bytes
}

/// Changes for `mutated`: where, of which kind, to what.
pub fn changes() -> impl Strategy<Value = Vec<(usize, u8, u8)>> {
    proptest::collection::vec((any::<usize>(), any::<u8>(), any::<u8>()), 1..6)
}
