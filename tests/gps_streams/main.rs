//! Receivers' streams with known truth. Encoded data is decoded unchanged, data that the receiver marks as invalid
//! gives no fix, and damaged data gives no false fix.

mod captures;
mod damage;
mod nmea;
mod nmea_oracle;
mod quality;
mod round_trip;
mod tsip;
mod ubx;
mod ubx_relative;

use hovernav::gps::{Protocol, Receiver, ReceiverFix};
use hovernav::time::Time;

/// The fixes of `wire`, with all bytes arriving at once.
fn fixes(protocol: Protocol, wire: &[u8]) -> Vec<ReceiverFix> {
    let mut receiver = Receiver::new(protocol);
    let mut rest = wire;
    let mut fixes = Vec::new();
    while let Some(fix) = receiver.read(&mut rest, Time::ZERO) {
        fixes.push(fix);
    }
    fixes.extend(receiver.flush());
    fixes
}
