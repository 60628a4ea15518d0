//! Serial ports, sensors that are played and a flight computer: on pseudo-terminals, or by emulated time.

#[cfg(target_os = "linux")]
mod fly;
#[cfg(unix)]
mod play;
#[cfg(unix)]
mod serial_ports;
