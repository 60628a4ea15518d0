//! The object: estimator, health monitor, autopilot and sensor protocols in one piece of memory.

use core::mem::{align_of, size_of};

use hovernav::autopilot::HoverAutopilot;
use hovernav::ekf::{Estimator, Measurement, Notice, Report, SteplessSolution, Unusable};
use hovernav::event::Event;
use hovernav::health::HealthMonitor;
use hovernav::imu::Notch;
use hovernav::sensors::Sensors;
use hovernav::time::Time;

use crate::queue::NoticeQueue;
use crate::status::Status;

/// Version of the binary interface: increases with every change of a structure, a code or a function.
pub const HOVERNAV_ABI: u32 = 12;

/// Largest size of an object, bytes, in any build of the library. hovernav_size() gives the size in this build.
pub const HOVERNAV_SIZE: usize = 35_328;

/// Largest size of an object, bytes, in a library built without heading-search.
pub const HOVERNAV_SIZE_WITHOUT_SEARCH: usize = 30_720;

/// Alignment of an object's memory, bytes.
pub const HOVERNAV_ALIGNMENT: usize = 16;

#[cfg(feature = "height-aids")]
type Filtering<T, H> = Estimator<hovernav::ekf::layout::Full, 28, T, H>;
#[cfg(not(feature = "height-aids"))]
type Filtering<T, H> = Estimator<hovernav::ekf::layout::WithoutHeightAids, 26, T, H>;
#[cfg(feature = "heading-search")]
type Search = hovernav::ekf::HeadingSearch<Number>;
#[cfg(not(feature = "heading-search"))]
type Search = hovernav::ekf::NoHeadingSearch;
#[cfg(not(feature = "f32"))]
type Number = f64;
#[cfg(feature = "f32")]
type Number = f32;

/// The object with estimator, health monitor, autopilot and sensor protocols. Its content is private; its size is
/// hovernav_size().
pub struct Hovernav {
    /// Equal to `MARK` from the end of creation to destruction.
    pub(crate) mark: u64,
    pub(crate) lines: Option<Sensors>,
    pub(crate) flight: Flight,
}

/// The components that receive the sensor events.
pub(crate) struct Flight {
    /// Notch filter, which all inertial samples pass before any other component.
    pub notch: Option<Notch>,
    pub estimator: Filtering<Number, Search>,
    pub monitor: HealthMonitor<Number>,
    /// Estimate for the autopilot: the solution without the jumps of corrections.
    pub stepless: SteplessSolution<Number>,
    pub autopilot: Option<HoverAutopilot<Number>>,
    pub notices: NoticeQueue,
}

pub(crate) const MARK: u64 = u64::from_be_bytes(*b"hovernav");

const _: () = {
    let most =
        if cfg!(feature = "heading-search") { HOVERNAV_SIZE } else { HOVERNAV_SIZE_WITHOUT_SEARCH };
    assert!(size_of::<Hovernav>() <= most && align_of::<Hovernav>() <= HOVERNAV_ALIGNMENT);
};

impl Flight {
    /// Calls [`push`](Self::push) with a height, if the build has states for it.
    pub fn push_height(&mut self, event: &Event) -> Result<(), Status> {
        if cfg!(not(feature = "height-aids")) {
            return Err(Status::NotBuilt);
        }
        self.push(event);
        Ok(())
    }

    /// Fuses a reading of the caller's own sensor.
    pub fn measure(
        &mut self,
        measurement: &impl Measurement,
        time: Time,
    ) -> Result<Report, Unusable> {
        self.estimator.update_traced(measurement, time, &mut self.stepless)
    }

    /// Passes the event to all components, and the estimator's notices to monitor, autopilot and queue. The notch first
    /// removes the rotor's vibration from an inertial sample.
    pub fn push(&mut self, event: &Event) {
        let Self { notch, estimator, monitor, stepless, autopilot, notices } = self;
        let filtered = match (event, notch) {
            (Event::Imu(sample), Some(notch)) => Some(Event::Imu(notch.filter(sample))),
            _ => None,
        };
        let event = filtered.as_ref().unwrap_or(event);
        monitor.observe(event);
        if let Some(autopilot) = autopilot {
            autopilot.observe(event);
        }
        estimator.push_traced(event, stepless, |notice: Notice| {
            monitor.observe_notice(&notice);
            if let Some(autopilot) = autopilot {
                autopilot.observe_notice(&notice);
            }
            notices.push(notice);
        });
    }
}
