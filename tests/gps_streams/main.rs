//! Receivers' streams whose truth is known: what goes in comes out, what the receiver does not vouch
//! for makes no fix, and what is damaged on the way gives no false one.

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

/// The fixes of `wire`, all of it arriving at once.
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
