//! Collects the rows of a reader into a log.

use std::path::Path;

use crate::format::Format;
use crate::inputs::{Chosen, Inputs};
use crate::log::{Log, Options};
use crate::onboard::{Onboard, OnboardInnovation, OnboardMoment};
use hovernav::earth::Geodetic;
use hovernav::ekf::Channel;
use hovernav::event::RangeReading;
use hovernav::frames::{Body, Vector};
use hovernav::gps::AntennaHeading;
use hovernav::imu::ImuSample;
use hovernav::time::Time;
use hovernav_dataset::{
    ClockSteps, Dataset, FixGate, LogError, Manifest, Remarks, Rows, StatedFix, field_fault,
    is_unknown, motion_fault, remark_faults,
};

/// Largest valid innovation, m, m/s or rad.
const LARGEST_INNOVATION: f64 = 1e7;

/// Rows of every sensor in file order. `place` is the line or byte offset of a row in the file.
#[derive(Debug)]
pub(crate) struct Assembly {
    imu: Rows<ImuSample>,
    fixes: FixGate,
    baro: Rows<(Time, f64)>,
    magnetometer: Rows<(Time, Vector<Body>)>,
    headings: Rows<AntennaHeading>,
    ranges: Rows<RangeReading>,
    inputs: Inputs,
    moments: Rows<OnboardMoment>,
    innovations: Rows<OnboardInnovation>,
    imu_remarks: Remarks,
    gps_remarks: Remarks,
    other_remarks: Remarks,
    remarks: Vec<String>,
    notes: Vec<String>,
}

