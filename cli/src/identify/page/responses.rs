//! The frequency responses, to which the model was not fitted.

use hovernav_sysid::helicopter::StickResponse;

use crate::page::{Axis, Figure, Role, Row, Section, Series};

/// Below this, a response is not worth fitting: Tischler and Remple, section 7.5.1.
const GOOD_COHERENCE: f64 = 0.6;

/// Flight and model from each stick to the output that answers to it.
pub fn responses(responses: &[StickResponse]) -> Section {
    let section = Section::new(
        "bode",
        "Frequency responses",
        "The same flight seen in frequency, to which the model was not fitted: amplification and \
         phase from stick to answer, all test points on the stick together, with twice their random \
         error. Where the coherence is below 0.6 noise and gusts outweigh the stick: believe neither.",
    );
    if responses.is_empty() {
        return section.with(vec!["No stick of this model has a test point.".to_owned()]);
    }
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
