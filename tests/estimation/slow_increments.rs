//! Accuracy of increments at low rates.

use hovernav_findings::SampleRates;

use crate::late_fixes::{flown, recording};

/// Root mean square errors of position, m, and velocity, m/s, in the second half of the flight.
fn errors(rate_hz: f64) -> [f64; 2] {
    let recording = recording(rate_hz);
    let states = flown(&recording, 0.0);
    let later = states.len() / 2;
    let apart = states.iter().zip(&recording.truth[1..]).skip(later).map(|(filter, truth)| {
        let state = filter.state();
        let position = state.position.displacement_from(&truth.position).norm();
        [position, (state.velocity_mps - truth.velocity_mps).norm()]
    });
    let squares = apart.fold([0.0; 2], |sum, errors| [0, 1].map(|k| sum[k] + errors[k].powi(2)));
    squares.map(|square| (square / (states.len() - later) as f64).sqrt())
}

/// A flight with turns of 30° a second and roll doublets of 8° in 1.5 s.
#[test]
fn as_few_increments_as_are_taken_navigate_nearly_as_well_as_many() {
    let [position, velocity] = errors(100.0);
    for rate_hz in [SampleRates::INCREMENTS.least_hz, 12.0, 15.0, 20.0] {
        let [slow_position, slow_velocity] = errors(rate_hz);
        println!(
            "{rate_hz} Hz: {slow_position:.3} m, {slow_velocity:.3} m/s; 100 Hz: {position:.3} m, {velocity:.3} m/s"
        );
        assert!(slow_position < 1.2 * position + 0.1 && slow_velocity < 1.2 * velocity + 0.02);
    }
}
