//! One parameter, or the fit of one response, by both methods of identification.

/// Largest difference between the two methods that chance explains, in sigma.
const APART: f64 = 3.0;

/// One parameter as identified by both methods.
#[derive(Debug, Clone, PartialEq)]
pub struct SideBySide {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value and bound, one sigma, in the time domain.
    pub time: (f64, f64),
    /// Value and bound, one sigma, in the frequency domain.
    pub frequency: (f64, f64),
}

impl SideBySide {
    /// Difference of the two values, in sigma of both together.
    #[must_use]
    pub fn apart(&self) -> f64 {
        (self.time.0 - self.frequency.0).abs() / self.time.1.hypot(self.frequency.1)
    }

    /// Whether the difference is larger than chance allows.
    #[must_use]
    pub fn disagrees(&self) -> bool {
        self.apart() > APART
    }

    /// Both values, in words.
    pub(super) fn in_words(&self) -> String {
        let Self { name, unit, time, frequency } = self;
        format!(
            "{name} is {:.3} ± {:.3} {unit} in the time domain and {:.3} ± {:.3} in the frequency domain, \
             {:.1} sigma apart",
            time.0,
            time.1,
            frequency.0,
            frequency.1,
            self.apart()
        )
    }
}

/// Cost J of both models, compared with the flight's response of one output to one stick.
#[derive(Debug, Clone, PartialEq)]
pub struct PairCost {
    /// The stick.
    pub stick: String,
    /// The output.
    pub output: String,
    /// Number of coherent frequencies.
    pub points: usize,
    /// Cost J of the model identified in the time domain.
    pub time: f64,
    /// Cost J of the model fitted to the responses.
    pub frequency: f64,
}
