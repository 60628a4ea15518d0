//! Events of all sensors as one stream.

use std::iter::Peekable;
use std::slice::Iter;

use crate::dataset::samples::Samples;
use crate::dataset::{Dataset, Source};
use hovernav::event::{BaroReading, Event, MagneticReading, RangeReading};
use hovernav::frames::{Body, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::{ImuSample, Notch};
use hovernav::time::Time;

/// Largest time from the validity of a fix to its arrival, s.
const LATEST_S: f64 = 0.2;

/// Iterator over the events of a dataset in order of arrival; a clone continues at the same event.
#[derive(Clone, Debug)]
pub struct Events<'a> {
    latency_s: f64,
    order: Iter<'a, Source>,
    imu: Peekable<Samples<'a>>,
    fixes: Peekable<Iter<'a, Fix>>,
    baro: Peekable<Iter<'a, (Time, f64)>>,
    magnetometer: Peekable<Iter<'a, (Time, Vector<Body>)>>,
    headings: Peekable<Iter<'a, AntennaHeading>>,
    ranges: Peekable<Iter<'a, RangeReading>>,
    rotor: Peekable<Iter<'a, (Time, f64)>>,
    notch: Option<Notch>,
}

impl Dataset {
    /// Events of all sensors, in order of arrival: by [`order`](Self::order) if it is complete, otherwise by time. A
    /// fix arrives after its time of validity by its latency, but at most 0.2 s: an estimator's history is no longer.
    #[must_use]
    pub fn events(&self) -> Events<'_> {
        Events {
            latency_s: self.manifest.gps.latency_s.clamp(0.0, LATEST_S),
            order: if self.has_order() { self.order.iter() } else { [].iter() },
            imu: self.samples().peekable(),
            fixes: self.fixes.iter().peekable(),
            baro: self.baro.iter().peekable(),
            magnetometer: self.magnetometer.iter().peekable(),
            headings: self.headings.iter().peekable(),
            ranges: self.ranges.iter().peekable(),
            rotor: self.rotor.iter().peekable(),
            notch: self.manifest.imu.notch.map(Notch::new),
        }
    }

    /// Whether `order` lists every event.
    fn has_order(&self) -> bool {
        let count = |of| self.order.iter().filter(|source| **source == of).count();
        count(Source::Imu) == self.sample_count()
            && count(Source::Gps) == self.fixes.len()
            && count(Source::Baro) == self.baro.len()
            && count(Source::Magnetometer) == self.magnetometer.len()
            && count(Source::AntennaHeading) == self.headings.len()
            && count(Source::Range) == self.ranges.len()
    }
}

impl Events<'_> {
    /// Source of the earliest event.
    fn earliest(&mut self) -> Option<Source> {
        let latency_s = self.latency_s;
        let times = [
            (Source::Imu, self.imu.peek().map(|sample| sample.time)),
            (Source::Gps, self.fixes.peek().map(|fix| fix.time.offset_by(latency_s))),
            (Source::Baro, self.baro.peek().map(|(time, _)| *time)),
            (Source::Magnetometer, self.magnetometer.peek().map(|(time, _)| *time)),
            (Source::AntennaHeading, self.headings.peek().map(|heading| heading.time)),
            (Source::Range, self.ranges.peek().map(|reading| reading.time)),
        ];
        let present = times.into_iter().filter_map(|(source, time)| Some((source, time?)));
        present.min_by_key(|(_, time)| *time).map(|(source, _)| source)
    }

    /// The next inertial sample, without the rotor's vibration if there is a notch.
    fn sample(&mut self) -> Option<ImuSample> {
        let sample = self.imu.next()?;
        let Some(notch) = &mut self.notch else { return Some(sample) };
        while let Some((_, rotor_hz)) = self.rotor.next_if(|(time, _)| *time <= sample.time) {
            notch.set_frequency_hz(*rotor_hz);
        }
        Some(notch.filter(&sample))
    }
}

impl Iterator for Events<'_> {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        match self.order.next().copied().or_else(|| self.earliest())? {
            Source::Imu => self.sample().map(Event::Imu),
            Source::AntennaHeading => self.headings.next().copied().map(Event::AntennaHeading),
            Source::Range => self.ranges.next().copied().map(Event::Range),
            Source::Gps => self.fixes.next().map(|fix| Event::Gps(*fix)),
            Source::Baro => self
                .baro
                .next()
                .map(|&(time, height_m)| Event::Baro(BaroReading::new(time, height_m))),
            Source::Magnetometer => self.magnetometer.next().map(|&(time, field_gauss)| {
                Event::Magnetometer(MagneticReading::new(time, field_gauss))
            }),
        }
    }
}
