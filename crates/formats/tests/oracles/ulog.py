"""Prints the samples that pyulog reads from a ULog file, one per line: kind, time, numbers."""
import sys

from pyulog import ULog

log = ULog(sys.argv[1])
start = log.start_timestamp
topics = {}
for topic in log.data_list:
    if topic.multi_id == 0:
        topics[topic.name] = topic.data
delay = log.initial_parameters.get("EKF2_GPS_DELAY", 0.0)
for _, name, value in log.changed_parameters:
    if name == "EKF2_GPS_DELAY":
        delay = value


def seconds(microseconds):
    return (int(microseconds) - start) / 1e6


def put(kind, time, numbers):
    print(kind, repr(float(time)), *(repr(float(number)) for number in numbers))


def sample_time(data, i):
    stamp = data.get("timestamp_sample")
    stamp = stamp[i] if stamp is not None and stamp[i] > 0 else data["timestamp"][i]
    return seconds(stamp)


def each(name):
    data = topics.get(name)
    if data is not None:
        for i in range(len(data["timestamp"])):
            yield data, i


def vector(data, name, i, count=3):
    return [data[f"{name}[{axis}]"][i] for axis in range(count)]


undulation = 0.0
for data, i in each("sensor_combined"):
    put("imu", seconds(data["timestamp"][i]),
        vector(data, "gyro_rad", i) + vector(data, "accelerometer_m_s2", i))
if "vehicle_magnetometer" in topics:
    for data, i in each("vehicle_magnetometer"):
        put("mag", sample_time(data, i), vector(data, "magnetometer_ga", i))
else:
    last = None
    for data, i in each("sensor_combined"):
        relative = data.get("magnetometer_timestamp_relative", [-2**31] * (i + 1))[i]
        time = seconds(int(data["timestamp"][i]) + int(relative))
        if abs(relative) < 2**31 - 1 and (last is None or time > last):
            last = time
            put("mag", time, vector(data, "magnetometer_ga", i))
if "vehicle_air_data" in topics:
    for data, i in each("vehicle_air_data"):
        put("baro", sample_time(data, i), [data["baro_alt_meter"][i]])
else:
    last = None
    for data, i in each("sensor_combined"):
        relative = data.get("baro_timestamp_relative", [-2**31] * (i + 1))[i]
        time = seconds(int(data["timestamp"][i]) + int(relative))
        if abs(relative) < 2**31 - 1 and (last is None or time > last):
            last = time
            put("baro", time, [data["baro_alt_meter"][i]])
for data, i in each("vehicle_gps_position"):
    if data["fix_type"][i] < 2:
        continue
    if "latitude_deg" in data:
        place = [data["latitude_deg"][i], data["longitude_deg"][i], data["altitude_ellipsoid_m"][i]]
    else:
        place = [data["lat"][i] / 1e7, data["lon"][i] / 1e7, data["alt_ellipsoid"][i] / 1e3]
    put("gps", seconds(data["timestamp"][i]) - delay / 1e3,
        place + [data["vel_n_m_s"][i], data["vel_e_m_s"][i],
                 # A receiver that holds its height measures no vertical velocity.
                 float("nan") if data["fix_type"][i] == 2 else data["vel_d_m_s"][i]]
        + [data[name][i] for name in ("eph", "epv", "s_variance_m_s", "satellites_used")])
for data, i in each("manual_control_setpoint"):
    if "roll" in data:
        sticks = [data[name][i] for name in ("roll", "pitch", "throttle", "yaw")]
    else:
        sticks = [data["y"][i], data["x"][i], 2.0 * float(data["z"][i]) - 1.0, data["r"][i]]
    put("controls", seconds(data["timestamp"][i]), sticks)
for data, i in each("vehicle_attitude"):
    put("attitude", sample_time(data, i), vector(data, "q", i, 4))
for data, i in each("vehicle_local_position"):
    if data["v_xy_valid"][i] and data["v_z_valid"][i]:
        put("velocity", sample_time(data, i), [data[name][i] for name in ("vx", "vy", "vz")])
for data, i in each("vehicle_global_position"):
    if data["alt_ellipsoid"][i] is not None:
        put("position", sample_time(data, i),
            [data["lat"][i], data["lon"][i], data["alt_ellipsoid"][i]])
