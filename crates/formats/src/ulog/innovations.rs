//! Innovations of PX4's estimator. In the log, the variances come with the innovations or after them.
//!
//! # Source
//! PX4, `msg/EstimatorInnovations.msg` and `ekf2_innovations.msg`; EKF2's innovation is prediction minus
//! measurement; heights are positions downwards.

use crate::assembly::Assembly;
use crate::onboard::OnboardInnovation;
use hovernav::ekf::Channel;
use hovernav::time::Time;

/// Channels in the order of the topics' columns.
const CHANNELS: [Channel; 8] = [
    Channel::PositionNorth,
    Channel::PositionEast,
    Channel::PositionDown,
    Channel::VelocityNorth,
    Channel::VelocityEast,
    Channel::VelocityDown,
    Channel::BaroHeight,
    Channel::Yaw,
];

/// Largest time between innovations and their variances, s.
const TOGETHER_S: f64 = 0.05;

/// Innovations whose variances have not arrived yet.
#[derive(Debug, Default)]
pub(super) struct Innovations(Option<(Time, [f64; 8])>);

impl Innovations {
    /// Reads innovations in the order of [`CHANNELS`].
    pub fn take(&mut self, time: Time, sizes: &[f64], to: &mut Assembly) {
        self.flush(to);
        self.0 = sizes.first_chunk().map(|sizes| (time, *sizes));
    }

    /// Reads the variances of the pending innovations.
    pub fn variances(&mut self, time: Time, variances: &[f64], to: &mut Assembly) {
        match self.0.take() {
            Some((of, sizes)) if (time - of).abs() <= TOGETHER_S => say(of, &sizes, variances, to),
            other => self.0 = other,
        }
    }

    /// Reads a row with innovations and variances, from old logs, which have no barometer innovation.
    pub fn old(time: Time, row: &[f64], to: &mut Assembly) {
        let Some((sizes, variances)) = row.split_at_checked(7) else { return };
        let with_baro = |row: &[f64]| -> Vec<f64> {
            let (gps, heading) = row.split_at(6);
            [gps, &[f64::NAN], &heading[..1]].concat()
        };
        if variances.len() >= 7 {
            say(time, &with_baro(sizes), &with_baro(variances), to);
        }
    }

    /// Adds the pending innovations without variances to `to`.
    pub fn flush(&mut self, to: &mut Assembly) {
        if let Some((time, sizes)) = self.0.take() {
            say(time, &sizes, &[f64::NAN; 8], to);
        }
    }
}

fn say(time: Time, sizes: &[f64], variances: &[f64], to: &mut Assembly) {
    for ((channel, size), variance) in CHANNELS.into_iter().zip(sizes).zip(variances) {
        // PX4's downward prediction minus measurement equals the upward measurement minus prediction.
        let innovation = if channel == Channel::BaroHeight { *size } else { -size };
        let sigma = Some(variance.sqrt());
        to.innovation(OnboardInnovation { time, channel, innovation, sigma });
    }
}
