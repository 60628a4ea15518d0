//! ArduPilot's inputs: sticks for the axes of a system identification, and the mixer of its frames.

/// Index of the stick for `SID_AXIS`, the axis of a system identification, and the sign of the signal.
///
/// # Source
/// ArduPilot, `ArduCopter/mode_systemid.cpp`: angles 1 to 6, rates 7 to 9, mixer 10 to 13.
pub(super) fn stick_of_axis(axis: f64) -> Option<(usize, f64)> {
    const ROLL: (usize, f64) = (0, 1.0);
    // ArduPilot counts nose up as positive, hovernav the forward stick.
    const PITCH: (usize, f64) = (1, -1.0);
    const YAW: (usize, f64) = (3, 1.0);
    const THROTTLE: (usize, f64) = (2, 1.0);
    match axis as u8 {
        1 | 4 | 7 | 10 => Some(ROLL),
        2 | 5 | 8 | 11 => Some(PITCH),
        3 | 6 | 9 | 12 => Some(YAW),
        13 => Some(THROTTLE),
        _ => None,
    }
}

/// Contributions of the first four motors to roll, pitch, throttle and yaw, for the quadcopter frames X and plus.
///
/// # Source
/// ArduPilot, `libraries/AP_Motors/AP_MotorsMatrix.cpp`: its factors, inverted.
pub(super) fn mixer(class: Option<f64>, frame: Option<f64>) -> Option<[[f64; 4]; 4]> {
    const THROTTLE: [f64; 4] = [0.25; 4];
    const YAW: [f64; 4] = [0.5, 0.5, -0.5, -0.5];
    if class != Some(1.0) {
        return None;
    }
    match frame.unwrap_or(1.0) as u8 {
        0 => Some([[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0], THROTTLE, YAW]),
        1 => Some([[-0.5, 0.5, 0.5, -0.5], [0.5, -0.5, 0.5, -0.5], THROTTLE, YAW]),
        _ => None,
    }
}

/// Lateral, longitudinal, collective and pedal from the `pulses_us` to four motors.
pub(super) fn of_motors(mixer: &[[f64; 4]; 4], pulses_us: &[f64]) -> [f64; 4] {
    /// Pulses without thrust and with full thrust, µs.
    const RANGE_US: [f64; 2] = [1000.0, 2000.0];
    let [roll, pitch, throttle, yaw] = mixer.map(|shares| {
        let shares = shares.iter().zip(pulses_us);
        shares.map(|(share, pulse_us)| share * (pulse_us - RANGE_US[0])).sum::<f64>()
            / (RANGE_US[1] - RANGE_US[0])
    });
    [roll, -pitch, throttle, yaw]
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    #[test]
    fn more_thrust_on_the_left_rolls_right_and_at_the_nose_pulls() {
        let x = mixer(Some(1.0), None).unwrap();
        // Front right, rear left, front left, rear right.
        let left = of_motors(&x, &[1400.0, 1500.0, 1500.0, 1400.0]);
        assert_abs_diff_eq!(left[..], [0.1, 0.0, 0.45, 0.0], epsilon = 1e-12);
        let nose = of_motors(&x, &[1500.0, 1400.0, 1500.0, 1400.0]);
        assert_abs_diff_eq!(nose[..], [0.0, -0.1, 0.45, 0.0], epsilon = 1e-12);
        assert!(mixer(Some(6.0), None).is_none() && mixer(None, None).is_none());
    }
}
