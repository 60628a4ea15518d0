"""Writes a telemetry log with pymavlink, MAVLink 1 and 2 frames in turn, and prints its contents."""
import math
import struct
import sys

from pymavlink.dialects.v20 import common
from pymavlink.dialects.v10 import common as common1

out = open(sys.argv[1], "wb")
lines = []
mavs = []
for dialect in (common1, common):
    mav = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    mav.robust_parsing = True
    mavs.append((dialect, mav))
other = common.MAVLink(None, srcSystem=255, srcComponent=190)
START = 1_700_000_000_000_000
BOOT = 50_000_000


def send(at_us, message, mav):
    out.write(struct.pack(">Q", START + at_us) + message.pack(mav))


def put(kind, time, numbers):
    lines.append(" ".join([kind, repr(float(time))] + [repr(float(number)) for number in numbers]))


undulation = 0.0
MILLI_G = 9.80665e-3
for i in range(2000):
    at = 20_000 * i
    boot_us = BOOT + at
    boot_ms = boot_us // 1000
    dialect, mav = mavs[i % 2]
    is_new = dialect is common
    t = at / 1e6
    gyro = [round(1000 * 0.3 * math.sin(t + k)) for k in range(3)]
    force = [round(100 * math.sin(0.7 * t)), round(80 * math.cos(t)), -1000]
    field = [200, round(30 * math.sin(t)), 450]
    send(at, mav.scaled_imu_encode(boot_ms, *force, *gyro, *field), mav)
    put("imu", t, [g * 1e-3 for g in gyro] + [f * MILLI_G for f in force])
    if i % 2 == 0:
        send(at, other.heartbeat_encode(6, 8, 0, 0, 0), other)
        send(at, mav.scaled_imu2_encode(boot_ms, *force, *gyro, *field), mav)
        q = (math.cos(0.1 * t), 0.0, 0.0, math.sin(0.1 * t))
        send(at, mav.attitude_encode(boot_ms, 0.1, -0.2, 0.3, 0.0, 0.0, 0.0), mav)
        put("euler", t, struct.unpack("3f", struct.pack("3f", 0.1, -0.2, 0.3)))
        send(at, mav.local_position_ned_encode(boot_ms, 1, 2, 3, 0.5, 0.25, -0.125), mav)
        put("velocity", t, [0.5, 0.25, -0.125])
    if i % 10 == 0:
        mav2 = mavs[1][1]
        lat, lon, alt = 471234567 + i, 85123456 - i, 500_000 + i
        send(at, mav2.gps_raw_int_encode(boot_us, 3, lat, lon, alt, 80, 120, 250, 9000, 11,
                                         alt + 47_000, 1200, 2300, 400, 0), mav2)
        put("gps", t - 0.11, [lat * 1e-7, lon * 1e-7, (alt + 47_000) / 1e3,
                              2.5 * math.cos(math.pi / 2), 2.5, math.nan, 1.2, 2.3, 0.4, 11])
        send(at, mav.scaled_pressure_encode(boot_ms, 1013.25, 0.0, 2000), mav)
        put("baro", t, [0.0])
        send(at, mav2.rc_channels_encode(boot_ms, 8, 1600, 1400, 1500, 1550, *[0] * 14, 255), mav2)
        put("controls", t, [0.2, 0.2, 0.0, 0.1])
print("\n".join(lines))
