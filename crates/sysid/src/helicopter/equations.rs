//! Parametrised hover dynamics of a small helicopter, from yaw alone to Mettler's 13 states.
//!
//! States and inputs have the names of a flight record. The states are u, v, w, m/s; p, q, r, rad/s; phi, theta, rad.
//! The inputs are lateral, longitudinal, collective and pedal, −1…1 about trim. Derivatives are in SI, per unit stick.
//! Every structure is continuous in time.
//!
//! # Source
//! Paw (2005), *System identification and control system design for a model helicopter in hover*, NTU,
//! doi:10.32657/10356/47095, equations 3.39–3.57 and section 5.6.1.3. Mettler, Tischler and Kanade (2002), *J. AHS*
//! 47(1), the R-50.

use super::kind::Kind;
use super::velocity_error::{SlowError, VelocityError};
use crate::methods::structure::{Parameter, Structure};

/// Row of a parameter table: name, unit, initial value, lower and upper limit. The initial values are round numbers of
/// a 60-class helicopter.
type Row = (&'static str, &'static str, f64, f64, f64);

/// Parameters of yaw.
const YAW: &[Row] = &[("Nr", "1/s", -5.0, -60.0, 5.0), ("Nped", "rad/s²", 20.0, -500.0, 500.0)];
/// Yaw due to collective and side velocity.
const YAW_COUPLING: &[Row] =
    &[("Ncol", "rad/s²", 0.0, -200.0, 200.0), ("Nv", "rad/(s m)", 0.0, -10.0, 10.0)];
