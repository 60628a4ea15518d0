//! Stability margins of a loop.

use std::f64::consts::PI;
use std::sync::OnceLock;

use nalgebra::{Complex, DMatrix};

use super::arguments::check;
use super::curve::{Curve, Peak};
use super::error::DesignError;
use super::response::logarithmic_frequencies;
use hovernav_model::linalg::{complex, eigenvalues};
use hovernav_model::{FrequencySweep, Signal, StateSpace, TimeDomain};

/// A loop with negative feedback, broken at some signals. L is the response from the signals injected at the break to
/// minus the returning signals. It has as many outputs as inputs.
#[derive(Clone, Debug)]
pub struct Loop {
    open: StateSpace,
    /// The loop prepared for many frequencies, at its first use.
    sweep: OnceLock<FrequencySweep>,
}

impl PartialEq for Loop {
    fn eq(&self, other: &Self) -> bool {
        self.open == other.open
    }
}

/// A margin and its frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The frequency, rad/s.
    pub frequency_radps: f64,
    /// The margin: a gain factor, or a phase in rad.
    pub margin: f64,
}

/// Margins of one channel, with the loop broken there and all other channels closed.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelMargins {
    /// Name of the channel.
    pub name: String,
    /// Factor above one by which the gain may increase; `None` for an unlimited increase.
    pub gain_up: Option<Crossing>,
    /// Factor below one by which the gain may decrease; `None` for a decrease to zero.
    pub gain_down: Option<Crossing>,
    /// Smallest phase change, of either sign, that destabilises the loop, rad; `None` where the loop gain never equals
    /// one.
    pub phase: Option<Crossing>,
    /// Smallest additional delay that destabilises the loop, s.
    pub delay_s: Option<f64>,
    /// Disturbance rejection bandwidth, rad/s: the frequency at which the channel's sensitivity first rises through −3
    /// dB. Slower disturbances are attenuated.
    pub disturbance_rejection_bandwidth_radps: Option<f64>,
}

impl ChannelMargins {
    /// The smaller of the two gain margins, dB; infinite without a gain margin.
    #[must_use]
    pub fn smallest_gain_db(&self) -> f64 {
        let crossings = [self.gain_up, self.gain_down].into_iter().flatten();
        crossings.map(|crossing| crossing.margin_db().abs()).fold(f64::INFINITY, f64::min)
    }

    /// The phase margin, °; infinite without a phase margin.
    #[must_use]
    pub fn phase_deg(&self) -> f64 {
        self.phase.map_or(f64::INFINITY, |phase| phase.margin.to_degrees())
    }
}

impl Crossing {
    /// The gain factor in dB.
    #[must_use]
    pub fn margin_db(&self) -> f64 {
        20.0 * self.margin.log10()
    }
}

/// All margins of a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Margins {
    /// Margins of each channel.
    pub channels: Vec<ChannelMargins>,
    /// Disk margin α for simultaneous changes of all channels. The loop stays stable if each channel is multiplied by
    /// any factor (1 + αδ/2)/(1 − αδ/2) with |δ| < 1. The value is a lower bound from diagonal scaling.
    pub disk: Peak,
    /// Maximum singular value of the sensitivity (I + L)⁻¹.
    pub sensitivity: Peak,
    /// Maximum singular value of the complementary sensitivity L(I + L)⁻¹.
    pub complementary: Peak,
}

impl Margins {
    /// Factors between which all gains may vary simultaneously according to the disk margin.
    #[must_use]
    pub fn disk_gain(&self) -> [f64; 2] {
        let alpha = self.disk.value;
        let highest = if alpha < 2.0 { (2.0 + alpha) / (2.0 - alpha) } else { f64::INFINITY };
        [((2.0 - alpha) / (2.0 + alpha)).max(0.0), highest]
    }

    /// Phase, rad, by which all channels may vary simultaneously according to the disk margin.
    #[must_use]
    pub fn disk_phase_rad(&self) -> f64 {
        2.0 * (0.5 * self.disk.value).atan()
    }
}

