//! The loops as they close: stability, and what each can stand at its actuator.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, DVector};

use super::HoverDesign;
use super::regulator::Plant;
use crate::autopilot::{Gains, PidGains, RegulatorGains};

/// The loop of one actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loop {
    /// Lateral cyclic.
    Lateral,
    /// Longitudinal cyclic.
    Longitudinal,
    /// Collective.
    Collective,
    /// Pedal.
    Pedal,
}

impl Loop {
    /// All four.
    pub const ALL: [Self; 4] = [Self::Lateral, Self::Longitudinal, Self::Collective, Self::Pedal];
}

/// What a loop can stand at its actuator, all other loops closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// By how much its gain may grow, dB; infinite where nothing limits it.
    pub gain_up_db: f64,
    /// By how much its gain may fall, dB; infinite where nothing limits it.
    pub gain_down_db: f64,
    /// By how much its phase may turn, °.
    pub phase_deg: f64,
    /// The highest frequency at which its gain is one, rad/s.
    pub crossover_radps: f64,
}

impl Margins {
    /// The smaller of the two gain margins, dB.
    #[must_use]
    pub fn gain_db(&self) -> f64 {
        self.gain_up_db.min(self.gain_down_db)
    }
}

/// Model, servos, delay and autopilot in one, when the autopilot holds velocity and heading.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    period_s: f64,
    /// Plant with servos and delay, by the four sticks.
    plant: DMatrix<f64>,
    from_sticks: DMatrix<f64>,
    /// The autopilot's own states, from themselves and from the plant's.
    own: DMatrix<f64>,
    own_from_plant: DMatrix<f64>,
    /// The sticks, from the autopilot's states and from the plant's.
    sticks_from_own: DMatrix<f64>,
    sticks_from_plant: DMatrix<f64>,
}

/// A controller's matrices: z⁺ = A z + B y, u = C z + D y.
struct Controller {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
}

impl ClosedLoop {
    pub(super) fn new(design: &HoverDesign, whole: &Plant, gains: &Gains) -> Self {
        let period_s = design.period_s;
        let servos_s = [design.servo_s, design.servo_s, design.servo_s, design.tail_servo_s];
        let (step, input) = whole.stepped(&servos_s, period_s);
        let moving = step.nrows();
        let size = moving + 4;
        let mut plant = DMatrix::zeros(size, size);
        plant.view_mut((0, 0), (moving, moving)).copy_from(&step);
        plant.view_mut((0, moving), (moving, 4)).copy_from(&input);
        let mut from_sticks = DMatrix::zeros(size, 4);
        from_sticks.view_mut((moving, 0), (4, 4)).fill_with_identity();

        let parts = [
            (
                regulator(&gains.roll_pitch, period_s),
                vec!["p", "q", "phi", "theta", "u", "v"],
                vec![0, 1],
            ),
            (pid(&gains.heave, period_s), vec!["w"], vec![2]),
            (regulator(&gains.yaw, period_s), vec!["r", "psi"], vec![3]),
        ];
        let states: usize = parts.iter().map(|(controller, ..)| controller.a.nrows()).sum();
        let mut own = DMatrix::zeros(states, states);
        let mut own_from_plant = DMatrix::zeros(states, size);
        let mut sticks_from_own = DMatrix::zeros(4, states);
        let mut sticks_from_plant = DMatrix::zeros(4, size);
        let mut first = 0;
        for (controller, measured, sticks) in &parts {
            let count = controller.a.nrows();
            own.view_mut((first, first), (count, count)).copy_from(&controller.a);
            for (column, name) in measured.iter().enumerate() {
                let from = whole.index(name);
                own_from_plant
                    .view_mut((first, from), (count, 1))
                    .copy_from(&controller.b.column(column));
                for (row, &stick) in sticks.iter().enumerate() {
                    sticks_from_plant[(stick, from)] = controller.d[(row, column)];
                }
            }
            for (row, &stick) in sticks.iter().enumerate() {
                sticks_from_own
                    .view_mut((stick, first), (1, count))
                    .copy_from(&controller.c.row(row));
            }
            first += count;
        }
        for sticks in [&mut sticks_from_own, &mut sticks_from_plant] {
            let more = sticks.row(2) * gains.pedal_per_collective;
            let pedal = sticks.row(3) + more;
            sticks.set_row(3, &pedal);
        }
        Self {
            period_s,
            plant,
            from_sticks,
            own,
            own_from_plant,
            sticks_from_own,
            sticks_from_plant,
        }
    }