impl Assembly {
    /// An empty assembly; its remarks name byte offsets if `by_bytes`, otherwise lines.
    pub fn new(by_bytes: bool) -> Self {
        let remarks = |about| match by_bytes {
            true => Remarks::of_bytes(about),
            false => Remarks::new(about),
        };
        Self {
            imu: Rows::new(),
            fixes: FixGate::default(),
            baro: Rows::new(),
            magnetometer: Rows::new(),
            headings: Rows::new(),
            ranges: Rows::new(),
            inputs: Inputs::default(),
            moments: Rows::new(),
            innovations: Rows::new(),
            imu_remarks: remarks("inertial unit"),
            gps_remarks: remarks("GPS"),
            other_remarks: remarks("other sensors"),
            remarks: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Adds a warning about the log.
    pub fn say(&mut self, sentence: impl Into<String>) {
        self.remarks.push(sentence.into());
    }

    /// Adds a note about a choice or an assumption, which is not a warning.
    pub fn note(&mut self, sentence: impl Into<String>) {
        self.notes.push(sentence.into());
    }

    /// Adds an inertial sample with plausible values; an implausible magnetic field is removed from it.
    pub fn imu(&mut self, place: u64, mut sample: ImuSample) {
        let field = sample.magnetic_field_gauss.map(Vector::to_array);
        if let Some(why) = field.and_then(field_fault) {
            self.imu_remarks.count(why, place);
            sample.magnetic_field_gauss = None;
        }
        match motion_fault(&sample.motion) {
            Some(why) => self.imu_remarks.count(why, place),
            None => self.imu.push(place, sample),
        }
    }

    /// Counts an inertial sample that was skipped or rejected, with the reason.
    pub fn skip_imu(&mut self, place: u64, why: &'static str) {
        self.imu_remarks.count(why, place);
    }

    /// Counts a value of another sensor that was skipped or rejected, with the reason.
    pub fn skip_other(&mut self, place: u64, why: &'static str) {
        self.other_remarks.count(why, place);
    }

    /// Adds a fix as the log states it. Returns whether it is accepted as a fix.
    pub fn fix(&mut self, place: u64, fix: StatedFix) -> bool {
        self.fixes.push(place, fix, &mut self.gps_remarks)
    }

    /// Adds a barometric height, m.
    pub fn baro(&mut self, place: u64, time: Time, height_m: f64) {
        match height_m.abs() <= 1e5 && !is_unknown(height_m) {
            true => self.baro.push(place, (time, height_m)),
            false => self.other_remarks.count(
                "skipped: the barometric height is missing or \
                                               beyond 100 km",
                place,
            ),
        }
    }

    /// Adds a magnetic field in body axes, gauss.
    pub fn magnetometer(&mut self, place: u64, time: Time, field_gauss: [f64; 3]) {
        match field_fault(field_gauss) {
            None => self.magnetometer.push(place, (time, field_gauss.into())),
            Some(why) => self.other_remarks.count(why, place),
        }
    }

    /// Adds a heading of two antennas.
    pub fn heading(&mut self, place: u64, heading: AntennaHeading) {
        let sound = |value: Option<f64>| value.filter(|value| *value > 0.0 && value.is_finite());
        let (sigma_rad, length_m) = (sound(heading.sigma_rad), sound(heading.length_m));
        match heading.heading_rad.is_finite() {
            true => self.headings.push(place, AntennaHeading { sigma_rad, length_m, ..heading }),
            false => self.other_remarks.count("skipped: the heading is missing", place),
        }
    }

    /// Adds a distance to the ground; `quality` runs from 0 to 1.
    pub fn range(&mut self, place: u64, reading: RangeReading) {
        let sigma_m = reading.sigma_m.filter(|sigma_m| *sigma_m > 0.0 && *sigma_m < 1e3);
        let quality = reading.quality.filter(|quality| (0.0..=1.0).contains(quality));
        match (0.0..=1e4).contains(&reading.range_m) {
            true => self.ranges.push(place, RangeReading { sigma_m, quality, ..reading }),
            false => {
                self.other_remarks.count("skipped: the distance is missing or out of range", place);
            }
        }
    }

    /// Selects the source of the controls that `options` name.
    pub fn select_input(&mut self, options: &Options) {
        self.inputs.wanted.clone_from(&options.input);
    }

    /// Adds lateral, longitudinal, collective and pedal of the source `name`.
    pub fn controls(&mut self, name: &'static str, place: u64, time: Time, inputs: [f64; 4]) {
        self.inputs.take(name, place, (time, inputs));
    }

    /// Adds the value that a system identification mode injected on a stick.
    pub fn injected(&mut self, time: Time, stick: usize, value: f64) {
        self.inputs.inject(time, stick, value);
    }

    /// Adds the solution of the onboard estimator at one time, in the order of the file.
    pub fn moment(&mut self, moment: OnboardMoment) {
        let is_sane = |place: &Geodetic| place.is_navigable();
        let moment = OnboardMoment {
            velocity_mps: moment.velocity_mps.filter(|velocity| velocity.is_finite()),
            position: moment.position.filter(is_sane),
            body_to_ned: moment
                .body_to_ned
                .filter(|attitude| (attitude.quaternion().length() - 1.0).abs() < 0.01),
            ..moment
        };
        let OnboardMoment { body_to_ned, velocity_mps, position, .. } = moment;
        if body_to_ned.is_some() || velocity_mps.is_some() || position.is_some() {
            self.moments.push(0, moment);
        }
    }

    /// Adds an innovation of the onboard estimator, in the order of the file. Exactly zero means no measurement and is
    /// ignored.
    pub fn innovation(&mut self, innovation: OnboardInnovation) {
        let OnboardInnovation { innovation: size, sigma, .. } = innovation;
        if size != 0.0 && size.abs() <= LARGEST_INNOVATION {
            let sigma = sigma.filter(|sigma| *sigma > 0.0 && *sigma <= LARGEST_INNOVATION);
            self.innovations.push(0, OnboardInnovation { sigma, ..innovation });
        }
    }

    /// The fixes with times as logged, the warnings and the notes.
    pub fn into_fixes(self) -> (FixGate, Vec<String>, Vec<String>) {
        let mut warnings = self.remarks;
        warnings.extend(self.gps_remarks.into_warnings());
        (self.fixes, warnings, self.notes)
    }

    /// The log with all rows in time order. `onboard` is the name of the onboard estimator.
    ///
    /// # Errors
    /// [`LogError::Unusable`] without inertial samples and fixes; [`LogError::Clock`] if the times of a clock do not
    /// increase.
    pub fn finish(
        mut self,
        path: &Path,
        format: Format,
        mut manifest: Manifest,
        onboard: &str,
    ) -> Result<Log, LogError> {
        if manifest.name.is_empty() {
            manifest.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        let steps = &mut ClockSteps::default();
        let (imu, places) = self.imu.together(&mut self.imu_remarks).in_time_order(
            |sample| &mut sample.time,
            path,
            steps,
            &mut self.imu_remarks,
        )?;
        let fixes = self.fixes.finish(path, steps, &mut self.gps_remarks)?;
        let others = &mut self.other_remarks;
        let (baro, _) = self.baro.in_time_order(|row| &mut row.0, path, steps, others)?;
        let (magnetometer, _) =
            self.magnetometer.in_time_order(|row| &mut row.0, path, steps, others)?;
        let (headings, _) =
            self.headings.in_time_order(|row| &mut row.time, path, steps, others)?;
        let (ranges, _) = self.ranges.in_time_order(|row| &mut row.time, path, steps, others)?;
        let Chosen { controls, injected, note } = self.inputs.choose(path, steps, others)?;
        self.notes.extend(note);
        if imu.is_empty() && fixes.is_empty() {
            let format = format.with_article();
            let mut reason = format!("found {format} without inertial samples and without fixes");
            for remark in [&self.imu_remarks, &self.gps_remarks] {
                let summary = remark.summary();
                if !summary.is_empty() {
                    reason = format!("{reason}; {summary}");
                }
            }
            for remark in self.remarks.into_iter().chain(self.notes) {
                reason = format!("{reason}; {remark}");
            }
            return Err(LogError::Unusable { path: path.to_path_buf(), reason });
        }
        remark_faults(&imu, &places, &mut self.imu_remarks);
        let mut warnings = self.remarks;
        for remarks in [self.imu_remarks, self.gps_remarks, self.other_remarks] {
            warnings.extend(remarks.into_warnings());
        }
        let notes = self.notes;
        let dataset = Dataset {
            manifest,
            imu,
            fixes,
            baro,
            magnetometer,
            headings,
            ranges,
            controls,
            injected,
            warnings,
            notes,
            ..Dataset::default()
        };
        let moments = merged(self.moments.shifted(|moment| &mut moment.time, steps));
        let innovations = fresh(self.innovations.shifted(|one| &mut one.time, steps));
        let onboard = (!moments.is_empty() || !innovations.is_empty()).then(|| Onboard {
            name: onboard.to_owned(),
            moments,
            innovations,
        });
        Ok(Log::of(format, dataset, onboard))
    }
}

/// Moments in time order; moments of equal time are combined.
fn merged(mut moments: Vec<OnboardMoment>) -> Vec<OnboardMoment> {
    moments.sort_by_key(|moment| moment.time);
    moments.dedup_by(|later, kept| {
        if later.time != kept.time {
            return false;
        }
        kept.body_to_ned = kept.body_to_ned.or(later.body_to_ned);
        kept.velocity_mps = kept.velocity_mps.or(later.velocity_mps);
        kept.position = kept.position.or(later.position);
        true
    });
    moments
}

/// Innovations in time order, without the repetitions that some logs write until the next measurement.
fn fresh(mut innovations: Vec<OnboardInnovation>) -> Vec<OnboardInnovation> {
    innovations.sort_by_key(|one| one.time);
    let mut last: Vec<(Channel, f64)> = Vec::new();
    innovations.retain(|one| match last.iter_mut().find(|(channel, _)| *channel == one.channel) {
        Some((_, size)) => std::mem::replace(size, one.innovation) != one.innovation,
        None => {
            last.push((one.channel, one.innovation));
            true
        }
    });
    innovations
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::imu::Motion;

    #[test]
    fn impossible_fields_are_rejected_with_a_warning() {
        let mut assembly = Assembly::new(true);
        let motion = Motion::Rates {
            angular_rate_radps: Vector::ZERO,
            specific_force_mps2: Vector::new(0.0, 0.0, -9.8),
        };
        for (k, north_gauss) in [0.2, 327.68, 0.21, 150.0].into_iter().enumerate() {
            let magnetic_field_gauss = Some(Vector::new(north_gauss, 0.0, 0.4));
            let time = Time::ZERO + k as f64;
            let sample = ImuSample { magnetic_field_gauss, ..ImuSample::new(time, motion) };
            assembly.imu(40 * k as u64, sample);
        }
        let log = assembly.finish("log".as_ref(), Format::Tlog, Manifest::default(), "").unwrap();
        let fields = log.dataset.imu.iter().map(|sample| sample.magnetic_field_gauss.is_some());
        assert_eq!(fields.collect::<Vec<_>>(), [true, false, true, false]);
        let told = "2 rows, the first at byte 40, magnetic field rejected: over 100 gauss";
        let warnings = &log.dataset.warnings;
        assert!(warnings.iter().any(|warning| warning.contains(told)), "{warnings:?}");
    }
}
