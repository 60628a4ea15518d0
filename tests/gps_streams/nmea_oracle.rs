//! NMEA sentences read by this project's reader and by the `nmea` crate (the oracle), compared value by value.
//!
//! Where the two differ, a row of [`reasons::REASONS`] has the rule of NMEA 0183. A difference without a row is a
//! failure.

mod readers;
mod reasons;
mod sentences;

use std::collections::BTreeMap;
use std::fs;

use hovernav_testing::shared;

use readers::{Quantity, Values, oracle, ours};
use reasons::{REASONS, Reason};
use sentences::{Generator, Kind, Sentence};

/// Kind of difference between the two readers for a sentence.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Difference {
    /// The oracle rejects a sentence that our reader accepts.
    OnlyOurs,
    /// Our reader rejects a sentence that the oracle accepts.
    OnlyOracle,
    /// One value differs, or one reader lacks it.
    Value { quantity: Quantity, ours: Option<f64>, oracle: Option<f64> },
}

/// Largest difference of two readings of the same digits.
///
/// The oracle rounds times to nanoseconds, degrees to double precision and all else to single precision, 2⁻²⁴ of the
/// value. Our reader stores positions in radians.
fn rounding(quantity: Quantity, values: &Values) -> f64 {
    const SINGLE: f64 = 1.0 / (1 << 24) as f64;
    let value = values.get(&quantity).map_or(0.0, |value| value.abs());
    match quantity {
        Quantity::TimeOfDayNs
        | Quantity::Day
        | Quantity::Satellites
        | Quantity::Quality
        | Quantity::Dimension => 0.0,
        Quantity::LatitudeDeg | Quantity::LongitudeDeg => 2e-13,
        // A course of 256° to 360° has a spacing of 2⁻¹⁵°.
        Quantity::NorthMps | Quantity::EastMps => {
            let speed_mps = values.get(&Quantity::SpeedMps).map_or(0.0, |speed| speed.abs());
            speed_mps * (SINGLE + (1.0 / f64::from(1 << 16)).to_radians()) + 1e-12
        }
        // This project's value is the difference of two heights of up to 100 km.
        Quantity::GeoidSeparationM => value * SINGLE + 1e-10,
        _ => value * SINGLE * (1.0 + 1e-9) + 1e-12,
    }
}

fn agree(quantity: Quantity, ours: f64, oracle: f64, limit: f64) -> bool {
    let difference = (ours - oracle).abs();
    // 180° west is 180° east.
    difference <= limit || (quantity == Quantity::LongitudeDeg && 360.0 - difference <= limit)
}

/// Result of comparing the two readers over many sentences.
#[derive(Default)]
struct Comparison {
    sentences: usize,
    read_by_both: usize,
    /// Values that both readers return.
    values: BTreeMap<(Kind, Quantity), usize>,
    /// For each reason, the differences that no other reason explains.
    explained: BTreeMap<&'static str, usize>,
    unexplained: Vec<(String, Difference)>,
}

impl Comparison {
    fn add(&mut self, sentence: &Sentence) {
        self.sentences += 1;
        match (ours(sentence), oracle(sentence)) {
            (None, None) => {}
            (Some(_), None) => self.explain(sentence, Difference::OnlyOurs),
            (None, Some(_)) => self.explain(sentence, Difference::OnlyOracle),
            (Some(ours), Some(oracle)) => {
                self.read_by_both += 1;
                self.compare(sentence, &ours, &oracle);
            }
        }
    }

    fn compare(&mut self, sentence: &Sentence, ours: &Values, oracle: &Values) {
        let mut quantities: Vec<Quantity> = ours.keys().chain(oracle.keys()).copied().collect();
        quantities.sort_unstable();
        quantities.dedup();
        for quantity in quantities {
            let (a, b) = (ours.get(&quantity).copied(), oracle.get(&quantity).copied());
            if let Some((a, b)) = a.zip(b) {
                *self.values.entry((sentence.kind, quantity)).or_default() += 1;
                if agree(quantity, a, b, rounding(quantity, ours)) {
                    continue;
                }
            }
            self.explain(sentence, Difference::Value { quantity, ours: a, oracle: b });
        }
    }

    fn explain(&mut self, sentence: &Sentence, difference: Difference) {
        let mut reasons =
            REASONS.iter().filter(|reason| (reason.explains)(sentence, &difference)).fuse();
        match (reasons.next(), reasons.next()) {
            (None, _) => self.unexplained.push((sentence.text.clone(), difference)),
            (Some(only), None) => *self.explained.entry(only.name).or_default() += 1,
            (Some(_), Some(_)) => {}
        }
    }

    fn assert_explained(&self) {
        println!("{} sentences, {} read by both", self.sentences, self.read_by_both);
        for (name, count) in &self.explained {
            println!("{count} by {name}");
        }
        assert!(
            self.unexplained.is_empty(),
            "{} differences without a reason: {:#?}",
            self.unexplained.len(),
            &self.unexplained[..self.unexplained.len().min(20)]
        );
    }
}

#[test]
fn captured_sentences_have_the_values_that_the_nmea_crate_reads() {
    let mut comparison = Comparison::default();
    for folder in ["gpsd", "nmea"] {
        let Some(folder) = shared(format!("captures/{folder}")) else { return };
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "log") {
                for sentence in Sentence::all_of(&fs::read(path).unwrap()) {
                    comparison.add(&sentence);
                }
            }
        }
    }
    comparison.assert_explained();
    assert!(comparison.sentences > 6_000 && comparison.read_by_both > 4_000);
}

#[test]
fn generated_sentences_have_the_values_that_the_nmea_crate_reads() {
    let mut generator = Generator::new(1);
    let mut comparison = Comparison::default();
    for _ in 0..100_000 {
        comparison.add(&generator.sentence());
    }
    comparison.assert_explained();
    assert!(comparison.read_by_both > 40_000);
    // Eight of GGA and GNS each, four of GSA and GST, seven of RMC, three of VTG.
    assert_eq!(comparison.values.len(), 34, "{:?}", comparison.values);
    for (value, count) in &comparison.values {
        assert!(*count > 2_500, "{value:?}: {count}");
    }
    for reason in REASONS {
        let Reason { name, rule, .. } = reason;
        assert!(comparison.explained.contains_key(name), "explains nothing: {name}: {rule}");
    }
}
