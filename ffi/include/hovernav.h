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
#define HOVERNAV_ABI 12

// Largest size of an object, bytes, in any build of the library. hovernav_size() gives the size in this build.
#define HOVERNAV_SIZE 35328

// Largest size of an object, bytes, in a library built without heading-search.
#define HOVERNAV_SIZE_WITHOUT_SEARCH 30720

// Alignment of an object's memory, bytes.
#define HOVERNAV_ALIGNMENT 16

// In HovernavAlignment.heading: the first available source in the order two antennas, inertial unit's own attitude,
// magnetometer; else unknown.
#define HOVERNAV_HEADING_ANY 0

// In HovernavAlignment.heading: the inertial unit's own attitude.
#define HOVERNAV_HEADING_ATTITUDE 1

// In HovernavAlignment.heading: the levelled magnetometer, corrected by the declination.
#define HOVERNAV_HEADING_MAGNETOMETER 2

// In HovernavAlignment.heading: the course over ground; only for vehicles that travel in the direction of their nose.
#define HOVERNAV_HEADING_COURSE 3

// In HovernavAlignment.heading: unknown; the estimator finds the heading in motion.
#define HOVERNAV_HEADING_UNKNOWN 4

// In HovernavAlignment.heading: two GPS antennas.
#define HOVERNAV_HEADING_SECOND_ANTENNA 5

// In HovernavLinesConfig.dmu_mode: rates, accelerations and magnetic field.
#define HOVERNAV_DMU_SCALED 1

// In HovernavLinesConfig.dmu_mode: rates, accelerations, magnetic field and the inertial unit's own attitude.
#define HOVERNAV_DMU_ANGLE 2

// In HovernavLinesConfig.gps_protocol: Trimble Standard Interface Protocol.
#define HOVERNAV_GPS_TSIP 1

// In HovernavLinesConfig.gps_protocol: NMEA 0183 sentences.
#define HOVERNAV_GPS_NMEA 2

// In HovernavLinesConfig.gps_protocol: u-blox binary.
#define HOVERNAV_GPS_UBX 3

// In HovernavConfig.vehicle_kind: unstated. The fixes show whether the vehicle rolls on wheels.
#define HOVERNAV_VEHICLE_UNSTATED 0

// Helicopter with one main rotor.
#define HOVERNAV_VEHICLE_HELICOPTER 1

// Vehicle with several rotors.
#define HOVERNAV_VEHICLE_MULTIROTOR 2

// Aeroplane.
#define HOVERNAV_VEHICLE_FIXED_WING 3

// Vehicle on wheels: its velocity across the road is constrained while fixes are absent.
#define HOVERNAV_VEHICLE_WHEELED 4

// Vessel on water.
#define HOVERNAV_VEHICLE_BOAT 5

// Inertial unit held in a hand or worn by a person.
#define HOVERNAV_VEHICLE_HANDHELD 6

// In HovernavImuSample.has: gyro and accel are integrals since the previous sample.
#define HOVERNAV_IMU_INCREMENTS 1

// In HovernavImuSample.has: the inertial unit's own attitude is present.
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

// In HovernavFix.has: the receiver held or assumed the height, so that neither height nor down velocity counts.
#define HOVERNAV_FIX_TWO_DIMENSIONAL 16

// Number of elements in the matrix of hovernav_get_covariance().
#define HOVERNAV_COVARIANCE 81

// Largest number of axes in one update.
#define HOVERNAV_AXES 6

// Largest number of rows, one per measured quantity, for one reading of a sensor of the caller.
#define HOVERNAV_ROWS 6

// In HovernavSetPoint.kind: stop, and hold the position where the vehicle stops.
#define HOVERNAV_SET_POINT_HOLD 0

// In HovernavSetPoint.kind: fly to a position and hold it, with the current heading.
#define HOVERNAV_SET_POINT_PLACE 1

// In HovernavSetPoint.kind: fly to a position and hold it, and turn to a heading.
#define HOVERNAV_SET_POINT_PLACE_AND_HEADING 2

// In HovernavSetPoint.kind: fly at a steady velocity.
#define HOVERNAV_SET_POINT_VELOCITY 3

// Size of the buffer for a reply, bytes: more than any call needs.
#define HOVERNAV_REPLY 64

// Status of a call. 0 is success, 1 is "not yet", the others are errors of the caller; a call with an error changes
// nothing.
typedef int32_t HovernavStatus;
enum {
    // Success.
    HOVERNAV_STATUS_OK = 0,
    // No result yet: alignment has not ended, or all notices are read.
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
    // A value is out of its range. If the function has a HovernavFault, this names the value.
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
    // Not good enough to fly on.
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
    // The estimator has found the heading, which was unknown at the start. `sigma`: one-sigma of the heading, rad.
    HOVERNAV_NOTICE_KIND_HEADING_FOUND = 1,
    // The heading was wrong and was replaced. `value`: change of the heading, rad; `sigma`: one-sigma of the new
    // heading, rad.
    HOVERNAV_NOTICE_KIND_HEADING_RESET = 2,
    // Alignment is complete except for a heading.
    HOVERNAV_NOTICE_KIND_HEADING_MISSING = 3,
    // The filter compared a measurement with the estimate, axis by axis: see `axes`.
    HOVERNAV_NOTICE_KIND_UPDATED = 4,
    // The filter did not use a measurement: see `aid` and `reason`.
    HOVERNAV_NOTICE_KIND_NOT_USED = 5,
    // An inertial sample ended a gap, which the estimator bridged. `value`: length of the gap, s.
    HOVERNAV_NOTICE_KIND_GAP_BRIDGED = 6,
    // The covariance was reset. `value`: the length of the gap that caused it, s, else 0.
    HOVERNAV_NOTICE_KIND_COVARIANCE_RESET = 7,
    // Inertial samples start to saturate, or their vibration is far above its usual level.
    HOVERNAV_NOTICE_KIND_SAMPLE_SUSPECT = 8,
    // An inertial sample was rejected: see `reason`.
    HOVERNAV_NOTICE_KIND_SAMPLE_REFUSED = 9,
    // The heading error exceeds its one-sigma, which was increased. `value`: heading correction indicated by the
    // fixes, rad; `sigma`: one-sigma of the correction, rad.
    HOVERNAV_NOTICE_KIND_HEADING_DOUBTED = 10,
    // An event unknown to this header.
    HOVERNAV_NOTICE_KIND_OTHER = 11,
    // The magnetic field differs from its usual value: a current or iron is nearby. `value`: difference as a fraction
    // of the field's strength; `sigma`: one-sigma of the resulting error of the magnetic heading, rad.
    HOVERNAV_NOTICE_KIND_FIELD_DISTURBED = 12,
    // The magnetic field is at its usual value again. `value`: 0 if the field returned, 1 if it stayed changed and
    // became the new usual value.
    HOVERNAV_NOTICE_KIND_FIELD_USUAL = 13,
    // The position of the antenna differs from the configured lever arm; the estimator uses the estimated position
    // instead. `value`: distance between the two positions, m; `sigma`: one-sigma of each horizontal component, m.
    HOVERNAV_NOTICE_KIND_ANTENNA_ELSEWHERE = 14,
    // The vehicle rolls on wheels: without fixes its velocity across the road is constrained. `sigma`: one-sigma of
    // this velocity, m/s. Only with the feature `height-aids`.
    HOVERNAV_NOTICE_KIND_ON_WHEELS = 15,
    // The vehicle no longer rolls on wheels: the constraint of its velocity across the road has ended.
    HOVERNAV_NOTICE_KIND_OFF_WHEELS = 16,
    // The first samples or fixes show a likely mistake in units, signs or axes; the solution cannot be trusted.
    // `value`: a HovernavSetupFault, whose text is hovernav_setup_fault_text(); `sigma`: the mean specific force,
    // m/s^2, the turn reported by the gyros in half a second, rad, or the unit of the velocity, m/s; else 0.
    HOVERNAV_NOTICE_KIND_SETUP_SUSPECT = 17,
};

