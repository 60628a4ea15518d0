//! Kinds of messages in an epoch, learned from previous epochs.

/// A set of message kinds, one bit each.
pub(super) type Kinds = u8;

/// Number of epochs remembered.
const MEMORY: usize = 4;

/// Detects the end of an epoch. Receivers send each epoch as a burst of messages and do not mark its end. A fix
/// delivered at the first message lacks the data of the others. A fix delivered at the start of the next epoch is late
/// by a whole epoch. An epoch is therefore complete when each expected kind has arrived. A kind is expected if it was
/// missing at most once in the last four epochs. A lost message thus has no effect, and an occasional message causes no
/// delay.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cycle {
    seen: Kinds,
    /// The last epochs, the latest first.
    memory: [Kinds; MEMORY],
    epochs: usize,
}

impl Cycle {
    /// Records a message of the current epoch.
    pub fn note(&mut self, kind: Kinds) {
        self.seen |= kind;
    }

    /// The kinds expected in an epoch; empty until two epochs have passed.
    pub fn expected(&self) -> Kinds {
        if self.epochs < 2 {
            return 0;
        }
        let (mut ever, mut missing, mut missing_twice) = (0, 0, 0);
        for kinds in self.memory.iter().take(self.epochs) {
            ever |= kinds;
            missing_twice |= missing & !kinds;
            missing |= !kinds;
        }
        ever & !missing_twice
    }

    /// Whether all expected messages of the current epoch have arrived.
    pub fn is_complete(&self) -> bool {
        let expected = self.expected();
        expected != 0 && self.seen & expected == expected
    }

    /// Ends the current epoch.
    pub fn close(&mut self) {
        if self.seen != 0 {
            self.memory.rotate_right(1);
            self.memory[0] = self.seen;
            self.epochs = (self.epochs + 1).min(MEMORY);
            self.seen = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For each epoch, the kinds that had arrived when it counted as complete; `None` if it never did.
    fn complete_at(epochs: &[&[Kinds]]) -> Vec<Option<Kinds>> {
        let mut cycle = Cycle::default();
        epochs
            .iter()
            .map(|kinds| {
                let mut complete = None;
                for kind in *kinds {
                    cycle.note(*kind);
                    if cycle.is_complete() && complete.is_none() {
                        complete = Some(cycle.seen);
                    }
                }
                cycle.close();
                complete
            })
            .collect()
    }

    #[test]
    fn an_epoch_is_complete_with_its_last_usual_message_from_the_third_on() {
        let all: &[Kinds] = &[1, 2, 4];
        assert_eq!(complete_at(&[all; 5]), [None, None, Some(7), Some(7), Some(7)]);
    }

    #[test]
    fn a_message_sent_now_and_then_is_not_waited_for() {
        let mut epochs: Vec<&[Kinds]> = vec![&[1, 2, 4]];
        for _ in 0..4 {
            epochs.extend([&[1, 2][..], &[1, 2], &[1, 2], &[1, 2], &[1, 2, 4]]);
        }
        assert!(complete_at(&epochs)[3..].iter().all(|complete| *complete == Some(3)));
    }

    #[test]
    fn after_a_lost_message_the_whole_epoch_is_still_waited_for() {
        let whole: &[Kinds] = &[1, 2, 4];
        for lost in 0..6 {
            let mut epochs = [whole; 8];
            epochs[lost] = &[1, 4];
            let complete = complete_at(&epochs);
            for (epoch, complete) in complete.iter().enumerate().skip(2) {
                let expected = (epoch != lost).then_some(7);
                assert_eq!(*complete, expected, "epoch {epoch}, lost in {lost}");
            }
        }
    }
}