/// Parameters of heave.
const HEAVE: &[Row] = &[("Zw", "1/s", -0.7, -10.0, 5.0), ("Zcol", "m/s²", -15.0, -500.0, 500.0)];
/// Damping of forward and side velocity.
const TRANSLATION: &[Row] = &[("Xu", "1/s", -0.05, -5.0, 5.0), ("Yv", "1/s", -0.1, -5.0, 5.0)];
/// Roll and pitch moments due to speed.
const SPEED_MOMENTS: &[Row] = &[
    ("Lu", "rad/(s m)", 0.0, -10.0, 10.0),
    ("Lv", "rad/(s m)", 0.0, -10.0, 10.0),
    ("Mu", "rad/(s m)", 0.0, -10.0, 10.0),
    ("Mv", "rad/(s m)", 0.0, -10.0, 10.0),
];
/// Parameters of roll and pitch without flapping states.
const REDUCED: &[Row] = &[
    ("Lp", "1/s", -10.0, -100.0, 10.0),
    ("Lq", "1/s", 0.0, -100.0, 100.0),
    ("Mp", "1/s", 0.0, -100.0, 100.0),
    ("Mq", "1/s", -8.0, -100.0, 10.0),
    ("Llat", "rad/s²", 20.0, -500.0, 500.0),
    ("Llon", "rad/s²", 0.0, -500.0, 500.0),
    ("Mlat", "rad/s²", 0.0, -500.0, 500.0),
    ("Mlon", "rad/s²", -15.0, -500.0, 500.0),
    ("Xlat", "m/s²", 0.0, -100.0, 100.0),
    ("Xlon", "m/s²", 0.0, -100.0, 100.0),
    ("Ylat", "m/s²", 0.0, -100.0, 100.0),
    ("Ylon", "m/s²", 0.0, -100.0, 100.0),
];
/// Parameters of first-order flapping. Equation 3.39 contains Ba, equation 3.40 Ab. The hub moments La and Mb are
/// omitted, because Lb and Ma with the cross-coupling of the flapping are equivalent.
const FLAPPING: &[Row] = &[
    ("tau_f", "s", 0.1, 0.01, 1.0),
    ("Ab", "", 0.0, -5.0, 5.0),
    ("Ba", "", 0.0, -5.0, 5.0),
    ("Alon", "rad", 0.2, -5.0, 5.0),
    ("Blat", "rad", 0.2, -5.0, 5.0),
    ("Lb", "1/s²", 120.0, 5.0, 1000.0),
    ("Ma", "1/s²", 80.0, 5.0, 1000.0),
];
/// Parameters of the stabiliser bar. Its tilts c and d turn the swashplate by Ac and Bd. Ac = Bd = 0 means no bar.
const BAR: &[Row] = &[
    ("Ac", "", 0.0, -2.0, 2.0),
    ("Bd", "", 0.0, -2.0, 2.0),
    ("tau_s", "s", 0.25, 0.05, 1.0),
    ("Clon", "rad", 0.0, -2.0, 2.0),
    ("Dlat", "rad", 0.0, -2.0, 2.0),
];
/// Parameters of Mettler's R-50. Initial values from Mettler, Tischler and Kanade (2002), table 2, feet converted to
/// metres.
const R50: &[Row] = &[
    ("Xu", "1/s", -0.050_46, -2.0, 2.0),
    ("Xa", "m/s²", -9.814_56, -50.0, 0.0),
    ("Yv", "1/s", -0.1539, -2.0, 2.0),
    ("Yb", "m/s²", 9.814_56, 0.0, 50.0),
    ("Lu", "rad/(s m)", -0.471_457, -10.0, 10.0),
    ("Lv", "rad/(s m)", 0.469_816, -10.0, 10.0),
    ("Lb", "1/s²", 166.1, 10.0, 1000.0),
    ("Mu", "rad/(s m)", -0.184_088, -10.0, 10.0),
    ("Mv", "rad/(s m)", -0.191_929, -10.0, 10.0),
    ("Ma", "1/s²", 82.57, 10.0, 1000.0),
    ("tau_f", "s", 0.046_31, 0.005, 0.5),
    ("Ab", "", -0.1892, -5.0, 5.0),
    ("Ac", "", 0.6439, -5.0, 5.0),
    ("Ba", "", 0.3681, -5.0, 5.0),
    ("Bd", "", 0.7103, -5.0, 5.0),
    ("Za", "m/s²", -2.971_19, -200.0, 200.0),
    ("Zb", "m/s²", -39.989_8, -200.0, 200.0),
    ("Zw", "1/s", -0.6141, -5.0, 5.0),
    ("Zr", "m/s", 0.283_555, -10.0, 10.0),
    ("Nv", "rad/(s m)", 0.098_753, -10.0, 10.0),
    ("Np", "1/s", -3.525, -50.0, 50.0),
    ("Nw", "rad/(s m)", 0.281_102, -10.0, 10.0),
    ("Nr", "1/s", -4.129, -50.0, 10.0),
    ("Kr", "1/s", 2.163, 0.01, 50.0),
    ("Krfb", "1/s", -8.258, -100.0, 0.0),
    ("tau_s", "s", 0.3415, 0.05, 5.0),
    ("Alat", "rad", 0.031_27, -5.0, 5.0),
    ("Alon", "rad", -0.1004, -5.0, 5.0),
    ("Blat", "rad", 0.1398, -5.0, 5.0),
    ("Blon", "rad", 0.0138, -5.0, 5.0),
    ("Zcol", "m/s²", -13.972, -500.0, 500.0),
    ("Nped", "rad/s²", 33.07, 0.1, 500.0),
    ("Ncol", "rad/s²", -3.329, -200.0, 200.0),
    ("Clon", "rad", -0.2587, -5.0, 5.0),
    ("Dlat", "rad", 0.2731, -5.0, 5.0),
];

/// Range of the delay from a stick sample to the sensor sample that shows the response, s. The delay is negative where
/// a stick is recorded after it moved. A movement between samples is recorded half a period late. Each stick has its
/// own delay, because the position of a step between two samples is random.
const DELAY_LIMITS_S: (f64, f64) = (-0.03, 0.2);
/// Delays of the cyclic sticks.
const CYCLIC_DELAY: &[Row] = &[
    ("tau_lat", "s", 0.005, DELAY_LIMITS_S.0, DELAY_LIMITS_S.1),
    ("tau_lon", "s", 0.005, DELAY_LIMITS_S.0, DELAY_LIMITS_S.1),
];
/// Delay of the collective.
const COLLECTIVE_DELAY: &[Row] = &[("tau_col", "s", 0.005, DELAY_LIMITS_S.0, DELAY_LIMITS_S.1)];
/// Delay of the pedal.
const PEDAL_DELAY: &[Row] = &[("tau_ped", "s", 0.005, DELAY_LIMITS_S.0, DELAY_LIMITS_S.1)];