// Sources of measurements besides the inertial unit.
typedef uint32_t HovernavAid;
enum {
    // The notice does not concern a source of measurements.
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
    // The measurement is older than the filter's history.
    HOVERNAV_UNUSED_REASON_TOO_OLD = 2,
    // The measurement is later than the inertial samples.
    HOVERNAV_UNUSED_REASON_AHEAD_OF_IMU = 3,
    // The reading repeats the previous one, although the vehicle moves.
    HOVERNAV_UNUSED_REASON_REPEATED = 4,
    // The measurement is too soon after the previous one to add information at its noise; no fault.
    HOVERNAV_UNUSED_REASON_TOO_SOON = 5,
    // The filter has no state for the measurement; no fault.
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
    // The measured baseline is longer or shorter than the mounted baseline.
    HOVERNAV_UNUSED_REASON_WRONG_BASELINE = 13,
    // A heading of two antennas that points in the opposite direction.
    HOVERNAV_UNUSED_REASON_REVERSED = 14,
    // A sample that a logger interpolated linearly between others.
    HOVERNAV_UNUSED_REASON_INTERPOLATED = 15,
    // An attitude whose change differs from the turn measured by the gyros.
    HOVERNAV_UNUSED_REASON_TURNS_OTHERWISE = 16,
    // A single reading of the magnetic field that differs from the earlier readings.
    HOVERNAV_UNUSED_REASON_OUTLIER = 17,
    // A magnetic field whose horizontal component is too small: vertical or zero.
    HOVERNAV_UNUSED_REASON_FIELD_TOO_STEEP = 18,
    // Roll and pitch after a gap are not yet accurate enough to level the magnetic field; no fault.
    HOVERNAV_UNUSED_REASON_NOT_LEVELLED = 19,
    // The barometer repeated its previous reading; no fault.
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
    // A row of a sensor of the caller, in the unit of the row.
    HOVERNAV_CHANNEL_OWN = 20,
};

// Outcome of one axis of an update.
typedef uint32_t HovernavVerdict;
enum {
    // The axis corrected the state.
    HOVERNAV_VERDICT_ACCEPTED = 0,
    // The innovation is outside the gate; the state is unchanged.
    HOVERNAV_VERDICT_REJECTED = 1,
    // Accepted after a lockout: the filter was reset to the measurement.
    HOVERNAV_VERDICT_REOPENED = 2,
};

// Mode of the autopilot.
typedef uint32_t HovernavMode;
enum {
    // The pilot flies.
    HOVERNAV_MODE_MANUAL = 0,
    // Holds a position or flies to it, and holds the heading.
    HOVERNAV_MODE_POSITION = 1,
    // Holds a velocity over ground, and the heading.
    HOVERNAV_MODE_VELOCITY = 2,
    // Holds roll, pitch, heading and, if possible, height.
    HOVERNAV_MODE_ATTITUDE = 3,
    // As Attitude, but descends at the configured sink rate.
    HOVERNAV_MODE_DESCENT = 4,
    // Moves the sticks to trim, because attitude is unknown.
    HOVERNAV_MODE_NEUTRAL = 5,
};

// Reason for the change of mode in this step.
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
    // Accelerations whose size differs from gravity, in an unknown unit or range.
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
    // A roll or pitch rate of the wrong sign, or both swapped.
    HOVERNAV_SETUP_FAULT_GYRO_TILTS = 14,
    // A yaw rate of the wrong sign.
    HOVERNAV_SETUP_FAULT_GYRO_YAW = 15,
    // Angular rates in other axes than the accelerations.
    HOVERNAV_SETUP_FAULT_GYRO_AXES = 16,
    // Velocities of zero while the positions move.
    HOVERNAV_SETUP_FAULT_VELOCITY_ZERO = 17,
    // Latitude and longitude in radians instead of degrees.
    HOVERNAV_SETUP_FAULT_POSITION_IN_RADIANS = 18,
    // A gyro axis that is always zero.
    HOVERNAV_SETUP_FAULT_GYRO_DEAD = 19,
    // An accelerometer axis that is always zero.
    HOVERNAV_SETUP_FAULT_ACCELEROMETER_DEAD = 20,
    // Heights in another unit than m.
    HOVERNAV_SETUP_FAULT_HEIGHT_SCALE = 21,
};

// The object with estimator, health monitor, autopilot and sensor protocols. Its content is private; its size is
// hovernav_size().
typedef struct Hovernav Hovernav;

