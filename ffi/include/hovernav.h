// hovernav: navigation and hover control for small helicopters and drones.
//
// Strapdown inertial navigation with a 1 Hz GPS, and a hover autopilot, in one object in memory of the
// caller. No allocation, no threads, no clock of its own, no global state. The work of every call is bounded.
//
//     #include <hovernav.h>
//
//     static _Alignas(HOVERNAV_ALIGNMENT) unsigned char memory[HOVERNAV_SIZE];
//
//     HovernavConfig config;
//     if (hovernav_default_config(&config, HOVERNAV_ABI) != HOVERNAV_STATUS_OK)
//         return complain("header and library are of different versions");
//     config.antenna_lever_arm_m[0] = -0.35;            // 35 cm behind the centre of gravity
//
//     Hovernav *nav;
//     HovernavFault fault;                              // written where a value is out of range
//     HovernavStatus status = hovernav_create(memory, sizeof memory, &config, &fault, &nav);
//     if (status == HOVERNAV_STATUS_OUT_OF_RANGE)
//         return report(fault.what, fault.found, fault.expected);
//     if (status != HOVERNAV_STATUS_OK)
//         return complain(hovernav_status_text(status));
//
//     for (;;) {                                        // the loop of a flight computer
//         HovernavImuSample sample = {.time_ns = now, .gyro = {p, q, r}, .accel = {x, y, z}};
//         hovernav_push_imu(nav, &sample);
//         if (have_fix)
//             hovernav_push_fix(nav, &fix);             // as it arrives: late fixes are handled
//         HovernavSolution solution;
//         if (hovernav_get_solution(nav, &solution) == HOVERNAV_STATUS_OK)
//             steer(&solution);
//     }
//
// Units and frames. Times are int64_t nanoseconds on one clock, any zero. Lengths are metres, speeds m/s,
// angles rad, rates rad/s, specific force m/s^2, magnetic field gauss; latitude and longitude degrees.
// Navigation axes are north, east, down; body axes forward, right, down. Roll, pitch and yaw turn in the
// order yaw, pitch, roll; yaw is the heading, from true north clockwise. A name ends with its unit.
//
// Errors. Each function returns a HovernavStatus; a call with an error changes nothing. Null and misaligned
// pointers, memory without an object, unknown codes and values out of range are detected. Other invalid
// pointers are not. hovernav_status_text() gives the text of a status.
//
// Threads. Different objects are independent. Only one thread at a time may use an object, and never an
// interrupt that may occur during a call.
//
// Generated from the Rust source by cbindgen: do not edit (ffi/README.md describes how to regenerate it).


#ifndef HOVERNAV_H
#define HOVERNAV_H

#include <stddef.h>
#include <stdint.h>

// Longest text in a HovernavFault, bytes, its zero byte included.
#define HOVERNAV_FAULT_TEXT 64

// Version of the binary interface: increases with every change of a structure, a code or a function.
#define HOVERNAV_ABI 9

// Largest memory of an object, bytes, in any build of the library. hovernav_size() gives the memory in this build.
#define HOVERNAV_SIZE 34816

// Largest memory of an object in a library built without heading-search, bytes.
#define HOVERNAV_SIZE_WITHOUT_SEARCH 28672

// Alignment of an object's memory, bytes.
#define HOVERNAV_ALIGNMENT 16

// In HovernavAlignment.heading: the first available of two antennas, the unit's attitude, the magnetometer, unknown.
#define HOVERNAV_HEADING_ANY 0

// The unit's own attitude.
#define HOVERNAV_HEADING_ATTITUDE 1

// The magnetometer, levelled, with the declination.
#define HOVERNAV_HEADING_MAGNETOMETER 2

// The course over ground; only for vehicles that travel in the direction of their nose.
#define HOVERNAV_HEADING_COURSE 3

// Unknown: found in motion.
#define HOVERNAV_HEADING_UNKNOWN 4

// Two GPS antennas.
#define HOVERNAV_HEADING_SECOND_ANTENNA 5

// In HovernavLinesConfig.dmu_mode: rates, accelerations and field.
#define HOVERNAV_DMU_SCALED 1

// Rates, accelerations, field and the unit's own attitude.
#define HOVERNAV_DMU_ANGLE 2

// In HovernavLinesConfig.gps_protocol: Trimble Standard Interface Protocol.
#define HOVERNAV_GPS_TSIP 1

// NMEA 0183 sentences.
#define HOVERNAV_GPS_NMEA 2

// u-blox binary.
#define HOVERNAV_GPS_UBX 3

// In HovernavConfig.vehicle_kind: unstated. The fixes show whether the vehicle rolls on wheels.
#define HOVERNAV_VEHICLE_UNSTATED 0

// Helicopter with one main rotor.
#define HOVERNAV_VEHICLE_HELICOPTER 1

// Vehicle with several rotors.
#define HOVERNAV_VEHICLE_MULTIROTOR 2

// Aeroplane.
#define HOVERNAV_VEHICLE_FIXED_WING 3

// Vehicle on wheels: it is held to its road while fixes are absent.
#define HOVERNAV_VEHICLE_WHEELED 4

// Vessel on water.
#define HOVERNAV_VEHICLE_BOAT 5

// Unit in a hand or on a person.
#define HOVERNAV_VEHICLE_HANDHELD 6

// In HovernavImuSample.has: gyro and accel are integrals since the previous sample.
#define HOVERNAV_IMU_INCREMENTS 1

// In HovernavImuSample.has: the unit's own attitude is present.
#define HOVERNAV_IMU_ATTITUDE 2

// In HovernavImuSample.has: the magnetic field is present.
#define HOVERNAV_IMU_MAGNETIC_FIELD 4

// In HovernavFix.has: one-sigma of position is present.
#define HOVERNAV_FIX_POSITION_SIGMA 1

// In HovernavFix.has: velocity north and east is present.
#define HOVERNAV_FIX_HORIZONTAL_VELOCITY 2

// In HovernavFix.has: velocity down is present.
#define HOVERNAV_FIX_DOWN_VELOCITY 4

// In HovernavFix.has: one-sigma of velocity is present.
#define HOVERNAV_FIX_VELOCITY_SIGMA 8

// In HovernavFix.has: the height was held or assumed, so that neither height nor down velocity counts.
#define HOVERNAV_FIX_TWO_DIMENSIONAL 16

// Count of numbers in the matrix of hovernav_get_covariance().
#define HOVERNAV_COVARIANCE 81

// Largest number of axes in one update.
#define HOVERNAV_AXES 6

// Largest number of rows of one reading.
#define HOVERNAV_ROWS 6

// In HovernavSetPoint.kind: stop, and hold the position where the vehicle stops.
#define HOVERNAV_SET_POINT_HOLD 0

// Fly to a position and hold it, with the current heading.
#define HOVERNAV_SET_POINT_PLACE 1

// Fly to a position and hold it, and turn to a heading.
#define HOVERNAV_SET_POINT_PLACE_AND_HEADING 2

// Fly at a steady velocity.
#define HOVERNAV_SET_POINT_VELOCITY 3

// Size of the reply, bytes: more than any call needs.
#define HOVERNAV_REPLY 64

// Status of a call. 0 is success, 1 is "not yet", the others are errors of the caller; a call with an error changes
// nothing.
typedef int32_t HovernavStatus;
enum {
    // Success.
    HOVERNAV_STATUS_OK = 0,
    // Nothing to give yet: before alignment has ended, or when all notices are read.
    HOVERNAV_STATUS_NOT_YET = 1,
    // A required pointer is null.
    HOVERNAV_STATUS_NULL_POINTER = -1,
    // A pointer lacks the alignment of its type.
    HOVERNAV_STATUS_MISALIGNED = -2,
    // The memory is smaller than hovernav_size().
    HOVERNAV_STATUS_MEMORY_TOO_SMALL = -3,
    // No object was created at this address, or it was destroyed.
    HOVERNAV_STATUS_NOT_CREATED = -4,
    // Header and library are of different versions of the binary interface.
    HOVERNAV_STATUS_ABI_MISMATCH = -5,
    // A value is out of its range; HovernavFault names it, where the function has one.
    HOVERNAV_STATUS_OUT_OF_RANGE = -6,
    // An unknown code, kind or flag.
    HOVERNAV_STATUS_UNKNOWN_CODE = -7,
    // hovernav_start_autopilot() was not called.
    HOVERNAV_STATUS_NO_AUTOPILOT = -8,
    // hovernav_start_lines() was not called.
    HOVERNAV_STATUS_NO_LINES = -9,
    // The library was built without this receiver protocol, or without height-aids.
    HOVERNAV_STATUS_NOT_BUILT = -10,
    // A set-point is not finite, not a valid position, or faster than the configuration allows.
    HOVERNAV_STATUS_SET_POINT_REFUSED = -11,
    // The configuration has no notch: its notch has no harmonics.
    HOVERNAV_STATUS_NO_NOTCH = -12,
};