    /// The step of everything, the sticks of the loops that are not in `closed` held at zero.
    fn step(&self, closed: [bool; 4]) -> DMatrix<f64> {
        let (n, own) = (self.plant.nrows(), self.own.nrows());
        let gate = DMatrix::from_diagonal(&DVector::from_row_slice(
            &closed.map(|closed| f64::from(u8::from(closed))),
        ));
        let through = &self.from_sticks * gate;
        let mut step = DMatrix::zeros(n + own, n + own);
        step.view_mut((0, 0), (n, n))
            .copy_from(&(&self.plant + &through * &self.sticks_from_plant));
        step.view_mut((0, n), (n, own)).copy_from(&(&through * &self.sticks_from_own));
        step.view_mut((n, 0), (own, n)).copy_from(&self.own_from_plant);
        step.view_mut((n, n), (own, own)).copy_from(&self.own);
        step
    }

    /// The largest modulus of a pole: below 1, every disturbance dies out.
    #[must_use]
    pub fn spectral_radius(&self) -> f64 {
        let poles = self.step([true; 4]).complex_eigenvalues();
        poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max)
    }

    /// Whether every disturbance dies out.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.spectral_radius() < 1.0
    }

    /// The margins of one loop, broken where its command goes to the actuator.
    ///
    /// Read off 2000 frequencies from 0.01 rad/s to the Nyquist frequency, with straight lines
    /// between them.
    #[must_use]
    pub fn margins(&self, of: Loop) -> Margins {
        let broken = of as usize;
        let step = self.step(std::array::from_fn(|stick| stick != broken));
        let (n, own) = (self.plant.nrows(), self.own.nrows());
        let mut input = DVector::zeros(n + own);
        input.rows_mut(0, n).copy_from(&self.from_sticks.column(broken));
        let mut output = DVector::zeros(n + own);
        output.rows_mut(0, n).tr_copy_from(&self.sticks_from_plant.row(broken));
        output.rows_mut(n, own).tr_copy_from(&self.sticks_from_own.row(broken));
        let response = Response::new(&step, &input, &output);

        let highest = 0.9995 * PI / self.period_s;
        let ratio = (highest / 0.01f64).powf(1.0 / 1999.0);
        let mut margins = Margins {
            gain_up_db: f64::INFINITY,
            gain_down_db: f64::INFINITY,
            phase_deg: f64::INFINITY,
            crossover_radps: 0.0,
        };
        let mut before: Option<Complex<f64>> = None;
        let mut frequency = 0.01;
        for _ in 0..2000 {
            // The loop's transfer with its sign turned: −1 is where it must not be.
            let now = -response.at(Complex::from_polar(1.0, frequency * self.period_s));
            if let Some(before) = before {
                margins.cross(before, now, frequency);
            }
            before = Some(now);
            frequency *= ratio;
        }
        margins
    }
}

impl Margins {
    fn cross(&mut self, before: Complex<f64>, now: Complex<f64>, frequency_radps: f64) {
        let (inside, outside) = (before.norm() - 1.0, now.norm() - 1.0);
        if inside * outside <= 0.0 && inside != outside {
            let at = before + (now - before) * (inside / (inside - outside));
            self.phase_deg = self.phase_deg.min((-at).arg().to_degrees().abs());
            self.crossover_radps = frequency_radps;
        }
        if before.im * now.im <= 0.0 && before.im != now.im {
            let real = before.re + (now.re - before.re) * before.im / (before.im - now.im);
            let db = -20.0 * (-real).log10();
            if real < -1.0 {
                self.gain_down_db = self.gain_down_db.min(-db);
            } else if real < 0.0 {
                self.gain_up_db = self.gain_up_db.min(db);
            }
        }
    }
}

