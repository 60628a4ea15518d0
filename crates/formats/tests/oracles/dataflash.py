"""Prints the samples that pymavlink reads from a DataFlash log, one per line: kind, time, numbers."""
import math
import sys

from pymavlink import DFReader

log = (DFReader.DFReader_text if sys.argv[1].endswith(".log") else DFReader.DFReader_binary)(
    sys.argv[1], zero_time_base=True)
READ = ("IMU", "IMU2", "IMU3", "IMT", "GPS", "GPA", "BARO", "MAG", "MAG2", "MAG3", "BAR2", "RCIN",
        "ATT", "NKQ1", "XKQ1", "XKQ", "NKQ2", "XKQ2", "NKF1", "XKF1", "POS", "TIME")
start = None
current = 0.0
trims = {1: 1500.0, 2: 1500.0, 4: 1500.0}
accuracies = {}
fixes = []
attitudes = []
rows = []
has_quaternion = False


def put(kind, time, numbers):
    print(kind, repr(float(time)), *(repr(float(number)) for number in numbers))


while True:
    message = log.recv_msg()
    if message is None:
        break
    kind = message.get_type()
    fields = message.get_fieldnames()
    if kind == "PARM" and message.Name in ("RC1_TRIM", "RC2_TRIM", "RC4_TRIM"):
        trims[int(message.Name[2])] = message.Value
    if kind not in READ:
        continue
    if kind == "TIME":
        current = message.StartTime / 1e6
        continue_time = current
    elif "TimeUS" in fields:
        continue_time = message.TimeUS / 1e6
    else:
        continue_time = current
    if start is None and continue_time > 0:
        start = continue_time
    rows.append((kind, continue_time, message, fields))
for kind, time, message, fields in rows:
    has_quaternion |= kind in ("NKQ1", "XKQ1", "XKQ")
    if kind == "GPA":
        accuracies[time] = message
for kind, time, message, fields in rows:
    time -= start
    if kind == "IMU" and getattr(message, "I", 0) == 0:
        gyro = "Gyr" if "GyrX" in fields else "Gyro"
        put("imu", time, [getattr(message, gyro + axis) for axis in "XYZ"]
            + [getattr(message, "Acc" + axis) for axis in "XYZ"])
    elif kind == "MAG" and getattr(message, "I", 0) == 0:
        put("mag", time, [getattr(message, "Mag" + axis) / 1e3 for axis in "XYZ"])
    elif kind == "BARO" and getattr(message, "I", 0) == 0:
        put("baro", time, [message.Alt])
    elif kind == "RCIN":
        put("controls", time, [(message.C1 - trims[1]) / 500, -(message.C2 - trims[2]) / 500,
                               (message.C3 - 1500) / 500, (message.C4 - trims[4]) / 500])
    elif kind == "GPS" and "Status" in fields and message.Status >= 2:
        accuracy = accuracies[time + start]
        course = math.radians(message.GCrs)
        put("gps", time - 0.11, [message.Lat, message.Lng, message.Alt,
                                 message.Spd * math.cos(course), message.Spd * math.sin(course),
                                 message.VZ, accuracy.HAcc, accuracy.VAcc, accuracy.SAcc,
                                 message.NSats])
    elif kind in ("NKQ1", "XKQ1", "XKQ") and getattr(message, "C", 0) == 0:
        put("attitude", time, [message.Q1, message.Q2, message.Q3, message.Q4])
    elif kind == "ATT" and not has_quaternion:
        angles = [message.Roll, message.Pitch, message.Yaw]
        if "RollRate" not in fields:
            angles = [math.radians(angle) for angle in angles]
        put("euler", time, angles)
    elif kind in ("NKF1", "XKF1") and getattr(message, "C", 0) == 0:
        put("velocity", time, [message.VN, message.VE, message.VD])
    elif kind == "POS":
        put("position", time, [message.Lat, message.Lng, message.Alt])
