//! Serial ports on pseudo-terminals, at real speed: the ports themselves, sensors that are played, a flight computer.

#[cfg(target_os = "linux")]
mod fly;
#[cfg(unix)]
mod play;
#[cfg(unix)]
mod serial_ports;