/// Gain factor, 120 dB, above which a gain margin counts as unlimited. An integral has infinite gain at zero frequency,
/// so the value computed there is only rounding error.
const ANY_GAIN: f64 = 1e6;
/// Number of points of the first search over frequency.
const GRID: usize = 1500;

/// (I + L)⁻¹ at a frequency.
type Sensitivity = DMatrix<Complex<f64>>;

impl Loop {
    /// The loop of `plant` under state feedback u = −K x, broken at the plant's inputs; `gain` is m×n.
    ///
    /// # Errors
    /// [`DesignError::Shape`] and [`DesignError::NotFinite`].
    pub fn state_feedback(plant: &StateSpace, gain: &DMatrix<f64>) -> Result<Self, DesignError> {
        let m = plant.inputs().len();
        check("gain", gain, m, plant.states().len())?;
        let outputs = plant.inputs().to_vec();
        let open = plant.clone().with_outputs(outputs, gain.clone(), DMatrix::zeros(m, m))?;
        Ok(Self::cut(open))
    }

    /// The loop of `plant` under a `controller` with u = −(controller) y, broken at the plant's inputs.
    ///
    /// # Errors
    /// [`DesignError::Shape`] where the numbers of inputs and outputs do not match, [`DesignError::Model`] where the
    /// two are in different time domains.
    pub fn at_plant_input(
        plant: &StateSpace,
        controller: &StateSpace,
    ) -> Result<Self, DesignError> {
        Ok(Self::cut(series(plant, controller)?))
    }

    fn cut(open: StateSpace) -> Self {
        Self { open, sweep: OnceLock::new() }
    }

    /// The loop broken at the plant's outputs, for disturbance rejection.
    ///
    /// # Errors
    /// As [`Loop::at_plant_input`].
    pub fn at_plant_output(
        plant: &StateSpace,
        controller: &StateSpace,
    ) -> Result<Self, DesignError> {
        Ok(Self::cut(series(controller, plant)?))
    }

    /// The open loop L.
    #[must_use]
    pub fn open(&self) -> &StateSpace {
        &self.open
    }

    /// Eigenvalues of the closed loop.
    ///
    /// # Errors
    /// [`DesignError::Singular`] where I + D is singular.
    pub fn closed_poles(&self) -> Result<Vec<Complex<f64>>, DesignError> {
        let m = self.open.inputs().len();
        let around = (DMatrix::identity(m, m) + self.open.d()).lu();
        let back = around.solve(self.open.c()).ok_or(DesignError::Singular { matrix: "I + D" })?;
        Ok(eigenvalues(&(self.open.a() - self.open.b() * back))?)
    }

    /// Whether every mode of the closed loop decays.
    ///
    /// # Errors
    /// As [`closed_poles`](Self::closed_poles).
    pub fn is_stable(&self) -> Result<bool, DesignError> {
        Ok(self.closed_poles()?.iter().all(|pole| self.is_damped(pole)))
    }

    /// Whether the mode of this pole decays; false for NaN.
    fn is_damped(&self, pole: &Complex<f64>) -> bool {
        match self.open.time() {
            TimeDomain::Continuous => pole.re < 0.0,
            TimeDomain::Discrete { .. } => pole.norm() < 1.0,
        }
    }

    /// The loop broken at its input `name` only, with every other channel closed. It has one input and one output.
    ///
    /// # Errors
    /// [`ModelError::Unknown`](hovernav_model::ModelError::Unknown), and [`DesignError::Singular`] where
    /// the other channels cannot be closed.
    pub fn channel(&self, name: &str) -> Result<StateSpace, DesignError> {
        let open = &self.open;
        let own = open.input(name)?;
        let others: Vec<usize> = (0..open.inputs().len()).filter(|&other| other != own).collect();
        let direct =
            |rows: &[usize], columns: &[usize]| open.d().select_rows(rows).select_columns(columns);
        // The other channels have the inputs u = −y, with y their own outputs. Solved for u: u = −back x − through
        // u_own.
        let around =
            (DMatrix::identity(others.len(), others.len()) + direct(&others, &others)).lu();
        let singular = DesignError::Singular { matrix: "I + D" };
        let back = around.solve(&open.c().select_rows(&others)).ok_or(singular)?;
        let singular = DesignError::Singular { matrix: "I + D" };
        let through = around.solve(&direct(&others, &[own])).ok_or(singular)?;
        let onto = open.b().select_columns(&others);
        let across = direct(&[own], &others);
        let input = vec![open.inputs()[own].clone()];
        let a = open.a() - &onto * &back;
        let b = open.b().select_columns(&[own]) - onto * &through;
        let c = open.c().select_rows(&[own]) - &across * back;
        let d = direct(&[own], &[own]) - across * through;
        let states = open.states().to_vec();
        let channel = StateSpace::new(name, open.time(), states, input, a, b)?;
        Ok(channel.with_outputs(vec![open.outputs()[own].clone()], c, d)?)
    }