// Alignment of the estimator at its start.
typedef struct HovernavAlignment {
    // Source of the first heading: one of HOVERNAV_HEADING_.
    uint32_t heading;
    // Duration of inertial data needed for alignment, 0.1 to 120 s.
    double duration_s;
    // Offset, rad, added to the inertial unit's yaw to give true heading: the declination, if the yaw is magnetic.
    double attitude_declination_rad;
    // Magnetic declination, east positive, rad, for the magnetometer.
    double declination_rad;
    // One-sigma of the inertial unit's own roll and pitch, rad.
    double attitude_tilt_sigma_rad;
    // One-sigma of the first heading, from the inertial unit's own attitude or the magnetometer, rad.
    double heading_sigma_rad;
    // One-sigma of roll and pitch from levelling at rest, rad.
    double level_sigma_rad;
    // One-sigma of roll and pitch from levelling in motion, rad.
    double moving_level_sigma_rad;
    // One-sigma of position, m, for a fix without an accuracy of its own.
    double position_sigma_m;
    // One-sigma of velocity, m/s, for a fix without an accuracy of its own.
    double velocity_sigma_mps;
    // Smallest speed at which the course gives the heading, m/s.
    double course_speed_mps;
} HovernavAlignment;

// Error model of the inertial sensors.
typedef struct HovernavImuModel {
    // Angle random walk, rad/sqrt(s).
    double angle_random_walk_rad;
    // Velocity random walk, m/s/sqrt(s).
    double velocity_random_walk_mps;
    // Fraction of the gyros' measured vibration that counts as white noise.
    double gyro_vibration_share;
    // Fraction of the accelerometers' measured vibration that counts as white noise.
    double accel_vibration_share;
    // Time, s, within which accelerometer samples have the same vibration error.
    double accel_vibration_time_s;
    // One-sigma of the gyro bias, rad/s.
    double gyro_bias_sigma_radps;
    // Correlation time of the gyro bias, s.
    double gyro_bias_time_s;
    // One-sigma of the accelerometer bias, m/s^2.
    double accel_bias_sigma_mps2;
    // Correlation time of the accelerometer bias, s.
    double accel_bias_time_s;
    // Gyro error about the axis of a turn, as a fraction of the turn, if the filter has no states for it. The error
    // across the axis is 2.5 times as large.
    double turn_error_share;
    // Time, s, for which the gyro error of a turn keeps its sign.
    double turn_error_time_s;
    // One-sigma of each gyro's scale factor error, as a fraction of the net turn about its axis, if the filter has no
    // states for it.
    double net_turn_error_share;
    // Time constant, s, with which the memory of a net turn decays.
    double net_turn_memory_s;
    // Full scale of the gyros, rad/s; 0 if unknown.
    double gyro_range_radps;
    // Full scale of the accelerometers, m/s^2; 0 if unknown.
    double accel_range_mps2;
    // Longest interval between samples that is not a gap, s.
    double gap_s;
    // One-sigma of the unmeasured acceleration during a gap, m/s^2.
    double gap_acceleration_mps2;
    // One-sigma of the unmeasured angular rate during a gap, rad/s.
    double gap_rate_radps;
    // Interval of covariance propagation, s; 0 for propagation at every sample, like the state. The covariance is also
    // propagated before each measurement.
    double covariance_interval_s;
} HovernavImuModel;

// Error model of the GPS.
typedef struct HovernavGpsModel {
    // One-sigma of horizontal position, each axis, m, for a fix without an accuracy of its own.
    double horizontal_sigma_m;
    // One-sigma of height, m, for a fix without an accuracy of its own.
    double vertical_sigma_m;
    // One-sigma of horizontal velocity, each axis, m/s, for a fix without an accuracy of its own.
    double horizontal_velocity_sigma_mps;
    // One-sigma of vertical velocity, m/s, for a fix without an accuracy of its own.
    double vertical_velocity_sigma_mps;
    // Lower limit of the one-sigma of the white position error, m.
    double position_floor_m;
    // Lower limit of the one-sigma of the white velocity error, m/s.
    double velocity_floor_mps;
    // Fraction of the position's one-sigma that varies slowly, 0 to 1.
    double position_wander_share;
    // Correlation time of the position's slow error, s.
    double position_wander_time_s;
    // Fraction of the velocity's one-sigma that varies slowly, 0 to 1.
    double velocity_wander_share;
    // Correlation time of the velocity's slow error, s.
    double velocity_wander_time_s;
    // One-sigma of the time over which a receiver averages its velocity, s.
    double velocity_smoothing_s;
    // Learning rate, 0 to 1: weight of one innovation in a learned GPS variance. The filter learns one-sigmas that the
    // fixes do not contain, or that are too small.
    double learning_rate;
    // One-sigma of the time between the validity of a fix's position and of its velocity, s.
    double position_latency_sigma_s;
    // One-sigma of the time, s, by which a fix is valid earlier than its declared time.
    double delay_sigma_s;
} HovernavGpsModel;

// Error model of the inertial unit's own attitude.
typedef struct HovernavAttitudeModel {
    // Shortest time between two updates, s.
    double interval_s;
    // One-sigma of the slow error in roll and pitch, rad.
    double tilt_wander_rad;
    // One-sigma of the slow error in heading, rad.
    double heading_wander_rad;
    // Correlation time of the slow error, s.
    double wander_time_s;
    // One-sigma of the white error, rad.
    double noise_rad;
} HovernavAttitudeModel;

// Error model of a heading from a magnetometer.
typedef struct HovernavMagnetometerModel {
    // Shortest time between two updates, s.
    double interval_s;
    // One-sigma of the slow error of the heading, rad.
    double heading_wander_rad;
    // Correlation time of the slow error, s.
    double wander_time_s;
    // One-sigma of the white error, rad.
    double noise_rad;
} HovernavMagnetometerModel;

