//! Numbers that are read and written at every step.

/// Numbers in a line of the cache.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 8;

/// Asks the processor to have the place of these numbers at hand when they are written; changes nothing.
///
/// An FMU that guards its instance by an atomic operation, as it should, waits there until all
/// earlier writes have reached the cache.
#[inline]
pub fn prefetch(numbers: &[f64]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let (lines, rest) = numbers.as_chunks::<LINE>();
        // SAFETY: a hint: at no address does it read, write or fault.
        let ask = |start: *const f64| unsafe { _mm_prefetch::<_MM_HINT_T0>(start.cast()) };
        lines.iter().for_each(|line| ask(line.as_ptr()));
        if !rest.is_empty() {
            ask(rest.as_ptr());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = numbers;
}

/// Places in a vector of numbers, which copies look at only once.
#[derive(Debug, Default)]
pub struct Places {
    places: Vec<usize>,
    /// All of them are below.
    end: usize,
}

impl Places {
    /// Of these places, in this order.
    pub fn new(places: Vec<usize>) -> Self {
        let end = places
            .iter()
            .map(|place| place.saturating_add(1))
            .max()
            .unwrap_or(0);
        Self { places, end }
    }

    /// The places.
    pub fn all(&self) -> &[usize] {
        &self.places
    }

    /// Copies the numbers at these places into as many, one after the other; where one is not there, none are numbers.
    #[inline(always)]
    pub fn copy(&self, from: &[f64], to: &mut [f64]) {
        if from.len() < self.end || to.len() != self.places.len() {
            to.fill(f64::NAN);
            return;
        }
        let (places, few) = self.places.as_chunks::<4>();
        let (four, rest) = to.as_chunks_mut::<4>();
        // SAFETY: `from` is longer than each of these places.
        let at = |place: usize| unsafe { *from.get_unchecked(place) };
        for (to, places) in four.iter_mut().zip(places) {
            *to = places.map(at);
        }
        for (to, place) in rest.iter_mut().zip(few) {
            *to = at(*place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Places;

    #[test]
    fn numbers_come_from_their_places() {
        let from: Vec<f64> = (0..9).map(f64::from).collect();
        for count in 0..9 {
            let places: Vec<usize> = (0..count).map(|k| (4 * k + 3) % 9).collect();
            let mut to = vec![-1.0; count];
            Places::new(places.clone()).copy(&from, &mut to);
            let expected: Vec<f64> = places.iter().map(|place| from[*place]).collect();
            assert_eq!(to, expected);
        }
    }

    #[test]
    fn beyond_the_end_there_is_no_number() {
        let places = Places::new(vec![0, 1, 2, 3, 9]);
        let mut to = [1.0; 5];
        places.copy(&[0.0; 9], &mut to);
        assert!(to.iter().all(|number| number.is_nan()));
        places.copy(&[0.0; 10], &mut to);
        assert_eq!(to, [0.0; 5]);
        places.copy(&[0.0; 10], &mut to[..4]);
        assert!(to[..4].iter().all(|number| number.is_nan()));
    }
}