// Trust in a quantity.
typedef uint32_t HovernavTrust;
enum {
    // Fully usable.
    HOVERNAV_TRUST_VALID = 0,
    // Good enough to fly on, but degraded: close to its limit, by dead reckoning, or suspect after a sensor fault.
    HOVERNAV_TRUST_DEGRADED = 1,
    // Not good enough.
    HOVERNAV_TRUST_LOST = 2,
};

// Reason why a quantity is not good enough to fly on.
typedef uint32_t HovernavDistrust;
enum {
    // The quantity is good enough.
    HOVERNAV_DISTRUST_NONE = 0,
    // There is no estimate.
    HOVERNAV_DISTRUST_MISSING = 1,
    // A value is not finite.
    HOVERNAV_DISTRUST_NOT_FINITE = 2,
    // The estimate is too old, or uses another clock.
    HOVERNAV_DISTRUST_STALE = 3,
    // Roll and pitch are too uncertain.
    HOVERNAV_DISTRUST_TILT = 4,
    // Heading is too uncertain.
    HOVERNAV_DISTRUST_HEADING = 5,
    // Horizontal velocity is too uncertain.
    HOVERNAV_DISTRUST_VELOCITY = 6,
    // Vertical velocity is too uncertain.
    HOVERNAV_DISTRUST_VERTICAL_VELOCITY = 7,
    // Position is too uncertain.
    HOVERNAV_DISTRUST_POSITION = 8,
    // The sensor repeats the same values: it does not measure.
    HOVERNAV_DISTRUST_FROZEN = 9,
    // The fixes contradict the estimate.
    HOVERNAV_DISTRUST_DISAGREEMENT = 10,
    // A reason unknown to this header.
    HOVERNAV_DISTRUST_OTHER = 11,
};

// Kind of a notice.
typedef uint32_t HovernavNoticeKind;
enum {
    // Alignment ended; the first solution is available. `sigma`: one-sigma of its heading, rad.
    HOVERNAV_NOTICE_KIND_ALIGNED = 0,
    // The heading, unknown at the start, is found. `sigma`: one-sigma of the heading, rad.
    HOVERNAV_NOTICE_KIND_HEADING_FOUND = 1,
    // The heading was wrong and was replaced. `value`: the turn, rad; `sigma`: one-sigma, rad.
    HOVERNAV_NOTICE_KIND_HEADING_RESET = 2,
    // Alignment is complete except for a heading.
    HOVERNAV_NOTICE_KIND_HEADING_MISSING = 3,
    // A measurement was compared with the estimate, axis by axis: see `axes`.
    HOVERNAV_NOTICE_KIND_UPDATED = 4,
    // A measurement was not compared: see `aid` and `reason`.
    HOVERNAV_NOTICE_KIND_NOT_USED = 5,
    // An inertial sample ended a gap, which was bridged. `value`: length of the gap, s.
    HOVERNAV_NOTICE_KIND_GAP_BRIDGED = 6,
    // The covariance was reset. `value`: the length of the gap that caused it, s, else 0.
    HOVERNAV_NOTICE_KIND_COVARIANCE_RESET = 7,
    // Inertial samples start to saturate, or their vibration is far above the usual level.
    HOVERNAV_NOTICE_KIND_SAMPLE_SUSPECT = 8,
    // An inertial sample was rejected: see `reason`.
    HOVERNAV_NOTICE_KIND_SAMPLE_REFUSED = 9,
    // The heading error exceeds its one-sigma, which was increased. `value`: heading correction indicated by the
    // fixes, rad; `sigma`: one-sigma of the correction, rad.
    HOVERNAV_NOTICE_KIND_HEADING_DOUBTED = 10,
    // An event unknown to this header.
    HOVERNAV_NOTICE_KIND_OTHER = 11,
    // The magnetic field differs from its usual value: a current or iron is nearby. `value`: difference as a share
    // of its strength; `sigma`: one-sigma of the resulting error of the magnetic heading, rad.
    HOVERNAV_NOTICE_KIND_FIELD_DISTURBED = 12,
    // The magnetic field is at its usual value again. `value`: 0 if the field returned, 1 if it stayed changed and
    // became the new usual value.
    HOVERNAV_NOTICE_KIND_FIELD_USUAL = 13,
    // The position of the antenna differs from its lever arm, and the position found is used instead. `value`:
    // distance between the two, m; `sigma`: one-sigma of each horizontal part, m.
    HOVERNAV_NOTICE_KIND_ANTENNA_ELSEWHERE = 14,
    // The vehicle rolls on wheels: without fixes its velocity across the road is constrained. `sigma`: one-sigma of
    // its velocity across, m/s. Only with the feature `height-aids`.
    HOVERNAV_NOTICE_KIND_ON_WHEELS = 15,
    // The vehicle is off its wheels: the constraint has ended.
    HOVERNAV_NOTICE_KIND_OFF_WHEELS = 16,
    // The first samples or fixes show a likely mistake in units, signs or axes; the solution cannot be trusted.
    // `value`: a HovernavSetupFault, whose text is hovernav_setup_fault_text(); `sigma`: the mean specific force,
    // m/s^2, the turn reported by the gyros in half a second, rad, or the size of the velocity's unit, m/s; else 0.
    HOVERNAV_NOTICE_KIND_SETUP_SUSPECT = 17,
};

// Sources of measurements besides the inertial unit.
typedef uint32_t HovernavAid;
enum {
    // The notice has no such source.
    HOVERNAV_AID_NONE = 0,
    // GPS position and velocity.
    HOVERNAV_AID_GPS = 1,
    // The inertial unit's own attitude.
    HOVERNAV_AID_ATTITUDE = 2,
    // The magnetometer.
    HOVERNAV_AID_MAGNETOMETER = 3,
    // The barometer.
    HOVERNAV_AID_BARO = 4,
    // The rangefinder.
    HOVERNAV_AID_RANGEFINDER = 5,
    // The second antenna.
    HOVERNAV_AID_SECOND_ANTENNA = 6,
    // A sensor of the caller: hovernav_measure().
    HOVERNAV_AID_OWN = 7,
};

// Reason why a measurement or a sample was not used.
typedef uint32_t HovernavUnusedReason;
enum {
    // The measurement or sample was used.
    HOVERNAV_UNUSED_REASON_NONE = 0,
    // A value is not finite, or beyond the measurable range.
    HOVERNAV_UNUSED_REASON_NOT_FINITE = 1,
    // Older than the filter's history.
    HOVERNAV_UNUSED_REASON_TOO_OLD = 2,
    // Later than the inertial samples.
    HOVERNAV_UNUSED_REASON_AHEAD_OF_IMU = 3,
    // The reading repeats the previous one, although the vehicle moves.
    HOVERNAV_UNUSED_REASON_REPEATED = 4,
    // Too soon after the previous one to add information at its noise; no fault.
    HOVERNAV_UNUSED_REASON_TOO_SOON = 5,
    // The filter has no state for it; no fault.
    HOVERNAV_UNUSED_REASON_NO_STATE = 6,
    // The heading is still unknown; no fault.
    HOVERNAV_UNUSED_REASON_HEADING_UNKNOWN = 7,
    // A sample that is not later than the previous one.
    HOVERNAV_UNUSED_REASON_NOT_LATER = 8,
    // A sample equal to the previous one to the bit, or an unchanged distance although the vehicle moves: the sensor
    // does not measure.
    HOVERNAV_UNUSED_REASON_STUCK = 9,
    // A reason unknown to this header.
    HOVERNAV_UNUSED_REASON_OTHER = 10,
    // A distance out of the rangefinder's range, or marked as invalid by the sensor; no fault.
    HOVERNAV_UNUSED_REASON_OUT_OF_RANGE = 11,
    // The beam of the rangefinder points away from the ground; no fault.
    HOVERNAV_UNUSED_REASON_TOO_TILTED = 12,
    // A baseline longer or shorter than the mounted one.
    HOVERNAV_UNUSED_REASON_WRONG_BASELINE = 13,
    // A heading of two antennas that points in the opposite direction.
    HOVERNAV_UNUSED_REASON_REVERSED = 14,
    // A sample that a logger interpolated linearly between others.
    HOVERNAV_UNUSED_REASON_INTERPOLATED = 15,
    // An attitude that turns differently from the gyros.
    HOVERNAV_UNUSED_REASON_TURNS_OTHERWISE = 16,
    // A single reading of the magnetic field that differs from the earlier ones.
    HOVERNAV_UNUSED_REASON_OUTLIER = 17,
    // A magnetic field with too small a horizontal part: vertical or zero.
    HOVERNAV_UNUSED_REASON_FIELD_TOO_STEEP = 18,
    // After a gap roll and pitch are not accurate enough yet to level a magnetic field; no fault.
    HOVERNAV_UNUSED_REASON_NOT_LEVELLED = 19,
    // The barometer's previous reading again; no fault.
    HOVERNAV_UNUSED_REASON_NOTHING_NEW = 20,
    // The estimator has not aligned yet; no fault.
    HOVERNAV_UNUSED_REASON_NOT_ALIGNED = 21,
};