    /// All margins of the loop.
    ///
    /// The search uses a logarithmic grid from a hundredth of the slowest mode to a hundred times the fastest. For a
    /// discrete loop it ends at the Nyquist frequency. The results are then refined.
    ///
    /// # Errors
    /// [`DesignError::UnstableLoop`] where the closed loop is unstable and has no margins.
    ///
    /// # Source
    /// Equation (L14) of docs/equations.md.
    pub fn margins(&self) -> Result<Margins, DesignError> {
        let poles = self.closed_poles()?;
        if let Some(pole) = poles.iter().find(|pole| !self.is_damped(pole)) {
            return Err(DesignError::UnstableLoop { re: pole.re, im: pole.im });
        }
        let grid = self.grid(&poles)?;
        let curve = Curve::new(&grid, |frequency| self.sensitivity(frequency));
        let channels = (0..self.open.inputs().len())
            .map(|channel| self.channel_margins(channel, &curve))
            .collect();
        let sensitivity = curve.peak(largest_singular_value);
        let complementary = curve.peak(|s| largest_singular_value(&(identity(s) - s)));
        // (S − T)/2, whose structured singular value is the inverse of the disk margin.
        let half = Complex::new(0.5, 0.0);
        let size = curve.peak(|s| scaled_singular_value(&(s - identity(s) * half)));
        let disk = Peak { frequency_radps: size.frequency_radps, value: 1.0 / size.value };
        Ok(Margins { channels, disk, sensitivity, complementary })
    }

    /// Smallest gain margin, dB, and phase margin, °, over all channels. Uses `points` frequencies between 0.05 rad/s
    /// and the Nyquist frequency (100 rad/s for a continuous loop). Fast, and accurate to a degree.
    #[must_use]
    pub fn weakest(&self, points: usize) -> (f64, f64) {
        let highest = match self.open.time() {
            TimeDomain::Continuous => 100.0,
            TimeDomain::Discrete { period_s } => PI / period_s,
        };
        let grid = logarithmic_frequencies(0.05, 0.999 * highest, points);
        let seen: Vec<_> = grid.iter().filter_map(|&at| self.sensitivity(at)).collect();
        let (mut gain_db, mut phase_deg) = (f64::INFINITY, f64::INFINITY);
        for channel in 0..self.open.inputs().len() {
            let value = |s: &DMatrix<Complex<f64>>| s[(channel, channel)].inv() - Complex::ONE;
            for pair in seen.windows(2) {
                let (before, after) = (value(&pair[0]), value(&pair[1]));
                // Linear interpolation of the logarithm of the magnitude and of the angle from −1.
                let (low, high) = (before.norm().ln(), after.norm().ln());
                let (lag, later) = ((-before).arg(), (-after).arg());
                if (low < 0.0) != (high < 0.0) {
                    let part = low / (low - high);
                    let there = (-(before + (after - before) * part)).arg();
                    phase_deg = phase_deg.min(there.abs().to_degrees());
                }
                if (lag < 0.0) != (later < 0.0) && (lag - later).abs() < PI {
                    let part = lag / (lag - later);
                    let there = low + part * (high - low);
                    gain_db = gain_db.min(there.abs() * 20.0 / std::f64::consts::LN_10);
                }
            }
        }
        (gain_db, phase_deg)
    }

