//! Transport delay of a stick's commands.

use std::collections::VecDeque;

/// Commands on their way to a servo.
#[derive(Clone, Debug)]
pub(super) struct Transport {
    delay_s: f64,
    /// Commands in transit, with their arrival times, s.
    waiting: VecDeque<(f64, f64)>,
    /// The last command that arrived.
    arrived: f64,
}

impl Transport {
    /// A delay of `delay_s`, with `command` acting at first.
    pub fn new(delay_s: f64, command: f64) -> Self {
        Self { delay_s, waiting: VecDeque::new(), arrived: command }
    }

    /// Sends `command` at `time_s`.
    pub fn send(&mut self, command: f64, time_s: f64) {
        if self.delay_s > 0.0 {
            self.waiting.push_back((time_s + self.delay_s, command));
        } else {
            self.arrived = command;
        }
    }

    /// The command that acts at `time_s`.
    pub fn at(&mut self, time_s: f64) -> f64 {
        /// Rounding of times, s.
        const ROUNDING_S: f64 = 1e-9;
        while let Some(&(arrival_s, command)) = self.waiting.front() {
            if arrival_s > time_s + ROUNDING_S {
                break;
            }
            self.arrived = command;
            self.waiting.pop_front();
        }
        self.arrived
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_acts_after_its_delay_and_none_is_lost() {
        let mut late = Transport::new(0.05, 0.0);
        late.send(0.1, 0.0);
        late.send(0.2, 0.03);
        assert_eq!(
            [0.0, 0.04, 0.05, 0.07, 0.08, 1.0].map(|at| late.at(at)),
            [0.0, 0.0, 0.1, 0.1, 0.2, 0.2]
        );
        let mut prompt = Transport::new(0.0, 0.3);
        assert_eq!(prompt.at(0.0), 0.3);
        prompt.send(-0.1, 0.0);
        assert_eq!(prompt.at(0.0), -0.1);
    }
}
