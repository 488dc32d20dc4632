//! PNG files: what begins as one, with the checksums that its chunks should have.
#![no_main]

use fuzz::{Counting, examine, prepare};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    prepare();
    let mut file = data.to_vec();
    file.resize(file.len().max(8), 0);
    file[..8].copy_from_slice(b"\x89PNG\r\n\x1A\n");
    let mut at = 8;
    while let Some(head) = file.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(checked) = file.get(at + 4..at + 8 + length) else { break };
        let sum = crc(checked);
        at += 8 + length;
        let Some(place) = file.get_mut(at..at + 4) else { break };
        place.copy_from_slice(&sum.to_be_bytes());
        at += 4;
    }
    let side = |at: usize| file.get(at..at + 4).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let size = (file.get(12..16) == Some(b"IHDR")).then(|| Some([side(16)?, side(20)?])).flatten();
    examine(&file, size);
});

/// The checksum of PNG (annex D).
fn crc(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let mut table = [0; 256];
        let mut i = 0;
        while i < 256 {
            let (mut value, mut bit) = (i as u32, 0);
            while bit < 8 {
                value = if value & 1 == 1 { 0xEDB8_8320 ^ value >> 1 } else { value >> 1 };
                bit += 1;
            }
            table[i] = value;
            i += 1;
        }
        table
    };
    !bytes.iter().fold(!0, |sum, byte| TABLE[(sum as u8 ^ byte) as usize] ^ sum >> 8)
}
