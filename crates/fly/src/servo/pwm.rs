//! Servo outputs through the kernel's PWM: `/sys/class/pwm/pwmchipN/pwmM`.
//!
//! Source: Linux kernel documentation, *Pulse Width Modulation (PWM) interface*
//! (driver-api/pwm), section "Using PWMs with the sysfs interface".

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use hovernav::controls::{Channel, Channels};
use hovernav::servo::{LONGEST_MS, PulseOutput, SHORTEST_MS, is_plausible};
use hovernav::time::Time;
use hovernav_record::PwmLine;

/// Directory with the kernel's PWM chips.
const ROOT: &str = "/sys/class/pwm";
/// Period of the pulses, ns: 50 Hz, which every servo accepts.
const PERIOD_NS: u32 = 20_000_000;

/// The action that failed on an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PwmAction {
    /// Export of the output by the kernel.
    Export,
    /// Opening one of its files.
    Open,
    /// Setting the period of the pulses.
    SetPeriod,
    /// Setting the width of the pulse.
    SetWidth,
    /// Starting the pulses.
    Enable,
    /// Stopping the pulses.
    Disable,
}

impl fmt::Display for PwmAction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Export => "export",
            Self::Open => "open",
            Self::SetPeriod => "set the period",
            Self::SetWidth => "set the width",
            Self::Enable => "enable",
            Self::Disable => "disable",
        })
    }
}

/// Reasons why an output cannot be driven.
#[derive(Debug, thiserror::Error)]
pub enum PwmError {
    /// The operating system returned an error.
    #[error("{channel}: cannot {action} by {}: {source}", path.display())]
    System {
        /// The channel.
        channel: Channel,
        /// The action that failed.
        action: PwmAction,
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A width outside the range of servos; the output keeps its last width.
    #[error("{channel}: found a width of {width_ms} ms, expected {SHORTEST_MS} to {LONGEST_MS}")]
    Width {
        /// The channel.
        channel: Channel,
        /// The width, ms.
        width_ms: f64,
    },
}

#[derive(Debug)]
struct Output {
    channel: Channel,
    folder: PathBuf,
    duty_cycle: File,
    enabled: bool,
}

/// Servos on the kernel's PWM outputs, 50 pulses a second.
///
/// An output is silent until its first width is written, so no servo moves to a width that was not commanded. When
/// this is dropped, the outputs continue with the last widths: servos that hold are safer than unpowered ones.
/// [`PwmOutput::disable`] stops them.
#[derive(Debug)]
pub struct PwmOutput {
    outputs: Channels<Option<Output>>,
}

impl PwmOutput {
    /// Opens the outputs of the channels that have one.
    ///
    /// A missing output is exported by the kernel. If its files need a udev rule to be writable, export the output
    /// at system start: the rule takes effect with a delay.
    ///
    /// # Errors
    /// [`PwmError::System`] for the first output that cannot be opened.
    pub fn open(lines: &Channels<Option<PwmLine>>) -> Result<Self, PwmError> {
        Self::open_at(Path::new(ROOT), lines)
    }

    /// As [`open`](Self::open), with the chips in `root` instead of `/sys/class/pwm`.
    ///
    /// # Errors
    /// [`PwmError::System`] for the first output that cannot be opened.
    pub fn open_at(root: &Path, lines: &Channels<Option<PwmLine>>) -> Result<Self, PwmError> {
        let mut outputs = Channels::from_fn(|_| None);
        for (channel, line) in lines.iter() {
            if let Some(line) = line {
                outputs[channel] = Some(Output::open(channel, root, *line)?);
            }
        }
        Ok(Self { outputs })
    }

    /// Stops the pulses of every output.
    ///
    /// # Errors
    /// The error of the first output that cannot be stopped; the others are stopped anyway.
    pub fn disable(&mut self) -> Result<(), PwmError> {
        self.each(|output| {
            output.set(PwmAction::Disable, "enable", 0)?;
            output.enabled = false;
            Ok(())
        })
    }

    /// Applies `change` to every output; returns the first error after all outputs.
    fn each(
        &mut self,
        mut change: impl FnMut(&mut Output) -> Result<(), PwmError>,
    ) -> Result<(), PwmError> {
        let mut first = Ok(());
        for channel in Channel::ALL {
            if let Some(output) = &mut self.outputs[channel] {
                first = first.and(change(output));
            }
        }
        first
    }
}

impl PulseOutput for PwmOutput {
    type Error = PwmError;