// Error model of a barometric height.
typedef struct HovernavBaroModel {
    // One-sigma of the white error of the height, m.
    double noise_m;
    // One-sigma of the slow error of the height, m.
    double wander_m;
    // Correlation time of the slow error, s.
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

// Switches of the mechanisms that the estimator has beyond a Kalman filter with fixed noise: 1 on, 0 off. All are on
// by default. Equations such as (M11) are in docs/equations.md.
typedef struct HovernavMechanisms {
    // Zero velocity and the Earth's rate at rest (M11).
    uint32_t rest;
    // Larger uncertainty of the gyro biases when a rest ends; the bias change is learned (M11).
    uint32_t rested_bias;
    // Learned factor on the noise of the inertial unit, from successive innovations (K18).
    uint32_t excess_noise;
    // Detection of bias steps, from growing innovations (K19).
    uint32_t bias_steps;
    // Learned one-sigmas of the fixes, from their innovations (M7).
    uint32_t fix_errors;
    // Learned white noise of the positions of fixes without velocity, from their second differences (M21).
    uint32_t position_scatter;
    // Heading information only from horizontal force that exceeds its own error (K23).
    uint32_t level_force;
    // Larger uncertainty of the accelerometer biases while vibration changes (K24).
    uint32_t rectification;
    // Offset of the antenna from its stated position, estimated in turns (M16).
    uint32_t antenna_offset;
    // Wheel constraint while fixes are absent: velocity only along the road (M17).
    uint32_t wheels;
    // Rejection of a receiver whose fixes contradict each other (K15).
    uint32_t self_contradiction;
    // Rejection of a height whose innovations are biased while another sensor of height agrees.
    uint32_t biased_heights;
    // Reports of positions that drift from their velocity; the one-sigma reaches back to the start of the drift (K25).
    uint32_t drifting_positions;
    // A second position as a hypothesis: the previous one after a jump was accepted, and one that contradicts the
    // start.
    uint32_t previous_position;
    // Rejection of fixes that repeat the previous one bit for bit.
    uint32_t repeated_fixes;
    // Correction of a heading by the heading bank (H2 to H5).
    uint32_t heading_monitor;
    // No reset to a heading sensor while the heading bank confirms the filter's heading.
    uint32_t confirmed_heading;
    // Second alignment in flight after gaps (H7).
    uint32_t lost_level;
    // Monitor of the magnetic field for changes (M15).
    uint32_t field_monitor;
    // Comparison of the inertial unit's own attitude with the gyros (M8).
    uint32_t attitude_monitor;
    // Learned noise of the barometer, from the scatter of its readings (M18).
    uint32_t barometer_scatter;
    // Barometer error caused by the airflow at the vehicle's speed (M10).
    uint32_t barometer_wind;
    // Shocks: the specific force is held close to its value before the shock, and noise is added (S13, S16).
    uint32_t shocks;
    // Larger uncertainty for readings at full scale (S13).
    uint32_t clipping;
    // Detection of single axes that repeat one reading (S13).
    uint32_t stuck_axes;
    // Rejection of samples that repeat all six readings.
    uint32_t stuck_samples;
    // Rejection of samples on a straight line, which a logger has interpolated (S17).
    uint32_t interpolated_samples;
} HovernavMechanisms;

// Error model of a rangefinder and of the ground height.
typedef struct HovernavRangeModel {
    // Shortest distance that the sensor measures, m.
    double least_m;
    // Longest distance that the sensor measures, m.
    double most_m;
    // Smallest quality of a usable reading, 0 to 1.
    double least_quality;
    // One-sigma of the white error, m, for a reading without an accuracy of its own.
    double noise_m;
    // One-sigma of an additional error that grows with the distance, as a fraction of the distance.
    double noise_share;
    // One-sigma of the change of ground height over a metre, m.
    double ground_walk_m;
} HovernavRangeModel;

// A rangefinder that looks at the ground.
typedef struct HovernavRangefinder {
    // Position of the sensor relative to the reference point of the solution, body axes, m.
    double lever_arm_m[3];
    // Unit vector along the beam, body axes; 0, 0, 1 is straight down.
    double beam[3];
    // Error model of the sensor and of the ground.
    struct HovernavRangeModel model;
} HovernavRangefinder;

// Error model of the heading of two antennas.
typedef struct HovernavAntennaHeadingModel {
    // Shortest time between two updates, s.
    double interval_s;
    // One-sigma of the heading, rad, for a reading without an accuracy of its own.
    double sigma_rad;
    // Lower limit of the one-sigma of a heading, rad.
    double floor_rad;
    // Fraction of the one-sigma that varies slowly, 0 to 1.
    double wander_share;
    // Correlation time of the slow error, s.
    double wander_time_s;
    // Largest difference between the measured and the mounted length of the baseline, m; beyond it the heading is
    // rejected.
    double length_tolerance_m;
} HovernavAntennaHeadingModel;

// The second of two GPS antennas that give a heading.
typedef struct HovernavSecondAntenna {
    // Baseline: vector from the first antenna to the second, body axes, m; all zero if the heading is that of the
    // vehicle itself.
    double baseline_m[3];
    // Error model of the heading of the two antennas.
    struct HovernavAntennaHeadingModel model;
} HovernavSecondAntenna;

// A notch filter at the speed of a rotor. It removes the rotor's vibration from the inertial samples before all other
// processing. It delays slow motion by width_hz / (2 pi frequency_hz^2) seconds, and corrects the times of the samples
// by this delay.
typedef struct HovernavNotch {
    // Speed of the rotor, turns a second, Hz; 0 until hovernav_push_rotor_speed() sets it.
    double frequency_hz;
    // Width of the notch at half power, Hz, the same at each harmonic.
    double width_hz;
    // Lowest frequency that the notch removes from the samples, Hz; lower frequencies are motion of the vehicle.
    double least_hz;
    // Number of harmonics of the rotor speed that the notch removes, 1 to 4. 0 for no notch, and then frequency_hz
    // must be 0.
    uint32_t harmonics;
} HovernavNotch;

// Accuracy of the estimate required to fly: one-sigmas and times.
typedef struct HovernavHealthLimits {
    // Largest one-sigma of roll and pitch, rad.
    double tilt_sigma_rad;
    // Largest one-sigma of heading, rad.
    double heading_sigma_rad;
    // Largest one-sigma of horizontal velocity, m/s.
    double velocity_sigma_mps;
    // Largest one-sigma of vertical velocity, m/s.
    double vertical_velocity_sigma_mps;
    // Largest one-sigma of position on each axis, m.
    double position_sigma_m;
    // Largest age of the estimate, s.
    double age_s;
    // Time without an accepted fix, s, after which the estimate counts as dead reckoning.
    double dead_reckoning_s;
    // Time, s, after which continually rejected fixes count as a contradiction to the estimate.
    double disagreement_s;
    // Time, s, for which a quantity must be good before the autopilot returns to a better mode that uses it.
    double recovery_s;
} HovernavHealthLimits;

// The complete configuration of the estimator. hovernav_default_config() sets it to defaults; then replace the values
// that you know.
typedef struct HovernavConfig {
    // Position of the inertial unit relative to the reference point of the solution (such as the centre of gravity),
    // body axes, m.
    double imu_lever_arm_m[3];
    // Position of the GPS antenna relative to the same point, body axes, m.
    double antenna_lever_arm_m[3];
    // 1 if the inertial unit's own attitude is used after alignment, else 0.
    uint32_t use_attitude;
    // 1 if the magnetometer is used, else 0. While use_attitude is 1, a sample's own attitude is used in place of its
    // magnetic field.
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
    // Alignment of the estimator at its start.
    struct HovernavAlignment alignment;
    // Error model of the inertial sensors.
    struct HovernavImuModel imu;
    // Error model of the GPS.
    struct HovernavGpsModel gps;
    // Error model of the inertial unit's own attitude.
    struct HovernavAttitudeModel attitude;
    // Error model of the magnetometer.
    struct HovernavMagnetometerModel magnetometer;
    // Error model of the barometer.
    struct HovernavBaroModel baro;
    // Gates, and lockout times after which the filter is reset.
    struct HovernavGateModel gate;
    // Switches of the filter's mechanisms.
    struct HovernavMechanisms mechanisms;
    // Settings of the rangefinder.
    struct HovernavRangefinder rangefinder;
    // Settings of the second antenna.
    struct HovernavSecondAntenna second_antenna;
    // Settings of the notch filter before the estimator.
    struct HovernavNotch notch;
    // Limits that hovernav_get_health() uses.
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
    // Positions of the controls.
    struct HovernavSticks sticks;
    // Roll, rad.
    double roll_rad;
    // Pitch, rad.
    double pitch_rad;
} HovernavTrim;

// Range and rate limits of the autopilot's commands, for each control.
typedef struct HovernavStickLimits {
    // Lowest position of each control, -1 to 0.
    struct HovernavSticks lowest;
    // Highest position of each control, 0 to 1.
    struct HovernavSticks highest;
    // Largest rate of each control, 1/s, above 0. The travel from neutral to a stop is 1.
    struct HovernavSticks rate_per_s;
} HovernavStickLimits;

// Limits and gains of guidance.
typedef struct HovernavGuidance {
    // Horizontal speed per distance from the set-point's position, 1/s.
    double position_gain_per_s;
    // Vertical speed per height error, 1/s.
    double height_gain_per_s;
    // Largest horizontal speed, m/s.
    double speed_mps;
    // Largest climb and sink rate, m/s.
    double climb_mps;
    // Largest commanded horizontal acceleration, m/s^2.
    double acceleration_mps2;
    // Largest commanded vertical acceleration, m/s^2.
    double climb_acceleration_mps2;
    // Largest turn rate, rad/s.
    double yaw_rate_radps;
} HovernavGuidance;

// Transitions between modes.
typedef struct HovernavTransfer {
    // Time constant, s, with which the difference between the commands of two modes fades out.
    double fade_s;
    // Time constant, s, with which the difference between autopilot and pilot fades out when the pilot takes over.
    double hand_back_s;
    // Time constant with which the sticks go to trim when attitude is unknown, s.
    double neutral_s;
    // Deflection of a stick from its position at engagement that counts as the pilot's override.
    double override_travel;
    // Time, s, for which the autopilot holds attitude without a good velocity before it descends.
    double patience_s;
    // Sink rate of the descent, m/s.
    double descent_mps;
    // Change of the collective from trim, in the sinking direction, during a descent without a good vertical velocity.
    double descent_collective;
    // Time constant, s, with which trim is learned in a steady hover.
    double trim_s;
} HovernavTransfer;

// Gains of a PID controller. Each gain has the unit of the command divided by the unit of the error, combined with s
// as its name states.
typedef struct HovernavPidGains {
    // Proportional gain: command per error.
    double proportional;
    // Integral gain: command per error and second.
    double integral_per_s;
    // Derivative gain, s: command per rate of change of the measured value.
    double derivative_s;
    // Time constant of the low-pass on the derivative, s; 0 or more.
    double derivative_filter_s;
    // Anti-windup time constant, s, with which the integral follows a limited command; above 0.
    double tracking_time_s;
} HovernavPidGains;

// Gains of the yaw regulator. The measured states are r and psi; there are two hidden states.
typedef struct HovernavYawGains {
    // Gain from each measured state to the stick, one row per control.
    double measured[1][2];
    // Gain from each hidden state to the stick, one row per control.
    double hidden[1][2];
    // Gain from the pending command, sent in the last sample, to the stick.
    double pending[1][1];
    // Gain from the time integral of each measured state's error to the stick, per s.
    double integral_per_s[1][2];
    // Gain from each hidden state before a sample to each one after it, one row per hidden state after it.
    double hidden_from_hidden[2][2];
    // Gain from each measured state before a sample to each hidden state after it.
    double hidden_from_measured[2][2];
    // Gain from each command that acted during a sample to each hidden state after it.
    double hidden_from_pending[2][1];
    // Anti-windup time constant, s, with which the integrals follow a limited command.
    double tracking_time_s;
} HovernavYawGains;

// Gains of the roll and pitch regulator. The measured states are p, q, phi, theta, u, v; there are six hidden states.
// The controls are lateral and longitudinal cyclic.
typedef struct HovernavRollPitchGains {
    // Gain from each measured state to the stick, one row per control.
    double measured[2][6];
    // Gain from each hidden state to the stick, one row per control.
    double hidden[2][6];
    // Gain from the pending command, sent in the last sample, to the stick.
    double pending[2][2];
    // Gain from the time integral of each measured state's error to the stick, per s.
    double integral_per_s[2][6];
    // Gain from each hidden state before a sample to each one after it, one row per hidden state after it.
    double hidden_from_hidden[6][6];
    // Gain from each measured state before a sample to each hidden state after it.
    double hidden_from_measured[6][6];
    // Gain from each command that acted during a sample to each hidden state after it.
    double hidden_from_pending[6][2];
    // Anti-windup time constant, s, with which the integrals follow a limited command.
    double tracking_time_s;
} HovernavRollPitchGains;

// Gains of the attitude regulator, for flight without a known velocity. The measured states are p, q, phi, theta.
typedef struct HovernavAttitudeGains {
    // Gain from each measured state to the stick, one row per control.
    double measured[2][4];
    // Gain from each hidden state to the stick, one row per control.
    double hidden[2][6];
    // Gain from the pending command, sent in the last sample, to the stick.
    double pending[2][2];
    // Gain from the time integral of each measured state's error to the stick, per s.
    double integral_per_s[2][4];
    // Gain from each hidden state before a sample to each one after it, one row per hidden state after it.
    double hidden_from_hidden[6][6];
    // Gain from each measured state before a sample to each hidden state after it.
    double hidden_from_measured[6][4];
    // Gain from each command that acted during a sample to each hidden state after it.
    double hidden_from_pending[6][2];
    // Anti-windup time constant, s, with which the integrals follow a limited command.
    double tracking_time_s;
} HovernavAttitudeGains;

// Gains of the autopilot, for the sample period of their design.
typedef struct HovernavGains {
    // Gains from the downward velocity w, body axes, to collective.
    struct HovernavPidGains heave;
    // Gains from r, psi to pedal.
    struct HovernavYawGains yaw;
    // Gain from collective to pedal, which compensates the yaw caused by collective.
    double pedal_per_collective;
    // Gains from p, q, phi, theta, u, v to cyclic.
    struct HovernavRollPitchGains roll_pitch;
    // Gains from p, q, phi, theta to cyclic, for flight without a known velocity.
    struct HovernavAttitudeGains attitude;
} HovernavGains;

// The complete configuration of the autopilot. hovernav_default_autopilot_config() sets it to the given gains, and to
// defaults for everything else.
typedef struct HovernavAutopilotConfig {
    // Period of the control loop, s, for which the gains were designed.
    double period_s;
    // Initial trim; the autopilot learns a better trim in flight.
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
    // Largest jump of a position, m: distance from the last good fix minus the distance that the vehicle can travel.
    double max_jump_m;
    // Largest delay of a fix, s, relative to the most prompt recent fix.
    double max_delay_s;
} HovernavFixLimits;

// Settings of the two serial lines: a Crossbow DMU-HDX-AHRS, and a receiver. With only one of the two sensors, leave
// the settings of the other sensor at their defaults and never call its function.
typedef struct HovernavLinesConfig {
    // Packet type that the inertial unit sends: one of HOVERNAV_DMU_.
    uint32_t dmu_mode;
    // Time between requests for a packet, s; with 0 the inertial unit sends as fast as it can.
    double dmu_cycle_s;
    // Latency from the moment of a sample to the arrival of its packet's last byte, s.
    double dmu_latency_s;
    // Rated range of the gyros, deg/s.
    double rate_range_degps;
    // Rated range of the accelerometers, standard gravity.
    double accel_range_g;
    // Signs of the accelerometers x, y, z: 1 if the output counts along the axis, -1 if it counts against the axis.
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
    // Angular rate, rad/s; with HOVERNAV_IMU_INCREMENTS its integral since the previous sample, rad.
    double gyro[3];
    // Specific force, m/s^2 (level and at rest z is -9.81); with HOVERNAV_IMU_INCREMENTS its integral since the
    // previous sample, m/s.
    double accel[3];
    // Roll from the inertial unit's own attitude, rad.
    double roll_rad;
    // Pitch from the inertial unit's own attitude, rad.
    double pitch_rad;
    // Yaw from the inertial unit's own attitude, rad, clockwise from north.
    double yaw_rad;
    // Magnetic field, gauss.
    double magnetic_field_gauss[3];
} HovernavImuSample;

// A satellite fix of the antenna. Its time is the time of validity (arrival minus latency), on the clock of the
// inertial samples.
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
    // Heading, rad, clockwise from true north.
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
    // Trust in roll, pitch and heading.
    HovernavTrust attitude;
    // Trust in velocity, all axes.
    HovernavTrust velocity;
    // Trust in position.
    HovernavTrust position;
    // Reason why roll, pitch and angular rates are not good enough.
    HovernavDistrust tilt_reason;
    // Reason why the heading is not good enough.
    HovernavDistrust heading_reason;
    // Reason why horizontal velocity is not good enough.
    HovernavDistrust velocity_reason;
    // Reason why vertical velocity is not good enough.
    HovernavDistrust vertical_velocity_reason;
    // Reason why position is not good enough.
    HovernavDistrust position_reason;
    // 1 if velocity and position are by dead reckoning, because fixes are missing.
    uint32_t dead_reckoning;
    // Time of the last accepted fix, ns, if dead_reckoning is 1; else 0.
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
    // Kind of the notice; it determines which other fields count.
    HovernavNoticeKind kind;
    // Source of the measurement.
    HovernavAid aid;
    // Reason why the measurement or sample was not used.
    HovernavUnusedReason reason;
    // Number of valid entries in `axes`.
    uint32_t axis_count;
    // Time of the event, ns.
    int64_t time_ns;
    // Number whose meaning depends on the kind: see HovernavNoticeKind.
    double value;
    // Number whose meaning depends on the kind: see HovernavNoticeKind.
    double sigma;
    // The axes of an update, in the order of their processing.
    struct HovernavInnovation axes[HOVERNAV_AXES];
} HovernavNotice;

