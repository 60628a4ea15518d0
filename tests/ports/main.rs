//! Serial ports, played sensors and a flight computer: on pseudo-terminals, or in emulated time.

#[cfg(target_os = "linux")]
mod fly;
#[cfg(unix)]
mod play;
#[cfg(unix)]
mod serial_ports;
