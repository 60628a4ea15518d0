//! Set-up of a vehicle: the sections of `fly.toml` and the file of its autopilot.

mod autopilot;
mod autopilot_section;
mod check;
mod error;
mod excitation_section;
mod fly_config;
mod lines;
mod mavlink;
mod navigation_ranges;
mod range;
mod ranges;
mod reach;
mod sections;

pub use autopilot::{AutopilotFileError, read_autopilot, write_autopilot};
pub use autopilot_section::{AutopilotSection, GeofenceSection, PilotRole, ThrottleSource};
pub use error::FlyConfigError;
pub use excitation_section::{ExcitationSection, InputKind, InputSection, StickName};
pub use fly_config::FlyConfig;
pub use mavlink::{MavlinkConfig, MavlinkRates};
pub use sections::{
    AccelerationSign, CaptureSection, DmuMode, DmuSection, LineSection, MavlinkSection, PwmLine,
    ReceiverProtocol, ReceiverSection, RecordSection, ServoSection, SiteSection, TelemetrySection,
};
