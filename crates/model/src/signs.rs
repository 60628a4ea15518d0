//! Signs of derivatives that are the same for every helicopter.

use std::fmt;

use super::state_space::StateSpace;

/// A derivative that has the same sign on every helicopter in hover.
///
/// Signs of sticks are those of `controls.csv`: lateral to the right, collective up, pedal to the right. The
/// longitudinal stick has no common convention, so its derivatives are not included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownSign {
    /// Name of the parameter in an identified model.
    pub name: &'static str,
    /// The state whose derivative the parameter changes.
    pub row: &'static str,
    /// The state (entry of A) or the stick (entry of B) that the parameter multiplies.
    pub column: &'static str,
    /// Sign, 1 or −1.
    pub sign: f64,
    /// Kind of the derivative.
    pub role: DerivativeRole,
}

/// Kind of a derivative with a known sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DerivativeRole {
    /// Control derivative. The text describes the response to a positive stick if the sign is wrong.
    Stick(&'static str),
    /// Moment on the fuselage due to rotor tilt. The text describes the effect if the sign is wrong.
    Rotor(&'static str),
    /// Damping of an axis.
    Damping,
}

/// Control derivatives: name, row, stick, sign, and the response to a positive stick if the sign is wrong.
const STICK: [(&str, &str, &str, f64, &str); 4] = [
    ("Zcol", "w", "collective", -1.0, "sinks"),
    ("Nped", "r", "pedal", 1.0, "turns to the left"),
    ("Blat", "b", "lateral", 1.0, "rolls to the left"),
    ("Llat", "p", "lateral", 1.0, "rolls to the left"),
];
/// Moments due to rotor tilt: name, row, column, and the effect if the sign is wrong. The correct sign is positive.
const ROTOR: [(&str, &str, &str, &str); 2] = [
    ("Lb", "p", "b", "a rotor tilted to the right rolls it to the left"),
    ("Ma", "q", "a", "a rotor tilted backwards pitches it down"),
];
/// Damping derivatives: name and state. The correct sign is negative.
const DAMPING: [(&str, &str); 6] =
    [("Zw", "w"), ("Nr", "r"), ("Xu", "u"), ("Yv", "v"), ("Lp", "p"), ("Mq", "q")];

/// Beginning of the text that reports a wrong sign of a control or rotor derivative.
const WRONG: &str = "of the wrong sign: ";

impl KnownSign {
    /// Distance from zero, in sigma, beyond which the sign of a derivative is certain.
    pub const SIGMAS: f64 = 2.0;
    /// Largest positive damping derivative, 1/s, that errors of the identification can explain.
    pub const UNDAMPED_PER_S: f64 = 1.0;

    /// All derivatives with a known sign.
    pub fn all() -> impl Iterator<Item = Self> {
        let stick = STICK.into_iter().map(|(name, row, column, sign, does)| {
            let role = DerivativeRole::Stick(does);
            Self { name, row, column, sign, role }
        });
        let rotor = ROTOR.into_iter().map(|(name, row, column, does)| {
            let role = DerivativeRole::Rotor(does);
            Self { name, row, column, sign: 1.0, role }
        });
        let damping = DAMPING.into_iter().map(|(name, state)| {
            let role = DerivativeRole::Damping;
            Self { name, row: state, column: state, sign: -1.0, role }
        });
        stick.chain(rotor).chain(damping)
    }

    /// The known sign of the parameter `name`, if any.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        Self::all().find(|known| known.name == name)
    }

    /// Text that reports the wrong sign. In a verdict it follows the value.
    #[must_use]
    pub fn objection(&self) -> String {
        match self.role {
            DerivativeRole::Stick(does) => {
                let stick = self.column;
                format!("{WRONG}with a positive {stick} stick it {does}")
            }
            DerivativeRole::Rotor(does) => format!("{WRONG}{does}"),
            DerivativeRole::Damping => "on every helicopter in hover it is below 0".into(),
        }
    }

    /// Whether `value`, with one-sigma `sigma`, has the wrong sign with certainty. A damping of the wrong sign always
    /// counts, without regard to `sigma`.
    fn is_against(&self, value: f64, sigma: f64) -> bool {
        let doubt = if self.role == DerivativeRole::Damping { 0.0 } else { Self::SIGMAS * sigma };
        self.sign * value < -doubt
    }
}

/// A derivative of a model with an impossible sign.
#[derive(Clone, Debug, PartialEq)]
pub struct WrongSign {
    /// The derivative and its known sign.
    pub known: KnownSign,
    /// Value found, in the model's units.
    pub value: f64,
    /// Location of the value in the model: the parameters or a matrix entry.
    place: String,
}

impl fmt::Display for WrongSign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { known, value, place } = self;
        let expected = if known.sign > 0.0 { "above 0" } else { "below 0" };
        let name = known.name;
        let objection = known.objection();
        let objection = objection.strip_prefix(WRONG).unwrap_or(&objection);
        write!(f, "{place}: found {name} {value}, expected it {expected}: {objection}")
    }
}

