//! What was wrong with a file yet not bad enough to refuse it, counted by reason.

/// Counts rows by what was wrong with them, for one sentence a kind and not one a row.
#[derive(Debug)]
pub struct Remarks {
    file: String,
    place: &'static str,
    tallies: Vec<Tally>,
    others: Vec<String>,
}

#[derive(Debug)]
struct Tally {
    what: &'static str,
    rows: usize,
    first_line: u64,
}

impl Remarks {
    /// About `file`, the name that every warning begins with.
    #[must_use]
    pub fn new(file: impl Into<String>) -> Self {
        Self { file: file.into(), place: "line", tallies: Vec::new(), others: Vec::new() }
    }

    /// About `file`, which has bytes and no lines.
    #[must_use]
    pub fn of_bytes(file: impl Into<String>) -> Self {
        Self { place: "byte", ..Self::new(file) }
    }

    /// What rows are counted by: `line` or `byte`.
    pub(crate) const fn place(&self) -> &'static str {
        self.place
    }

    /// Counts the row at `line` under `what`, which completes "3 rows, the first at line 7, …".
    pub fn count(&mut self, what: &'static str, line: u64) {
        match self.tallies.iter_mut().find(|tally| tally.what == what) {
            Some(tally) => {
                tally.rows += 1;
                tally.first_line = tally.first_line.min(line);
            }
            None => self.tallies.push(Tally { what, rows: 1, first_line: line }),
        }
    }

    /// Adds a sentence of its own.
    pub fn say(&mut self, sentence: String) {
        self.others.push(sentence);
    }

    /// Everything said, each line beginning with the file's name.
    pub fn into_warnings(self) -> impl Iterator<Item = String> {
        let Self { file, place, .. } = self;
        let tallies =
            self.tallies.into_iter().map(move |Tally { what, rows, first_line }| match rows {
                1 => format!("{place} {first_line} {what}"),
                _ => format!("{rows} rows, the first at {place} {first_line}, {what}"),
            });
        tallies.chain(self.others).map(move |sentence| format!("{file}: {sentence}"))
    }

    /// Everything counted so far in one sentence, for an error.
    #[must_use]
    pub fn summary(&self) -> String {
        let parts: Vec<String> = self
            .tallies
            .iter()
            .map(|tally| format!("{} rows {}", tally.rows, tally.what))
            .collect();
        parts.join("; ")
    }
}