// Motion of a sensor at the time of a reading, as predicted by the filter.
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

// One measured quantity in any unit: its residual, and the derivatives of the expected value with respect to the
// motion of the sensor. All numbers are finite: residual and sigma at most 1e9, derivatives at most 1e6, sigma at
// least 1e-9.
typedef struct HovernavRow {
    // Measured value minus expected value.
    double residual;
    // One-sigma of the measurement's white error.
    double sigma;
    // Derivative of the expected value with respect to the position north, east, down, per m.
    double by_position[3];
    // Derivative of the expected value with respect to the velocity north, east, down, per m/s.
    double by_velocity[3];
    // Derivative of the expected value with respect to a small rotation of the body about north, east, down, per rad.
    double by_attitude[3];
    // Derivative of the expected value with respect to the velocity in body axes, per m/s. It replaces `by_velocity`
    // and `by_attitude`, or adds to them.
    double by_velocity_body[3];
    // Derivative of the expected value with respect to the angular rate about the body axes, per rad/s.
    double by_angular_rate[3];
} HovernavRow;

// Function of the caller that compares a reading with the expected motion. It writes one row for each measured
// quantity to `rows` and returns the number of rows, or 0 to reject the reading. `rows` has room for HOVERNAV_ROWS
// rows and is zero before the call. The function must not use the object. `context` is the field of HovernavOwnSensor.
typedef uint32_t (*HovernavCompare)(const struct HovernavExpected *expected,
                                    struct HovernavRow *rows,
                                    void *context);

