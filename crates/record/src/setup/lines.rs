//! Assignment of devices to lines: every device has one, and no line has two.

use std::path::PathBuf;

use super::error::FlyConfigError;
use super::fly_config::FlyConfig;
use super::sections::CaptureSection;
use hovernav::controls::Channel;

impl FlyConfig {
    /// Checks that both sensors have a port, and that no two devices use the same line.
    pub(super) fn check_lines(&self) -> Result<(), FlyConfigError> {
        let servo = &self.servo;
        let pilot = match &servo.capture {
            Some(CaptureSection::Serial(line)) => Some(&line.port),
            _ => None,
        };
        let mut ports =
            vec![("dmu", "port", &self.dmu.port), ("receiver", "port", &self.receiver.port)];
        ports.extend(pilot.map(|port| ("servo.capture", "serial", port)));
        ports.extend(servo.stream.iter().map(|line| ("servo.stream", "port", &line.port)));
        let telemetry = self.telemetry.iter().filter_map(|section| section.port.as_ref());
        ports.extend(telemetry.map(|port| ("telemetry", "port", port)));
        let mavlink = self.mavlink.iter().filter_map(|section| section.port.as_ref());
        ports.extend(mavlink.map(|port| ("mavlink", "port", port)));
        for (section, key, port) in &ports {
            if port.as_os_str().is_empty() {
                let why = "found none, expected the path of a serial port";
                return Err(FlyConfigError::value(*section, *key, &why));
            }
        }
        let spelled = |port: &PathBuf| port.display().to_string();
        alone(ports.into_iter().map(|(section, key, port)| (section, key, spelled(port))))?;

        let outputs = servo.output.iter().filter_map(|(channel, line)| {
            line.map(|line| (channel, format!("chip {}, output {}", line.chip, line.output)))
        });
        alone(outputs.map(|(channel, line)| ("servo.output", channel.name(), line)))?;
        if let Some(CaptureSection::Gpio { lines, aux, .. }) = &servo.capture {
            let own = Channel::ALL.map(|channel| (channel.name(), lines[channel]));
            let all = own.into_iter().chain(aux.map(|line| ("aux", line)));
            alone(all.map(|(name, line)| ("servo.capture", name, format!("line {line}"))))?;
        }
        Ok(())
    }
}

/// Rejects the first line that an earlier device already uses.
fn alone(
    lines: impl Iterator<Item = (&'static str, &'static str, String)>,
) -> Result<(), FlyConfigError> {
    let mut known: Vec<(&'static str, &'static str, String)> = Vec::new();
    for (section, key, line) in lines {
        if let Some((other, its, _)) = known.iter().find(|(_, _, known)| *known == line) {
            let why = format!(
                "found {line}, already used by [{other}] {its}, expected a line of its own"
            );
            return Err(FlyConfigError::value(section, key, &why));
        }
        known.push((section, key, line));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_are_missing_or_taken_are_refused_with_both_keys() {
        let sensors = "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n";
        let gpio = |aux: u32| {
            format!(
                "{sensors}[servo.capture.gpio]\nchip = 'g'\naux = {aux}\nlines = {{ throttle = 1, \
                 collective = 2, longitudinal = 3, lateral = 4, pedal = 5 }}\n"
            )
        };
        let checked =
            |text: &str| FlyConfig::parse(text, "fly.toml".as_ref()).unwrap().check_lines();
        checked(sensors).unwrap();
        checked(&gpio(6)).unwrap();
        for (text, said) in [
            ("[receiver]\nport = 'b'\n".to_owned(), "[dmu] port: found none"),
            ("[dmu]\nport = 'a'\n".to_owned(), "[receiver] port: found none"),
            (
                "[dmu]\nport = 'a'\n[receiver]\nport = 'a'\n".to_owned(),
                "[receiver] port: found a, already used by [dmu] port",
            ),
            (
                format!(
                    "{sensors}[servo.capture]\nserial = {{ port = 'c' }}\n[servo.stream]\nport = 'c'\n"
                ),
                "[servo.stream] port: found c, already used by [servo.capture] serial",
            ),
            (
                format!("{sensors}[telemetry]\nport = 'd'\n[mavlink]\nport = 'd'\n"),
                "[mavlink] port: found d, already used by [telemetry] port",
            ),
            (
                format!(
                    "{sensors}[servo.output]\nlateral = {{ chip = 0, output = 1 }}\n\
                     pedal = {{ chip = 0, output = 1 }}\n"
                ),
                "pedal: found chip 0, output 1, already used by [servo.output] lateral",
            ),
            (
                gpio(3),
                "[servo.capture] aux: found line 3, already used by [servo.capture] longitudinal",
            ),
        ] {
            let error = checked(&text).expect_err(&text).to_string();
            assert!(error.contains(said) && error.contains("expected"), "{text}: {error}");
        }
    }
}
