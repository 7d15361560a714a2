//! Hashes of results, and their expected values in `testdata/golden.txt`.

const GOLDEN: &str = include_str!("../../../testdata/golden.txt");

/// FNV-1a.
#[derive(Debug, Clone, Copy)]
pub struct Hash(u64);

impl Hash {
    /// Of nothing.
    pub const NEW: Hash = Hash(0xcbf2_9ce4_8422_2325);

    /// Adds 32 bits.
    pub fn add(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    /// Adds 64 bits.
    pub fn add_long(&mut self, word: u64) {
        self.add(word as u32);
        self.add((word >> 32) as u32);
    }

    /// Adds the bits of a number, of zero without its sign: which of two zeros is the larger is not the same everywhere.
    pub fn add_real(&mut self, x: f64) {
        self.add_long((x + 0.0).to_bits());
    }

    /// So far.
    pub fn value(self) -> u64 {
        self.0
    }

    /// Panics unless this is the number of that name in the file of golden hashes.
    pub fn assert_golden(self, name: &str) {
        let written = GOLDEN.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_default().trim();
        assert_eq!(format!("{:016x}", self.0), written, "not the number of {name} in testdata/golden.txt");
    }
}
