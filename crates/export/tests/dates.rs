//! Formats with dates contain calendar time, and the others keep the log's own clock.

use std::io::Write;
use std::sync::{Arc, Mutex};

use hovernav::ekf::Solution;
use hovernav::time::Time;
use hovernav_export::{Export, ExportFormat};

/// Output bytes that are read after the export has ended.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

fn exported(format: ExportFormat, utc_at_zero_ns: i64) -> String {
    let out = Shared::default();
    let mut export = Export::new(format, "flight", utc_at_zero_ns, out.clone()).unwrap();
    for time_s in [0.25, 1.25] {
        let place = hovernav::earth::Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
        export.push(&Solution::at_rest(Time::ZERO + time_s, place)).unwrap();
    }
    export.finish().unwrap();
    let bytes = out.0.lock().unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn dated_formats_begin_at_the_flight_s_own_date() {
    // 2025-02-10 13:56:30 UTC.
    let zero_ns = 1_739_195_790_000_000_000;
    for (format, date) in [
        (ExportFormat::Kml, "2025-02-10T13:56:30.250Z"),
        (ExportFormat::Gpx, "2025-02-10T13:56:30.250Z"),
        (ExportFormat::Pos, "2025/02/10 13:56:30.250"),
    ] {
        let text = exported(format, zero_ns);
        assert!(text.contains(date), "{text}");
        assert!(exported(format, 0).contains("1970"));
    }
    assert_eq!(exported(ExportFormat::Tum, zero_ns), exported(ExportFormat::Tum, 0));
}
