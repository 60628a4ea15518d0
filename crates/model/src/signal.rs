//! Names and units of states, inputs and outputs.

use super::error::ModelError;

/// The name and unit of a state, an input or an output.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct Signal {
    /// Name, for example `p` or `lateral`.
    pub name: String,
    /// Unit, for example `rad/s` or `stick`.
    pub unit: String,
}

impl Signal {
    /// A signal of this name and unit.
    #[must_use]
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }
}

pub(super) fn position(
    list: &'static str,
    signals: &[Signal],
    name: &str,
) -> Result<usize, ModelError> {
    signals.iter().position(|signal| signal.name == name).ok_or_else(|| ModelError::Unknown {
        list,
        name: name.into(),
        known: signals.iter().map(|signal| signal.name.as_str()).collect::<Vec<_>>().join(", "),
    })
}

pub(super) fn check_names(list: &'static str, signals: &[Signal]) -> Result<(), ModelError> {
    check_unique(list, signals.iter().map(|signal| signal.name.as_str()))
}

pub(super) fn check_unique<'a>(
    list: &'static str,
    names: impl Iterator<Item = &'a str>,
) -> Result<(), ModelError> {
    let mut seen = std::collections::HashSet::new();
    for name in names {
        let found = match name.trim().is_empty() {
            true => "empty",
            false if !seen.insert(name) => "twice",
            false => continue,
        };
        return Err(ModelError::Name { list, name: name.into(), found });
    }
    Ok(())
}