impl StateSpace {
    /// Derivatives with an impossible sign that the verdict in the model does not report, for example after an edit by
    /// hand. A parameter is judged with its covariance. A matrix entry without a parameter is judged by its value; a
    /// damping of the wrong sign is then accepted up to [`KnownSign::UNDAMPED_PER_S`]. An entry of B is judged only if
    /// the unit of the stick is `stick`: its sign is that of a flight record. In a model in percent the source defines
    /// the sign of the sticks.
    #[must_use]
    pub fn wrong_signs(&self) -> Vec<WrongSign> {
        let found = KnownSign::all().filter(|known| !self.mentions(known));
        found.filter_map(|known| self.against(known)).collect()
    }

    /// Whether the verdict in the model already reports the wrong sign of `known`.
    fn mentions(&self, known: &KnownSign) -> bool {
        let begin = format!("{} is ", known.name);
        let objection = match known.role {
            // The full text differs between model files; all versions contain these words.
            DerivativeRole::Damping => "below 0".to_owned(),
            _ => known.objection(),
        };
        self.verdict().is_some_and(|verdict| {
            let mut reasons = verdict.reasons.iter();
            reasons.any(|reason| reason.starts_with(&begin) && reason.contains(&objection))
        })
    }

    fn against(&self, known: KnownSign) -> Option<WrongSign> {
        let named = self.parameters().iter().position(|own| own.name == known.name);
        let mut least =
            if known.role == DerivativeRole::Damping { KnownSign::UNDAMPED_PER_S } else { 0.0 };
        if let Some(at) = named {
            let value = self.parameters()[at].value;
            let sigma = self.covariance().map_or(0.0, |covariance| covariance[(at, at)].sqrt());
            if known.is_against(value, sigma) {
                return Some(WrongSign { known, value, place: "parameters".into() });
            }
            // If the sign of the parameter is uncertain, so is the sign of its matrix entry.
            if known.sign * value < 0.0 {
                return None;
            }
            least = 0.0;
        }
        let row = self.state(known.row).ok()?;
        let (matrix, value) = match (self.state(known.column), self.input(known.column)) {
            (Ok(column), _) => ("A", self.a()[(row, column)]),
            (_, Ok(column)) if self.inputs()[column].unit == "stick" => {
                ("B", self.b()[(row, column)])
            }
            _ => return None,
        };
        let place = || format!("{matrix}, row {}, column {}", known.row, known.column);
        (known.sign * value < -least).then(|| WrongSign { known, value, place: place() })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::{Grade, Parameter, Verdict, shipped};

    fn named(model: &StateSpace) -> Vec<&'static str> {
        model.wrong_signs().iter().map(|wrong| wrong.known.name).collect()
    }

    #[test]
    fn no_shipped_model_has_a_wrong_sign() {
        for model in [shipped::raptor60(), shipped::mettler_r50(), shipped::thesis()] {
            assert_eq!(model.wrong_signs(), []);
        }
    }

    #[test]
    fn every_known_sign_is_missed_in_a_matrix_where_it_is_turned() {
        for known in KnownSign::all() {
            let model = shipped::raptor60();
            let (mut a, mut b) = (model.a().clone(), model.b().clone());
            let row = model.state(known.row).unwrap();
            // The value is far beyond zero, because with flapping some of the damping is in other entries.
            let turned = -3.0 * known.sign;
            match model.state(known.column) {
                Ok(column) => a[(row, column)] = turned,
                Err(_) => b[(row, model.input(known.column).unwrap())] = turned,
            }
            let (states, inputs) = (model.states().to_vec(), model.inputs().to_vec());
            let model = StateSpace::new("turned", model.time(), states, inputs, a, b).unwrap();
            assert_eq!(named(&model), [known.name]);
        }
    }

    #[test]
    fn a_parameter_is_of_the_wrong_sign_beyond_its_doubt_and_where_no_verdict_reported_it() {
        let with = |name: &str, value: f64, sigma: f64| {
            let parameter = Parameter { name: name.into(), value, unit: "rad/s²".into() };
            let covariance = DMatrix::from_element(1, 1, sigma * sigma);
            shipped::raptor60().with_parameters(vec![parameter], Some(covariance)).unwrap()
        };
        assert_eq!(named(&with("Nped", -20.0, 11.0)), [""; 0]);
        assert_eq!(named(&with("Nr", 0.5, 11.0)), ["Nr"]);
        let wrong = with("Nped", -20.0, 9.0);
        let words = wrong.wrong_signs()[0].to_string();
        let expected = "parameters: found Nped -20, expected it above 0: with a positive pedal stick it turns to \
                        the left";
        assert_eq!(words, expected);
        let verdict = |reason: &str| Verdict { grade: Grade::Care, reasons: vec![reason.into()] };
        let told = "Nped is -20.000 ± 9.000 rad/s², of the wrong sign: with a positive pedal stick it turns to the left. Is";
        assert_eq!(named(&wrong.clone().with_verdict(verdict(told))), [""; 0]);
        let other = verdict("Nped is -20.000 ± 9.000 rad/s², known to 45 % only");
        assert_eq!(named(&wrong.with_verdict(other)), ["Nped"]);
    }
}