// Quantity compared in one axis of an update.
typedef uint32_t HovernavChannel;
enum {
    // Antenna position north, m.
    HOVERNAV_CHANNEL_POSITION_NORTH = 0,
    // Antenna position east, m.
    HOVERNAV_CHANNEL_POSITION_EAST = 1,
    // Antenna position down, m.
    HOVERNAV_CHANNEL_POSITION_DOWN = 2,
    // Antenna velocity north, m/s.
    HOVERNAV_CHANNEL_VELOCITY_NORTH = 3,
    // Antenna velocity east, m/s.
    HOVERNAV_CHANNEL_VELOCITY_EAST = 4,
    // Antenna velocity down, m/s.
    HOVERNAV_CHANNEL_VELOCITY_DOWN = 5,
    // Roll, rad.
    HOVERNAV_CHANNEL_ROLL = 6,
    // Pitch, rad.
    HOVERNAV_CHANNEL_PITCH = 7,
    // Heading, rad.
    HOVERNAV_CHANNEL_YAW = 8,
    // Barometric height, m, up.
    HOVERNAV_CHANNEL_BARO_HEIGHT = 9,
    // Angular rate of a vehicle at rest, forward, rad/s.
    HOVERNAV_CHANNEL_REST_RATE_X = 10,
    // Angular rate of a vehicle at rest, right, rad/s.
    HOVERNAV_CHANNEL_REST_RATE_Y = 11,
    // Angular rate of a vehicle at rest, down, rad/s.
    HOVERNAV_CHANNEL_REST_RATE_Z = 12,
    // Velocity of a vehicle at rest, north, m/s.
    HOVERNAV_CHANNEL_REST_VELOCITY_NORTH = 13,
    // Velocity of a vehicle at rest, east, m/s.
    HOVERNAV_CHANNEL_REST_VELOCITY_EAST = 14,
    // Velocity of a vehicle at rest, down, m/s.
    HOVERNAV_CHANNEL_REST_VELOCITY_DOWN = 15,
    // Distance to the ground, m.
    HOVERNAV_CHANNEL_RANGE = 16,
    // Heading of two antennas, rad.
    HOVERNAV_CHANNEL_BASELINE_HEADING = 17,
    // Velocity of a vehicle on wheels across its road, to the right, m/s.
    HOVERNAV_CHANNEL_WHEELS_RIGHT = 18,
    // Velocity of a vehicle on wheels normal to its road, down, m/s.
    HOVERNAV_CHANNEL_WHEELS_DOWN = 19,
    // A row of a sensor of the caller, in its unit.
    HOVERNAV_CHANNEL_OWN = 20,
};

// Outcome of one axis of an update.
typedef uint32_t HovernavVerdict;
enum {
    // The axis corrected the state.
    HOVERNAV_VERDICT_ACCEPTED = 0,
    // Outside the gate; the state is unchanged.
    HOVERNAV_VERDICT_REJECTED = 1,
    // Accepted after a lockout: the filter was reset to the measurement.
    HOVERNAV_VERDICT_REOPENED = 2,
};

// Mode of the autopilot.
typedef uint32_t HovernavMode;
enum {
    // The pilot flies.
    HOVERNAV_MODE_MANUAL = 0,
    // Holds or moves to a position, holds the heading.
    HOVERNAV_MODE_POSITION = 1,
    // Holds a velocity over ground and the heading.
    HOVERNAV_MODE_VELOCITY = 2,
    // Holds roll, pitch, heading and, if possible, height.
    HOVERNAV_MODE_ATTITUDE = 3,
    // As Attitude, sinking at a set rate.
    HOVERNAV_MODE_DESCENT = 4,
    // The sticks go to trim, because attitude is unknown too.
    HOVERNAV_MODE_NEUTRAL = 5,
};

// Reason of the change of mode in this step.
typedef uint32_t HovernavModeReason;
enum {
    // The mode did not change.
    HOVERNAV_MODE_REASON_UNCHANGED = 0,
    // The pilot's switch.
    HOVERNAV_MODE_REASON_SWITCH = 1,
    // The pilot moved a stick.
    HOVERNAV_MODE_REASON_OVERRIDE = 2,
    // The estimate is not good enough for the mode: see `distrust`.
    HOVERNAV_MODE_REASON_DISTRUST = 3,
    // The estimate is good enough for a better mode again.
    HOVERNAV_MODE_REASON_RECOVERED = 4,
    // Velocity did not recover within the configured time.
    HOVERNAV_MODE_REASON_PATIENCE = 5,
    // A reason unknown to this header.
    HOVERNAV_MODE_REASON_OTHER = 6,
};

// Likely mistakes in the set-up of the sensors.
typedef uint32_t HovernavSetupFault;
enum {
    // A mistake unknown to this header.
    HOVERNAV_SETUP_FAULT_OTHER = 0,
    // Accelerations in g instead of m/s^2.
    HOVERNAV_SETUP_FAULT_FORCE_IN_G = 1,
    // Accelerations in thousandths of g.
    HOVERNAV_SETUP_FAULT_FORCE_IN_THOUSANDTHS_OF_G = 2,
    // Accelerations multiplied by g once too often.
    HOVERNAV_SETUP_FAULT_FORCE_TIMES_G = 3,
    // Accelerometers with another range than assumed.
    HOVERNAV_SETUP_FAULT_FORCE_OTHER_RANGE = 4,
    // Accelerations without gravity.
    HOVERNAV_SETUP_FAULT_FORCE_WITHOUT_GRAVITY = 5,
    // Accelerations of another size than gravity.
    HOVERNAV_SETUP_FAULT_FORCE_SIZE = 6,
    // A specific force that does not point along -z: axes other than forward, right, down.
    HOVERNAV_SETUP_FAULT_FORCE_DIRECTION = 7,
    // Angular rates in deg/s instead of rad/s.
    HOVERNAV_SETUP_FAULT_RATES_IN_DEGREES = 8,
    // A vertical velocity positive up instead of down.
    HOVERNAV_SETUP_FAULT_VELOCITY_UP = 9,
    // North and east velocity swapped.
    HOVERNAV_SETUP_FAULT_VELOCITY_SWAPPED = 10,
    // A north velocity of the wrong sign.
    HOVERNAV_SETUP_FAULT_VELOCITY_NORTH_REVERSED = 11,
    // An east velocity of the wrong sign.
    HOVERNAV_SETUP_FAULT_VELOCITY_EAST_REVERSED = 12,
    // A velocity in another unit than m/s.
    HOVERNAV_SETUP_FAULT_VELOCITY_SCALE = 13,
};

// Estimator, health, autopilot and sensor lines. The content is private; its size is hovernav_size().
typedef struct Hovernav Hovernav;

// Start of the estimator.
typedef struct HovernavAlignment {
    // Source of the first heading: one of HOVERNAV_HEADING_.
    uint32_t heading;
    // Length of inertial data needed, 0.1 to 120 s.
    double duration_s;
    // Offset added to the unit's yaw for true heading, rad: the declination, if the yaw is magnetic.
    double attitude_declination_rad;
    // Magnetic declination, east positive, rad, for the magnetometer.
    double declination_rad;
    // One-sigma of the unit's own roll and pitch, rad.
    double attitude_tilt_sigma_rad;
    // One-sigma of the unit's own or the magnetic heading, rad.
    double heading_sigma_rad;
    // One-sigma of levelling at rest, rad.
    double level_sigma_rad;
    // One-sigma of levelling in motion, rad.
    double moving_level_sigma_rad;
    // One-sigma of position, used where a fix states no accuracy of its own, m.
    double position_sigma_m;
    // One-sigma of velocity, used where a fix states no accuracy of its own, m/s.
    double velocity_sigma_mps;
    // Speed from which on the course gives the heading, m/s.
    double course_speed_mps;
} HovernavAlignment;