/// Time constant of the horizontal gusts, first-order Gauss–Markov on each axis. MIL-F-8785C gives a turbulence scale
/// of 67 m at a height of 10 m. The wind carries the turbulence past the vehicle at a few m/s.
const GUST: &[Row] = &[("tau_gust", "s", 15.0, 0.5, 100.0)];
/// Time constant of the vertical gusts. MIL-F-8785C gives a turbulence scale of 10 m at a height of 10 m.
const VERTICAL_GUST: &[Row] = &[("tau_gust_w", "s", 3.0, 0.3, 30.0)];

/// Range of the servo time constants, s: first-order lags, typically with corners from 5 to 13 Hz.
const SERVO_LAG: (f64, f64) = (0.0, 0.1);
/// Servo lags of the cyclic sticks.
const CYCLIC_LAG: &[Row] = &[
    ("lag_lat", "s", 0.005, SERVO_LAG.0, SERVO_LAG.1),
    ("lag_lon", "s", 0.005, SERVO_LAG.0, SERVO_LAG.1),
];
/// Servo lag of the collective.
const COLLECTIVE_LAG: &[Row] = &[("lag_col", "s", 0.005, SERVO_LAG.0, SERVO_LAG.1)];
/// Servo lag of the pedal.
const PEDAL_LAG: &[Row] = &[("lag_ped", "s", 0.005, SERVO_LAG.0, SERVO_LAG.1)];

/// Prior values of a hovering helicopter of a few kilograms: value and one sigma.
///
/// Zw of a hovering rotor is −2 a A_b ρ ΩR λ / ((16 λ + a s) m): −0.6 to −1 1/s for models with a rotor of 1 to 2 m. A
/// wind of some m/s increases the magnitude by up to half. The other derivatives are small, of either sign.
///
/// # Source
/// Padfield, *Helicopter Flight Dynamics*, section 4.3.3; Mettler, Tischler and Kanade (2002), table 2;
/// Gavrilets, Mettler and Feron (2003), MIT LIDS P-2580.
const EXPECTED: [(&str, f64, f64); 11] = [
    ("Zw", -0.8, 0.25),
    ("Xu", -0.08, 0.08),
    ("Yv", -0.15, 0.1),
    ("Lu", 0.0, 0.2),
    ("Lv", 0.0, 0.2),
    ("Mu", 0.0, 0.2),
    ("Mv", 0.0, 0.2),
    ("lag_lat", 0.005, 0.012),
    ("lag_lon", 0.005, 0.012),
    ("lag_col", 0.005, 0.012),
    ("lag_ped", 0.005, 0.012),
];
/// Correlation time of the error of the measured horizontal velocity. Its value comes from the estimator.
const VELOCITY_ERROR: &[Row] = &[("tau_vh", "s", 5.0, 0.01, 1000.0)];
/// Correlation time of the error of the measured vertical velocity. Its value comes from the estimator.
const VERTICAL_VELOCITY_ERROR: &[Row] = &[("tau_vv", "s", 5.0, 0.01, 1000.0)];

/// Heave equation. In all equations the effect of gusts on an axis is a slow acceleration of its own, dp to dw. The
/// response to a gust can then exceed what the derivative predicts, and no gust grows as its derivative vanishes. The
/// terms ku, kv, kw, kphi and ktheta are those that rigid-body kinematics add to the linear equations. They are known
/// from the flight.
///
/// A horizontal gust also adds lift, dl, as slowly as the gust itself. It acts on roll and pitch by tilting the disc.
/// In models with flapping, dp and dq are therefore rates of tilt. As accelerations they would act faster than any
/// rotor, and the identified rotor would be too fast.
const HEAVE_EQUATIONS: &str = "
    w' = Zw*w + Zcol*collective + kw + dw + dl";