    fn grid(&self, closed: &[Complex<f64>]) -> Result<Vec<f64>, DesignError> {
        let open = eigenvalues(self.open.a())?;
        let speeds = open.iter().chain(closed).filter_map(|&pole| {
            let speed = match self.open.time() {
                TimeDomain::Continuous => pole.norm(),
                TimeDomain::Discrete { period_s } if pole.norm() > 1e-6 => {
                    pole.ln().norm() / period_s
                }
                TimeDomain::Discrete { .. } => return None,
            };
            (speed > 1e-6).then_some(speed)
        });
        let (slowest, fastest) = speeds.fold((f64::INFINITY, 0.0), |(low, high), speed| {
            (f64::min(low, speed), f64::max(high, speed))
        });
        let (slowest, fastest) = if fastest > 0.0 { (slowest, fastest) } else { (1.0, 1.0) };
        let highest = match self.open.time() {
            TimeDomain::Continuous => 100.0 * fastest,
            TimeDomain::Discrete { period_s } => PI / period_s,
        };
        Ok(logarithmic_frequencies((0.01 * slowest).min(0.1 * highest), highest, GRID))
    }

    /// (I + L)⁻¹ at a frequency.
    pub(super) fn sensitivity(&self, frequency_radps: f64) -> Option<Sensitivity> {
        let sweep = self.sweep.get_or_init(|| self.open.linear().sweep());
        let mut around = sweep.at(frequency_radps)?;
        for index in 0..around.nrows() {
            around[(index, index)] += Complex::ONE;
        }
        around.try_inverse()
    }

    /// Margins of one channel, with all other channels closed.
    ///
    /// # Source
    /// Equation (L13) of docs/equations.md.
    fn channel_margins(
        &self,
        channel: usize,
        curve: &Curve<'_, Sensitivity, impl Fn(f64) -> Option<Sensitivity>>,
    ) -> ChannelMargins {
        // With the other channels closed, the loop at this channel is 1/S − 1.
        let seen = |s: &Sensitivity| s[(channel, channel)].inv() - Complex::ONE;
        let mut margins = ChannelMargins {
            name: self.open.inputs()[channel].name.clone(),
            gain_up: None,
            gain_down: None,
            phase: None,
            delay_s: None,
            disturbance_rejection_bandwidth_radps: None,
        };
        let mut note_gain = |frequency_radps: f64, value: Complex<f64>| {
            if value.re >= 0.0 {
                return;
            }
            let crossing = Crossing { frequency_radps, margin: -1.0 / value.re };
            if !(1.0 / ANY_GAIN..=ANY_GAIN).contains(&crossing.margin) {
                return;
            }
            if crossing.margin >= 1.0 {
                if margins.gain_up.is_none_or(|known| crossing.margin < known.margin) {
                    margins.gain_up = Some(crossing);
                }
            } else if margins.gain_down.is_none_or(|known| crossing.margin > known.margin) {
                margins.gain_down = Some(crossing);
            }
        };
        // At zero and the Nyquist frequency the loop is real by symmetry. It touches the real axis there without
        // crossing it.
        let nyquist = match self.open.time() {
            TimeDomain::Continuous => None,
            TimeDomain::Discrete { period_s } => Some(PI / period_s),
        };
        for frequency in [Some(0.0), nyquist].into_iter().flatten() {
            if let Some(value) = curve.at(frequency).as_ref().map(seen)
                && value.im.abs() <= 1e-6 * value.norm()
            {
                note_gain(frequency, value);
            }
        }
        for frequency in curve.zeros(|s| seen(s).im) {
            if let Some(s) = curve.at(frequency) {
                note_gain(frequency, seen(&s));
            }
        }
        for frequency_radps in curve.zeros(|s| seen(s).norm().ln()) {
            let Some(s) = curve.at(frequency_radps) else { continue };
            let value = seen(&s);
            let lag = (-value).arg();
            let crossing = Crossing { frequency_radps, margin: lag.abs() };
            if margins.phase.is_none_or(|known| crossing.margin < known.margin) {
                margins.phase = Some(crossing);
            }
            let delay_s = lag.rem_euclid(2.0 * PI) / frequency_radps;
            if margins.delay_s.is_none_or(|known| delay_s < known) {
                margins.delay_s = Some(delay_s);
            }
        }
        let rejection = |s: &Sensitivity| s[(channel, channel)].norm().ln() + 0.5 * 2f64.ln();
        if curve.first().is_some_and(|s| rejection(s) < 0.0) {
            margins.disturbance_rejection_bandwidth_radps = curve.zeros(rejection).first().copied();
        }
        margins
    }
}

