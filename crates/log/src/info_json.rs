//! Contents of a log, as JSON.

use serde_json::{Value, json};

use crate::clock::gaps;
use crate::info::{Info, rates, sensors, vibration};
use crate::statistics::median_interval_s;
use hovernav::imu::Motion;
use hovernav::time::Time;

impl Info<'_> {
    /// The description as one JSON object: name; sensors with rates, spans and gaps; means and vibration of the
    /// inertial unit; properties of the receiver; notes and warnings.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let dataset = self.0;
        let manifest = &dataset.manifest;
        let sensors: serde_json::Map<String, Value> = sensors(dataset)
            .into_iter()
            .map(|(name, times)| (name.to_owned(), sensor(&times)))
            .collect();
        let rates = rates(dataset.samples());
        let mean = |component: usize| {
            let sum: f64 = rates.iter().map(|row| row[component]).sum();
            sum / rates.len() as f64
        };
        let form = dataset.samples().next().map(|sample| match sample.motion {
            Motion::Rates { .. } => "rates",
            Motion::Increments { .. } => "increments",
        });
        let with = |has: usize| json!({"samples": has});
        let fixes = &dataset.fixes;
        json!({
            "tool": "hovernav",
            "version": env!("CARGO_PKG_VERSION"),
            "name": manifest.name,
            "vehicle": manifest.vehicle,
            "kind": manifest.kind,
            "sensors": sensors,
            "imu": {
                "form": form,
                "attitude": with(dataset.samples().filter(|one| one.attitude.is_some()).count()),
                "mean_rate_radps": (!rates.is_empty()).then(|| [mean(0), mean(1), mean(2)]),
                "mean_specific_force_mps2": (!rates.is_empty()).then(|| [mean(3), mean(4), mean(5)]),
                "vibration_radps_and_mps2": vibration(&rates),
            },
            "gps": {
                "velocity": with(fixes.iter().filter(|fix| fix.velocity_mps().is_some()).count()),
                "horizontal_velocity":
                    with(fixes.iter().filter(|fix| fix.horizontal_velocity_mps.is_some()).count()),
                "position_sigma": with(fixes.iter().filter(|fix| fix.position_sigma_m.is_some()).count()),
                "latency_s": manifest.gps.latency_s,
                "first": fixes.first().map(|fix| json!({
                    "lat_deg": fix.position.latitude_deg(),
                    "lon_deg": fix.position.longitude_deg(),
                    "height_m": fix.position.height_m,
                })),
            },
            "notes": dataset.notes,
            "warnings": dataset.warnings,
        })
    }
}

fn sensor(times: &[Time]) -> Value {
    let interval_s = median_interval_s(times);
    let longest_s = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let gaps: Vec<Value> = gaps(times)
        .iter()
        .map(|gap| json!({"after_s": gap.after.seconds(), "length_s": gap.length_s}))
        .collect();
    json!({
        "samples": times.len(),
        "from_s": times.first().map(|time| time.seconds()),
        "to_s": times.last().map(|time| time.seconds()),
        "rate_hz": interval_s.map(|interval_s| 1.0 / interval_s),
        "longest_interval_s": longest_s,
        "gaps": gaps,
    })
}