/// Gusts that act on heave.
const VERTICAL_GUST_EQUATION: &str = "
    dw' = -dw/tau_gust_w + n_dw
    dl' = -dl/tau_gust + n_dl";
/// Yaw equation.
const YAW_EQUATION: &str = "
    r' = Nr*r + Nped*pedal + Ncol*collective + Nv*v + dr + n_r";
/// Gust that acts on yaw.
const YAW_GUST_EQUATION: &str = "
    dr' = -dr/tau_gust + n_dr";
/// Kinematics of roll and pitch.
const ATTITUDE_EQUATIONS: &str = "
    phi' = p + kphi
    theta' = q + ktheta";
/// Gusts that act on roll, pitch and horizontal velocity.
const GUST_EQUATIONS: &str = "
    dp' = -dp/tau_gust + n_dp
    dq' = -dq/tau_gust + n_dq
    du' = -du/tau_gust + n_du
    dv' = -dv/tau_gust + n_dv";
/// Horizontal velocity with its error. The error of a smoothed velocity varies as slowly as the blend of accelerometers
/// and GPS.
const VELOCITY_EQUATIONS: &str = "
    eu' = -eu/tau_vh + n_eu
    ev' = -ev/tau_vh + n_ev
    u = u + eu
    v = v + ev";
/// Vertical velocity with its error.
const VERTICAL_VELOCITY_EQUATIONS: &str = "
    ew' = -ew/tau_vv + n_ew
    w = w + ew";
/// Roll, pitch and horizontal velocity without flapping states.
const REDUCED_EQUATIONS: &str = "
    p' = Lp*p + Lq*q + Lu*u + Lv*v + Llat*lateral + Llon*longitudinal + dp + n_p
    q' = Mp*p + Mq*q + Mu*u + Mv*v + Mlat*lateral + Mlon*longitudinal + dq + n_q
    u' = Xu*u - 9.81*theta + Xlat*lateral + Xlon*longitudinal + ku + du
    v' = Yv*v + 9.81*phi + Ylat*lateral + Ylon*longitudinal + kv + dv";
/// Flapping, stabiliser bar, roll, pitch and horizontal velocity.
const HYBRID_EQUATIONS: &str = "
    b' = -b/tau_f - p + Ba/tau_f*a + Bd/tau_f*d + Blat/tau_f*lateral + dp
    a' = -a/tau_f - q + Ab/tau_f*b + Ac/tau_f*c + Alon/tau_f*longitudinal + dq
    c' = -q - c/tau_s + Clon/tau_s*longitudinal
    d' = -p - d/tau_s + Dlat/tau_s*lateral
    p' = Lu*u + Lv*v + Lb*b + n_p
    q' = Mu*u + Mv*v + Ma*a + n_q
    u' = Xu*u - 9.81*theta - 9.81*a + ku + du
    v' = Yv*v + 9.81*phi + 9.81*b + kv + dv";
/// Process noises of roll, pitch and horizontal velocity.
const CYCLIC_NOISE: &str = "n_p n_q n_dp n_dq n_du n_dv n_eu n_ev";
/// Mettler's equations of the R-50.
const R50_EQUATIONS: &str = "
    inputs  lateral longitudinal pedal collective
    outputs u v w p q r phi theta
    noise   n_u n_v n_p n_q n_w n_r
    u' = Xu*u - 9.81456*theta + Xa*a + n_u
    v' = Yv*v + 9.81456*phi + Yb*b + n_v
    p' = Lu*u + Lv*v + Lb*b + n_p
    q' = Mu*u + Mv*v + Ma*a + n_q
    phi' = p
    theta' = q
    a' = -q - a/tau_f + Ab/tau_f*b + Ac/tau_f*c + Alat/tau_f*lateral + Alon/tau_f*longitudinal
    b' = -p - b/tau_f + Ba/tau_f*a + Bd/tau_f*d + Blat/tau_f*lateral + Blon/tau_f*longitudinal
    w' = Za*a + Zb*b + Zw*w + Zr*r + Zcol*collective + n_w
    r' = Nv*v + Np*p + Nw*w + Nr*r - Nped*rfb + Nped*pedal + Ncol*collective + n_r
    rfb' = Kr*r + Krfb*rfb
    c' = -q - c/tau_s + Clon/tau_s*longitudinal
    d' = -p - d/tau_s + Dlat/tau_s*lateral";