    fn write(&mut self, widths_ms: &Channels<f64>, _now: Time) -> Result<(), PwmError> {
        self.each(|output| output.write(widths_ms[output.channel]))
    }
}

impl Output {
    fn open(channel: Channel, root: &Path, line: PwmLine) -> Result<Self, PwmError> {
        let chip = root.join(format!("pwmchip{}", line.chip));
        let folder = chip.join(format!("pwm{}", line.output));
        if !folder.is_dir() {
            let path = chip.join("export");
            put(&path, line.output)
                .map_err(|source| system(channel, PwmAction::Export, path, source))?;
        }
        let path = folder.join("duty_cycle");
        let duty_cycle = OpenOptions::new()
            .write(true)
            .open(&path)
            .map_err(|source| system(channel, PwmAction::Open, path, source))?;
        let output = Self { channel, folder, duty_cycle, enabled: false };
        // The previous user of the output may have left a pulse longer than the new period. The kernel rejects a
        // period shorter than the pulse, and any pulse while the period is 0.
        if fs::read_to_string(output.folder.join("period")).is_ok_and(|text| text.trim() != "0") {
            output.set(PwmAction::Disable, "enable", 0)?;
            output.set(PwmAction::SetWidth, "duty_cycle", 0)?;
        }
        output.set(PwmAction::SetPeriod, "period", PERIOD_NS)?;
        Ok(output)
    }

    fn write(&mut self, width_ms: f64) -> Result<(), PwmError> {
        if !is_plausible(width_ms) {
            return Err(PwmError::Width { channel: self.channel, width_ms });
        }
        let width_ns = libm::round(width_ms * 1e6) as u32;
        let mut text = [b' '; 11];
        // At most seven digits and a line end.
        let written = writeln!(&mut text[..], "{width_ns}")
            .and_then(|()| self.duty_cycle.write_all_at(text.trim_ascii_end(), 0));
        written.map_err(|source| {
            let path = self.folder.join("duty_cycle");
            system(self.channel, PwmAction::SetWidth, path, source)
        })?;
        if !self.enabled {
            self.set(PwmAction::Enable, "enable", 1)?;
            self.enabled = true;
        }
        Ok(())
    }

    fn set(&self, action: PwmAction, file: &str, value: u32) -> Result<(), PwmError> {
        let path = self.folder.join(file);
        put(&path, value).map_err(|source| system(self.channel, action, path, source))
    }
}

/// Writes a number to an existing file of the kernel. A missing file is an error and is not created.
fn put(path: &Path, value: u32) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).truncate(true).open(path)?;
    writeln!(file, "{value}")
}

