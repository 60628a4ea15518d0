//! A design in words, for the page and the terminal.

use std::fmt::Write as _;
use std::path::Path;

use hovernav_design::hover::{
    EstimatorLag, FlightMode, ForwardFlight, GustResponse, PerturbedStability, SampledMode,
    SampledRobustness,
};
use hovernav_design::{
    ChannelMargins, CheckedDesign, CheckedPrintedDesign, Crossing, DesignError, NotchCost,
    Regulator, ZONE,
};

/// The text for the terminal.
pub fn in_words(checked: &CheckedDesign, out: &Path) -> String {
    let mut text = format!(
        "{}: {} at {:.1} Hz, spectral radius of the closed loop {:.4}\n\n",
        out.display(),
        checked.model.name(),
        1.0 / checked.design.period_s,
        checked.spectral_radius
    );
    let _ = writeln!(
        text,
        "{:>14}  {:>8}  {:>8}  {:>7}  {:>9}   holding velocity",
        "loop", "gain up", "down", "phase", "delay"
    );
    for channel in &checked.margins.channels {
        let ChannelMargins { name, gain_up, gain_down, delay_s, .. } = channel;
        let db = |crossing: &Option<Crossing>| match crossing {
            Some(crossing) => format!("{:.1} dB", crossing.margin_db()),
            None => "any".into(),
        };
        let delay = delay_s.map_or_else(|| "any".into(), |s| format!("{:.0} ms", 1e3 * s));
        let (up, down, phase) = (db(gain_up), db(gain_down), channel.phase_deg());
        let _ = writeln!(text, "{name:>14}  {up:>8}  {down:>8}  {phase:>6.1}°  {delay:>9}");
    }
    let modes = checked.modes.iter();
    let modes = modes.map(|(mode, margins)| (format!("in {}", mode.name()), margins));
    // Margins at one output at a time, when holding velocity.
    for (name, margins) in modes.chain([("at outputs".into(), &checked.at_outputs)]) {
        let Some(margins) = margins else { continue };
        let channels = || margins.channels.iter();
        let gain_db =
            channels().map(ChannelMargins::smallest_gain_db).fold(f64::INFINITY, f64::min);
        let phase_deg = channels().map(ChannelMargins::phase_deg).fold(f64::INFINITY, f64::min);
        let _ =
            writeln!(text, "{name:>14}  {gain_db:>5.1} dB  {:>8}  {phase_deg:>6.1}°", "weakest");
    }
    if let Some((mode, channel)) = checked.weakest() {
        let (gain_db, phase_deg) = (channel.smallest_gain_db(), channel.phase_deg());
        let (mode, name) = (mode.name(), &channel.name);
        let _ = writeln!(
            text,
            "weakest: {name}, holding {mode}, with {gain_db:.1} dB and {phase_deg:.1}°"
        );
    }
    let _ = writeln!(text, "{}", perturbed(checked));
    for sentence in checked.sampled.iter().flat_map(sampled) {
        let _ = writeln!(text, "{sentence}");
    }
    let _ = writeln!(text, "{}", of_lag(checked));
    if let Some(notch) = &checked.notch {
        let _ = writeln!(text, "{}", of_notch(notch));
    }
    if let Some(forward) = &checked.forward {
        text.push_str(&in_forward_flight(checked, forward));
    }
    let _ = writeln!(
        text,
        "\n{:>14}  {:>12}  {:>12}  {:>14}  {:>16}",
        "disturbance", "within 5 %", "within 2 %", "all at trim", "5 % with stops"
    );
    for (response, within) in checked.responses.iter().zip(&checked.limited) {
        let seconds = |s: Option<f64>| s.map_or_else(|| "-".into(), |s| format!("{s:.2} s"));
        let name = format!("{} {}", response.state, response.size);
        let own = |share| seconds(response.recovered_s(share));
        let (near, nearer, all) = (own(0.05), own(0.02), seconds(response.settled_s()));
        let stopped = seconds(within.recovered_s(0.05));
        let _ = writeln!(text, "{name:>14}  {near:>12}  {nearer:>12}  {all:>14}  {stopped:>16}");
    }
    for (mode, found) in &checked.in_gusts {
        let _ = writeln!(text, "\n{}", in_gusts(checked, *mode, found));
    }
    if let Some(printed) = &checked.printed {
        text.push_str(&printed_in_words(printed, 1.0 / checked.design.period_s));
    }
    for warning in &checked.warnings {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    text
}

/// Number of models, with errors in every derivative, that stay stable in every mode and in each mode, in words.
pub fn perturbed(checked: &CheckedDesign) -> String {
    let PerturbedStability { off, of, modes, in_every_mode } = &checked.perturbed;
    let each = modes.iter().map(|(mode, stable)| format!("{} {stable}", mode.name()));
    format!(
        "stable with errors of up to {:.0} % in every derivative: {in_every_mode} of {of} in every mode ({})",
        100.0 * off,
        each.collect::<Vec<_>>().join(", ")
    )
}

/// Stability of vehicles drawn from the model's covariance, and the proven radius, in words.
pub fn sampled(found: &SampledRobustness) -> [String; 2] {
    let SampledRobustness { of, stable, directions, within_proven, modes } = found;
    let least = |margins: fn(&SampledMode) -> (f64, f64)| {
        let all = || modes.iter().map(margins);
        let gain_db = all().map(|(gain, _)| gain).fold(f64::INFINITY, f64::min);
        let phase_deg = all().map(|(_, phase)| phase).fold(f64::INFINITY, f64::min);
        format!("{gain_db:.1} dB, {phase_deg:.1}°")
    };
    let proven = modes.iter().map(|own| own.proven.map_or(0.0, |proven| proven.sigmas));
    let proven = proven.fold(f64::INFINITY, f64::min);
    let proven = if proven < 1e3 { format!("{proven:.2}") } else { "a thousand".to_owned() };
    [
        format!(
            "vehicles drawn from the covariance of the model\u{2019}s parameters: {stable} of {of} stable in every \
             mode; margins of the weakest 5 % below {}, of the worst {}",
            least(|own| own.twentieth),
            least(|own| own.worst)
        ),
        format!(
            "proven: stable while all parameters together, in {directions} directions, deviate by less than \
             {proven} sigmas; {within_proven} of these vehicles do"
        ),
    ]
}

/// The effect of the estimator's delay on the margins, in words.
pub fn of_lag(checked: &CheckedDesign) -> String {
    let EstimatorLag { rate_s, attitude_s, velocity_s } = checked.lag;
    let weakest = |which: usize| {
        let all = || checked.by_lag.iter().map(|by_lag| by_lag[which]);
        let gain_db = all().map(|(gain, _)| gain).fold(f64::INFINITY, f64::min);
        let phase_deg = all().map(|(_, phase)| phase).fold(f64::INFINITY, f64::min);
        format!("{gain_db:.1} dB, {phase_deg:.1}°")
    };
    format!(
        "delay of the estimator: {:.1} ms in rates, {:.1} ms in attitude, {:.1} ms in velocity; weakest margins in \
         any mode {}, without the delay {}",
        1e3 * rate_s,
        1e3 * attitude_s,
        1e3 * velocity_s,
        weakest(1),
        weakest(0)
    )
}

/// The delay of a notch and its phase lag, in words.
pub fn of_notch(notch: &NotchCost) -> String {
    let costs = notch.at_crossover.iter().map(|(name, radps, lag_rad)| {
        format!("{name} {:.1}° at {radps:.1} rad/s", lag_rad.to_degrees())
    });
    format!(
        "notch at {} Hz in samples of {:.0} Hz: delay {:.1} ms, included in every margin; phase lag at crossover: {}",
        notch.config.frequency_hz,
        notch.imu_hz,
        1e3 * notch.delay_s,
        costs.collect::<Vec<_>>().join(", ")
    )
}

/// The weakest margins at each speed, one line per model.
fn in_forward_flight(checked: &CheckedDesign, forward: &ForwardFlight) -> String {
    let mut text = format!(
        "\n{:>14}  {:>8}  {:>7}  {:>5}   weakest in any mode\n",
        "speed", "gain", "phase", "disk"
    );
    for point in &forward.points {
        let found = point.weakest().map_or_else(
            || "a mode is unstable".into(),
            |[gain_db, phase_deg, disk]| {
                format!("{gain_db:>5.1} dB  {phase_deg:>6.1}°  {disk:>5.2}")
            },
        );
        let origin = if point.is_given { "" } else { "   interpolated" };
        let _ = writeln!(text, "{:>10.1} m/s  {found}{origin}", point.speed_mps);
    }
    let _ = writeln!(text, "{}", allowed(checked, forward));
    text
}

/// The speed up to which the margins suffice, and the one that the autopilot allows, in words.
pub fn allowed(checked: &CheckedDesign, forward: &ForwardFlight) -> String {
    let allowed_mps = checked.autopilot().guidance.speed_mps;
    let (gain_db, phase_deg) = ZONE;
    let directions = ["forwards", "backwards"].into_iter().zip(forward.fastest_mps);
    let found = directions.filter_map(|(direction, fastest_mps)| {
        Some(format!("{direction} up to {:.1} m/s", fastest_mps?))
    });
    format!(
        "{gain_db} dB and {phase_deg}° {}; autopilot.toml allows {allowed_mps:.1} m/s",
        found.collect::<Vec<_>>().join(" and ")
    )
}

/// The response to gusts in a mode, in words.
fn in_gusts(checked: &CheckedDesign, mode: FlightMode, found: &GustResponse) -> String {
    let [horizontal, vertical] = checked.gusts.sigma_mps;
    let [p, q, r, phi, theta, psi, u, v, w] = found.states;
    let [p, q, r, phi, theta, psi] = [p, q, r, phi, theta, psi].map(f64::to_degrees);
    let [lateral, longitudinal, collective, pedal] = found.sticks.map(|stick| 100.0 * stick);
    format!(
        "holding {} in gusts of {horizontal} and {vertical} m/s, RMS: u, v, w {u:.2}, {v:.2}, {w:.2} m/s; roll, \
         pitch, heading {phi:.1}, {theta:.1}, {psi:.1}°; p, q, r {p:.1}, {q:.1}, {r:.1} °/s; sticks {lateral:.1}, \
         {longitudinal:.1}, {collective:.1}, {pedal:.1} %",
        mode.name()
    )
}

fn printed_in_words(printed: &CheckedPrintedDesign, rate_hz: f64) -> String {
    let findings = findings(printed, rate_hz).unwrap_or_default();
    let lines: String = findings.iter().map(|finding| format!("  {finding}\n")).collect();
    format!("\nthe design as printed, continuous:\n{lines}")
}

/// Findings on the printed design of the thesis, one sentence each.
pub fn findings(printed: &CheckedPrintedDesign, rate_hz: f64) -> Result<Vec<String>, DesignError> {
    let row =
        |row: Vec<f64>| row.iter().map(|value| five_digits(*value)).collect::<Vec<_>>().join(", ");
    let rows = |gain: &Regulator| {
        let rows = gain.gain.row_iter().map(|own| row(own.iter().copied().collect()));
        rows.collect::<Vec<_>>().join("; ")
    };
    let poles = printed.design.heave_poles()?;
    let [pole, ..] = &poles[..] else { return Ok(Vec::new()) };
    let [(roll_pitch, roll_pitch_seen), (yaw, yaw_seen)] = printed.design.reach()?;
    let [roll_pitch_radius, heave_radius] = printed.spectral_radii;
    Ok(vec![
        format!("roll and pitch, K = [{}]", rows(&printed.design.roll_pitch)),
        format!("yaw, K = [{}]", rows(&printed.design.yaw)),
        format!("heave, closed-loop poles {:.2} ± {:.2}i", pole.re, pole.im.abs()),
        format!(
            "ranks of controllability and observability: roll and pitch {} and {}, yaw {} and {}",
            roll_pitch.rank, roll_pitch_seen.rank, yaw.rank, yaw_seen.rank
        ),
        format!(
            "unstable when sampled at {rate_hz:.0} Hz: spectral radius {roll_pitch_radius:.1} in roll \
             and pitch, {heave_radius:.1} in heave"
        ),
    ])
}

/// Formats a number with the five digits of the thesis.
fn five_digits(value: f64) -> String {
    let size = value.abs().max(1e-12).log10().floor();
    format!("{value:.*}", (4.0 - size).clamp(0.0, 6.0) as usize)
}
