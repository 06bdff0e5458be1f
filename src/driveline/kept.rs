//! An answer that is kept for as long as the question stays the same.
//!
//! An exponential depends on the step and on parameters, which hardly ever change from one step to the next. What
//! is kept follows from the question alone, so it is no part of a state: it is neither saved nor restored.

/// The last question and its answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kept<Q, A>(Option<(Q, A)>);

impl<Q, A> Kept<Q, A> {
    /// Nothing has been asked.
    pub const NOTHING: Self = Self(None);
}

impl<Q, A> Default for Kept<Q, A> {
    fn default() -> Self {
        Self::NOTHING
    }
}

impl<Q: Copy + PartialEq, A: Copy> Kept<Q, A> {
    /// The answer to `question`, which `answer` gives where it is another one than the last.
    #[inline]
    pub fn of(&mut self, question: Q, answer: impl FnOnce(Q) -> A) -> A {
        match self.0 {
            Some((last, known)) if last == question => known,
            _ => self.renew(question, answer),
        }
    }

    #[cold]
    #[inline(never)]
    fn renew(&mut self, question: Q, answer: impl FnOnce(Q) -> A) -> A {
        let new = answer(question);
        self.0 = Some((question, new));
        new
    }
}

#[cfg(test)]
mod tests {
    use super::Kept;

    #[test]
    fn the_same_question_is_answered_once() {
        let (mut kept, mut asked) = (Kept::NOTHING, 0);
        let questions = [2.0, 2.0, 3.0, 2.0, f64::NAN, f64::NAN];
        let answers = questions.map(|q: f64| {
            kept.of(q, |q| {
                asked += 1;
                q * q
            })
        });
        assert_eq!(answers[..4], [4.0, 4.0, 9.0, 4.0]);
        assert!(answers[4].is_nan() && answers[5].is_nan());
        assert_eq!(asked, 5);
    }
}
