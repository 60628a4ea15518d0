//! `--columns`: additional columns of `solution.csv`.

use std::str::FromStr;

use hovernav_dataset::ExtraColumns;

/// A group of columns, by name.
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

/// The requested groups, without duplicates, in the order of [`ExtraColumns::ALL`].
pub fn of(arguments: &[ColumnsArgument]) -> Vec<ExtraColumns> {
    let asked = |extra: &ExtraColumns| arguments.iter().any(|argument| argument.0 == *extra);
    ExtraColumns::ALL.into_iter().filter(asked).collect()
}