// A sensor of the caller.
typedef struct HovernavOwnSensor {
    // Function that compares a reading; must not be null.
    HovernavCompare compare;
    // Pointer passed to `compare`, for example to the reading; may be null.
    void *context;
    // Position of the sensor relative to the reference point of the lever arms, body axes, m.
    double lever_arm_m[3];
} HovernavOwnSensor;

// Inputs of one step of the autopilot.
typedef struct HovernavAutopilotInputs {
    // Time of the step, ns, on the clock of the samples.
    int64_t now_ns;
    // 1 if the pilot's sticks are received, else 0.
    uint32_t has_pilot;
    // The pilot's switch: 1 if the autopilot is to fly, else 0.
    uint32_t engage;
    // The pilot's sticks. If one value is not finite, all four sticks count as not received.
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
    // Kind of the set-point: one of HOVERNAV_SET_POINT_.
    uint32_t kind;
    // Latitude, degrees.
    double latitude_deg;
    // Longitude, degrees.
    double longitude_deg;
    // Height above the ellipsoid, m.
    double height_m;
    // Heading, rad, clockwise from true north.
    double heading_rad;
    // Velocity in the direction of the heading, m/s.
    double forward_mps;
    // Velocity to the right of the heading, m/s.
    double right_mps;
    // Velocity downwards, m/s.
    double down_mps;
    // Turn rate, rad/s, positive to the right.
    double yaw_rate_radps;
} HovernavSetPoint;