// Error model of the inertial sensors.
typedef struct HovernavImuModel {
    // Angle random walk, rad/sqrt(s).
    double angle_random_walk_rad;
    // Velocity random walk, m/s/sqrt(s).
    double velocity_random_walk_mps;
    // Share of the gyros' measured vibration that counts as white noise.
    double gyro_vibration_share;
    // Share of the accelerometers' measured vibration that counts as white noise.
    double accel_vibration_share;
    // Time, s, within which accelerometer samples share one vibration error.
    double accel_vibration_time_s;
    // One-sigma of the gyro bias, rad/s.
    double gyro_bias_sigma_radps;
    // Correlation time of the gyro bias, s.
    double gyro_bias_time_s;
    // One-sigma of the accelerometer bias, m/s^2.
    double accel_bias_sigma_mps2;
    // Correlation time of the accelerometer bias, s.
    double accel_bias_time_s;
    // One-sigma of each gyro's scale factor error.
    double gyro_scale_sigma;
    // One-sigma of each accelerometer's scale factor error.
    double accel_scale_sigma;
    // Gyro error about the axis of a turn, as a share of the turn, without states for it. Across the axis it is 2.5
    // times as large.
    double turn_error_share;
    // Time, s, for which the error of a turn keeps its sign.
    double turn_error_time_s;
    // One-sigma of each gyro's scale factor error as a share of the net turn about its axis, without states for it.
    double net_turn_error_share;
    // Time constant with which a net turn is forgotten, s.
    double net_turn_memory_s;
    // Full scale of the gyros, rad/s; 0 if unknown.
    double gyro_range_radps;
    // Full scale of the accelerometers, m/s^2; 0 if unknown.
    double accel_range_mps2;
    // Intervals longer than this, s, are gaps.
    double gap_s;
    // One-sigma of the acceleration that a gap may have hidden, m/s^2.
    double gap_acceleration_mps2;
    // One-sigma of the angular rate that a gap may have hidden, rad/s.
    double gap_rate_radps;
    // Interval of covariance propagation, s; it is also propagated before each measurement. 0 for every sample, like
    // the state.
    double covariance_interval_s;
} HovernavImuModel;

// Error model of the GPS.
typedef struct HovernavGpsModel {
    // One-sigma of horizontal position, each axis, used where a fix states no accuracy of its own, m.
    double horizontal_sigma_m;
    // One-sigma of height, used where a fix states no accuracy of its own, m.
    double vertical_sigma_m;
    // One-sigma of horizontal velocity, each axis, used where a fix states no accuracy of its own, m/s.
    double horizontal_velocity_sigma_mps;
    // One-sigma of vertical velocity, used where a fix states no accuracy of its own, m/s.
    double vertical_velocity_sigma_mps;
    // Smallest one-sigma of the white part of position, m.
    double position_floor_m;
    // Smallest one-sigma of the white part of velocity, m/s.
    double velocity_floor_mps;
    // Share of the position's one-sigma that varies slowly, 0 to 1.
    double position_wander_share;
    // Correlation time of the position's slow error, s.
    double position_wander_time_s;
    // Share of the velocity's one-sigma that varies slowly, 0 to 1.
    double velocity_wander_share;
    // Correlation time of the velocity's slow error, s.
    double velocity_wander_time_s;
    // Time over which a receiver may have averaged its velocity, one-sigma, s.
    double velocity_smoothing_s;
    // Learning rate, 0 to 1: weight of one innovation in a learned GPS variance. The filter learns one-sigmas that
    // fixes do not state, or state too small.
    double learning_rate;
    // One-sigma of the time between a fix's position and its velocity, s.
    double position_latency_sigma_s;
    // One-sigma of the time by which a fix is valid earlier than declared, s.
    double delay_sigma_s;
} HovernavGpsModel;

// Error model of an attitude reference.
typedef struct HovernavAttitudeModel {
    // Shortest time between two updates, s.
    double interval_s;
    // One-sigma of its slow error in roll and pitch, rad.
    double tilt_wander_rad;
    // One-sigma of its slow error in heading, rad.
    double heading_wander_rad;
    // Correlation time of its slow error, s.
    double wander_time_s;
    // One-sigma of its white error, rad.
    double noise_rad;
} HovernavAttitudeModel;

// Error model of a heading from a magnetometer.
typedef struct HovernavMagnetometerModel {
    // Shortest time between two updates, s.
    double interval_s;
    // One-sigma of its slow error, rad.
    double heading_wander_rad;
    // Correlation time of its slow error, s.
    double wander_time_s;
    // One-sigma of its white error, rad.
    double noise_rad;
} HovernavMagnetometerModel;

// Error model of a barometric height.
typedef struct HovernavBaroModel {
    // One-sigma of its white error, m.
    double noise_m;
    // One-sigma of its slow error, m.
    double wander_m;
    // Correlation time of its slow error, s.
    double wander_time_s;
} HovernavBaroModel;

// Gates, and the times after which the filter is reset to rejected measurements.
typedef struct HovernavGateModel {
    // Gate, in one-sigmas: larger innovations are rejected.
    double sigmas;
    // Lockout time after an absence of measurements or a fault of the inertial samples, s.
    double recovery_s;
    // Lockout time of positions that jumped while velocity still agrees, s.
    double fault_s;
    // Lockout time of any other measurement rejected without interruption, s.
    double lockout_s;
} HovernavGateModel;

// Switches of the mechanisms that the estimator has beyond a Kalman filter with fixed noise: 1 on, 0 off. All are on by
// default. Equations such as (M11) are in docs/equations.md.
typedef struct HovernavMechanisms {
    // Zero velocity and the Earth's rate at rest (M11).
    uint32_t rest;
    // Smaller gyro biases after a rest: the change of the bias between rest and motion is learned (M11).
    uint32_t rested_bias;
    // Factor on the noise of the inertial unit, from successive innovations (K18).
    uint32_t excess_noise;
    // Steps of a bias, from growing innovations (K19).
    uint32_t bias_steps;
    // Sizes of the errors of fixes, from their innovations (M7).
    uint32_t fix_errors;
    // Heading from horizontal force only beyond the force's own error (K23).
    uint32_t level_force;
    // Larger accelerometer biases while vibration changes (K24).
    uint32_t rectification;
    // Offset of the antenna from its stated position, from turns (M16).
    uint32_t antenna_offset;
    // Motion along the road while fixes are absent, for vehicles on wheels (M17).
    uint32_t wheels;
    // Rejection of a receiver whose fixes contradict each other (K15).
    uint32_t self_contradiction;
    // Rejection of a height whose innovations are biased while another sensor of height agrees.
    uint32_t biased_heights;
    // Reports of positions that drift from their own velocity; the one-sigma reaches back to the start (K25).
    uint32_t drifting_positions;
    // A previous position as second hypothesis, after a position that jumped was accepted.
    uint32_t previous_position;
    // No fusion of fixes that repeat the previous one bit for bit.
    uint32_t repeated_fixes;
    // Correction of a heading by the heading bank (H2 to H5).
    uint32_t heading_monitor;
    // No reset by a sensor of heading while the heading bank confirms the heading.
    uint32_t confirmed_heading;
    // Second alignment after gaps (H7).
    uint32_t lost_level;
    // Changes of the magnetic field (M15).
    uint32_t field_monitor;
    // Comparison of the unit's own attitude with the gyros (M8).
    uint32_t attitude_monitor;
    // Scatter of the barometer (M18).
    uint32_t barometer_scatter;
    // Error of the barometer by the wind of the vehicle's own speed (M10).
    uint32_t barometer_wind;
    // Shocks and lost samples: force is withheld, and noise is added (S13, S16).
    uint32_t shocks;
    // Readings at full scale (S13).
    uint32_t clipping;
    // Single axes that repeat one reading (S13).
    uint32_t stuck_axes;
    // No use of samples that repeat all six readings.
    uint32_t stuck_samples;
    // No use of samples on a straight line, which a logger has interpolated (S17).
    uint32_t interpolated_samples;
} HovernavMechanisms;

// Error model of a distance to the ground, and of the ground.
typedef struct HovernavRangeModel {
    // Shortest distance that the sensor measures, m.
    double least_m;
    // Longest distance that the sensor measures, m.
    double most_m;
    // Readings below this quality, 0 to 1, are not used.
    double least_quality;
    // One-sigma of its white error, used where a reading states no accuracy of its own, m.
    double noise_m;
    // One-sigma of an additional error that grows with the distance, as a share of the distance.
    double noise_share;
    // One-sigma of the change of ground height over a metre, m.
    double ground_walk_m;
} HovernavRangeModel;

