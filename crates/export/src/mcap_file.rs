//! MCAP for Foxglove and PlotJuggler: map, pose, and every column of the solution.

use std::collections::BTreeMap;
use std::io::Write as _;

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::time::Time;
use hovernav_dataset::{SOLUTION_COLUMNS, solution_row};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions};
use serde_json::{Map, Value, json};

use crate::local::{enu, flu_to_enu, position_m};
use crate::text::Thinning;
use crate::{ExportError, Out, Sink, schemas};

/// A Foxglove layout for the file: map, attitude in three dimensions, plots.
pub const LAYOUT: &str = include_str!("foxglove-layout.json");

/// Interval of the messages, s: fast enough for the motion of any vehicle, while the messages are text.
const INTERVAL_S: f64 = 0.02;

impl From<McapError> for ExportError {
    fn from(error: McapError) -> Self {
        match error {
            McapError::Io(error) => Self::Io(error),
            other => Self::Library(other.to_string()),
        }
    }
}

/// The channels of the file.
struct Channels {
    fix: u16,
    pose: u16,
    transform: u16,
    solution: u16,
}

pub struct Mcap<'w> {
    file: mcap::Writer<NoSeek<Out<'w>>>,
    channels: Channels,
    thinning: Thinning,
    /// Position of the first solution.
    origin: Option<Geodetic>,
    sequence: u32,
}

impl<'w> Mcap<'w> {
    pub fn new(out: Out<'w>) -> Result<Self, ExportError> {
        let options =
            WriteOptions::new().compression(None).disable_seeking(true).library("hovernav");
        let mut file = mcap::Writer::with_options(NoSeek::new(out), options)?;
        let mut channel = |topic: &str, name: &str, schema: Value| -> Result<u16, ExportError> {
            let schema = file.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
            Ok(file.add_channel(schema, topic, "json", &BTreeMap::new())?)
        };
        let fix = channel("/fix", "foxglove.LocationFix", schemas::location_fix())?;
        let pose = channel("/pose", "foxglove.PoseInFrame", schemas::pose_in_frame())?;
        let transform = channel("/tf", "foxglove.FrameTransform", schemas::frame_transform())?;
        let columns = schemas::solution(&SOLUTION_COLUMNS);
        let solution = channel("/solution", "hovernav.Solution", columns)?;
        let channels = Channels { fix, pose, transform, solution };
        let thinning = Thinning::to(INTERVAL_S);
        Ok(Self { file, channels, thinning, origin: None, sequence: 0 })
    }

    fn write(&mut self, one: &Solution) -> Result<(), ExportError> {
        if one.time < Time::ZERO {
            return Err(ExportError::BeforeZero(one.time.seconds()));
        }
        let origin = *self.origin.get_or_insert(one.position);
        let Channels { fix, pose, transform, solution } = self.channels;
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        let log_time = one.time.nanoseconds().cast_unsigned();
        let stamp = json!({"sec": log_time / 1_000_000_000, "nsec": log_time % 1_000_000_000});
        let [x, y, z] = position_m(one, &origin);
        let [qx, qy, qz, qw] = flu_to_enu(one.body_to_ned);
        let place = json!({"x": x, "y": y, "z": z});
        let turn = json!({"x": qx, "y": qy, "z": qz, "w": qw});
        let [east, north, up] = enu(one.position_sigma_m).map(|sigma| sigma * sigma);
        let row = SOLUTION_COLUMNS.iter().zip(solution_row(one));
        let row: Map<String, Value> =
            row.map(|(name, value)| ((*name).to_owned(), value.into())).collect();
        for (channel_id, message) in [
            (
                fix,
                json!({
                    "timestamp": stamp,
                    "frame_id": "map",
                    "latitude": one.position.latitude_deg(),
                    "longitude": one.position.longitude_deg(),
                    "altitude": one.position.height_m,
                    "position_covariance": [east, 0.0, 0.0, 0.0, north, 0.0, 0.0, 0.0, up],
                    "position_covariance_type": 2,
                }),
            ),
            (
                pose,
                json!({
                    "timestamp": stamp,
                    "frame_id": "map",
                    "pose": {"position": place, "orientation": turn},
                }),
            ),
            (
                transform,
                json!({
                    "timestamp": stamp,
                    "parent_frame_id": "map",
                    "child_frame_id": "body",
                    "translation": place,
                    "rotation": turn,
                }),
            ),
            (solution, Value::Object(row)),
        ] {
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            self.file.write_to_known_channel(&header, message.to_string().as_bytes())?;
        }
        Ok(())
    }
}

impl Sink for Mcap<'_> {
    fn push(&mut self, solution: &Solution) -> Result<(), ExportError> {
        if self.thinning.takes(solution) { self.write(solution) } else { Ok(()) }
    }

    fn finish(mut self: Box<Self>) -> Result<(), ExportError> {
        if let Some(last) = self.thinning.rest() {
            self.write(&last)?;
        }
        if self.origin.is_none() {
            return Err(ExportError::Library("found no solution, expected at least one".into()));
        }
        self.file.finish()?;
        Ok(self.file.into_inner().flush()?)
    }
}