// Result of the bytes passed from one serial line.
typedef struct HovernavLineResult {
    // Bytes to write to the same line now; the first reply_length bytes count.
    uint8_t reply[HOVERNAV_REPLY];
    // Number of bytes in the reply.
    uint32_t reply_length;
    // Number of samples or fixes in the bytes that were passed to the estimator.
    uint32_t used;
    // Number of packets or fixes rejected because of impossible values, an unusable time or insufficient quality.
    uint32_t refused;
    // 1 if the link to the inertial unit failed and restarts, else 0.
    uint32_t lost;
    // For the inertial unit: time, ns, until which the caller waits for bytes. Call again when bytes arrive, or at
    // this time without bytes.
    int64_t read_until_ns;
} HovernavLineResult;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The text of a status: static, ends with a zero byte, never null.
const char *hovernav_status_text(int32_t status);

// Size of an object of this library, bytes: at most HOVERNAV_SIZE.
size_t hovernav_size(void);

// Alignment of an object of this library, bytes: at most HOVERNAV_ALIGNMENT.
size_t hovernav_alignment(void);

// The library's version, such as "0.1.0": a static text that ends with a zero byte.
const char *hovernav_version(void);

// Checks that header and library match; call it with HOVERNAV_ABI. Returns HOVERNAV_STATUS_ABI_MISMATCH if they do not
// match. hovernav_default_config() makes the same check.
HovernavStatus hovernav_check_abi(uint32_t abi);

// Creates an object in `memory`. `size` is the size of the memory, bytes, at least hovernav_size(). The memory is
// aligned at least to hovernav_alignment(). `created` receives the address of the object, which is the address of the
// memory. The memory belongs to the object until hovernav_destroy(); nothing else is ever allocated. An earlier object
// in the memory is overwritten. `fault`, unless null, receives the first value of the configuration that is out of
// range.
//
// HOVERNAV_STATUS_NULL_POINTER, _MISALIGNED, _MEMORY_TOO_SMALL or _OUT_OF_RANGE.
HovernavStatus hovernav_create(void *memory,
                               size_t size,
                               const struct HovernavConfig *config,
                               struct HovernavFault *fault,
                               struct Hovernav **created);

// Destroys an object. Its memory belongs to the caller again, and its address is no longer the address of an object. A
// null pointer is accepted and has no effect.
//
// HOVERNAV_STATUS_NOT_CREATED if there is no object at the address, or _MISALIGNED.
HovernavStatus hovernav_destroy(struct Hovernav *nav);

// Sets `config` to the defaults: a consumer or tactical-grade MEMS inertial unit on a vibrating vehicle, a stand-alone
// GPS, no lever arms. `abi` is HOVERNAV_ABI. If the library has another version, nothing is written and the result is
// HOVERNAV_STATUS_ABI_MISMATCH.
HovernavStatus hovernav_default_config(struct HovernavConfig *config,
                                       uint32_t abi);

// Checks `config`. `fault`, unless null, receives the first value that is out of range.
HovernavStatus hovernav_check_config(const struct HovernavConfig *config,
                                     struct HovernavFault *fault);

// Fills `config` with `gains`, designed for `period_s`, and defaults for everything else. `abi` is
// HOVERNAV_ABI.
HovernavStatus hovernav_default_autopilot_config(struct HovernavAutopilotConfig *config,
                                                 double period_s,
                                                 const struct HovernavGains *gains,
                                                 uint32_t abi);

// Sets `config` to the defaults. The inertial unit has ranges of 200 deg/s and 4 g, and is polled in angle mode every
// 30.3 ms. The receiver sends NMEA with a latency of 0.12 s. `abi` is HOVERNAV_ABI.
HovernavStatus hovernav_default_lines_config(struct HovernavLinesConfig *config,
                                             uint32_t abi);

// Passes a sample of the inertial unit to the estimator. A notice reports a sample that the estimator cannot use: not
// finite, or not later than the previous sample. Notices report all other results too. The estimator bridges a gap of
// any length. A wrong time far in the future therefore counts as a gap, and every sample up to this time is rejected.
// In this case hovernav_get_health() reports the estimate as stale, and the object must be created again.
HovernavStatus hovernav_push_imu(struct Hovernav *nav,
                                 const struct HovernavImuSample *sample);

