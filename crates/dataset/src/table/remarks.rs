//! Defects of a file that do not make it unusable, counted by kind.

/// Remark on a row with the time of the row before it.
pub(crate) const REPEATED: &str = "skipped: same time as the row before";

/// Counts defective rows by kind, for one sentence a kind instead of one a row.
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
    /// Remarks on `file`; every warning begins with that name.
    #[must_use]
    pub fn new(file: impl Into<String>) -> Self {
        Self { file: file.into(), place: "line", tallies: Vec::new(), others: Vec::new() }
    }

    /// Remarks on a binary `file`, counted by byte offset instead of line.
    #[must_use]
    pub fn of_bytes(file: impl Into<String>) -> Self {
        Self { place: "byte", ..Self::new(file) }
    }

    /// Unit of the positions: `line` or `byte`.
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

    /// Adds a separate sentence.
    pub fn say(&mut self, sentence: String) {
        self.others.push(sentence);
    }

    /// All sentences, each beginning with the file's name.
    pub fn into_warnings(self) -> impl Iterator<Item = String> {
        let Self { file, place, .. } = self;
        let tallies =
            self.tallies.into_iter().map(move |Tally { what, rows, first_line }| match rows {
                1 => format!("{place} {first_line} {what}"),
                _ => format!("{rows} rows, the first at {place} {first_line}, {what}"),
            });
        tallies.chain(self.others).map(move |sentence| format!("{file}: {sentence}"))
    }

    /// All counts in one sentence, for an error.
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
