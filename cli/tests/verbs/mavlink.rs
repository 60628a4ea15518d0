//! A flight and a ground station of another project: pymavlink, the library of MAVProxy.
#![cfg(all(feature = "fly", target_os = "linux"))]

use std::fs;
use std::net::UdpSocket;
use std::process::{Command, Stdio};

use crate::common::place;

/// The ground station as a Python program: it prints every failed check, and `done` at the end.
const STATION: &str = r#"
import sys, time
from pymavlink import mavutil
m = mavutil.mavlink_connection(sys.argv[1], source_system=255, source_component=190)
heartbeat = m.wait_heartbeat(timeout=20)
assert heartbeat, "no heartbeat"
# MAVProxy shows this text: no mode of another autopilot.
assert mavutil.mode_string_v10(heartbeat).startswith("Mode(10"), mavutil.mode_string_v10(heartbeat)
mav = mavutil.mavlink
def ask(kind, send, wanted=lambda message: True):
    until = time.time() + 20
    send()
    while time.time() < until:
        message = m.recv_match(type=kind, blocking=True, timeout=1)
        if message is not None and wanted(message):
            return message
    raise SystemExit(f"no {kind}")
system, component = m.target_system, m.target_component

m.param_fetch_all()
values = {}
until = time.time() + 20
while time.time() < until:
    message = m.recv_match(type="PARAM_VALUE", blocking=True, timeout=1)
    if message is not None:
        values[message.param_id] = message.param_value
        if len(values) == message.param_count:
            break
assert values["HZ_ATTITUDE"] == 33 and len(values) == 11, values
value = ask("PARAM_VALUE", lambda: m.param_set_send("HZ_ATTITUDE", 5), lambda v: v.param_id == "HZ_ATTITUDE")
assert value.param_value == 33, value

for kind in range(3):
    count = ask("MISSION_COUNT", lambda: m.mav.mission_request_list_send(system, component, kind))
    assert (count.count, count.mission_type, count.target_system) == (0, kind, 255), count

def command(number, *params):
    params = list(params) + [0] * (7 - len(params))
    send = lambda: m.mav.command_long_send(system, component, number, 0, *params)
    return ask("COMMAND_ACK", send, lambda ack: ack.command == number)
ack = command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1)
assert (ack.result, ack.target_system) == (mav.MAV_RESULT_DENIED, 255), ack
assert command(mav.MAV_CMD_NAV_TAKEOFF).result == mav.MAV_RESULT_UNSUPPORTED
asked = lambda number: m.mav.command_long_send(system, component, mav.MAV_CMD_REQUEST_MESSAGE, 0, number, 0, 0, 0, 0, 0, 0)
assert ask("AUTOPILOT_VERSION", lambda: asked(148)).capabilities & mav.MAV_PROTOCOL_CAPABILITY_MAVLINK2
names = []
asked(435)
while len(names) < 6:
    message = m.recv_match(type="AVAILABLE_MODES", blocking=True, timeout=5)
    names.append(message.mode_name)
assert names[3:5] == ["the pilot", "the autopilot"], names
name = b"@PARAM/param.pck"
payload = bytes([5, 0, 0, 4, len(name), 0, 0, 0, 0, 0, 0, 0]) + name
payload += bytes(251 - len(payload))
no = ask("FILE_TRANSFER_PROTOCOL", lambda: m.mav.file_transfer_protocol_send(0, system, component, payload))
assert (no.payload[0], no.payload[3], no.payload[5], no.payload[12]) == (6, 129, 4, 10), no
sync = ask("TIMESYNC", lambda: m.mav.timesync_send(0, 12345))
assert sync.ts1 == 12345 and sync.tc1 > 0, sync
ping = ask("PING", lambda: m.mav.ping_send(1, 9, 0, 0))
assert (ping.seq, ping.target_system) == (9, 255), ping
for kind in ["SYS_STATUS", "VFR_HUD", "EXTENDED_SYS_STATE", "CURRENT_MODE", "SYSTEM_TIME", "RC_CHANNELS"]:
    ask(kind, lambda: None)
print("done")
"#;

#[test]
fn pymavlink_gets_an_answer_to_every_request() {
    let Some(python) = hovernav_testing::python(&["pymavlink==2.4.50"]) else { return };
    let directory = place("pymavlink");
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let text = format!(
        "[dmu]\nport = \"no-unit\"\n[receiver]\nport = \"no-receiver\"\nprotocol = \"ubx\"\n\
         [mavlink]\nudp = \"127.0.0.1:{port}\"\n\
         [site]\nlatitude_deg = 1.3521\nlongitude_deg = 103.8198\nheight_m = 0.0\n"
    );
    fs::write(directory.join("fly.toml"), text).unwrap();
    let mut flight = Command::new(env!("CARGO_BIN_EXE_hovernav"))
        .current_dir(&directory)
        .args(["fly", "--config", "fly.toml", "--duration", "120"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let station = Command::new(python)
        .args(["-c", STATION, &format!("udpin:127.0.0.1:{port}")])
        .env("MAVLINK20", "1")
        .env("MAVLINK_DIALECT", "development")
        .output()
        .unwrap();
    let _ = flight.kill();
    let _ = flight.wait();
    let said = String::from_utf8_lossy(&station.stdout).into_owned();
    let wrong = String::from_utf8_lossy(&station.stderr).into_owned();
    assert!(station.status.success() && said.ends_with("done\n"), "{said}{wrong}");
}
