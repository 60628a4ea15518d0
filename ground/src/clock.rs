//! Conversion of the vehicle's time to ground time, and the delay of each frame.

/// Delay relative to the fastest frame, s, above which a frame is late.
const LATE_S: f64 = 0.2;
/// Lead of the vehicle's time, s, above which the vehicle's clock was set.
const AHEAD_S: f64 = 0.5;
/// Lag of the vehicle's time, s, above which the vehicle's clock was set: no link delays a frame that long.
const BEHIND_S: f64 = 10.0;
/// Largest relative drift of the two clocks.
const DRIFT: f64 = 2e-4;

/// The vehicle's clock relative to ground time.
#[derive(Clone, Copy, Debug, Default)]
pub struct VehicleClock {
    /// Ground time minus vehicle time, s, at the first comparison.
    offset_s: Option<f64>,
    /// Smallest recent difference between ground time and vehicle time, s: that of a frame without delay.
    min_s: f64,
    last_arrival_s: f64,
    /// Number of times the vehicle's clock was set.
    pub jumps: u64,
}

/// The time of a frame, and its delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Ground time, s.
    pub time_s: f64,
    /// Delay relative to the fastest frame, s.
    pub delay_s: f64,
    /// Whether the frame is late.
    pub is_late: bool,
    /// Whether the vehicle's clock was set since the previous frame.
    pub jumped: bool,
}

impl VehicleClock {
    /// Converts the vehicle time `vehicle_s` of a frame that arrived at ground time `arrival_s`.
    pub fn place(&mut self, vehicle_s: f64, arrival_s: f64) -> Placed {
        let difference_s = arrival_s - vehicle_s;
        let known = self.offset_s.filter(|offset_s| {
            let behind_s = difference_s - offset_s;
            (-AHEAD_S..=BEHIND_S).contains(&behind_s)
        });
        let jumped = self.offset_s.is_some() && known.is_none();
        let offset_s = known.unwrap_or_else(|| {
            self.min_s = difference_s;
            self.last_arrival_s = arrival_s;
            self.jumps += u64::from(jumped);
            self.offset_s = Some(difference_s);
            difference_s
        });
        // The smallest difference may be old; it grows with the drift of the clocks.
        let since_s = (arrival_s - self.last_arrival_s).max(0.0);
        self.min_s = difference_s.min(self.min_s + DRIFT * since_s);
        self.last_arrival_s = arrival_s;
        let delay_s = difference_s - self.min_s;
        Placed { time_s: vehicle_s + offset_s, delay_s, is_late: delay_s > LATE_S, jumped }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_burst_after_a_stall_is_late_and_keeps_its_own_times() {
        let mut clock = VehicleClock::default();
        assert_eq!(clock.place(10.0, 1000.0).time_s, 1000.0);
        for k in 1..100 {
            let stalled = f64::from(k) * 0.03;
            let placed = clock.place(10.0 + stalled, 1003.0);
            assert_abs_diff_eq!(placed.time_s - 1000.0, stalled, epsilon = 1e-9);
            assert!(!placed.jumped);
            assert_eq!(placed.is_late, placed.delay_s > 0.2);
        }
        assert!(!clock.place(13.0, 1003.01).is_late);
    }

    #[test]
    fn a_vehicle_that_starts_again_is_placed_again() {
        let mut clock = VehicleClock::default();
        clock.place(500.0, 1000.0);
        let placed = clock.place(0.5, 1010.0);
        assert!(placed.jumped && placed.time_s == 1010.0);
        assert_eq!(clock.jumps, 1);
    }

    #[test]
    fn crystals_that_differ_make_no_frame_late() {
        let mut clock = VehicleClock::default();
        for k in 0..7_200 {
            let vehicle_s = f64::from(k);
            assert!(!clock.place(vehicle_s, vehicle_s * (1.0 + 1e-4)).is_late);
        }
    }
}