// Passes a fix to the estimator. A fix up to 10 s later than the last inertial sample waits for the next sample. A
// notice reports impossible velocities and one-sigmas, and a time on a clock other than that of the samples.
//
// HOVERNAV_STATUS_OUT_OF_RANGE for an invalid position: not finite, latitude beyond 90 degrees, longitude beyond
// 360, height beyond 100 km. HOVERNAV_STATUS_UNKNOWN_CODE for an unknown flag.
HovernavStatus hovernav_push_fix(struct Hovernav *nav,
                                 const struct HovernavFix *fix);

// Passes a barometric height to the estimator: m, up, above any fixed level, valid at `time_ns`. A notice reports a
// height beyond 100 km.
//
// HOVERNAV_STATUS_NOT_BUILT if the library was built without height-aids.
HovernavStatus hovernav_push_baro(struct Hovernav *nav,
                                  int64_t time_ns,
                                  double height_m);

// Passes the magnetic field of a magnetometer separate from the inertial unit to the estimator. `field_gauss` has
// three components in body axes, gauss, valid at `time_ns`. Only its direction is used.
HovernavStatus hovernav_push_magnetometer(struct Hovernav *nav,
                                          int64_t time_ns,
                                          const double *field_gauss);

// Passes the current speed of the rotor to the notch: turns a second, Hz. The notch follows this speed from the next
// sample on. At 0, a rotor at rest, the notch stays at its last frequency.
//
// HOVERNAV_STATUS_NO_NOTCH if the configuration has no notch; HOVERNAV_STATUS_OUT_OF_RANGE for a speed that is not
// finite, negative, or 10000 Hz and more.
HovernavStatus hovernav_push_rotor_speed(struct Hovernav *nav,
                                         double rotor_hz);

// Passes a distance to the ground, m, along the beam of the rangefinder to the estimator. The distance is valid at
// `time_ns`, and `sigma_m` is its one-sigma, m. `quality` is the sensor's quality figure, from 0 (invalid) to 1.
// `sigma_m` or `quality` is NaN if the sensor does not report it.
//
// HOVERNAV_STATUS_NOT_BUILT if the library was built without height-aids.
HovernavStatus hovernav_push_range(struct Hovernav *nav,
                                   int64_t time_ns,
                                   double range_m,
                                   double sigma_m,
                                   double quality);

// Passes the heading of two GPS antennas to the estimator. The heading is the direction from the first antenna to the
// second, clockwise from true north, rad, valid at `time_ns`. `sigma_rad` is its one-sigma, rad, and `length_m` is the
// measured length of the baseline, m. `sigma_rad` or `length_m` is NaN if the receiver does not report it.
HovernavStatus hovernav_push_antenna_heading(struct Hovernav *nav,
                                             int64_t time_ns,
                                             double heading_rad,
                                             double sigma_rad,
                                             double length_m);

// Gives the solution at the last inertial sample; HOVERNAV_STATUS_NOT_YET until alignment has ended.
HovernavStatus hovernav_get_solution(struct Hovernav *nav,
                                     struct HovernavSolution *solution);

// Gives the joint covariance, 9 x 9, row by row, HOVERNAV_COVARIANCE numbers. Its rows are the attitude error (a small
// rotation, rad), the velocity error (m/s) and the position error (m) of the inertial unit, each north, east, down.
// HOVERNAV_STATUS_NOT_YET until alignment and a search for the heading, if any, have ended.
HovernavStatus hovernav_get_covariance(struct Hovernav *nav,
                                       double *covariance);

// Gives the health of the estimate at `now_ns`, on the clock of the samples. Call it once a cycle: a quantity that was
// lost must be well within its limit before it counts as good again.
HovernavStatus hovernav_get_health(struct Hovernav *nav,
                                   int64_t now_ns,
                                   struct HovernavHealth *health);

// The text of a HovernavSetupFault: static, ends with a zero byte, never null.
const char *hovernav_setup_fault_text(uint32_t fault);

// Gives the oldest unread notice and removes it; HOVERNAV_STATUS_NOT_YET when all are read. The queue stores twelve
// notices, more than one measurement can cause. After each push call it until it returns HOVERNAV_STATUS_NOT_YET.
HovernavStatus hovernav_next_notice(struct Hovernav *nav,
                                    struct HovernavNotice *notice);

// Gives the number of unread notices that newer notices overwrote.
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
// null, receives the first invalid value of the configuration. With an invalid configuration the previous autopilot
// stays active.
HovernavStatus hovernav_start_autopilot(struct Hovernav *nav,
                                        const struct HovernavAutopilotConfig *config,
                                        struct HovernavFault *fault);

// Runs one step of the autopilot. Call it once every period of its configuration. The autopilot uses the solution
// without the latest corrections, which fade in over about a second. A fix therefore never causes a jump of a stick.
// Each call counts as one period, independent of `now_ns`. A call at a rate other than the design rate of the gains is
// an error that cannot be detected here. `now_ns` gives the age of the solution and the duration of a mode.
HovernavStatus hovernav_step_autopilot(struct Hovernav *nav,
                                       const struct HovernavAutopilotInputs *inputs,
                                       struct HovernavAutopilotOutputs *outputs);

// Sets the set-point. Engagement resets it to HOVERNAV_SET_POINT_HOLD.
HovernavStatus hovernav_set(struct Hovernav *nav, const struct HovernavSetPoint *set_point);

// Starts the protocols on both serial lines, or restarts them. `fault`, unless null, receives the first invalid value
// of the configuration.
HovernavStatus hovernav_start_lines(struct Hovernav *nav,
                                    const struct HovernavLinesConfig *config,
                                    int64_t now_ns,
                                    struct HovernavFault *fault);

// Processes `length` bytes read from the inertial unit's line; the last byte arrived at `now_ns`. Pass 0 bytes if no
// byte arrived until the `read_until_ns` of the previous call. Samples in the bytes go to the estimator.
HovernavStatus hovernav_push_dmu_bytes(struct Hovernav *nav,
                                       const uint8_t *bytes,
                                       size_t length,
                                       int64_t now_ns,
                                       struct HovernavLineResult *result);

// Processes `length` bytes read from the receiver's line, which arrived at `now_ns`. Pass 0 bytes once the line is
// silent after an epoch: this ends the epoch. Good fixes go to the estimator.
HovernavStatus hovernav_push_gps_bytes(struct Hovernav *nav,
                                       const uint8_t *bytes,
                                       size_t length,
                                       int64_t now_ns,
                                       struct HovernavLineResult *result);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HOVERNAV_H */
