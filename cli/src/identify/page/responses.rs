//! The frequency responses, and the parameters identified from them.

use hovernav_sysid::helicopter::{Basis, FrequencyDomain, PairCost, StickResponse};
use hovernav_sysid::methods::frequency::FrequencyError;

use hovernav_pages::{Axis, Figure, Role, Row, Section, Series, Table, TableRow, digits};

/// Minimum coherence of a response that is worth fitting: Tischler and Remple, section 7.5.1.
const GOOD_COHERENCE: f64 = 0.6;

/// Both methods side by side.
pub fn second_opinion(frequency: Result<&FrequencyDomain, &FrequencyError>) -> Section {
    let section = Section::new(
        "second-opinion",
        "Comparison with the frequency domain",
        "The same equations fitted again, to the flight\u{2019}s frequency responses. In each response, the effect of \
         the other sticks is removed. If the two methods differ by more than three sigma in a parameter, the \
         flight does not determine that parameter.",
    );
    let frequency = match frequency {
        Ok(frequency) => frequency,
        Err(error) => return section.with(vec![format!("Not available: {error}.")]),
    };
    let rests_on = match frequency.basis {
        Basis::Sticks => {
            "The responses use the stick movements over the test points. This is valid if the sticks do not \
             respond to gusts."
        }
        Basis::Injected => {
            "The responses use the injected test inputs, over the whole flight near the trim. Corrections of \
             gusts by the pilot or the autopilot do not disturb them."
        }
    };
    let mut notes = vec![rests_on.to_owned()];
    if !frequency.untold.is_empty() {
        let untold = frequency.untold.join(", ");
        notes.push(format!(
            "Not determined by the responses, held at the values of the time domain: {untold}."
        ));
    }
    section.with(both(frequency)).with(costs(frequency)).with(notes)
}

/// Frequency responses of flight and model, from each stick to its main output.
pub fn responses(frequency: Result<&FrequencyDomain, &FrequencyError>) -> Section {
    let section = Section::new(
        "bode",
        "Frequency responses",
        "Gain and phase from each stick to its main output, with the effect of the other sticks removed: of the \
         flight, and of the model from the time domain, which was not fitted to them. Both are unreliable where \
         the coherence or the power of the stick is low.",
    );
    let responses = frequency.map(FrequencyDomain::stick_responses).unwrap_or_default();
    if responses.is_empty() {
        return section.with(vec!["No responses are available.".to_owned()]);
    }
    let section = section.folded("One figure per stick");
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
                        .named("0.6: minimum"),
                ),
        ];
        let axis = Axis::logarithmic("Frequency", "Hz").within(ends);
        let figure = Figure::against(axis, rows);
        section.with(figure.captioned(format!("{stick} to {output}, {unit} per full stick")))
    })
}

/// Every parameter that both methods determine.
fn both(frequency: &FrequencyDomain) -> Table {
    let rows = frequency.parameters.iter().map(|own| {
        let apart = match own.disagrees() {
            true => format!("{:.1}: disagree", own.apart()),
            false => format!("{:.1}", own.apart()),
        };
        let shown = |(value, bound): (f64, f64)| format!("{} ±{}", digits(value), digits(bound));
        let numbers = vec![shown(own.time), shown(own.frequency), own.unit.clone(), apart];
        TableRow::new(own.name.clone(), numbers)
    });
    Table {
        caption: "Parameters by both methods, ±1σ".into(),
        heads: ["", "Time domain", "Frequency domain", "Unit", "Difference, σ"]
            .map(Into::into)
            .into(),
        rows: rows.collect(),
    }
}

/// The cost of each model against each response.
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
        caption: "Cost J of each coherent response. Below 100 a model is good for most uses; below 50 it \
                  is nearly indistinguishable from the vehicle"
            .into(),
        heads: ["Response", "Frequencies", "Time domain\u{2019}s model", "Frequency domain\u{2019}s"]
            .map(Into::into)
            .into(),
        rows: frequency.costs.iter().map(pair).chain([mean]).collect(),
    }
}