// A rangefinder that looks at the ground.
typedef struct HovernavRangefinder {
    // Position of the sensor relative to the point of the solution, body axes, m.
    double lever_arm_m[3];
    // Direction of its beam, body axes, of length one; 0, 0, 1 is straight down.
    double beam[3];
    // Error model of the sensor and of the ground.
    struct HovernavRangeModel model;
} HovernavRangefinder;

// Error model of the heading of two antennas.
typedef struct HovernavAntennaHeadingModel {
    // Shortest time between two updates, s.
    double interval_s;
    // One-sigma of the heading, used where a reading states no accuracy of its own, rad.
    double sigma_rad;
    // Smallest one-sigma, rad.
    double floor_rad;
    // Share of the one-sigma that varies slowly, 0 to 1.
    double wander_share;
    // Correlation time of the slow error, s.
    double wander_time_s;
    // Largest difference of a measured baseline from the mounted one, m; beyond it the heading is rejected.
    double length_tolerance_m;
} HovernavAntennaHeadingModel;

// The second of two GPS antennas that give a heading.
typedef struct HovernavSecondAntenna {
    // Vector from the first antenna to the second, body axes, m; all zero for headings of the vehicle itself.
    double baseline_m[3];
    // Error model of its heading.
    struct HovernavAntennaHeadingModel model;
} HovernavSecondAntenna;

// A notch at the speed of a rotor: removes its vibration from the inertial samples before all other processing. Slow
// motion is delayed by width_hz / (2 pi frequency_hz^2) seconds, and the times of the samples are corrected for
// that.
typedef struct HovernavNotch {
    // Speed of the rotor, turns a second, Hz; 0 until hovernav_push_rotor_speed() sets it.
    double frequency_hz;
    // Width of the notch at half power, Hz, the same at each harmonic.
    double width_hz;
    // Lowest frequency in the samples that is removed, Hz: below it the vehicle itself moves.
    double least_hz;
    // Number of harmonics of the speed that are removed, 1 to 4; 0 for no notch, and then frequency_hz is 0.
    uint32_t harmonics;
} HovernavNotch;

// Accuracy of the estimate required to fly: one-sigmas and times.
typedef struct HovernavHealthLimits {
    // Roll and pitch, rad.
    double tilt_sigma_rad;
    // Heading, rad.
    double heading_sigma_rad;
    // Horizontal velocity, m/s.
    double velocity_sigma_mps;
    // Vertical velocity, m/s.
    double vertical_velocity_sigma_mps;
    // Position, each axis, m.
    double position_sigma_m;
    // Age of the estimate, s.
    double age_s;
    // Time without an accepted fix, s, after which the estimate counts as dead reckoning.
    double dead_reckoning_s;
    // Time of rejected fixes, s, after which they contradict the estimate.
    double disagreement_s;
    // Time, s, for which a quantity must be good before a better mode is flown on it again.
    double recovery_s;
} HovernavHealthLimits;

// The complete configuration of the estimator. hovernav_default_config() sets it to defaults; change known values.
typedef struct HovernavConfig {
    // Position of the inertial unit relative to the point of the solution (such as the centre of gravity), body
    // axes, m.
    double imu_lever_arm_m[3];
    // Position of the GPS antenna relative to the same point, body axes, m.
    double antenna_lever_arm_m[3];
    // 1 if the unit's own attitude is used after alignment, else 0.
    uint32_t use_attitude;
    // 1 if the magnetometer is used, unless the unit's own attitude is, else 0.
    uint32_t use_magnetometer;
    // 1 if the barometer is used, else 0.
    uint32_t use_baro;
    // 1 if the rangefinder is used, else 0.
    uint32_t use_rangefinder;
    // 1 if the heading of two antennas is used, else 0.
    uint32_t use_second_antenna;
    // Kind of the vehicle, one of `HOVERNAV_VEHICLE_`. With `HOVERNAV_VEHICLE_UNSTATED` the fixes show whether the
    // vehicle rolls on wheels.
    uint32_t vehicle_kind;
    // Start of the estimator.
    struct HovernavAlignment alignment;
    // Inertial sensors.
    struct HovernavImuModel imu;
    // GPS.
    struct HovernavGpsModel gps;
    // The unit's own attitude.
    struct HovernavAttitudeModel attitude;
    // Magnetometer.
    struct HovernavMagnetometerModel magnetometer;
    // Barometer.
    struct HovernavBaroModel baro;
    // Gates and recovery.
    struct HovernavGateModel gate;
    // Switches of the mechanisms.
    struct HovernavMechanisms mechanisms;
    // The rangefinder.
    struct HovernavRangefinder rangefinder;
    // The second antenna.
    struct HovernavSecondAntenna second_antenna;
    // The notch before the estimator.
    struct HovernavNotch notch;
    // Limits of hovernav_get_health().
    struct HovernavHealthLimits health;
} HovernavConfig;

// The value of a configuration that is out of range. Texts are UTF-8 and end with a zero byte.
typedef struct HovernavFault {
    // Path of the field in the configuration: "imu.gap_s". An array, or the gains of one regulator, count as one
    // field.
    char what[HOVERNAV_FAULT_TEXT];
    // The value found.
    double found;
    // The expected range, as text.
    char expected[HOVERNAV_FAULT_TEXT];
} HovernavFault;

// The four controls about hover trim, each -1 to 1 of full travel.
typedef struct HovernavSticks {
    // Lateral cyclic.
    double lateral;
    // Longitudinal cyclic.
    double longitudinal;
    // Collective.
    double collective;
    // Pedal.
    double pedal;
} HovernavSticks;

// Positions of the sticks in a steady hover, and the roll and pitch of the vehicle.
typedef struct HovernavTrim {
    // The controls.
    struct HovernavSticks sticks;
    // Roll, rad.
    double roll_rad;
    // Pitch, rad.
    double pitch_rad;
} HovernavTrim;

// Range and rate limits of the autopilot's commands, for each control.
typedef struct HovernavStickLimits {
    // Lowest, -1 to 0.
    struct HovernavSticks lowest;
    // Highest, 0 to 1.
    struct HovernavSticks highest;
    // Fastest, full travels (of 1) a second; above 0.
    struct HovernavSticks rate_per_s;
} HovernavStickLimits;

// Limits and gains of guidance.
typedef struct HovernavGuidance {
    // Horizontal speed per distance from the set-point's position, 1/s.
    double position_gain_per_s;
    // Vertical speed per height error, 1/s.
    double height_gain_per_s;
    // Fastest horizontal speed, m/s.
    double speed_mps;
    // Fastest climb and descent, m/s.
    double climb_mps;
    // Largest commanded horizontal acceleration, m/s^2.
    double acceleration_mps2;
    // Largest commanded vertical acceleration, m/s^2.
    double climb_acceleration_mps2;
    // Fastest turn, rad/s.
    double yaw_rate_radps;
} HovernavGuidance;

// Transitions between modes.
typedef struct HovernavTransfer {
    // Time constant, s, of the fade of the difference between two modes' commands.
    double fade_s;
    // Time constant of the same fade when the pilot takes over, s.
    double hand_back_s;
    // Time constant with which the sticks go to trim when attitude is unknown, s.
    double neutral_s;
    // Deflection of a stick that counts as the pilot's override.
    double override_travel;
    // Time for which attitude is held without velocity before the descent begins, s.
    double patience_s;
    // Sink rate of the descent, m/s.
    double descent_mps;
    // Stick by which the trimmed collective changes, in the sinking direction, in a descent without vertical
    // velocity.
    double descent_collective;
    // Time constant of learning trim in a steady hover, s.
    double trim_s;
} HovernavTransfer;

// Gains of a PID controller; units are the command's over the error's, combined with s as the names state.
typedef struct HovernavPidGains {
    // Command per error.
    double proportional;
    // Command per error and s.
    double integral_per_s;
    // Command per rate of change of the measured value, s.
    double derivative_s;
    // Time constant of the low-pass on the derivative, s; from 0.
    double derivative_filter_s;
    // Time constant with which the integral follows a limited command, s; above 0.
    double tracking_time_s;
} HovernavPidGains;

// Gains of the yaw regulator. Measured states are r, psi; there are two hidden states.
typedef struct HovernavYawGains {
    // Stick per measured state, row by control.
    double measured[1][2];
    // Stick per hidden state.
    double hidden[1][2];
    // Stick per command under way.
    double pending[1][1];
    // Stick per s of measured error.
    double integral_per_s[1][2];
    // Propagation of the hidden states over a sample, from themselves.
    double hidden_from_hidden[2][2];
    // Propagation from the measured states.
    double hidden_from_measured[2][2];
    // Propagation from the command that acts.
    double hidden_from_pending[2][1];
    // Time constant with which the integrals follow a limited command, s.
    double tracking_time_s;
} HovernavYawGains;

