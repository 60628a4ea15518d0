//! From the vehicle's time to the ground's, and how late a frame is.

/// A frame later than this after the fastest is late, s.
const LATE_S: f64 = 0.2;
/// A vehicle's time that runs ahead of the ground's by more than this has been set, s.
const AHEAD_S: f64 = 0.5;
/// One that stays behind by more than this too: no link holds a frame back for so long.
const BEHIND_S: f64 = 10.0;
/// Two crystals differ by less than this.
const DRIFT: f64 = 2e-4;

/// The vehicle's clock as seen from the ground.
#[derive(Clone, Copy, Debug, Default)]
pub struct VehicleClock {
    /// The ground's time less the vehicle's, s, when they were compared first.
    offset_s: Option<f64>,
    /// The least difference lately: that of a frame with no delay of its own.
    least_s: f64,
    last_arrival_s: f64,
    /// Times that the clock was set.
    pub jumps: u64,
}

/// When a frame was true, and how late it came.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// On the ground's clock, s.
    pub time_s: f64,
    /// More than the fastest frame took, s.
    pub delay_s: f64,
    /// Whether that is late.
    pub is_late: bool,
    /// Whether the vehicle's clock was set since the frame before.
    pub jumped: bool,
}

impl VehicleClock {
    /// Places a frame of the vehicle's time `vehicle_s` that arrived at `arrival_s`.
    pub fn place(&mut self, vehicle_s: f64, arrival_s: f64) -> Placed {
        let difference_s = arrival_s - vehicle_s;
        let known = self.offset_s.filter(|offset_s| {
            let behind_s = difference_s - offset_s;
            (-AHEAD_S..=BEHIND_S).contains(&behind_s)
        });
        let jumped = self.offset_s.is_some() && known.is_none();
        let offset_s = known.unwrap_or_else(|| {
            self.least_s = difference_s;
            self.last_arrival_s = arrival_s;
            self.jumps += u64::from(jumped);
            self.offset_s = Some(difference_s);
            difference_s
        });
        // The least may be of long ago, and the clocks have run apart since.
        let since_s = (arrival_s - self.last_arrival_s).max(0.0);
        self.least_s = difference_s.min(self.least_s + DRIFT * since_s);
        self.last_arrival_s = arrival_s;
        let delay_s = difference_s - self.least_s;
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
    fn a_vehicle_that_starts_anew_is_placed_anew() {
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