/// `first`, then `second`, in series: outputs are connected to inputs by order, not by name.
fn series(first: &StateSpace, second: &StateSpace) -> Result<StateSpace, DesignError> {
    match first.time() {
        TimeDomain::Continuous => second.require_continuous()?,
        TimeDomain::Discrete { period_s } => {
            let other = second.require_discrete()?;
            if (other - period_s).abs() > 1e-9 * period_s {
                let expected = "the same period on both sides of the loop";
                return Err(DesignError::Range { name: "period_s", value: other, expected });
            }
        }
    }
    let (n, k) = (first.states().len(), second.states().len());
    let (m, between, p) = (first.inputs().len(), first.outputs().len(), second.outputs().len());
    check("input matrix of the second", second.b(), k, between)?;
    check("direct matrix of the second", second.d(), m, between)?;
    let mut a = DMatrix::zeros(n + k, n + k);
    a.view_mut((0, 0), (n, n)).copy_from(first.a());
    a.view_mut((n, 0), (k, n)).copy_from(&(second.b() * first.c()));
    a.view_mut((n, n), (k, k)).copy_from(second.a());
    let mut b = DMatrix::zeros(n + k, m);
    b.view_mut((0, 0), (n, m)).copy_from(first.b());
    b.view_mut((n, 0), (k, m)).copy_from(&(second.b() * first.d()));
    let mut c = DMatrix::zeros(p, n + k);
    c.view_mut((0, 0), (p, n)).copy_from(&(second.d() * first.c()));
    c.view_mut((0, n), (p, k)).copy_from(second.c());
    let states = first
        .states()
        .iter()
        .map(|state| Signal::new(&format!("first_{}", state.name), &state.unit))
        .chain(
            second
                .states()
                .iter()
                .map(|state| Signal::new(&format!("second_{}", state.name), &state.unit)),
        )
        .collect();
    let joined =
        StateSpace::new(first.name(), first.time(), states, first.inputs().to_vec(), a, b)?
            .with_outputs(second.outputs().to_vec(), c, second.d() * first.d())?;
    Ok(joined)
}

fn identity(like: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    complex(&DMatrix::identity(like.nrows(), like.ncols()))
}

fn largest_singular_value(matrix: &DMatrix<Complex<f64>>) -> f64 {
    matrix.singular_values().iter().copied().fold(0.0, f64::max)
}

/// Approximate minimum over diagonal D of the largest singular value of DMD⁻¹. It is an upper bound of the structured
/// singular value for independent perturbations of the channels.
///
/// # Source
/// Osborne's scaling, as used by Safonov 1982.
fn scaled_singular_value(matrix: &DMatrix<Complex<f64>>) -> f64 {
    let mut scaled = matrix.clone();
    let size = scaled.nrows();
    for _ in 0..10 {
        for index in 0..size {
            let others = || (0..size).filter(|&other| other != index);
            let column: f64 = others().map(|other| scaled[(other, index)].norm_sqr()).sum();
            let row: f64 = others().map(|other| scaled[(index, other)].norm_sqr()).sum();
            if column > 0.0 && row > 0.0 {
                let factor = Complex::from((row / column).powf(0.25));
                scaled.row_mut(index).iter_mut().for_each(|value| *value /= factor);
                scaled.column_mut(index).iter_mut().for_each(|value| *value *= factor);
            }
        }
    }
    largest_singular_value(&scaled).min(largest_singular_value(matrix))
}
