//! The flight computer: the real-time loop and its lines.

mod cycle_timer;
mod downlink;
mod error;
mod flight_computer;
mod flight_loop;
mod ground_line;
mod messages;
mod notification;
mod port_name;
mod realtime;
mod receiver_monitor;
mod repeats;
mod report;
mod sensor_monitor;
mod servos;
mod utc;

pub use downlink::DownlinkCounts;
pub use error::FlyError;
pub use flight_computer::fly;
pub use notification::Notification;
pub use report::FlightReport;