impl Kind {
    /// The parametrised model. Initial values and limits suit model helicopters with a rotor of 1 to 2 m.
    #[must_use]
    pub fn structure(self) -> Structure {
        structure(self)
    }

    /// Initial σ of each process noise of [`Kind::structure`]. Gusts and unmodelled dynamics are accelerations per
    /// sample of `period_s`; the noise of the velocity error starts at half the σ that explains `error`.
    #[must_use]
    pub fn process_sigma(self, error: &VelocityError, period_s: f64) -> Vec<f64> {
        let of = |noise: &String| match noise.as_str() {
            "n_p" | "n_q" | "n_r" => 0.3,
            // This noise is a rate of tilt. A rotor turns it into an angular acceleration at least ten times as large.
            "n_dp" | "n_dq" if matches!(self, Self::Flapping | Self::Hybrid) => 0.01,
            "n_dp" | "n_dq" | "n_du" | "n_dv" | "n_dl" | "n_dr" => 0.5,
            "n_dw" => 1.0,
            "n_eu" | "n_ev" => DRIVEN * error.horizontal.drive(period_s),
            "n_ew" => DRIVEN * error.vertical.drive(period_s),
            _ => 0.2,
        };
        self.structure().noises.iter().map(of).collect()
    }

    /// Outputs whose noise is fixed instead of estimated, with its σ, rad and m/s.
    ///
    /// An estimator's attitude is the integral of its gyros, noise included. If it had its own precision, it would
    /// imply rates without noise. With a much larger σ the attitude only contributes the direction of gravity, and the
    /// rates determine the dynamics. A velocity with a slow `error` has hardly any white noise. Its σ is a small
    /// fraction of the slow error's change within a sample of `period_s`.
    #[must_use]
    pub fn held_sigma(self, error: &VelocityError, period_s: f64) -> Vec<(String, f64)> {
        let white = |error: &SlowError| WHITE * error.drive(period_s) * period_s;
        let (horizontal, vertical) = (white(&error.horizontal), white(&error.vertical));
        let held = match self {
            Self::Yaw | Self::R50 => vec![],
            Self::Heave => vec![("w", vertical)],
            Self::RollPitch | Self::Flapping => {
                vec![("phi", 0.02), ("theta", 0.02), ("u", horizontal), ("v", horizontal)]
            }
            Self::Hybrid | Self::Hover => vec![
                ("phi", 0.02),
                ("theta", 0.02),
                ("u", horizontal),
                ("v", horizontal),
                ("w", vertical),
            ],
        };
        let known = |(name, _): &(&str, f64)| *error != VelocityError::NONE || name.len() > 1;
        held.into_iter().filter(known).map(|(name, sigma)| (name.to_owned(), sigma)).collect()
    }
}

/// Initial σ of the noise that drives the error of a smoothed velocity, as a fraction of the σ for the whole error. A
/// smoother counts vibration as noise, but notches have removed it from these data. With too large a σ the likelihood
/// assigns the helicopter's motion to the measurement error.
const DRIVEN: f64 = 0.5;
/// σ of the white part of a smoothed velocity's error, in units of the slow error's change within a sample.
const WHITE: f64 = 0.03;

/// Parameters that are fixed at their initial values.
const HELD: [&str; 4] = ["tau_gust", "tau_gust_w", "tau_vh", "tau_vv"];

/// Parameters that are never dropped: the main effect of each stick, its delay, and the damping of its axis.
const NEEDED: [&str; 20] = [
    "Zcol", "Nped", "Blat", "Alon", "Llat", "Mlon", "tau_lat", "tau_lon", "tau_col", "tau_ped",
    "tau_f", "Lb", "Ma", "Lp", "Mq", "Nr", "Zw", "Xu", "Yv", "Clon",
];