// Gains of the roll and pitch regulator. Measured states are p, q, phi, theta, u, v; there are six hidden states.
// The controls are lateral and longitudinal cyclic.
typedef struct HovernavRollPitchGains {
    // Stick per measured state, row by control.
    double measured[2][6];
    // Stick per hidden state.
    double hidden[2][6];
    // Stick per command under way.
    double pending[2][2];
    // Stick per s of measured error.
    double integral_per_s[2][6];
    // Propagation of the hidden states over a sample, from themselves.
    double hidden_from_hidden[6][6];
    // Propagation from the measured states.
    double hidden_from_measured[6][6];
    // Propagation from the command that acts.
    double hidden_from_pending[6][2];
    // Time constant with which the integrals follow a limited command, s.
    double tracking_time_s;
} HovernavRollPitchGains;

// Gains of the attitude regulator, for flight without a known velocity. Measured states are p, q, phi, theta.
typedef struct HovernavAttitudeGains {
    // Stick per measured state, row by control.
    double measured[2][4];
    // Stick per hidden state.
    double hidden[2][6];
    // Stick per command under way.
    double pending[2][2];
    // Stick per s of measured error.
    double integral_per_s[2][4];
    // Propagation of the hidden states over a sample, from themselves.
    double hidden_from_hidden[6][6];
    // Propagation from the measured states.
    double hidden_from_measured[6][4];
    // Propagation from the command that acts.
    double hidden_from_pending[6][2];
    // Time constant with which the integrals follow a limited command, s.
    double tracking_time_s;
} HovernavAttitudeGains;

// Gains of the autopilot, for the sample period of their design.
typedef struct HovernavGains {
    // Collective from the downward velocity w, body axes.
    struct HovernavPidGains heave;
    // Pedal from r, psi.
    struct HovernavYawGains yaw;
    // Pedal per collective.
    double pedal_per_collective;
    // Cyclic from p, q, phi, theta, u, v.
    struct HovernavRollPitchGains roll_pitch;
    // Cyclic from p, q, phi, theta.
    struct HovernavAttitudeGains attitude;
} HovernavGains;

// The complete configuration of the autopilot. hovernav_default_autopilot_config() sets it to the given gains, and to
// defaults for everything else.
typedef struct HovernavAutopilotConfig {
    // Period of the control loop, s, for which the gains were designed.
    double period_s;
    // Initial trim; a better one is learned in flight.
    struct HovernavTrim trim;
    // Range and rate of the commands.
    struct HovernavStickLimits limits;
    // Limits and gains of guidance.
    struct HovernavGuidance guidance;
    // Accuracy of the estimate required to fly.
    struct HovernavHealthLimits health;
    // Transitions between modes.
    struct HovernavTransfer transfer;
    // The gains.
    struct HovernavGains gains;
} HovernavAutopilotConfig;

// Limits of a receiver's fix.
typedef struct HovernavFixLimits {
    // 1 if a fix whose height is held or assumed is rejected, else 0.
    uint32_t need_three_dimensions;
    // Smallest number of satellites used, 0 to 255.
    uint32_t min_satellites;
    // Largest dilution of precision of position.
    double max_position_dilution;
    // Largest horizontal dilution of precision.
    double max_horizontal_dilution;
    // Largest one-sigma of horizontal position, m.
    double max_horizontal_sigma_m;
    // Largest one-sigma of height, m.
    double max_vertical_sigma_m;
    // Largest one-sigma of velocity on any axis, m/s.
    double max_velocity_sigma_mps;
    // Largest ground speed of the vehicle, m/s.
    double max_ground_speed_mps;
    // Largest climb or sink rate of the vehicle, m/s.
    double max_vertical_speed_mps;
    // Largest distance of a position beyond the reach of the top speed since the last good fix, m.
    double max_jump_m;
    // Largest delay of a fix relative to the most prompt recent fix, s.
    double max_delay_s;
} HovernavFixLimits;

// Settings of the two serial lines: a Crossbow DMU-HDX-AHRS, and a receiver. With only one of them, leave the
// other's settings at their defaults and never call its function.
typedef struct HovernavLinesConfig {
    // Packet type that the unit sends: one of HOVERNAV_DMU_.
    uint32_t dmu_mode;
    // Time between requests for a packet, s; with 0 the unit sends as fast as it can.
    double dmu_cycle_s;
    // Latency from the moment of a sample to the arrival of its packet's last byte, s.
    double dmu_latency_s;
    // Rated range of the gyros, deg/s.
    double rate_range_degps;
    // Rated range of the accelerometers, standard gravity.
    double accel_range_g;
    // 1 for an accelerometer whose word counts along its axis, -1 against it: x, y, z.
    int32_t accel_signs[3];
    // Protocol of the receiver: one of HOVERNAV_GPS_.
    uint32_t gps_protocol;
    // Fix rate for the receiver, Hz, 1 to 10; 0 leaves the receiver as it is.
    uint32_t gps_rate_hz;
    // Latency from the validity of a fix to its arrival, s.
    double gps_latency_s;
    // 1 if geoid_separation_m is used, for a receiver that does not send it, else 0.
    uint32_t has_geoid_separation;
    // The geoid's height above the ellipsoid at the site, m.
    double geoid_separation_m;
    // Limits that a fix must meet.
    struct HovernavFixLimits fix_limits;
} HovernavLinesConfig;

// One sample of the inertial unit, body axes forward, right, down.
typedef struct HovernavImuSample {
    // Time of the rates, or end of the increments, ns.
    int64_t time_ns;
    // Sum of HOVERNAV_IMU_ flags; 0 for rates only.
    uint32_t has;
    // Angular rate, rad/s; as an increment its integral, rad.
    double gyro[3];
    // Specific force, m/s^2 (level and at rest z is -9.81); as an increment its integral, m/s.
    double accel[3];
    // The unit's own roll, rad.
    double roll_rad;
    // The unit's own pitch, rad.
    double pitch_rad;
    // The unit's own yaw, rad, from north clockwise.
    double yaw_rad;
    // Magnetic field, gauss.
    double magnetic_field_gauss[3];
} HovernavImuSample;

// A satellite fix of the antenna, at its time of validity (arrival minus latency), on the clock of the inertial
// samples.
typedef struct HovernavFix {
    // Time of validity, ns.
    int64_t time_ns;
    // Sum of HOVERNAV_FIX_ flags; 0 for a position only.
    uint32_t has;
    // Geodetic latitude, WGS-84, degrees, north positive.
    double latitude_deg;
    // Longitude, degrees, east positive.
    double longitude_deg;
    // Height above the ellipsoid (not above the sea), m.
    double height_m;
    // One-sigma of position north, east, down, m; above 0.
    double position_sigma_m[3];
    // Velocity north, east, down, m/s.
    double velocity_ned_mps[3];
    // One-sigma of velocity, m/s; above 0.
    double velocity_sigma_mps[3];
} HovernavFix;

// Position, velocity and attitude at one moment, corrected for biases, with one-sigmas. Position and velocity are
// those of the reference point of the configured lever arms.
typedef struct HovernavSolution {
    // Time of the inertial sample of the solution, ns.
    int64_t time_ns;
    // Geodetic latitude, WGS-84, degrees, north positive.
    double latitude_deg;
    // Longitude, degrees, east positive.
    double longitude_deg;
    // Height above the ellipsoid, m.
    double height_m;
    // Velocity over ground north, east, down, m/s.
    double velocity_ned_mps[3];
    // Velocity in body axes: u, v, w, m/s.
    double velocity_body_mps[3];
    // Attitude as a quaternion w, x, y, z that turns body axes into north, east, down.
    double body_to_ned[4];
    // Roll, rad.
    double roll_rad;
    // Pitch, rad.
    double pitch_rad;
    // Heading, rad, from true north clockwise.
    double yaw_rad;
    // Angular rate p, q, r, body axes, rad/s.
    double angular_rate_radps[3];
    // One-sigma of position north, east, down, m.
    double position_sigma_m[3];
    // One-sigma of velocity north, east, down, m/s.
    double velocity_sigma_mps[3];
    // One-sigma of roll, pitch, yaw, rad.
    double attitude_sigma_rad[3];
    // Gyro bias, body axes, rad/s.
    double gyro_bias_radps[3];
    // Accelerometer bias, body axes, m/s^2.
    double accel_bias_mps2[3];
    // One-sigma of the gyro bias, rad/s.
    double gyro_bias_sigma_radps[3];
    // One-sigma of the accelerometer bias, m/s^2.
    double accel_bias_sigma_mps2[3];
} HovernavSolution;