/// c (zI − A)⁻¹ b at many z: A is brought to Hessenberg form once, so that each takes O(n²).
struct Response {
    step: DMatrix<f64>,
    input: DVector<f64>,
    output: DVector<f64>,
}

impl Response {
    fn new(step: &DMatrix<f64>, input: &DVector<f64>, output: &DVector<f64>) -> Self {
        let (basis, step) = step.clone().hessenberg().unpack();
        Self { step, input: basis.tr_mul(input), output: basis.tr_mul(output) }
    }

    fn at(&self, z: Complex<f64>) -> Complex<f64> {
        let n = self.step.nrows();
        let mut matrix = self.step.map(|value| Complex::new(-value, 0.0));
        for k in 0..n {
            matrix[(k, k)] += z;
        }
        let mut right = self.input.map(|value| Complex::new(value, 0.0));
        // Gauss with row exchanges; below the diagonal stands one entry a column.
        for k in 0..n.saturating_sub(1) {
            if matrix[(k + 1, k)].norm_sqr() > matrix[(k, k)].norm_sqr() {
                matrix.swap_rows(k, k + 1);
                right.swap_rows(k, k + 1);
            }
            let factor = matrix[(k + 1, k)] / matrix[(k, k)];
            for column in k..n {
                let above = matrix[(k, column)];
                matrix[(k + 1, column)] -= factor * above;
            }
            let above = right[k];
            right[k + 1] -= factor * above;
        }
        for k in (0..n).rev() {
            let mut value = right[k];
            for column in k + 1..n {
                value -= matrix[(k, column)] * right[column];
            }
            right[k] = value / matrix[(k, k)];
        }
        right.iter().zip(&self.output).map(|(x, c)| x * *c).sum()
    }
}

/// States: hidden, pending, integrals.
fn regulator<const Y: usize, const H: usize, const U: usize>(
    gains: &RegulatorGains<Y, H, U>,
    period_s: f64,
) -> Controller {
    let states = H + 2 * U;
    let mut c = DMatrix::zeros(U, states);
    let mut d = DMatrix::zeros(U, Y);
    for u in 0..U {
        for h in 0..H {
            c[(u, h)] = -gains.hidden[u][h];
        }
        for other in 0..U {
            c[(u, H + other)] = -gains.pending[u][other];
        }
        c[(u, H + U + u)] = 1.0;
        for y in 0..Y {
            d[(u, y)] = -gains.measured[u][y];
        }
    }
    let mut a = DMatrix::zeros(states, states);
    let mut b = DMatrix::zeros(states, Y);
    for h in 0..H {
        for other in 0..H {
            a[(h, other)] = gains.hidden_from_hidden[h][other];
        }
        for u in 0..U {
            a[(h, H + u)] = gains.hidden_from_pending[h][u];
        }
        for y in 0..Y {
            b[(h, y)] = gains.hidden_from_measured[h][y];
        }
    }
    a.view_mut((H, 0), (U, states)).copy_from(&c);
    b.view_mut((H, 0), (U, Y)).copy_from(&d);
    for u in 0..U {
        a[(H + U + u, H + U + u)] = 1.0;
        for y in 0..Y {
            b[(H + U + u, y)] = -gains.integral_per_s[u][y] * period_s;
        }
    }
    Controller { a, b, c, d }
}

/// States: integral, derivative, the measurement before.
fn pid(gains: &PidGains, period_s: f64) -> Controller {
    let per = 1.0 / (gains.derivative_filter_s + period_s);
    let keep = gains.derivative_filter_s * per;
    let slope = gains.derivative_s * per;
    Controller {
        a: DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 0.0, keep, slope, 0.0, 0.0, 0.0]),
        b: DMatrix::from_row_slice(3, 1, &[-gains.integral_per_s * period_s, -slope, 1.0]),
        c: DMatrix::from_row_slice(1, 3, &[1.0, keep, slope]),
        d: DMatrix::from_row_slice(1, 1, &[-gains.proportional - slope]),
    }
}