/// Upper limits of process noises, by name: σ as an acceleration per sample of `period_s`. The error of the vertical
/// velocity is at most as large as `error`, the value of the smoother. A smoother counts vibration as noise, so its
/// value is too large for data without vibration. Without the limit the likelihood has a second optimum: gusts count as
/// velocity errors, and the collective acts too weakly and too late.
pub(super) fn largest_process_sigma(error: &VelocityError, period_s: f64) -> Vec<(String, f64)> {
    vec![("n_ew".to_owned(), error.vertical.drive(period_s))]
}

fn structure(kind: Kind) -> Structure {
    let slow = [SPEED_MOMENTS, TRANSLATION];
    let air = [GUST, VELOCITY_ERROR];
    let cyclic = |rows: &[&'static [Row]], text: &str| -> (Vec<&[Row]>, String) {
        let text = format!(
            "inputs lateral longitudinal ku kv kphi ktheta\noutputs p q phi theta u v\n\
             noise {CYCLIC_NOISE}\noffsets p q u v\n\
             delay lateral tau_lat\ndelay longitudinal tau_lon\n\
             lag lateral lag_lat\nlag longitudinal lag_lon\n\
             {text}{ATTITUDE_EQUATIONS}{GUST_EQUATIONS}{VELOCITY_EQUATIONS}"
        );
        ([rows, &slow, &[CYCLIC_DELAY, CYCLIC_LAG], &air].concat(), text)
    };
    let whole = |rows: &[&'static [Row]], text: &str| -> (Vec<&[Row]>, String) {
        let text = format!(
            "inputs lateral longitudinal collective pedal ku kv kw kphi ktheta\n\
             outputs p q phi theta u v w r\n\
             noise {CYCLIC_NOISE} n_dw n_dl n_ew n_r n_dr\noffsets p q u v w r\n\
             delay lateral tau_lat\ndelay longitudinal tau_lon\n\
             delay collective tau_col\ndelay pedal tau_ped\n\
             lag lateral lag_lat\nlag longitudinal lag_lon\n\
             lag collective lag_col\nlag pedal lag_ped\n\
             {text}{ATTITUDE_EQUATIONS}{HEAVE_EQUATIONS}{YAW_EQUATION}{GUST_EQUATIONS}\
             {VERTICAL_GUST_EQUATION}{YAW_GUST_EQUATION}\
             {VELOCITY_EQUATIONS}{VERTICAL_VELOCITY_EQUATIONS}"
        );
        let rest = [HEAVE, YAW, YAW_COUPLING, CYCLIC_DELAY, COLLECTIVE_DELAY, PEDAL_DELAY];
        let lags = [CYCLIC_LAG, COLLECTIVE_LAG, PEDAL_LAG];
        let vertical = [VERTICAL_GUST, VERTICAL_VELOCITY_ERROR];
        ([rows, &slow, &rest, &lags, &air, &vertical].concat(), text)
    };
    let (rows, text): (Vec<&[Row]>, String) = match kind {
        // Both sticks pass through the same electronics to similar servos. Yaw alone contains little information about
        // the collective's delay, so the collective shares the pedal's delay and lag.
        Kind::Yaw => (
            vec![YAW, YAW_COUPLING, PEDAL_DELAY, PEDAL_LAG, GUST],
            format!(
                "inputs collective pedal v\noutputs r\nnoise n_r n_dr\noffsets r\n\
                 delay collective tau_ped\nlag collective lag_ped\n\
                 delay pedal tau_ped\nlag pedal lag_ped\n{YAW_EQUATION}{YAW_GUST_EQUATION}"
            ),
        ),
        Kind::Heave => (
            vec![
                HEAVE,
                COLLECTIVE_DELAY,
                COLLECTIVE_LAG,
                GUST,
                VERTICAL_GUST,
                VERTICAL_VELOCITY_ERROR,
            ],
            format!(
                "inputs collective kw\noutputs w\nnoise n_dw n_dl n_ew\noffsets w\n\
                 delay collective tau_col\nlag collective lag_col\n\
                 {HEAVE_EQUATIONS}{VERTICAL_GUST_EQUATION}{VERTICAL_VELOCITY_EQUATIONS}"
            ),
        ),
        Kind::RollPitch => cyclic(&[REDUCED], REDUCED_EQUATIONS),
        Kind::Flapping => cyclic(&[FLAPPING, BAR], HYBRID_EQUATIONS),
        Kind::Hybrid => whole(&[FLAPPING, BAR], HYBRID_EQUATIONS),
        Kind::Hover => whole(&[REDUCED], REDUCED_EQUATIONS),
        Kind::R50 => (vec![R50], R50_EQUATIONS.into()),
    };
    let parameters = rows
        .concat()
        .iter()
        .map(|&(name, unit, start, lower, upper)| {
            let parameter = Parameter::new(name, unit, start).within(lower, upper);
            let is_bar = kind != Kind::R50 && BAR.iter().any(|row| row.0 == name);
            let parameter = if is_bar { parameter.held() } else { parameter };
            // A flight of minutes cannot separate the time constant from the noise that it filters.
            let parameter = if HELD.contains(&name) { parameter.held() } else { parameter };
            let parameter = match EXPECTED.iter().find(|(known, ..)| *known == name) {
                Some(&(_, value, sigma)) if kind != Kind::R50 => parameter.expected(value, sigma),
                _ => parameter,
            };
            if NEEDED.contains(&name) { parameter.needed() } else { parameter }
        })
        .collect();
    match Structure::new(kind.name(), parameters, &text) {
        Ok(structure) => structure,
        Err(error) => unreachable!("the equations above are constant: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::methods::prediction_error::{Settings, identify};
    use crate::record::Experiment;

    #[test]
    fn a_still_collective_leaves_the_pedals_delay_to_be_found() {
        let is_held = |structure: &Structure| {
            let delay = structure.parameter("tau_ped").expect("it has one");
            structure.parameters[delay].fixed
        };
        let structure = Kind::Yaw.structure().with_still("collective");
        assert!(!is_held(&structure));
        assert!(is_held(&structure.with_still("pedal")));
    }

    /// A step response with collective and pedal both delayed by a sample, as from one computer.
    #[test]
    fn torque_that_comes_as_late_as_the_pedal_does_not_slow_the_yaw() {
        const PERIOD_S: f64 = 0.03;
        const DAMPING: f64 = -20.0;
        let decay = f64::exp(DAMPING * PERIOD_S);
        let stepped = |sample: usize, every: usize| {
            if (sample / every).is_multiple_of(2) { 0.1 } else { -0.1 }
        };
        let (collective, pedal) = (|at| stepped(at, 37), |at| stepped(at, 50));
        let mut rate = 0.0;
        let outputs = DMatrix::from_fn(1000, 1, |sample, _| {
            let measured: f64 = rate + 0.002 * ((sample * sample) as f64 * 0.618).fract();
            let late = sample.saturating_sub(1);
            let driven = 40.0 * pedal(late) - 9.0 * collective(late);
            rate = decay * rate + (decay - 1.0) / DAMPING * driven;
            measured
        });
        let inputs = DMatrix::from_fn(1000, 3, |sample, input| match input {
            0 => collective(sample),
            1 => pedal(sample),
            _ => 0.0,
        });
        let names = ["collective", "pedal", "v"].map(str::to_owned).to_vec();
        let record = Experiment::new("yaw", PERIOD_S, names, vec!["r".to_owned()], inputs, outputs)
            .expect("finite numbers");
        let settings =
            Settings::innovations(Kind::Yaw.process_sigma(&VelocityError::NONE, PERIOD_S));
        let structure = Kind::Yaw.structure().with_still("v");
        let found = identify(&structure, &[record], &settings).expect("it is identifiable");
        for (name, expected) in [("Nr", DAMPING), ("Nped", 40.0), ("Ncol", -9.0)] {
            let value = found.estimates.get(name).expect("it has one").value;
            assert!((value / expected - 1.0).abs() < 0.03, "{name}: {value}, not {expected}");
        }
    }
}
