//! The bytes of the fuzzer, read as choices and numbers; zeros when they are used up.

/// What is left of them.
pub struct Script<'a>(pub &'a [u8]);

const ODD: [f64; 12] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    1e-300,
    1e300,
    -1.0,
    f64::MAX,
    f64::MIN_POSITIVE,
    1e9,
    0.5,
];

impl Script<'_> {
    pub fn is_over(&self) -> bool {
        self.0.is_empty()
    }

    pub fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    pub fn below(&mut self, limit: usize) -> usize {
        usize::from(self.byte()) % limit
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// One in sixteen.
    pub fn seldom(&mut self) -> bool {
        self.byte().is_multiple_of(16) && !self.is_over()
    }

    /// A number of two digits of some magnitude; now and then one that no model expects.
    pub fn real(&mut self) -> f64 {
        let magnitude = self.byte();
        if magnitude >= 0xf0 {
            return self.pick(&ODD);
        }
        if magnitude >= 0xe8 {
            return f64::from_bits(u64::from_le_bytes(core::array::from_fn(|_| self.byte())));
        }
        let digits = f64::from(i8::from_le_bytes([self.byte()]));
        digits * 10_f64.powi(i32::from(magnitude % 8) - 5)
    }

    pub fn integer(&mut self) -> i32 {
        let small = i32::from(i8::from_le_bytes([self.byte()]));
        if self.seldom() {
            self.pick(&[i32::MIN, i32::MAX, 256])
        } else {
            small
        }
    }
}
