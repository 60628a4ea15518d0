//! Findings that show only over time, in flight: lost samples, vibration, a drifting clock, swapped ports. Kinds and
//! limits are the same as in `hovernav estimate`.

use hovernav::frames::{Body, Vector};
use hovernav::time::Time;
use hovernav_findings::FindingKind;
use hovernav_findings::limits::{DRIFTED_S, HIGH_VIBRATION_MPS, LOST_SAMPLES, vibration_mps};
use hovernav_record::{Level, ShortText};

/// Length of the evaluation window for the samples, s.
const WINDOW_S: f64 = 10.0;
/// Fraction of a limit below which a finding ends.
const OVER: f64 = 0.5;
/// Shortest interval, in usual intervals, that is a gap. The estimator reports gaps, so they are not counted here.
const GAP_INTERVALS: f64 = 5.0;
/// Weight of a new interval in the running mean; the mean is the usual interval.
const SHARE: f64 = 0.02;
/// Time between two reports of a finding that continues, s.
const AGAIN_S: f64 = 60.0;
/// Length of the window in which the smallest delay of the fixes is determined, s.
const CLOCK_WINDOW_S: f64 = 30.0;
/// Smallest rate error of the flight clock that is reported. The rate errors of crystals are about a quarter of this
/// value.
const MIN_RATE: f64 = 2e-4;
/// First bytes of a receiver's messages. On the IMU's port they show that the ports are swapped.
const STARTS: [[u8; 3]; 4] = [*b"$GP", *b"$GN", [0xB5, 0x62, 0x01], [0x10, 0x8F, 0x20]];
/// Number of receiver messages on the IMU's port, without an IMU packet in between, that shows swapped ports.
const MIN_STARTS: u32 = 3;

/// A report: severity, kind and text.
pub type Report = (Level, FindingKind, ShortText);

/// State of a finding that lasts: time of its last report, `None` before the first report and after its end.
#[derive(Clone, Copy, Debug, Default)]
struct Lasting {
    reported: Option<Time>,
}

impl Lasting {
    /// Returns `Some(true)` if the finding is to be reported at `now`, `Some(false)` if its end is to be reported.
    /// `size` is in multiples of the finding's limit.
    fn update(&mut self, size: f64, now: Time) -> Option<bool> {
        if size > 1.0 && self.reported.is_none_or(|reported| now - reported >= AGAIN_S) {
            self.reported = Some(now);
            return Some(true);
        }
        (size < OVER && self.reported.take().is_some()).then_some(false)
    }
}

/// Monitor of the samples, the fixes and the IMU's line.
#[derive(Debug)]
pub struct SensorMonitor {
    usual_s: f64,
    begun: Option<Time>,
    count: u32,
    missing: f64,
    missing_in_all: f64,
    /// Whether this computer began a cycle late in the present window. Samples that are missing then are no fault of
    /// the line.
    pub is_late: bool,
    /// Specific forces of the last two samples, m/s².
    before: [Option<Vector<Body>>; 2],
    /// Sums of the squared second differences of the specific force per axis, m²/s⁴.
    bends: [f64; 3],
    lost: Lasting,
    shaken: Lasting,
    clock: ClockMonitor,
    line: LineMonitor,
}

impl SensorMonitor {
    /// A monitor of an IMU whose samples are `usual_s` apart, s.
    pub fn new(usual_s: f64) -> Self {
        Self {
            usual_s,
            begun: None,
            count: 0,
            missing: 0.0,
            missing_in_all: 0.0,
            is_late: false,
            before: [None; 2],
            bends: [0.0; 3],
            lost: Lasting::default(),
            shaken: Lasting::default(),
            clock: ClockMonitor::default(),
            line: LineMonitor::default(),
        }
    }

    /// Number of samples missing since the start. Intervals of five or more usual intervals are gaps and do not count.
    pub fn missing(&self) -> u32 {
        self.missing_in_all as u32
    }

    /// Takes a sample with its specific force, m/s², `interval_s` after the previous one; reports new findings.
    pub fn sample(
        &mut self,
        now: Time,
        interval_s: f64,
        force_mps2: Vector<Body>,
        mut report: impl FnMut(Report),
    ) {
        self.line = LineMonitor::default();
        let intervals = interval_s / self.usual_s;
        if intervals < GAP_INTERVALS {
            let missing = (intervals.round() - 1.0).max(0.0);
            self.missing += missing;
            self.missing_in_all += missing;
            if intervals < 1.5 {
                self.usual_s += SHARE * (interval_s - self.usual_s);
            }
        }
        self.count += 1;
        if let [Some(first), Some(second)] = self.before {
            let bend = (first - second * 2.0 + force_mps2).to_array();
            self.bends.iter_mut().zip(bend).for_each(|(sum, bend)| *sum += bend * bend);
        }
        self.before = [self.before[1], Some(force_mps2)];
        let begun = *self.begun.get_or_insert(now);
        if now - begun >= WINDOW_S {
            self.judge(now, &mut report);
            (self.begun, self.count, self.missing, self.bends) = (Some(now), 0, 0.0, [0.0; 3]);
            self.is_late = false;
        }
    }

