//! FNV-1a in 128 bits: the same number on every machine, for GUID and checksum.

const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

#[derive(Clone, Copy)]
pub(crate) struct Hash(u128);

impl Hash {
    pub(crate) const fn new() -> Self {
        Self(OFFSET)
    }

    pub(crate) const fn bytes(&mut self, bytes: &[u8]) {
        let mut index = 0;
        while index < bytes.len() {
            self.0 = (self.0 ^ bytes[index] as u128).wrapping_mul(PRIME);
            index += 1;
        }
    }

    /// A text with a separator that no text contains, so that `ab`, `c` and `a`, `bc` differ.
    pub(crate) const fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
        self.bytes(&[0xff]);
    }

    pub(crate) const fn value(self) -> u128 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From the FNV authors' test suite (draft-eastlake-fnv, 128 bit FNV-1a).
    #[test]
    fn hash_equals_the_published_vectors() {
        let hash = |text: &str| {
            let mut hash = Hash::new();
            hash.bytes(text.as_bytes());
            hash.value()
        };
        assert_eq!(hash(""), 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        assert_eq!(hash("a"), 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
        assert_eq!(hash("foobar"), 0x343e_1662_793c_64bf_6f0d_3597_ba44_6f18);
    }
}
