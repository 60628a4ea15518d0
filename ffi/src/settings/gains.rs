//! Gains of the autopilot, from a design for the vehicle.

use hovernav::autopilot as core;

use super::mirror;

/// Gains of a PID controller. Each gain has the unit of the command divided by the unit of the error, combined with s
/// as its name states.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct PidGains {
    /// Proportional gain: command per error.
    pub proportional: f64,
    /// Integral gain: command per error and second.
    pub integral_per_s: f64,
    /// Derivative gain, s: command per rate of change of the measured value.
    pub derivative_s: f64,
    /// Time constant of the low-pass on the derivative, s; 0 or more.
    pub derivative_filter_s: f64,
    /// Anti-windup time constant, s, with which the integral follows a limited command; above 0.
    pub tracking_time_s: f64,
}

/// Gains of the yaw regulator. The measured states are r and psi; there are two hidden states.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct YawGains {
    /// Gain from each measured state to the stick, one row per control.
    pub measured: [[f64; 2]; 1],
    /// Gain from each hidden state to the stick, one row per control.
    pub hidden: [[f64; 2]; 1],
    /// Gain from the pending command, sent in the last sample, to the stick.
    pub pending: [[f64; 1]; 1],
    /// Gain from the time integral of each measured state's error to the stick, per s.
    pub integral_per_s: [[f64; 2]; 1],
    /// Gain from each hidden state before a sample to each one after it, one row per hidden state after it.
    pub hidden_from_hidden: [[f64; 2]; 2],
    /// Gain from each measured state before a sample to each hidden state after it.
    pub hidden_from_measured: [[f64; 2]; 2],
    /// Gain from each command that acted during a sample to each hidden state after it.
    pub hidden_from_pending: [[f64; 1]; 2],
    /// Anti-windup time constant, s, with which the integrals follow a limited command.
    pub tracking_time_s: f64,
}

/// Gains of the roll and pitch regulator. The measured states are p, q, phi, theta, u, v; there are six hidden states.
/// The controls are lateral and longitudinal cyclic.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RollPitchGains {
    /// Gain from each measured state to the stick, one row per control.
    pub measured: [[f64; 6]; 2],
    /// Gain from each hidden state to the stick, one row per control.
    pub hidden: [[f64; 6]; 2],
    /// Gain from the pending command, sent in the last sample, to the stick.
    pub pending: [[f64; 2]; 2],
    /// Gain from the time integral of each measured state's error to the stick, per s.
    pub integral_per_s: [[f64; 6]; 2],
    /// Gain from each hidden state before a sample to each one after it, one row per hidden state after it.
    pub hidden_from_hidden: [[f64; 6]; 6],
    /// Gain from each measured state before a sample to each hidden state after it.
    pub hidden_from_measured: [[f64; 6]; 6],
    /// Gain from each command that acted during a sample to each hidden state after it.
    pub hidden_from_pending: [[f64; 2]; 6],
    /// Anti-windup time constant, s, with which the integrals follow a limited command.
    pub tracking_time_s: f64,
}

/// Gains of the attitude regulator, for flight without a known velocity. The measured states are p, q, phi, theta.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AttitudeGains {
    /// Gain from each measured state to the stick, one row per control.
    pub measured: [[f64; 4]; 2],
    /// Gain from each hidden state to the stick, one row per control.
    pub hidden: [[f64; 6]; 2],
    /// Gain from the pending command, sent in the last sample, to the stick.
    pub pending: [[f64; 2]; 2],
    /// Gain from the time integral of each measured state's error to the stick, per s.
    pub integral_per_s: [[f64; 4]; 2],
    /// Gain from each hidden state before a sample to each one after it, one row per hidden state after it.
    pub hidden_from_hidden: [[f64; 6]; 6],
    /// Gain from each measured state before a sample to each hidden state after it.
    pub hidden_from_measured: [[f64; 4]; 6],
    /// Gain from each command that acted during a sample to each hidden state after it.
    pub hidden_from_pending: [[f64; 2]; 6],
    /// Anti-windup time constant, s, with which the integrals follow a limited command.
    pub tracking_time_s: f64,
}

/// Gains of the autopilot, for the sample period of their design.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Gains {
    /// Gains from the downward velocity w, body axes, to collective.
    pub heave: PidGains,
    /// Gains from r, psi to pedal.
    pub yaw: YawGains,
    /// Gain from collective to pedal, which compensates the yaw caused by collective.
    pub pedal_per_collective: f64,
    /// Gains from p, q, phi, theta, u, v to cyclic.
    pub roll_pitch: RollPitchGains,
    /// Gains from p, q, phi, theta to cyclic, for flight without a known velocity.
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
