"""Fills the corpora of ulog, dataflash, tlog and ros2 with a complete log each, of under a kilobyte: so short
that a fuzzer varies every part many times a second. Usage: python3 fuzz/seed-small.py"""

import struct
from pathlib import Path

CORPUS = Path(__file__).parent / "corpus"


def ulog():
    """Two inertial samples, a fix and an attitude, by PX4's definitions."""
    def message(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    definitions = {
        "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
        "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint8_t accelerometer_clipping;",
        "vehicle_gps_position": "uint64_t timestamp;double latitude_deg;double longitude_deg;"
        "double altitude_ellipsoid_m;float eph;float epv;uint8_t fix_type;",
        "vehicle_attitude": "uint64_t timestamp;float[4] q;",
    }
    log = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1000)
    log += message("B", bytes(40)) + message("I", b"\x0echar[3] ver_hwABC")
    log += message("P", b"\x14float EKF2_GPS_DELAY" + struct.pack("<f", 110))
    for number, (name, fields) in enumerate(definitions.items()):
        log += message("F", f"{name}:{fields}".encode())
        log += message("A", struct.pack("<BH", 0, number) + name.encode())
    for t in (2000, 7000):
        row = struct.pack("<QfffIifffB", t, 0.1, 0.2, 0.3, 5000, 0, 0.1, 0.2, -9.8, 1)
        log += message("D", struct.pack("<H", 0) + row)
    fix = struct.pack("<QdddffB", 5000, 47.1, 8.5, 500.0, 0.8, 1.2, 3)
    log += message("D", struct.pack("<H", 1) + fix) + message("O", struct.pack("<H", 20))
    return log + message("D", struct.pack("<H", 2) + struct.pack("<Qffff", 6000, 1, 0, 0, 0))


def dataflash():
    """Three kinds of messages, described by the log itself, and one of each."""
    def described(number, length, name, formats, labels):
        text = struct.pack("<4s16s64s", name, formats, labels)
        return b"\xa3\x95\x80" + bytes([number, length]) + text

    log = described(129, 36, b"IMU", b"QBffffff", b"TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
    log += described(130, 35, b"GPS", b"QBIHBLLef", b"TimeUS,Status,GMS,GWk,NSats,Lat,Lng,Alt,Spd")
    for t in (1_000_000, 1_020_000):
        log += b"\xa3\x95\x81" + struct.pack("<QBffffff", t, 0, 0.1, 0.2, 0.3, 0.1, 0.2, -9.8)
    return log + b"\xa3\x95\x82" + struct.pack("<QBIHBiiif", 1_010_000, 3, 1000, 2000, 9, 471000000, 85000000, 50000, 1)


def tlog():
    """Inertial samples and fixes as MAVLink 1 sends them, with valid checksums."""
    def frame(number, seed, payload, at):
        head = bytes([len(payload), at & 255, 1, 1, number])
        crc = 0xFFFF
        for byte in head + payload + bytes([seed]):
            low = byte ^ (crc & 0xFF)
            low = (low ^ low << 4) & 0xFF
            crc = (crc >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4)
        stamp = struct.pack(">Q", 1_700_000_000_000_000 + 20_000 * at)
        return stamp + b"\xfe" + head + payload + struct.pack("<H", crc)

    log = b""
    for at in range(6):
        imu = struct.pack("<I9h", 20 * at, 10, -20, -1000, 3, -4, 5 + at, 200, 10, 450)
        fix = struct.pack("<QiiiHHHHBB", 20_000 * at, 471234567, 85123456, 500000, 80, 120, 250, 9000, 3, 11)
        log += frame(26, 170, imu, at) + frame(24, 24, fix, at)
    return log


def ros2():
    """An inertial sample and a fix, without a chunk."""
    def record(opcode, body):
        return bytes([opcode]) + struct.pack("<Q", len(body)) + body

    def text(words):
        return struct.pack("<I", len(words)) + words

    def cdr(at_ns, *doubles, before=b""):
        head = struct.pack("<iII", 5, at_ns, 4) + b"imu\0" + before
        return b"\0\1\0\0" + head + bytes(-len(head) % 8) + struct.pack(f"<{len(doubles)}d", *doubles)

    log = b"\x89MCAP0\r\n" + record(1, text(b"ros2") + text(b"x"))
    for number, name in enumerate((b"sensor_msgs/msg/Imu", b"sensor_msgs/msg/NavSatFix")):
        schema = struct.pack("<H", number + 1) + text(name) + text(b"ros2msg") + text(b"")
        channel = struct.pack("<HH", number, number + 1) + text(b"/a%d" % number) + text(b"cdr") + text(b"")
        log += record(3, schema) + record(4, channel)
    imu = [0, 0, 0, 1] + 9 * [0] + [0.1, 0.2, 0.3] + 9 * [0] + [0.1, 0.2, 9.8]
    fix = cdr(3, 47.1, 8.5, 500.0, *9 * [1.0], before=b"\0\0\1\0") + b"\2"
    for number, data in ((0, cdr(1, *imu)), (1, fix)):
        log += record(5, struct.pack("<HIQQ", number, 0, 9, 9) + data)
    return log + record(15, bytes(4)) + record(2, bytes(20)) + b"\x89MCAP0\r\n"


for make in (ulog, dataflash, tlog, ros2):
    place = CORPUS / make.__name__
    place.mkdir(parents=True, exist_ok=True)
    (place / "small").write_bytes(make())