// Health of the estimate: trust in its quantities, with reasons.
typedef struct HovernavHealth {
    // Roll, pitch and heading.
    HovernavTrust attitude;
    // Velocity, all axes.
    HovernavTrust velocity;
    // Position.
    HovernavTrust position;
    // Reason for roll, pitch and angular rates.
    HovernavDistrust tilt_reason;
    // Reason for the heading.
    HovernavDistrust heading_reason;
    // Reason for horizontal velocity.
    HovernavDistrust velocity_reason;
    // Reason for vertical velocity.
    HovernavDistrust vertical_velocity_reason;
    // Reason for position.
    HovernavDistrust position_reason;
    // 1 if velocity and position are by dead reckoning, because fixes are missing.
    uint32_t dead_reckoning;
    // Time of the last accepted fix in this case, ns.
    int64_t dead_reckoning_since_ns;
} HovernavHealth;

// One axis of an update.
typedef struct HovernavInnovation {
    // The quantity compared.
    HovernavChannel channel;
    // The outcome.
    HovernavVerdict verdict;
    // Measured minus predicted, in the channel's unit.
    double innovation;
    // Predicted one-sigma of the innovation, in the channel's unit.
    double sigma;
} HovernavInnovation;

// A notice of the estimator.
typedef struct HovernavNotice {
    // The kind, which determines which of the fields below count.
    HovernavNoticeKind kind;
    // Source of the measurement.
    HovernavAid aid;
    // Reason why it was not used.
    HovernavUnusedReason reason;
    // Number of valid entries in `axes`.
    uint32_t axis_count;
    // Time of the event, ns.
    int64_t time_ns;
    // Meaning depends on the kind.
    double value;
    // Meaning depends on the kind.
    double sigma;
    // The axes of an update, in the order of their processing.
    struct HovernavInnovation axes[HOVERNAV_AXES];
} HovernavNotice;

// The motion of a sensor that the filter expects at the time of a reading.
typedef struct HovernavExpected {
    // Time of the reading, ns.
    int64_t time_ns;
    // Geodetic latitude of the sensor, WGS-84, degrees, north positive.
    double latitude_deg;
    // Longitude, degrees, east positive.
    double longitude_deg;
    // Height above the ellipsoid, m.
    double height_m;
    // Velocity of the sensor over ground north, east, down, m/s.
    double velocity_ned_mps[3];
    // Velocity of the sensor over ground in body axes, m/s.
    double velocity_body_mps[3];
    // Attitude as a quaternion w, x, y, z that turns body axes into north, east, down.
    double body_to_ned[4];
    // Angular rate p, q, r relative to inertial space, body axes, rad/s.
    double angular_rate_radps[3];
} HovernavExpected;

// One measured quantity in any unit: its residual, and the derivatives of the expected value by the motion of the
// sensor. All numbers are finite: residual and sigma at most 1e9, derivatives at most 1e6, sigma at least 1e-9.
typedef struct HovernavRow {
    // Measured minus expected.
    double residual;
    // One-sigma of the measurement's white error.
    double sigma;
    // Derivative by the position north, east, down, per m.
    double by_position[3];
    // Derivative by the velocity north, east, down, per m/s.
    double by_velocity[3];
    // Derivative by a small rotation of the body about north, east, down, per rad.
    double by_attitude[3];
    // Derivative by the velocity in body axes, per m/s: in place of `by_velocity` and `by_attitude`, or in addition
    // to them.
    double by_velocity_body[3];
    // Derivative by the angular rate about the body axes, per rad/s.
    double by_angular_rate[3];
} HovernavRow;

// Compares a reading with the expected motion: writes a row for each measured quantity to `rows`, which has room for
// HOVERNAV_ROWS and is zero before, and returns their number. 0 for a reading that is not to be used. It must not use
// the object. `context` is that of HovernavOwnSensor.
typedef uint32_t (*HovernavCompare)(const struct HovernavExpected *expected,
                                    struct HovernavRow *rows,
                                    void *context);

// A sensor of the caller.
typedef struct HovernavOwnSensor {
    // Compares a reading; must not be null.
    HovernavCompare compare;
    // Passed to `compare`, for example the reading; may be null.
    void *context;
    // Position of the sensor relative to the reference point of the lever arms, body axes, m.
    double lever_arm_m[3];
} HovernavOwnSensor;

// Inputs of one step of the autopilot.
typedef struct HovernavAutopilotInputs {
    // The moment of the step, on the clock of the samples, ns.
    int64_t now_ns;
    // 1 if the pilot's sticks are received, else 0.
    uint32_t has_pilot;
    // The pilot's switch: 1 if the autopilot is to fly, else 0.
    uint32_t engage;
    // The pilot's sticks. If one is not finite, none of them counts as received.
    struct HovernavSticks pilot;
} HovernavAutopilotInputs;

// The result of one step of the autopilot.
typedef struct HovernavAutopilotOutputs {
    // Positions of the controls, -1 to 1; while the pilot flies, up to the pilot's own deflection, at most 1.25.
    struct HovernavSticks sticks;
    // The active mode.
    HovernavMode mode;
    // Reason of the change of mode in this step, if it changed.
    HovernavModeReason reason;
    // Reason why the estimate is not good enough.
    HovernavDistrust distrust;
} HovernavAutopilotOutputs;

// A set-point; the kind determines which fields count.
typedef struct HovernavSetPoint {
    // One of HOVERNAV_SET_POINT_.
    uint32_t kind;
    // Latitude, degrees.
    double latitude_deg;
    // Longitude, degrees.
    double longitude_deg;
    // Height above the ellipsoid, m.
    double height_m;
    // Heading, rad, from true north clockwise.
    double heading_rad;
    // Velocity forward of the heading, m/s.
    double forward_mps;
    // Velocity right of the heading, m/s.
    double right_mps;
    // Velocity downwards, m/s.
    double down_mps;
    // Turn rate, right positive, rad/s.
    double yaw_rate_radps;
} HovernavSetPoint;

// Result of the bytes of a line.
typedef struct HovernavLineResult {
    // Bytes to write to the same line now: the first reply_length of reply.
    uint8_t reply[HOVERNAV_REPLY];
    // Number of bytes in the reply.
    uint32_t reply_length;
    // Number of samples or fixes passed to the estimator.
    uint32_t used;
    // Number of rejected packets or fixes: impossible values, no usable time, not good enough.
    uint32_t refused;
    // 1 if the link to the unit failed and starts over, else 0.
    uint32_t lost;
    // For the inertial unit: time until which to read next, ns. Call again then, with or without bytes.
    int64_t read_until_ns;
} HovernavLineResult;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The text of a status: static, ends with a zero byte, never null.
const char *hovernav_status_text(int32_t status);

// Memory of an object of this library, bytes: at most HOVERNAV_SIZE.
size_t hovernav_size(void);

// Alignment of this memory, bytes: at most HOVERNAV_ALIGNMENT.
size_t hovernav_alignment(void);

// The library's version, "0.1.0": static, ends with a zero byte.
const char *hovernav_version(void);

// Whether header and library match: call it with HOVERNAV_ABI. HOVERNAV_STATUS_ABI_MISMATCH if they do not.
// hovernav_default_config() makes the same check.
HovernavStatus hovernav_check_abi(uint32_t abi);

// Creates an object in `memory`, of `size` bytes, at least hovernav_size(), aligned at least to
// hovernav_alignment(). Returns its address, which is that of the memory. The memory belongs to the object until
// hovernav_destroy(); nothing else is ever allocated. An earlier object there is overwritten. `fault`, unless null,
// receives the first value of the configuration that is out of range.
//
// HOVERNAV_STATUS_NULL_POINTER, _MISALIGNED, _MEMORY_TOO_SMALL or _OUT_OF_RANGE.
HovernavStatus hovernav_create(void *memory,
                               size_t size,
                               const struct HovernavConfig *config,
                               struct HovernavFault *fault,
                               struct Hovernav **created);

// Destroys an object: its memory belongs to the caller again, and its address is no longer an object. Null counts as
// an object already destroyed.
//
// HOVERNAV_STATUS_NOT_CREATED without an object, or _MISALIGNED.
HovernavStatus hovernav_destroy(struct Hovernav *nav);

// Sets `config` to the defaults: a consumer or tactical-grade MEMS unit on a vibrating vehicle, a stand-alone GPS,
// no lever arms. `abi` is HOVERNAV_ABI. If the library has another version, nothing is written and the result is
// HOVERNAV_STATUS_ABI_MISMATCH.
HovernavStatus hovernav_default_config(struct HovernavConfig *config,
                                       uint32_t abi);

