//! Reading a damaged file of a dataset gives valid data or an error that names the file. Written data is read back.

use std::f64::consts::PI;
use std::path::Path;

use hovernav::earth::Geodetic;
use hovernav::event::RangeReading;
use hovernav::frames::{EulerAngles, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::{ImuAxes, ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::{Dataset, Manifest};
use proptest::prelude::*;

const FILES: [&str; 6] =
    ["dataset.toml", "imu.csv", "gps.csv", "controls.csv", "baro.csv", "mag.csv"];

/// Valid files, one of each kind: the first rows of the hover flight, and made-up baro and mag.
fn sound_files() -> Vec<Vec<u8>> {
    let heli = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let beginning = |file: &str| {
        let text = std::fs::read_to_string(heli.join(file)).unwrap();
        text.lines().take(40).flat_map(|line| [line, "\n"]).collect::<String>().into_bytes()
    };
    let baro = "t_s,pressure_pa\n0.1,101000\n0.2,101001\n0.3,101002\n";
    let mag = "t_s,mag_x_gauss,mag_y_gauss,mag_z_gauss\n0.1,0.2,0,0.4\n0.2,0.2,0,0.4\n";
    vec![
        beginning("dataset.toml"),
        beginning("imu.csv"),
        beginning("gps.csv"),
        beginning("controls.csv"),
        baro.into(),
        mag.into(),
    ]
}

/// A kind of damage to a file; positions are fractions of its length.
#[derive(Clone, Debug)]
enum Damage {
    DeleteBytes(f64, usize),
    Insert(f64, Vec<u8>),
    SwapLines(f64, f64),
    RepeatLine(f64),
    DeleteLine(f64),
    SwapColumns(usize, usize),
    SetField(f64, usize, String),
    CutOff(f64),
}

fn damage() -> impl Strategy<Value = Damage> {
    let junk = prop_oneof![
        prop::collection::vec(any::<u8>(), 0..8),
        prop::sample::select(vec![
            "\"", ",", "\n", "\r\n", "-", ".", "e", "9", "\0", "\u{feff}", "é"
        ])
        .prop_map(|text| text.as_bytes().to_vec()),
    ];
    let value = prop::sample::select(vec![
        "",
        "nan",
        "-nan",
        "inf",
        "-inf",
        "1e300",
        "-1e300",
        "1e-320",
        "9223372036.9",
        "1e9",
        "0",
        "-0",
        "99",
        "abc",
        "1,2",
        "--1",
        "\"3\"",
        "18446744073709551616",
        "0.00000000000000000001",
    ]);
    prop_oneof![
        (0.0..1.0, 1usize..30).prop_map(|(at, count)| Damage::DeleteBytes(at, count)),
        (0.0..1.0, junk).prop_map(|(at, junk)| Damage::Insert(at, junk)),
        (0.0..1.0, 0.0..1.0).prop_map(|(a, b)| Damage::SwapLines(a, b)),
        (0.0..1.0).prop_map(Damage::RepeatLine),
        (0.0..1.0).prop_map(Damage::DeleteLine),
        (0usize..8, 0usize..8).prop_map(|(a, b)| Damage::SwapColumns(a, b)),
        (0.0..1.0, 0usize..14, value).prop_map(|(line, column, value)| Damage::SetField(
            line,
            column,
            value.into()
        )),
        (0.0..1.0).prop_map(Damage::CutOff),
    ]
}

impl Damage {
    fn apply(&self, file: &mut Vec<u8>) {
        let length = file.len();
        let place = |fraction: f64| (fraction * length as f64) as usize;
        let mut lines: Vec<Vec<u8>> = file.split(|byte| *byte == b'\n').map(Vec::from).collect();
        let line = |fraction: f64| (fraction * lines.len() as f64) as usize;
        let fields = |line: &[u8]| line.split(|byte| *byte == b',').map(Vec::from).collect();
        match self {
            Self::DeleteBytes(at, count) => {
                file.drain(place(*at)..(place(*at) + count).min(length));
                return;
            }
            Self::Insert(at, junk) => {
                file.splice(place(*at)..place(*at), junk.iter().copied());
                return;
            }
            Self::CutOff(at) => return file.truncate(place(*at)),
            Self::SwapLines(a, b) => {
                let (a, b) = (line(*a), line(*b));
                lines.swap(a, b);
            }
            Self::RepeatLine(at) => lines.insert(line(*at), lines[line(*at)].clone()),
            Self::DeleteLine(at) => drop(lines.remove(line(*at))),
            Self::SwapColumns(a, b) => {
                for line in &mut lines {
                    let mut fields: Vec<Vec<u8>> = fields(line);
                    if fields.len() > *a.max(b) {
                        fields.swap(*a, *b);
                    }
                    *line = fields.join(&b',');
                }
            }
            Self::SetField(at, column, value) => {
                let line = line(*at);
                let mut fields: Vec<Vec<u8>> = fields(&lines[line]);
                if let Some(field) = fields.get_mut(*column) {
                    *field = value.as_bytes().to_vec();
                }
                lines[line] = fields.join(&b',');
            }
        }
        *file = lines.join(&b'\n');
    }
}

fn assert_sound(dataset: &Dataset) {
    let is_increasing = |times: Vec<Time>| times.windows(2).all(|pair| pair[0] < pair[1]);
    assert!(!dataset.imu.is_empty());
    assert!(is_increasing(dataset.imu.iter().map(|sample| sample.time).collect()));
    assert!(is_increasing(dataset.fixes.iter().map(|fix| fix.time).collect()));
    assert!(is_increasing(dataset.baro.iter().map(|row| row.0).collect()));
    assert!(is_increasing(dataset.magnetometer.iter().map(|row| row.0).collect()));
    assert!(is_increasing(dataset.controls.iter().map(|row| row.0).collect()));
    for sample in &dataset.imu {
        assert!(sample.motion.is_finite());
        assert!(sample.attitude.is_none_or(|attitude| attitude.is_finite()));
        assert!(sample.magnetic_field_gauss.is_none_or(Vector::is_finite));
    }
    for fix in &dataset.fixes {
        let Geodetic { latitude_rad, longitude_rad, height_m } = fix.position;
        assert!(
            latitude_rad.abs() <= PI / 2.0 && longitude_rad.abs() <= PI && height_m.is_finite()
        );
        assert!(fix.horizontal_velocity_mps.is_none_or(|v| v.iter().all(|v| v.is_finite())));
        assert!(fix.down_velocity_mps.is_none_or(f64::is_finite));
        for sigma in [fix.position_sigma_m, fix.velocity_sigma_mps].into_iter().flatten() {
            assert!(sigma.is_finite() && sigma.to_array().iter().all(|sigma| *sigma > 0.0));
        }
    }
    assert!(dataset.baro.iter().all(|row| row.1.is_finite()));
    assert!(dataset.magnetometer.iter().all(|row| row.1.is_finite()));
    assert!(dataset.controls.iter().all(|row| row.1.iter().all(|stick| stick.is_finite())));
    assert!(
        dataset.warnings.iter().all(|warning| FILES.iter().any(|file| warning.starts_with(file)))
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn a_damaged_dataset_is_sound_or_refused_by_name(
        damages in prop::collection::vec((0..FILES.len(), damage()), 1..5),
    ) {
        let dir = tempfile::tempdir().unwrap();
        let mut files = sound_files();
        for (file, damage) in &damages {
            damage.apply(&mut files[*file]);
        }
        for (file, bytes) in FILES.iter().zip(&files) {
            std::fs::write(dir.path().join(file), bytes).unwrap();
        }
        match Dataset::open(dir.path()) {
            Ok(dataset) => assert_sound(&dataset),
            Err(error) => {
                let error = error.to_string();
                prop_assert!(FILES.iter().any(|file| error.contains(file)), "{error}");
                prop_assert!(!error.contains('\n') && error.len() < 500, "{error}");
            }
        }
    }

    #[test]
    fn a_dataset_written_and_read_is_the_same(dataset in dataset()) {
        let dir = tempfile::tempdir().unwrap();
        dataset.write(dir.path(), &[]).unwrap();
        let mut read = Dataset::open(dir.path()).unwrap();
        read.warnings.retain(|warning| !warning.contains("no GPS") && !warning.contains("gap of"));
        prop_assert_eq!(&read.warnings, &Vec::<String>::new());
        prop_assert_eq!(&read.manifest, &dataset.manifest);
        prop_assert_eq!(&read.baro, &dataset.baro);
        prop_assert_eq!(&read.magnetometer, &dataset.magnetometer);
        prop_assert_eq!(&read.ranges, &dataset.ranges);
        prop_assert_eq!(&read.rotor, &dataset.rotor);
        for (read, written) in read.headings.iter().zip(&dataset.headings) {
            prop_assert!((read.heading_rad - written.heading_rad).abs() < 1e-14);
        }
        prop_assert_eq!(read.headings.len(), dataset.headings.len());
        prop_assert_eq!(&read.controls, &dataset.controls);
        prop_assert_eq!(read.imu.len(), dataset.imu.len());
        for (read, written) in read.imu.iter().zip(&dataset.imu) {
            prop_assert_eq!((read.time, read.motion), (written.time, written.motion));
            prop_assert_eq!(read.magnetic_field_gauss, written.magnetic_field_gauss);
            prop_assert_eq!(read.clipped, written.clipped);
            prop_assert_eq!(read.attitude.is_some(), written.attitude.is_some());
            for (read, written) in read.attitude.iter().zip(&written.attitude) {
                prop_assert!((read.roll_rad - written.roll_rad).abs() < 1e-14);
                prop_assert!((read.pitch_rad - written.pitch_rad).abs() < 1e-14);
                prop_assert!((read.yaw_rad - written.yaw_rad).abs() < 1e-14);
            }
        }
        prop_assert_eq!(&read.injected, &dataset.injected);
        prop_assert_eq!(read.fixes.len(), dataset.fixes.len());
        for (read, written) in read.fixes.iter().zip(&dataset.fixes) {
            prop_assert!(read.position.displacement_from(&written.position).norm() < 1e-8);
            prop_assert_eq!(Fix { position: written.position, ..*read }, *written);
        }
    }
}

fn vector<F: 'static>(range: std::ops::Range<f64>) -> impl Strategy<Value = Vector<F>> {
    prop::array::uniform3(range).prop_map(|v| Vector::new(v[0], v[1], v[2]))
}

fn dataset() -> impl Strategy<Value = Dataset> {
    use prop::option::of;
    let sample = |is_rates: bool| {
        let attitude =
            (-3.1..3.1, -1.5..1.5, -3.1..3.1).prop_map(|(roll_rad, pitch_rad, yaw_rad)| {
                EulerAngles { roll_rad, pitch_rad, yaw_rad }
            });
        (
            1i64..1_000_000_000,
            vector(-9.0..9.0),
            vector(-90.0..90.0),
            of(attitude),
            of(vector(-1.0..1.0)),
            prop::array::uniform2(prop::array::uniform3(any::<bool>())),
        )
            .prop_map(move |(interval, a, b, attitude, magnetic_field_gauss, marks)| {
                ImuSample {
                    time: Time::from_nanoseconds(interval),
                    motion: match is_rates {
                        true => Motion::Rates { angular_rate_radps: a, specific_force_mps2: b },
                        false => Motion::Increments { angle_rad: a, velocity_mps: b },
                    },
                    attitude,
                    magnetic_field_gauss,
                    clipped: ImuAxes { gyro: marks[0], accel: marks[1] },
                }
            })
    };
    let imu =
        any::<bool>().prop_flat_map(move |is_rates| prop::collection::vec(sample(is_rates), 1..30));
    let fix = (
        (1i64..1_000_000_000, -89.0..89.0, -179.9..179.9, -100.0..9000.0),
        (of(prop::array::uniform2(-30.0..30.0)), of(-30.0..30.0)),
        // Rows with 0 satellites are skipped where other rows have some.
        (of(vector(0.01..50.0)), of(vector(0.01..50.0)), of(1_u8..)),
    )
        .prop_map(|((interval, lat, lon, height), (horizontal, down), (p, v, satellites))| Fix {
            horizontal_velocity_mps: horizontal,
            down_velocity_mps: down,
            position_sigma_m: p,
            velocity_sigma_mps: v,
            satellites,
            ..Fix::at(
                Time::from_nanoseconds(interval),
                Geodetic::from_degrees(lat, lon, height).unwrap(),
            )
        });
    let manifest =
        (-10.0..10.0, vector(-9.0..9.0), of(0.1..99.0)).prop_map(|(latency_s, arm, rate_hz)| {
            let mut manifest = Manifest { name: "made \"up\"".into(), ..Manifest::default() };
            manifest.gps.latency_s = latency_s;
            manifest.imu.lever_arm_m = arm;
            manifest.imu.rate_hz = rate_hz;
            manifest
        });
    (imu, prop::collection::vec(fix, 0..20), manifest, prop::array::uniform4(-1.0..1.0)).prop_map(
        |(mut imu, mut fixes, manifest, sticks)| {
            // Intervals are replaced by times of a clock that counts since 1970.
            let mut now = 1_752_000_000_123_456_789;
            for sample in &mut imu {
                now += sample.time.nanoseconds();
                sample.time = Time::from_nanoseconds(now);
            }
            for fix in &mut fixes {
                now += fix.time.nanoseconds();
                fix.time = Time::from_nanoseconds(now);
            }
            let time = imu[0].time;
            Dataset {
                manifest,
                baro: vec![(time, 1000.0 * sticks[0])],
                magnetometer: vec![(time, Vector::new(sticks[0], sticks[1], sticks[2]))],
                ranges: vec![RangeReading {
                    quality: Some(sticks[3].abs()),
                    ..RangeReading::new(time, 10.0 * sticks[1].abs())
                }],
                headings: vec![AntennaHeading::new(time, 3.0 * sticks[2], None)],
                rotor: vec![(time, 30.0 * sticks[0].abs())],
                controls: vec![(time, sticks)],
                injected: vec![sticks],
                imu,
                imu_file: None,
                controls_file: None,
                fixes,
                order: Vec::new(),
                warnings: Vec::new(),
                notes: Vec::new(),
            }
        },
    )
}

#[test]
fn a_dataset_with_a_number_that_is_none_is_not_written() {
    let mut dataset =
        Dataset::open(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover").as_ref())
            .unwrap();
    dataset.imu[7].motion = Motion::Rates {
        angular_rate_radps: Vector::new(0.0, f64::NAN, 0.0),
        specific_force_mps2: Vector::ZERO,
    };
    let dir = tempfile::tempdir().unwrap();
    let error = dataset.write(dir.path(), &[]).unwrap_err().to_string();
    assert!(
        error.ends_with("imu.csv: row 8, column gyro_y_radps: NaN cannot be written"),
        "{error}"
    );
    assert!(!dir.path().join("imu.csv").exists());
}