    fn judge(&mut self, now: Time, report: &mut impl FnMut(Report)) {
        let count = f64::from(self.count);
        let share = self.missing / (self.missing + count).max(1.0);
        let percent = 100.0 * share;
        if let Some(is_there) = self.lost.update(share / LOST_SAMPLES, now) {
            let (level, text) = if is_there {
                let cause = if self.is_late {
                    "this computer was late: reduce its load, or give fly a real-time priority"
                } else {
                    "as on a line that loses packets: check plug, cable and baud rate"
                };
                let text = format_args!(
                    "inertial unit: {percent:.1} % of the samples are missing, {cause}"
                );
                (Level::Warning, ShortText::new(text))
            } else {
                (Level::Info, ShortText::new("inertial unit: recovered: the samples are complete"))
            };
            report((level, FindingKind::SamplesLost, text));
        }
        let squares = self.bends.into_iter().fold(0.0, f64::max);
        let walk_mps = vibration_mps(squares, count, self.usual_s);
        if let Some(is_there) = self.shaken.update(walk_mps / HIGH_VIBRATION_MPS, now) {
            let (level, text) = if is_there {
                let text = format_args!(
                    "inertial unit: vibration is high: the part too fast for the sample rate adds up to \
                     {walk_mps:.2} m/s in a second; check balance and mount"
                );
                (Level::Warning, ShortText::new(text))
            } else {
                (Level::Info, ShortText::new("inertial unit: recovered: vibration is usual"))
            };
            report((level, FindingKind::Vibration, text));
        }
    }

    /// Checks the flight clock with a fix of UTC `unix_ns`, ns since 1970, that arrived at `arrival`; reports a drift.
    pub fn fix(&mut self, arrival: Time, unix_ns: i64) -> Option<Report> {
        self.clock.fix(arrival, unix_ns)
    }

    /// Checks bytes from the IMU's line; reports a receiver at the other end of this line.
    pub fn unit_bytes(&mut self, bytes: &[u8]) -> Option<Report> {
        self.line.bytes(bytes).then(|| {
            let text = "inertial unit: its port sends GPS: swap [dmu] port and [receiver] port";
            (Level::Error, FindingKind::SetUp, ShortText::new(text))
        })
    }
}

/// Monitor of the drift of the flight clock against GPS time, from the smallest delay of the fixes in each window.
#[derive(Clone, Copy, Debug, Default)]
struct ClockMonitor {
    /// Start of the window, and the smallest delay in it, ns.
    window: Option<(Time, i64)>,
    /// Start of the first window, and the smallest delay in it, ns.
    first: Option<(Time, i64)>,
    drifted: Lasting,
}

impl ClockMonitor {
    fn fix(&mut self, arrival: Time, unix_ns: i64) -> Option<Report> {
        let delay_ns = arrival.nanoseconds().saturating_sub(unix_ns);
        let (start, min_ns) = self.window.unwrap_or((arrival, delay_ns));
        if arrival - start < CLOCK_WINDOW_S {
            self.window = Some((start, min_ns.min(delay_ns)));
            return None;
        }
        self.window = Some((arrival, delay_ns));
        let Some((first, first_ns)) = self.first else {
            self.first = Some((start, min_ns));
            return None;
        };
        let drifted_s = min_ns.saturating_sub(first_ns) as f64 * 1e-9;
        let rate = drifted_s / (start - first);
        // A jump of the receiver's UTC, by leap seconds or at its first fix, is not a drift.
        if drifted_s.abs() > 1.0 && self.drifted.reported.is_none() {
            self.first = Some((start, min_ns));
            return None;
        }
        let size = (drifted_s.abs() / DRIFTED_S).min(rate.abs() / MIN_RATE);
        self.drifted.update(size, arrival)?.then(|| {
            let side = if rate > 0.0 { "fast" } else { "slow" };
            let text = format_args!(
                "clocks: the flight clock runs {:.3} % {side} against GPS: all rates and times have this error",
                100.0 * rate.abs()
            );
            (Level::Warning, FindingKind::ClockRate, ShortText::new(text))
        })
    }
}

