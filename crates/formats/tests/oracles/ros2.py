"""Writes an MCAP file of ROS 2 with the reference library, with the given compression, and prints what the
reference library reads from it: times in ns, numbers as in the messages."""
import io
import math
import sys

from mcap.writer import CompressionType
from mcap_ros2.reader import read_ros2_messages
from mcap_ros2.writer import Writer

path, packing = sys.argv[1], CompressionType[sys.argv[2].upper()]
HEADER = """
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
VECTOR = """
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
QUATERNION = """
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""
IMU = """std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
""" + HEADER + VECTOR + QUATERNION
STATUS = """
================================================================================
MSG: sensor_msgs/NavSatStatus
int8 status
uint16 service
"""
FIX = """std_msgs/Header header
sensor_msgs/NavSatStatus status
float64 latitude
float64 longitude
float64 altitude
float64[9] position_covariance
uint8 position_covariance_type
""" + HEADER + STATUS
TWIST = """std_msgs/Header header
geometry_msgs/Twist twist
================================================================================
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
""" + HEADER + VECTOR
FIELD = """std_msgs/Header header
geometry_msgs/Vector3 magnetic_field
float64[9] magnetic_field_covariance
""" + HEADER + VECTOR
PRESSURE = """std_msgs/Header header
float64 fluid_pressure
float64 variance
""" + HEADER
TEXT = "string data\n"
START = 1_752_000_000_000_000_000


def xyz(*values):
    return dict(zip("xyz", values))


def header(at, frame):
    return {"stamp": {"sec": at // 10**9, "nanosec": at % 10**9}, "frame_id": frame}


with open(path, "wb") as out:
    writer = Writer(out, compression=packing, chunk_size=20_000)
    schema = writer.register_msgdef
    imu = schema("sensor_msgs/msg/Imu", IMU)
    fix = schema("sensor_msgs/msg/NavSatFix", FIX)
    twist = schema("geometry_msgs/msg/TwistStamped", TWIST)
    field = schema("sensor_msgs/msg/MagneticField", FIELD)
    pressure = schema("sensor_msgs/msg/FluidPressure", PRESSURE)
    text = schema("std_msgs/msg/String", TEXT)
    for i in range(3000):
        at = START + 10_000_000 * i
        t = i / 100

        def send(topic, kind, message, late=1_000_000):
            writer.write_message(topic, kind, message, at + late, at + late, i)

        half = 0.1 * t
        send("/imu/data", imu, {
            "header": header(at, "imu_link"),
            "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
            "orientation_covariance": [0.01] + 8 * [0.0],
            "angular_velocity": xyz(0.3 * math.sin(t), 0.2 * math.cos(t), 0.2),
            "angular_velocity_covariance": 9 * [0.0],
            "linear_acceleration": xyz(0.5 * math.sin(t), 0.3, 9.81 + 0.1 * math.cos(t)),
            "linear_acceleration_covariance": 9 * [0.0],
        })
        if i % 20 == 0:
            send("/imu/mag", field, {
                "header": header(at, "imu_link"),
                "magnetic_field": xyz(2e-5 * math.cos(t), 2e-5 * math.sin(t), -4e-5),
                "magnetic_field_covariance": 9 * [0.0],
            })
            send("/baro", pressure, {"header": header(at, ""), "fluid_pressure": 95e3 + t, "variance": 0.0})
            send("/chatter", text, {"data": "x" * (i % 7)})
        if i % 100 == 0:
            send("/fix", fix, {
                "header": header(at, "gps"),
                "status": {"status": 0 if i else -1, "service": 1},
                "latitude": 47.1 + 1e-6 * t, "longitude": 8.5 - 1e-6 * t, "altitude": 500 + t,
                "position_covariance": [4.0, 0, 0, 0, 2.25, 0, 0, 0, 9.0],
                "position_covariance_type": 2,
            })
            send("/fix_velocity", twist, {
                "header": header(at, "gps"),
                "twist": {"linear": xyz(0.5 + t, 0.25, -0.125), "angular": xyz(0, 0, 0)},
            })
    writer.finish()


def put(kind, at, *numbers):
    print(kind, at.sec * 10**9 + at.nanosec - START, *(repr(float(number)) for number in numbers))


for read in read_ros2_messages(path):
    message, topic = read.ros_msg, read.channel.topic
    if topic == "/imu/data":
        w, a, q = message.angular_velocity, message.linear_acceleration, message.orientation
        put("imu", message.header.stamp, w.x, w.y, w.z, a.x, a.y, a.z, q.w, q.x, q.y, q.z)
    elif topic == "/imu/mag":
        m = message.magnetic_field
        put("mag", message.header.stamp, m.x, m.y, m.z)
    elif topic == "/baro":
        put("baro", message.header.stamp, message.fluid_pressure)
    elif topic == "/fix" and message.status.status >= 0:
        put("fix", message.header.stamp, message.latitude, message.longitude, message.altitude,
            *(message.position_covariance[i] for i in (4, 0, 8)))
    elif topic == "/fix_velocity":
        v = message.twist.linear
        put("velocity", message.header.stamp, v.x, v.y, v.z)
