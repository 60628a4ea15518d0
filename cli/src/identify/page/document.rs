//! The page of an identification as a whole.

use hovernav_dataset::Dataset;
use hovernav_model::ModelError;
use hovernav_sysid::helicopter::{FrequencyDomain, Identification, IdentifyError};
use hovernav_sysid::methods::frequency::FrequencyError;

use super::held::compared;
use super::histories::{histories, residuals, runs_of};
use super::parameters::{fits, parameters};
use super::poles::poles;
use super::responses::{responses, second_opinion};
use hovernav_pages::{Fact, Page, Section, Verdict};

/// The contents of the page of an identification.
pub struct IdentificationPage<'a> {
    pub title: &'a str,
    pub facts: &'a [Fact],
    pub headlines: &'a [Fact],
    pub warnings: &'a [String],
    pub verdict: Verdict,
    pub dataset: &'a Dataset,
    pub found: &'a Identification,
    /// The identification from held GPS velocity, or the reason for its failure, where requested.
    pub held: Option<Result<&'a Identification, &'a IdentifyError>>,
    /// The identification in the frequency domain, or the reason for its failure.
    pub frequency: Result<&'a FrequencyDomain, &'a FrequencyError>,
}

impl<'a> IdentificationPage<'a> {
    /// Builds the page.
    ///
    /// # Errors
    /// If the computation of the poles does not converge.
    pub fn build(&self) -> Result<Page<'a>, ModelError> {
        let found = self.found;
        let compared_with = self.held.and_then(Result::ok);
        let mut sections = vec![parameters(found, compared_with), second_opinion(self.frequency)];
        let fit = found.fit();
        let (title, points) = match found.validation {
            Some(_) => ("Validation", "validation test points, which the search did not use"),
            None => ("Fit", "the test points of the search, because validation has no others"),
        };
        let runs = runs_of(found);
        let explanation = format!(
            "Over {points}. The model runs freely for {:.1} s at a time from its own initial state, \
             with the sticks as its only input. The offsets are those of the test point.",
            fit.window_s()
        );
        let section = Section::new("histories", title, explanation);
        let section = histories(self.dataset, found, &runs).fold(section, Section::with);
        sections.push(section.folded("Flight and model over each test point"));
        sections.push(residuals(found, &runs).folded("Flight minus model over each test point"));
        sections.push(responses(self.frequency));
        sections.push(poles(found, compared_with)?);
        sections.extend(self.held.map(|held| {
            let section = compared(self.dataset, found, held);
            section.folded("Both fits, and the flight as the receiver measured it")
        }));
        Ok(Page {
            verdict: Some(self.verdict.clone()),
            title: self.title,
            headlines: self.headlines,
            warnings: self.warnings,
            facts: self.facts,
            table: Some(fits(found, compared_with)),
            sections,
            time: None,
        })
    }
}
