//! `--columns`: what `solution.csv` has beyond its own columns.

use std::str::FromStr;

use hovernav_log::ExtraColumns;

/// Columns by their name.
#[derive(Clone, Copy)]
pub struct ColumnsArgument(ExtraColumns);

impl FromStr for ColumnsArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = ExtraColumns::ALL.into_iter().find(|extra| extra.name() == text);
        found.map(Self).ok_or_else(|| {
            format!(
                "found \"{text}\", expected {}",
                ExtraColumns::ALL.map(ExtraColumns::name).join(", ")
            )
        })
    }
}

/// What was asked for, each once and in the order of [`ExtraColumns::ALL`].
pub fn of(arguments: &[ColumnsArgument]) -> Vec<ExtraColumns> {
    let asked = |extra: &ExtraColumns| arguments.iter().any(|argument| argument.0 == *extra);
    ExtraColumns::ALL.into_iter().filter(asked).collect()
}
