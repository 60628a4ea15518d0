//! The frequency responses, and what they say of the parameters.

use hovernav_sysid::helicopter::{Basis, FrequencyDomain, PairCost, StickResponse};
use hovernav_sysid::methods::frequency::FrequencyError;

use crate::page::{Axis, Figure, Role, Row, Section, Series, Table, TableRow, digits};

/// Below this, a response is not worth fitting: Tischler and Remple, section 7.5.1.
const GOOD_COHERENCE: f64 = 0.6;

/// Both methods side by side.
pub fn second_opinion(frequency: Result<&FrequencyDomain, &FrequencyError>) -> Section {
    let section = Section::new(
        "second-opinion",
        "A second opinion: the frequency domain",
        "The same equations fitted anew to the flight\u{2019}s frequency responses, each with the other sticks \
         taken out. A parameter on which the two methods differ by more than three sigma is one that the flight \
         does not settle.",
    );
    let frequency = match frequency {
        Ok(frequency) => frequency,
        Err(error) => return section.with(vec![format!("There is none: {error}.")]),
    };
    let rests_on = match frequency.basis {
        Basis::Sticks => {
            "The responses rest on what the sticks did over the test points, which is right where nobody \
             answers gusts with them."
        }
        Basis::Injected => {
            "The responses rest on what was injected on the sticks beside whoever held the flight, over all \
             of it that is near a hover: what answers gusts does not disturb them."
        }
    };
    let mut notes = vec![rests_on.to_owned()];
    if !frequency.untold.is_empty() {
        let untold = frequency.untold.join(", ");
        notes.push(format!(
            "Not told by the responses, held as the time domain has them: {untold}."
        ));
    }
    section.with(both(frequency)).with(costs(frequency)).with(notes)
}

/// Flight and model from each stick to the output that answers to it.
pub fn responses(frequency: Result<&FrequencyDomain, &FrequencyError>) -> Section {
    let section = Section::new(
        "bode",
        "Frequency responses",
        "Amplification and phase from each stick to the output that answers to it, the other sticks taken out: \
         the flight, and the model found in the time domain, which never saw them. Where the coherence is low, \
         or the stick has no power of its own, believe neither.",
    );
    let responses = frequency.map(FrequencyDomain::stick_responses).unwrap_or_default();
    if responses.is_empty() {
        return section.with(vec!["There are none to show.".to_owned()]);
    }
    let section = section.folded("A figure for each stick");
    responses.iter().fold(section, |section, response| {
        let StickResponse { stick, output, unit, frequencies_hz, .. } = response;
        let points = |values: Vec<f64>| frequencies_hz.clone().into_iter().zip(values);
        let part = |curve: &[(f64, f64)], pick: fn(&(f64, f64)) -> f64| {
            points(curve.iter().map(pick).collect())
        };
        let spread = |sign: f64| -> Vec<f64> {
            let each = response.flight.iter().zip(&response.random_error);
            each.map(|((size, _), error)| {
                size + 20.0 * (1.0 + sign * 2.0 * error).max(0.01).log10()
            })
            .collect()
        };
        let swing = |sign: f64| -> Vec<f64> {
            let each = response.flight.iter().zip(&response.random_error);
            each.map(|((_, phase), error)| {
                phase + sign * (2.0 * error).min(1.0).asin().to_degrees()
            })
            .collect()
        };
        let range = |low: Vec<f64>, high: Vec<f64>| {
            Series::range(Role::Bound, frequencies_hz, &low, &high).named("±2σ random error")
        };
        let ends = [frequencies_hz.first(), frequencies_hz.last()].map(|end| *end.unwrap_or(&1.0));
        let rows = [
            Row::new("Magnitude", "dB")
                .with(range(spread(-1.0), spread(1.0)))
                .with(Series::curve(Role::Flight, part(&response.flight, |point| point.0)))
                .with(Series::curve(Role::Model, part(&response.model, |point| point.0))),
            Row::new("Phase", "°")
                .with(range(swing(-1.0), swing(1.0)))
                .with(Series::curve(Role::Flight, part(&response.flight, |point| point.1)))
                .with(Series::curve(Role::Model, part(&response.model, |point| point.1))),
            Row { limits: Some([0.0, 1.05]), ..Row::new("Coherence", "") }
                .with(Series::curve(Role::Flight, points(response.coherence.clone())))
                .with(
                    Series::curve(Role::Limit, ends.map(|end| (end, GOOD_COHERENCE)))
                        .named("0.6: good enough"),
                ),
        ];
        let axis = Axis::logarithmic("Frequency", "Hz").within(ends);
        let figure = Figure::against(axis, rows);
        section.with(figure.captioned(format!("{stick} to {output}, {unit} per full stick")))
    })
}

/// Every parameter that both methods tell.
fn both(frequency: &FrequencyDomain) -> Table {
    let rows = frequency.parameters.iter().map(|own| {
        let apart = match own.disagrees() {
            true => format!("{:.1}: they disagree", own.apart()),
            false => format!("{:.1}", own.apart()),
        };
        let shown = |(value, bound): (f64, f64)| format!("{} ±{}", digits(value), digits(bound));
        let numbers = vec![shown(own.time), shown(own.frequency), own.unit.clone(), apart];
        TableRow::new(own.name.clone(), numbers)
    });
    Table {
        caption: "Parameters by both methods, ±1σ".into(),
        heads: ["", "Time domain", "Frequency domain", "Unit", "Apart, σ"].map(Into::into).into(),
        rows: rows.collect(),
    }
}

/// How far each model is from each response.
fn costs(frequency: &FrequencyDomain) -> Table {
    let pair = |own: &PairCost| {
        TableRow::new(
            format!("{} to {}", own.stick, own.output),
            vec![
                own.points.to_string(),
                format!("{:.1}", own.time),
                format!("{:.1}", own.frequency),
            ],
        )
    };
    let (time, fitted) = frequency.mean_cost;
    let mean =
        TableRow::new("mean", vec![String::new(), format!("{time:.1}"), format!("{fitted:.1}")]);
    Table {
        caption: "Cost J of each response that is coherent: below 100 a model is good for most uses, below 50 it \
                  is hardly told from the vehicle"
            .into(),
        heads: ["Response", "Frequencies", "Time domain\u{2019}s model", "Frequency domain\u{2019}s"]
            .map(Into::into)
            .into(),
        rows: frequency.costs.iter().map(pair).chain([mean]).collect(),
    }
}