fn system(channel: Channel, action: PwmAction, path: PathBuf, source: io::Error) -> PwmError {
    PwmError::System { channel, action, path, source }
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;

    /// A directory like the kernel's, with `outputs` of chip 0 exported, each with the given period.
    fn chip(outputs: u32, period: &str) -> TempDir {
        let root = tempfile::tempdir().unwrap();
        for output in 0..outputs {
            let folder = root.path().join(format!("pwmchip0/pwm{output}"));
            fs::create_dir_all(&folder).unwrap();
            for (file, text) in [("period", period), ("duty_cycle", "0"), ("enable", "0")] {
                fs::write(folder.join(file), format!("{text}\n")).unwrap();
            }
        }
        fs::write(root.path().join("pwmchip0/export"), "").unwrap();
        root
    }

    fn lines() -> Channels<Option<PwmLine>> {
        Channels::from([0, 1, 2, 3, 4]).map(|output| Some(PwmLine { chip: 0, output }))
    }

    /// The first line of a file, which is what the kernel would read.
    fn read(root: &TempDir, output: u32, file: &str) -> String {
        let text = fs::read_to_string(root.path().join(format!("pwmchip0/pwm{output}/{file}")));
        text.unwrap().lines().next().unwrap_or_default().to_owned()
    }

    fn widths() -> Channels<f64> {
        Channels::from([1.0, 1.25, 1.5, 1.75, 2.000_001])
    }

    #[test]
    fn widths_reach_the_kernel_in_nanoseconds_and_the_first_enables_the_output() {
        let root = chip(5, "0");
        let mut servos = PwmOutput::open_at(root.path(), &lines()).unwrap();
        for output in 0..5 {
            assert_eq!(read(&root, output, "period"), "20000000");
            assert_eq!(read(&root, output, "enable"), "0");
        }
        servos.write(&widths(), Time::ZERO).unwrap();
        let duties = [0, 1, 2, 3, 4].map(|output| read(&root, output, "duty_cycle"));
        assert_eq!(duties, ["1000000", "1250000", "1500000", "1750000", "2000001"]);
        assert!((0..5).all(|output| read(&root, output, "enable") == "1"));
        servos.disable().unwrap();
        assert!((0..5).all(|output| read(&root, output, "enable") == "0"));
    }

    #[test]
    fn a_running_output_is_stopped_before_its_period_changes() {
        let root = chip(5, "50000000");
        fs::write(root.path().join("pwmchip0/pwm3/duty_cycle"), "40000000\n").unwrap();
        fs::write(root.path().join("pwmchip0/pwm3/enable"), "1\n").unwrap();
        let _servos = PwmOutput::open_at(root.path(), &lines()).unwrap();
        assert_eq!(
            ["enable", "duty_cycle", "period"].map(|f| read(&root, 3, f)),
            ["0", "0", "20000000"]
        );
    }

    #[test]
    fn a_missing_output_is_exported_and_named_in_the_error() {
        let root = chip(4, "0");
        let error = PwmOutput::open_at(root.path(), &lines()).unwrap_err();
        assert_eq!(fs::read_to_string(root.path().join("pwmchip0/export")).unwrap(), "4\n");
        let PwmError::System { channel, action, path, source } = error else { panic!() };
        assert_eq!((channel, action), (Channel::Pedal, PwmAction::Open));
        assert!(path.ends_with("pwmchip0/pwm4/duty_cycle"));
        assert_eq!(source.kind(), io::ErrorKind::NotFound);

        let other_chip = Some(PwmLine { chip: 7, output: 0 });
        let error = PwmOutput::open_at(
            root.path(),
            &Channels { lateral: other_chip, ..Channels::default() },
        );
        let message = error.unwrap_err().to_string();
        assert!(message.starts_with("lateral: cannot export by "), "{message}");
    }

    #[test]
    fn a_width_out_of_range_is_rejected_and_the_others_are_written() {
        let root = chip(5, "0");
        let mut servos = PwmOutput::open_at(root.path(), &lines()).unwrap();
        servos.write(&widths(), Time::ZERO).unwrap();
        for width_ms in [f64::NAN, 0.4, 2.6, f64::INFINITY] {
            let bad = Channels { throttle: width_ms, pedal: 1.1, ..widths() };
            let error = servos.write(&bad, Time::ZERO).unwrap_err();
            assert!(matches!(error, PwmError::Width { channel: Channel::Throttle, .. }));
            assert_eq!(read(&root, 0, "duty_cycle"), "1000000");
            assert_eq!(read(&root, 4, "duty_cycle"), "1100000");
        }
    }

    #[test]
    fn a_width_that_the_kernel_rejects_is_reported_and_the_others_are_written() {
        let root = chip(5, "0");
        let duty_cycle = root.path().join("pwmchip0/pwm1/duty_cycle");
        fs::remove_file(&duty_cycle).unwrap();
        std::os::unix::fs::symlink("/dev/full", &duty_cycle).unwrap();
        let mut servos = PwmOutput::open_at(root.path(), &lines()).unwrap();
        let error = servos.write(&widths(), Time::ZERO).unwrap_err();
        let PwmError::System { channel, action, path, source } = error else { panic!() };
        assert_eq!((channel, action, path), (Channel::Collective, PwmAction::SetWidth, duty_cycle));
        assert_eq!(source.kind(), io::ErrorKind::StorageFull);
        assert_eq!(read(&root, 1, "enable"), "0");
        assert!([0, 2, 3, 4].into_iter().all(|output| read(&root, output, "enable") == "1"));
    }

    #[test]
    fn an_output_that_does_not_start_is_reported_and_the_others_are_written() {
        let root = chip(5, "0");
        let mut servos = PwmOutput::open_at(root.path(), &lines()).unwrap();
        fs::remove_file(root.path().join("pwmchip0/pwm1/enable")).unwrap();
        let error = servos.write(&widths(), Time::ZERO).unwrap_err();
        assert!(matches!(
            error,
            PwmError::System { channel: Channel::Collective, action: PwmAction::Enable, .. }
        ));
        assert!([0, 2, 3, 4].into_iter().all(|output| read(&root, output, "enable") == "1"));
    }

    #[test]
    fn channels_without_an_output_are_ignored() {
        let root = chip(1, "0");
        let line = Some(PwmLine { chip: 0, output: 0 });
        let lines = Channels { collective: line, ..Channels::default() };
        let mut servos = PwmOutput::open_at(root.path(), &lines).unwrap();
        servos.write(&Channels { throttle: f64::NAN, ..widths() }, Time::ZERO).unwrap();
        assert_eq!(read(&root, 0, "duty_cycle"), "1250000");
    }
}
