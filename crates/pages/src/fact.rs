//! Facts in words and numbers.

/// A label and its value, plain text with unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    /// The quantity.
    pub label: String,
    /// Its value, with the unit.
    pub value: String,
}

impl Fact {
    /// A fact from any displayable value.
    #[must_use]
    pub fn new(label: &str, value: impl ToString) -> Self {
        Self { label: label.into(), value: value.to_string() }
    }
}

/// A number with four significant digits; a dash if unknown.
#[must_use]
pub fn digits(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    if value.abs() < 1e-4 {
        return format!("{value:.2e}");
    }
    let whole_digits = value.abs().log10().floor();
    format!("{value:.*}", (3.0 - whole_digits).clamp(0.0, 7.0) as usize)
}