// Whether `config` can be used to navigate; `fault`, unless null, receives the first value out of range.
HovernavStatus hovernav_check_config(const struct HovernavConfig *config,
                                     struct HovernavFault *fault);

// Fills `config` with `gains`, designed for `period_s`, and defaults for everything else. `abi` is
// HOVERNAV_ABI.
HovernavStatus hovernav_default_autopilot_config(struct HovernavAutopilotConfig *config,
                                                 double period_s,
                                                 const struct HovernavGains *gains,
                                                 uint32_t abi);

// Sets `config` to the defaults: a unit of 200 deg/s and 4 g in angle mode, polled every 30.3 ms. The receiver is an
// NMEA one with a latency of 0.12 s. `abi` is HOVERNAV_ABI.
HovernavStatus hovernav_default_lines_config(struct HovernavLinesConfig *config,
                                             uint32_t abi);

// Passes on a sample of the inertial unit. A notice reports a sample that the estimator cannot use: not finite, or
// not later than the previous one. Notices report all other results too. The estimator bridges a gap of any length.
// A wrong time far in the future therefore counts as a gap, and every sample up to it is rejected. Then
// hovernav_get_health() reports the estimate as stale, and the object must be created again.
HovernavStatus hovernav_push_imu(struct Hovernav *nav,
                                 const struct HovernavImuSample *sample);

// Passes on a fix. A fix up to 10 s later than the last inertial sample waits for the next sample. A notice reports
// impossible velocities and one-sigmas, and a time on another clock than that of the samples.
//
// HOVERNAV_STATUS_OUT_OF_RANGE for an invalid position: not finite, latitude beyond 90 degrees, longitude beyond
// 360, height beyond 100 km. HOVERNAV_STATUS_UNKNOWN_CODE for an unknown flag.
HovernavStatus hovernav_push_fix(struct Hovernav *nav,
                                 const struct HovernavFix *fix);

// Passes on a barometric height above any fixed level, m, up, valid at `time_ns`. A notice reports a height beyond
// 100 km.
//
// HOVERNAV_STATUS_NOT_BUILT if the library was built without height-aids.
HovernavStatus hovernav_push_baro(struct Hovernav *nav,
                                  int64_t time_ns,
                                  double height_m);

// Passes on the field of a magnetometer separate from the inertial unit, three components in body axes, gauss, valid
// at `time_ns`. Only its direction is used.
HovernavStatus hovernav_push_magnetometer(struct Hovernav *nav,
                                          int64_t time_ns,
                                          const double *field_gauss);

// Passes on the current speed of the rotor, turns a second, Hz: the notch follows it from the next sample on. At 0,
// a rotor at rest, the notch stays at its last frequency.
//
// HOVERNAV_STATUS_NO_NOTCH if the configuration has no notch; HOVERNAV_STATUS_OUT_OF_RANGE for a speed that is not
// finite, negative, or 10000 Hz and more.
HovernavStatus hovernav_push_rotor_speed(struct Hovernav *nav,
                                         double rotor_hz);

// Passes on a distance to the ground along the beam of the rangefinder, m, valid at `time_ns`. `sigma_m` is its
// one-sigma, m. `quality` is the sensor's quality figure from 0, invalid, to 1. Both are NaN if the sensor does not
// report them.
//
// HOVERNAV_STATUS_NOT_BUILT if the library was built without height-aids.
HovernavStatus hovernav_push_range(struct Hovernav *nav,
                                   int64_t time_ns,
                                   double range_m,
                                   double sigma_m,
                                   double quality);

// Passes on the heading of two GPS antennas, from the first to the second, clockwise from true north, rad, valid at
// `time_ns`. `sigma_rad` is its one-sigma, rad, and `length_m` the measured length of the baseline, m. Both are NaN
// if the receiver does not report them.
HovernavStatus hovernav_push_antenna_heading(struct Hovernav *nav,
                                             int64_t time_ns,
                                             double heading_rad,
                                             double sigma_rad,
                                             double length_m);

// Gives the solution at the last inertial sample; HOVERNAV_STATUS_NOT_YET until alignment has ended.
HovernavStatus hovernav_get_solution(struct Hovernav *nav,
                                     struct HovernavSolution *solution);

// Gives the joint covariance, 9 x 9, row by row, HOVERNAV_COVARIANCE numbers. Its rows are the attitude error (a
// small turn, rad), the velocity error (m/s) and the position error (m) of the inertial unit. Each is north, east,
// down. HOVERNAV_STATUS_NOT_YET until alignment and a search for the heading, if any, have ended.
HovernavStatus hovernav_get_covariance(struct Hovernav *nav,
                                       double *covariance);

// Gives the health of the estimate at `now_ns`, on the clock of the samples. Call it once a cycle: a quantity that
// has recovered must stay well within its limits before it counts as good.
HovernavStatus hovernav_get_health(struct Hovernav *nav,
                                   int64_t now_ns,
                                   struct HovernavHealth *health);

// The text of a HovernavSetupFault: static, ends with a zero byte, never null.
const char *hovernav_setup_fault_text(uint32_t fault);

// Gives the oldest unread notice and removes it; HOVERNAV_STATUS_NOT_YET when all are read. The queue stores twelve,
// more than one measurement can cause. Call it after each push until HOVERNAV_STATUS_NOT_YET.
HovernavStatus hovernav_next_notice(struct Hovernav *nav,
                                    struct HovernavNotice *notice);

// Gives the number of unread notices that newer ones overwrote.
HovernavStatus hovernav_lost_notices(struct Hovernav *nav, uint32_t *lost);

// Fuses a reading of the caller's own sensor, valid at `time_ns`: up to 0.5 s before the last inertial sample, and up
// to 0.1 s after it. Calls `sensor->compare` once, if the reading can be compared. All its rows are accepted or
// rejected together; a rejected reading never resets the filter.
//
// The outcome is written to `notice`, which may be null, and is not stored for hovernav_next_notice():
// HOVERNAV_NOTICE_KIND_UPDATED, or HOVERNAV_NOTICE_KIND_NOT_USED with its reason.
HovernavStatus hovernav_measure(struct Hovernav *nav,
                                int64_t time_ns,
                                const struct HovernavOwnSensor *sensor,
                                struct HovernavNotice *notice);

// Starts an autopilot inside the object, or restarts it, with the sticks at trim and not engaged. `fault`, unless
// null, receives the first invalid value of the configuration. The previous autopilot then stays active.
HovernavStatus hovernav_start_autopilot(struct Hovernav *nav,
                                        const struct HovernavAutopilotConfig *config,
                                        struct HovernavFault *fault);

// One step of the autopilot: call it once every period of its configuration. Its estimate is the solution without
// the latest corrections, which fade in over about a second. A fix thus never moves a stick by a step. Each call
// counts as one period, independent of `now_ns`. A call at another rate than that of the gains' design is an error
// that cannot be detected here. `now_ns` gives the age of the solution and the duration of a mode.
HovernavStatus hovernav_step_autopilot(struct Hovernav *nav,
                                       const struct HovernavAutopilotInputs *inputs,
                                       struct HovernavAutopilotOutputs *outputs);

// Sets the set-point. Engagement resets it to HOVERNAV_SET_POINT_HOLD.
HovernavStatus hovernav_set(struct Hovernav *nav, const struct HovernavSetPoint *set_point);

// Starts the protocols on both lines, or restarts them. `fault`, unless null, receives the first invalid value of
// the configuration.
HovernavStatus hovernav_start_lines(struct Hovernav *nav,
                                    const struct HovernavLinesConfig *config,
                                    int64_t now_ns,
                                    struct HovernavFault *fault);

// Takes `length` bytes read from the inertial unit's line; the last of them arrived at `now_ns`. Pass 0 bytes when
// the time that the last call returned was reached without any. Its samples go to the estimator.
HovernavStatus hovernav_push_dmu_bytes(struct Hovernav *nav,
                                       const uint8_t *bytes,
                                       size_t length,
                                       int64_t now_ns,
                                       struct HovernavLineResult *result);

// Takes `length` bytes read from the receiver's line that arrived at `now_ns`. Pass 0 bytes once the line is silent
// after an epoch: this ends the epoch. Good fixes go to the estimator.
HovernavStatus hovernav_push_gps_bytes(struct Hovernav *nav,
                                       const uint8_t *bytes,
                                       size_t length,
                                       int64_t now_ns,
                                       struct HovernavLineResult *result);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HOVERNAV_H */
