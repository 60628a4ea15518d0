//! Gains of the autopilot, from a design for the vehicle.

use hovernav::autopilot as core;

use super::mirror;

/// Gains of a PID controller; units are the command's over the error's, combined with s as the names state.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PidGains {
    /// Command per error.
    pub proportional: f64,
    /// Command per error and s.
    pub integral_per_s: f64,
    /// Command per rate of change of the measured value, s.
    pub derivative_s: f64,
    /// Time constant of the low-pass on the derivative, s; from 0.
    pub derivative_filter_s: f64,
    /// Time constant with which the integral follows a limited command, s; above 0.
    pub tracking_time_s: f64,
}

/// Gains of the yaw regulator. Measured states are r, psi; there are two hidden states.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct YawGains {
    /// Stick per measured state, row by control.
    pub measured: [[f64; 2]; 1],
    /// Stick per hidden state.
    pub hidden: [[f64; 2]; 1],
    /// Stick per command under way.
    pub pending: [[f64; 1]; 1],
    /// Stick per s of measured error.
    pub integral_per_s: [[f64; 2]; 1],
    /// Propagation of the hidden states over a sample, from themselves.
    pub hidden_from_hidden: [[f64; 2]; 2],
    /// Propagation from the measured states.
    pub hidden_from_measured: [[f64; 2]; 2],
    /// Propagation from the command that acts.
    pub hidden_from_pending: [[f64; 1]; 2],
    /// Time constant with which the integrals follow a limited command, s.
    pub tracking_time_s: f64,
}

/// Gains of the roll and pitch regulator. Measured states are p, q, phi, theta, u, v; there are six hidden states.
/// The controls are lateral and longitudinal cyclic.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RollPitchGains {
    /// Stick per measured state, row by control.
    pub measured: [[f64; 6]; 2],
    /// Stick per hidden state.
    pub hidden: [[f64; 6]; 2],
    /// Stick per command under way.
    pub pending: [[f64; 2]; 2],
    /// Stick per s of measured error.
    pub integral_per_s: [[f64; 6]; 2],
    /// Propagation of the hidden states over a sample, from themselves.
    pub hidden_from_hidden: [[f64; 6]; 6],
    /// Propagation from the measured states.
    pub hidden_from_measured: [[f64; 6]; 6],
    /// Propagation from the command that acts.
    pub hidden_from_pending: [[f64; 2]; 6],
    /// Time constant with which the integrals follow a limited command, s.
    pub tracking_time_s: f64,
}

/// Gains of the attitude regulator, for flight without a known velocity. Measured states are p, q, phi, theta.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AttitudeGains {
    /// Stick per measured state, row by control.
    pub measured: [[f64; 4]; 2],
    /// Stick per hidden state.
    pub hidden: [[f64; 6]; 2],
    /// Stick per command under way.
    pub pending: [[f64; 2]; 2],
    /// Stick per s of measured error.
    pub integral_per_s: [[f64; 4]; 2],
    /// Propagation of the hidden states over a sample, from themselves.
    pub hidden_from_hidden: [[f64; 6]; 6],
    /// Propagation from the measured states.
    pub hidden_from_measured: [[f64; 4]; 6],
    /// Propagation from the command that acts.
    pub hidden_from_pending: [[f64; 2]; 6],
    /// Time constant with which the integrals follow a limited command, s.
    pub tracking_time_s: f64,
}

/// Gains of the autopilot, for the sample period of their design.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Gains {
    /// Collective from the downward velocity w, body axes.
    pub heave: PidGains,
    /// Pedal from r, psi.
    pub yaw: YawGains,
    /// Pedal per collective.
    pub pedal_per_collective: f64,
    /// Cyclic from p, q, phi, theta, u, v.
    pub roll_pitch: RollPitchGains,
    /// Cyclic from p, q, phi, theta.
    pub attitude: AttitudeGains,
}

mirror!(PidGains, core::PidGains {
    proportional integral_per_s derivative_s derivative_filter_s tracking_time_s
});
mirror!(YawGains, core::RegulatorGains<2, 2, 1> {
    measured hidden pending integral_per_s hidden_from_hidden hidden_from_measured
    hidden_from_pending tracking_time_s
});
mirror!(RollPitchGains, core::RegulatorGains<6, 6, 2> {
    measured hidden pending integral_per_s hidden_from_hidden hidden_from_measured
    hidden_from_pending tracking_time_s
});
mirror!(AttitudeGains, core::RegulatorGains<4, 6, 2> {
    measured hidden pending integral_per_s hidden_from_hidden hidden_from_measured
    hidden_from_pending tracking_time_s
});

impl From<&core::Gains> for Gains {
    fn from(core: &core::Gains) -> Self {
        Self {
            heave: (&core.heave).into(),
            yaw: (&core.yaw).into(),
            pedal_per_collective: core.pedal_per_collective,
            roll_pitch: (&core.roll_pitch).into(),
            attitude: (&core.attitude).into(),
        }
    }
}

impl Gains {
    pub(crate) fn core(&self) -> core::Gains {
        let mut gains = core::Gains::default();
        self.heave.put(&mut gains.heave);
        self.yaw.put(&mut gains.yaw);
        gains.pedal_per_collective = self.pedal_per_collective;
        self.roll_pitch.put(&mut gains.roll_pitch);
        self.attitude.put(&mut gains.attitude);
        gains
    }
}