/// Monitor of the IMU's line for messages of a receiver.
#[derive(Clone, Copy, Debug, Default)]
struct LineMonitor {
    last: [u8; 3],
    starts: u32,
}

impl LineMonitor {
    /// Returns true once: when these bytes complete the evidence of swapped ports.
    fn bytes(&mut self, bytes: &[u8]) -> bool {
        let before = self.starts;
        for byte in bytes {
            self.last = [self.last[1], self.last[2], *byte];
            self.starts = self.starts.saturating_add(u32::from(STARTS.contains(&self.last)));
        }
        before < MIN_STARTS && self.starts >= MIN_STARTS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 1.0 / 33.0;

    /// Reports of samples up to `until_s`; `is_lost` and `force` by the number of the sample.
    fn reported(
        until_s: f64,
        is_lost: impl Fn(u32) -> bool,
        force_z: impl Fn(u32) -> f64,
    ) -> Vec<(Level, FindingKind, String)> {
        let (mut watch, mut reported, mut last) = (SensorMonitor::new(PERIOD_S), Vec::new(), 0);
        for number in (1..(until_s / PERIOD_S) as u32).filter(|number| !is_lost(*number)) {
            let now = Time::ZERO + PERIOD_S * f64::from(number);
            let interval_s = PERIOD_S * f64::from(number - last);
            last = number;
            let force = Vector::new(0.0, 0.0, force_z(number));
            watch.sample(now, interval_s, force, |(level, kind, text)| {
                reported.push((level, kind, text.as_str().to_owned()));
            });
        }
        reported
    }

    #[test]
    fn a_quarter_of_the_samples_lost_is_reported_and_its_end_too() {
        let steady = |_| -9.81;
        assert_eq!(reported(300.0, |_| false, steady), []);
        assert_eq!(reported(300.0, |number| number % 100 == 0, steady), [], "one percent is usual");
        let reported = reported(300.0, |number| number % 4 == 0 && number < 33 * 150, steady);
        let levels: Vec<_> = reported.iter().map(|(level, ..)| *level).collect();
        // At once, each minute, and when it is over.
        assert_eq!(
            levels,
            [Level::Warning, Level::Warning, Level::Warning, Level::Info],
            "{reported:?}"
        );
        assert!(reported.iter().all(|(_, kind, _)| *kind == FindingKind::SamplesLost));
        assert!(
            reported[0].2.contains("24.8 %") && reported[3].2.contains("recovered"),
            "{reported:?}"
        );
    }

    #[test]
    fn vibration_is_reported_by_the_limit_of_estimate() {
        let shaken = |number: u32| -9.81 + if number.is_multiple_of(2) { 8.0 } else { -8.0 };
        let reported = reported(100.0, |_| false, |k| if k < 33 * 50 { shaken(k) } else { -9.81 });
        let kinds: Vec<_> = reported.iter().map(|(level, kind, _)| (*level, *kind)).collect();
        let (bad, good) = (Level::Warning, Level::Info);
        assert_eq!(kinds, [(bad, FindingKind::Vibration), (good, FindingKind::Vibration)]);
    }

    #[test]
    fn a_drifting_clock_is_found_and_late_fixes_are_none() {
        let found = |rate: f64| {
            let mut watch = SensorMonitor::new(PERIOD_S);
            (0..900).find_map(|second| {
                let late_s = 0.1 + 0.2 * f64::from(second % 7) / 7.0;
                let arrival = Time::ZERO + f64::from(second) * (1.0 + rate) + late_s;
                watch.fix(arrival, 1_700_000_000_000_000_000 + i64::from(second) * 1_000_000_000)
            })
        };
        assert!(found(0.0).is_none() && found(5e-5).is_none());
        let (level, kind, text) = found(1e-3).unwrap();
        assert_eq!((level, kind), (Level::Warning, FindingKind::ClockRate));
        assert!(text.as_str().contains("runs 0.10"), "{}", text.as_str());
    }

    #[test]
    fn a_receiver_on_the_units_port_is_named_once() {
        let mut watch = SensorMonitor::new(PERIOD_S);
        let mut reported = Vec::new();
        for _ in 0..20 {
            for piece in b"$GPGGA,120000,0121.0,N,10349.0,E,1,9,1.1,42,M,,M,,*00\r\n".chunks(7) {
                reported.extend(watch.unit_bytes(piece));
            }
        }
        assert_eq!(reported.len(), 1);
        assert!(reported[0].2.as_str().contains("its port sends GPS"));
    }
}
