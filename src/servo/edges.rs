//! Pulse widths from timed edges.

/// Result of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paired {
    /// No complete pulse yet: a pulse has begun, or the first edge was the end of a pulse.
    Waiting,
    /// A pulse has ended; its width, ms, plausible or not.
    Width(f64),
    /// The other edge of this pulse is missing, or the two edges are not in order.
    Broken,
}

/// Pairs the edges of one line into pulses.
///
/// The timing hardware or driver numbers the edges, so that lost edges are detected. A pulse counts only if the falling
/// edge has the number after that of the rising edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeTimer {
    /// Number and time, ns, of the rising edge of an incomplete pulse.
    rose: Option<(u32, u64)>,
    started: bool,
}

impl EdgeTimer {
    /// Processes the edge with the number `sequence` at `time_ns` on any steady clock.
    pub fn edge(&mut self, rising: bool, sequence: u32, time_ns: u64) -> Paired {
        let first = !core::mem::replace(&mut self.started, true);
        let rose = self.rose.take();
        if rising {
            self.rose = Some((sequence, time_ns));
            return if rose.is_some() { Paired::Broken } else { Paired::Waiting };
        }
        let width_ns = rose
            .filter(|(number, _)| number.wrapping_add(1) == sequence)
            .and_then(|(_, start_ns)| time_ns.checked_sub(start_ns));
        match width_ns {
            Some(width_ns) => Paired::Width(width_ns as f64 / 1e6),
            None if first => Paired::Waiting,
            None => Paired::Broken,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pulse_is_a_rise_and_the_fall_numbered_next() {
        let mut timer = EdgeTimer::default();
        assert_eq!(timer.edge(true, u32::MAX, 1_000_000), Paired::Waiting);
        assert_eq!(timer.edge(false, 0, 2_500_500), Paired::Width(1.5005));
        assert_eq!(timer.edge(true, 1, 21_000_000), Paired::Waiting);
        assert_eq!(timer.edge(false, 2, 22_000_000), Paired::Width(1.0));
    }

    #[test]
    fn a_lost_edge_costs_its_own_pulse_and_no_other() {
        let mut timer = EdgeTimer::default();
        timer.edge(true, 1, 0);
        // The falling edge 2 and the rising edge 3 are lost.
        assert_eq!(timer.edge(false, 4, 21_000_000), Paired::Broken);
        timer.edge(true, 5, 40_000_000);
        // The falling edge 6 is lost.
        assert_eq!(timer.edge(true, 7, 60_000_000), Paired::Broken);
        assert_eq!(timer.edge(false, 8, 61_200_000), Paired::Width(1.2));
    }

    #[test]
    fn starting_inside_a_pulse_is_no_fault_and_time_running_back_is_one() {
        let mut timer = EdgeTimer::default();
        assert_eq!(timer.edge(false, 1, 5_000_000), Paired::Waiting);
        timer.edge(true, 2, 9_000_000);
        assert_eq!(timer.edge(false, 3, 8_000_000), Paired::Broken);
    }
}
