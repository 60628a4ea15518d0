// hovernav: navigation and hover control for small helicopters and drones.
//
// Strapdown inertial navigation with a 1 Hz GPS, and a hover autopilot, in one object that lives in
// memory you give it. No allocation, no threads, no clock of its own, no global state; every call ends
// after bounded work.
//
//     #include <hovernav.h>
//
//     static _Alignas(HOVERNAV_ALIGNMENT) unsigned char memory[HOVERNAV_SIZE];
//
//     HovernavConfig config;
//     if (hovernav_default_config(&config, HOVERNAV_ABI) != HOVERNAV_STATUS_OK)
//         return complain("the library is not this header's");
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
//             hovernav_push_fix(nav, &fix);             // as it comes: late fixes are no trouble
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
// Mistakes. Each function answers with a HovernavStatus; a call that made a mistake has changed nothing.
// Null and misaligned pointers, memory that holds no object, unknown codes and values out of range
// are found; a pointer that leads elsewhere is not. hovernav_status_text() has the words.
//
// Threads. Different objects are independent; one object is used by one thread at a time, and never from
// an interrupt that may come during a call.
//
// Made from the Rust source by cbindgen: do not edit (ffi/README.md tells how it is kept fresh).


#ifndef HOVERNAV_H
#define HOVERNAV_H

#include <stddef.h>
#include <stdint.h>

// Longest text in a HovernavFault, bytes, its zero byte included.
#define HOVERNAV_FAULT_TEXT 64

// Version of the binary interface: grows with every change of a structure, a code or a function.
#define HOVERNAV_ABI 7

// Memory that an object takes at most, bytes, in any build of the library. hovernav_size() tells how
// much it is in this one.
#define HOVERNAV_SIZE 56320

// The same where the library was built without heading-search.
#define HOVERNAV_SIZE_WITHOUT_SEARCH 28672

// Alignment of an object's memory, bytes.
#define HOVERNAV_ALIGNMENT 16

// In HovernavAlignment.heading: the first there is of two antennas', the unit's own, the magnetometer's, none.
#define HOVERNAV_HEADING_ANY 0

// The unit's own attitude.
#define HOVERNAV_HEADING_ATTITUDE 1

// The magnetometer, levelled, and the declination.
#define HOVERNAV_HEADING_MAGNETOMETER 2

// The course over ground; only for vehicles that point where they go.
#define HOVERNAV_HEADING_COURSE 3

// None: found in motion.
#define HOVERNAV_HEADING_UNKNOWN 4

// Two GPS antennas.
#define HOVERNAV_HEADING_SECOND_ANTENNA 5

// In HovernavLinesConfig.dmu_mode: rates, accelerations and field.
#define HOVERNAV_DMU_SCALED 1

// All of that and the unit's own attitude.
#define HOVERNAV_DMU_ANGLE 2

// In HovernavLinesConfig.gps_protocol: Trimble Standard Interface Protocol.
#define HOVERNAV_GPS_TSIP 1

// NMEA 0183 sentences.
#define HOVERNAV_GPS_NMEA 2

// u-blox binary.
#define HOVERNAV_GPS_UBX 3

// In HovernavImuSample.has: gyro and accel are integrals since the sample before.
#define HOVERNAV_IMU_INCREMENTS 1

// In HovernavImuSample.has: the unit's own attitude is there.
#define HOVERNAV_IMU_ATTITUDE 2

// In HovernavImuSample.has: the magnetic field is there.
#define HOVERNAV_IMU_MAGNETIC_FIELD 4

// In HovernavFix.has: one-sigma of position is there.
#define HOVERNAV_FIX_POSITION_SIGMA 1

// In HovernavFix.has: velocity north and east is there.
#define HOVERNAV_FIX_HORIZONTAL_VELOCITY 2

// In HovernavFix.has: velocity down is there.
#define HOVERNAV_FIX_DOWN_VELOCITY 4

// In HovernavFix.has: one-sigma of velocity is there.
#define HOVERNAV_FIX_VELOCITY_SIGMA 8

// In HovernavFix.has: the height was held or assumed, so that neither it nor the velocity down counts.
#define HOVERNAV_FIX_TWO_DIMENSIONAL 16

// Numbers in the matrix that hovernav_get_covariance() gives.
#define HOVERNAV_COVARIANCE 81

// Most axes of one update.
#define HOVERNAV_AXES 6

// In HovernavSetPoint.kind: stop, and stay where it stops.
#define HOVERNAV_SET_POINT_HOLD 0

// Go to a place and stay, the heading as it is.
#define HOVERNAV_SET_POINT_PLACE 1

// Go to a place and stay, and turn to a heading.
#define HOVERNAV_SET_POINT_PLACE_AND_HEADING 2

// Fly at a steady velocity.
#define HOVERNAV_SET_POINT_VELOCITY 3

// Room for what is to be written in return, bytes: more than any call asks for.
#define HOVERNAV_REPLY 64

// What a call answers. 0 is success, 1 is "not yet", the rest are mistakes of the caller; a call that
// made one has changed nothing.
typedef int32_t HovernavStatus;
enum {
    // Done.
    HOVERNAV_STATUS_OK = 0,
    // There is nothing to give yet: before alignment has ended, or when all notices are read.
    HOVERNAV_STATUS_NOT_YET = 1,
    // A pointer that is needed is null.
    HOVERNAV_STATUS_NULL_POINTER = -1,
    // A pointer is not aligned as its type must be.
    HOVERNAV_STATUS_MISALIGNED = -2,
    // The memory is smaller than hovernav_size().
    HOVERNAV_STATUS_MEMORY_TOO_SMALL = -3,
    // No object was created at this address, or it was destroyed.
    HOVERNAV_STATUS_NOT_CREATED = -4,
    // Header and library are of different versions of the binary interface.
    HOVERNAV_STATUS_ABI_MISMATCH = -5,
    // A value is out of its range; the HovernavFault says which, where the function gives one.
    HOVERNAV_STATUS_OUT_OF_RANGE = -6,
    // A code, kind or flag is none that the header names.
    HOVERNAV_STATUS_UNKNOWN_CODE = -7,
    // hovernav_start_autopilot() was not called.
    HOVERNAV_STATUS_NO_AUTOPILOT = -8,
    // hovernav_start_lines() was not called.
    HOVERNAV_STATUS_NO_LINES = -9,
    // The library was built without this receiver protocol, or without height-aids.
    HOVERNAV_STATUS_NOT_BUILT = -10,
    // A set-point is not finite, no place on Earth, or faster than the configuration allows.
    HOVERNAV_STATUS_SET_POINT_REFUSED = -11,
    // The configuration's notch has no harmonics: there is none.
    HOVERNAV_STATUS_NO_NOTCH = -12,
};

// How far a quantity can be trusted.
typedef uint32_t HovernavTrust;
enum {
    // As it should be.
    HOVERNAV_TRUST_VALID = 0,
    // Good enough to fly by, but near its limits, by dead reckoning, or doubted by a sensor.
    HOVERNAV_TRUST_DEGRADED = 1,
    // Not good enough.
    HOVERNAV_TRUST_LOST = 2,
};

// Why a quantity is not good enough to fly by.
typedef uint32_t HovernavDistrust;
enum {
    // It is good enough.
    HOVERNAV_DISTRUST_NONE = 0,
    // There is no estimate.
    HOVERNAV_DISTRUST_MISSING = 1,
    // A value of it is not finite.
    HOVERNAV_DISTRUST_NOT_FINITE = 2,
    // It is too old, or of another clock.
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
    // The sensor repeats itself: it does not measure.
    HOVERNAV_DISTRUST_FROZEN = 9,
    // The fixes deny the estimate.
    HOVERNAV_DISTRUST_DISAGREEMENT = 10,
    // A reason that this header does not know.
    HOVERNAV_DISTRUST_OTHER = 11,
};

// What a notice tells.
typedef uint32_t HovernavNoticeKind;
enum {
    // Alignment ended; the first solution is there. `sigma`: of its heading, rad.
    HOVERNAV_NOTICE_KIND_ALIGNED = 0,
    // The heading, unknown at the start, is found. `sigma`: one-sigma of it, rad.
    HOVERNAV_NOTICE_KIND_HEADING_FOUND = 1,
    // The heading was wrong and was replaced. `value`: the turn, rad; `sigma`: one-sigma, rad.
    HOVERNAV_NOTICE_KIND_HEADING_RESET = 2,
    // Alignment lacks nothing but a heading, and waits for one.
    HOVERNAV_NOTICE_KIND_HEADING_MISSING = 3,
    // A measurement was compared, axis by axis: see `axes`.
    HOVERNAV_NOTICE_KIND_UPDATED = 4,
    // A measurement could not be compared: see `aid` and `reason`.
    HOVERNAV_NOTICE_KIND_NOT_USED = 5,
    // An inertial sample ended a gap, which was bridged. `value`: its length, s.
    HOVERNAV_NOTICE_KIND_GAP_BRIDGED = 6,
    // The covariance was reset. `value`: the length of the gap that caused it, s, else 0.
    HOVERNAV_NOTICE_KIND_COVARIANCE_RESET = 7,
    // Inertial samples begin to stand at full scale, or to shake far beyond what is usual.
    HOVERNAV_NOTICE_KIND_SAMPLE_SUSPECT = 8,
    // An inertial sample was refused: see `reason`.
    HOVERNAV_NOTICE_KIND_SAMPLE_REFUSED = 9,
    // The heading is further off than its one-sigma allows, and is less sure now. `value`: the turn that
    // the fixes ask for, rad; `sigma`: its one-sigma, rad.
    HOVERNAV_NOTICE_KIND_HEADING_DOUBTED = 10,
    // Something that this header does not know.
    HOVERNAV_NOTICE_KIND_OTHER = 11,
    // The magnetic field has come off what is usual: a current or iron is nearby. `value`: by which share of its
    // strength; `sigma`: one-sigma of what this makes of the heading that goes by it, rad.
    HOVERNAV_NOTICE_KIND_FIELD_DISTURBED = 12,
    // The magnetic field is what is usual again. `value`: 0 where it is back, 1 where it has stayed changed for so long
    // that this is the usual now.
    HOVERNAV_NOTICE_KIND_FIELD_USUAL = 13,
    // The antenna does not stand where its lever arm says, and is taken to stand where it was found. `value`: how far
    // off, m; `sigma`: one-sigma of each level part, m.
    HOVERNAV_NOTICE_KIND_ANTENNA_ELSEWHERE = 14,
    // The vehicle rolls on wheels: where fixes are absent it is held to its road. `sigma`: one-sigma of its velocity
    // across, m/s. With the feature `height-aids` alone.
    HOVERNAV_NOTICE_KIND_ON_WHEELS = 15,
    // It is off its wheels, and not held to a road.
    HOVERNAV_NOTICE_KIND_OFF_WHEELS = 16,
};

// What measures beside the inertial unit.
typedef uint32_t HovernavAid;
enum {
    // The notice is not of an aid.
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
};

// Why a measurement or a sample was not used.
typedef uint32_t HovernavUnusedReason;
enum {
    // It was used.
    HOVERNAV_UNUSED_REASON_NONE = 0,
    // A value is not finite, or beyond what can be measured.
    HOVERNAV_UNUSED_REASON_NOT_FINITE = 1,
    // Older than the filter's history.
    HOVERNAV_UNUSED_REASON_TOO_OLD = 2,
    // Later than the inertial samples.
    HOVERNAV_UNUSED_REASON_AHEAD_OF_IMU = 3,
    // The same as before, though moving.
    HOVERNAV_UNUSED_REASON_REPEATED = 4,
    // Sooner than its own noise allows to be worth anything; no fault.
    HOVERNAV_UNUSED_REASON_TOO_SOON = 5,
    // The filter has no state for it; no fault.
    HOVERNAV_UNUSED_REASON_NO_STATE = 6,
    // The heading is still searched for; no fault.
    HOVERNAV_UNUSED_REASON_HEADING_UNKNOWN = 7,
    // A sample not later than the one before.
    HOVERNAV_UNUSED_REASON_NOT_LATER = 8,
    // A sample that repeats the one before to the bit, or a distance that stays the same though the vehicle
    // moves: the sensor was not measuring.
    HOVERNAV_UNUSED_REASON_STUCK = 9,
    // A reason that this header does not know.
    HOVERNAV_UNUSED_REASON_OTHER = 10,
    // A distance out of the rangefinder's reach, or that the sensor does not vouch for; no fault.
    HOVERNAV_UNUSED_REASON_OUT_OF_RANGE = 11,
    // The beam of the rangefinder leads away from the ground; no fault.
    HOVERNAV_UNUSED_REASON_TOO_TILTED = 12,
    // Two antennas further apart, or closer, than they are mounted.
    HOVERNAV_UNUSED_REASON_WRONG_BASELINE = 13,
    // A heading of two antennas that points the other way.
    HOVERNAV_UNUSED_REASON_REVERSED = 14,
    // A sample that a logger has made up between others, on a straight line.
    HOVERNAV_UNUSED_REASON_INTERPOLATED = 15,
    // An attitude that turns otherwise than the gyros.
    HOVERNAV_UNUSED_REASON_TURNS_OTHERWISE = 16,
    // A magnetic field off what it was in one reading alone so far.
    HOVERNAV_UNUSED_REASON_OUTLIER = 17,
    // A magnetic field with hardly a level part, vertical or none at all.
    HOVERNAV_UNUSED_REASON_FIELD_TOO_STEEP = 18,
    // After a gap roll and pitch are not yet known well enough to level a magnetic field; no fault.
    HOVERNAV_UNUSED_REASON_NOT_LEVELLED = 19,
    // The barometer's reading before again; no fault.
    HOVERNAV_UNUSED_REASON_NOTHING_NEW = 20,
};

// What an axis of an update compared.
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
    // Velocity of a vehicle on wheels across its road, right, m/s.
    HOVERNAV_CHANNEL_WHEELS_RIGHT = 18,
    // Velocity of a vehicle on wheels up or down from its road, down, m/s.
    HOVERNAV_CHANNEL_WHEELS_DOWN = 19,
};

// What became of an axis of an update.
typedef uint32_t HovernavVerdict;
enum {
    // It corrected the state.
    HOVERNAV_VERDICT_ACCEPTED = 0,
    // Outside the gate; the state is untouched.
    HOVERNAV_VERDICT_REJECTED = 1,
    // The filter had locked itself out and was reopened to take it.
    HOVERNAV_VERDICT_REOPENED = 2,
};

// What the autopilot is doing.
typedef uint32_t HovernavMode;
enum {
    // The pilot flies.
    HOVERNAV_MODE_MANUAL = 0,
    // Holds or moves to a position, holds the heading.
    HOVERNAV_MODE_POSITION = 1,
    // Holds a velocity over ground and the heading.
    HOVERNAV_MODE_VELOCITY = 2,
    // Holds roll, pitch and heading, and if it can the height.
    HOVERNAV_MODE_ATTITUDE = 3,
    // The same, sinking at a set rate.
    HOVERNAV_MODE_DESCENT = 4,
    // The sticks go to trim, as not even attitude is known.
    HOVERNAV_MODE_NEUTRAL = 5,
};

// Why the mode changed in this step.
typedef uint32_t HovernavModeReason;
enum {
    // It did not.
    HOVERNAV_MODE_REASON_UNCHANGED = 0,
    // The pilot's switch.
    HOVERNAV_MODE_REASON_SWITCH = 1,
    // The pilot moved a stick.
    HOVERNAV_MODE_REASON_OVERRIDE = 2,
    // The estimate is not good enough for the mode: see `distrust`.
    HOVERNAV_MODE_REASON_DISTRUST = 3,
    // The estimate is good enough for a better mode again.
    HOVERNAV_MODE_REASON_RECOVERED = 4,
    // Velocity did not come back within the configured time.
    HOVERNAV_MODE_REASON_PATIENCE = 5,
    // A reason that this header does not know.
    HOVERNAV_MODE_REASON_OTHER = 6,
};

// Estimator, health, autopilot and sensor lines. Its inside is nobody's business; its size is
// hovernav_size().
typedef struct Hovernav Hovernav;

// How the estimator starts.
typedef struct HovernavAlignment {
    // Where the first heading comes from: one of HOVERNAV_HEADING_.
    uint32_t heading;
    // Length of inertial data needed, 0.1 to 120 s.
    double duration_s;
    // What to add to the unit's yaw for true heading: the declination where it is magnetic, rad.
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
    // One-sigma of position where the fix does not say, m.
    double position_sigma_m;
    // One-sigma of velocity where the fix does not say, m/s.
    double velocity_sigma_mps;
    // Speed at which the course gives the heading, m/s.
    double course_speed_mps;
} HovernavAlignment;

// Errors of the inertial sensors.
typedef struct HovernavImuModel {
    // Angle random walk, rad/sqrt(s).
    double angle_random_walk_rad;
    // Velocity random walk, m/s/sqrt(s).
    double velocity_random_walk_mps;
    // Share of the measured vibration of the gyros that counts as noise without memory.
    double gyro_vibration_share;
    // The same of the accelerometers.
    double accel_vibration_share;
    // Accelerometer samples closer than this, s, share one error by vibration.
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
    // Share of a turn by which gyros err about its axis, where there are no states for it; those across it by two and
    // a half times as much.
    double turn_error_share;
    // A turn errs to one side for about this long, s.
    double turn_error_time_s;
    // One-sigma of each gyro's scale factor error as a share of the net turn about its axis, where there are no states
    // for it.
    double net_turn_error_share;
    // A net turn is forgotten with this time constant, s.
    double net_turn_memory_s;
    // Full scale of the gyros, rad/s; 0 where it is not known.
    double gyro_range_radps;
    // Full scale of the accelerometers, m/s^2; 0 where it is not known.
    double accel_range_mps2;
    // Intervals longer than this, s, are gaps.
    double gap_s;
    // Acceleration that a gap may have hidden, one-sigma, m/s^2.
    double gap_acceleration_mps2;
    // Angular rate that a gap may have hidden, one-sigma, rad/s.
    double gap_rate_radps;
    // The covariance is propagated once so much time has come together, s, and before each measurement; 0 at
    // every sample, as the state is.
    double covariance_interval_s;
} HovernavImuModel;

// Errors of the GPS.
typedef struct HovernavGpsModel {
    // One-sigma of horizontal position, each axis, where a fix does not say, m.
    double horizontal_sigma_m;
    // One-sigma of height where a fix does not say, m.
    double vertical_sigma_m;
    // One-sigma of horizontal velocity, each axis, where a fix does not say, m/s.
    double horizontal_velocity_sigma_mps;
    // One-sigma of vertical velocity where a fix does not say, m/s.
    double vertical_velocity_sigma_mps;
    // Least one-sigma of the white part of position, m.
    double position_floor_m;
    // Least one-sigma of the white part of velocity, m/s.
    double velocity_floor_mps;
    // Share of the position's one-sigma that wanders slowly, 0 to 1.
    double position_wander_share;
    // Correlation time of the position's slow error, s.
    double position_wander_time_s;
    // Share of the velocity's one-sigma that wanders slowly, 0 to 1.
    double velocity_wander_share;
    // Correlation time of the velocity's slow error, s.
    double velocity_wander_time_s;
    // Time over which a receiver may have taken its velocity, one-sigma, s.
    double velocity_smoothing_s;
    // Share by which one innovation moves a one-sigma that no fix states, 0 to 1.
    double learning_rate;
    // One-sigma of the time between a fix's position and its velocity, s.
    double position_latency_sigma_s;
    // One-sigma of the time by which a fix holds earlier than declared, s.
    double delay_sigma_s;
} HovernavGpsModel;

// Errors of an attitude reference.
typedef struct HovernavAttitudeModel {
    // Shortest time between two uses, s.
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

// Errors of a heading from a magnetometer.
typedef struct HovernavMagnetometerModel {
    // Shortest time between two uses, s.
    double interval_s;
    // One-sigma of its slow error, rad.
    double heading_wander_rad;
    // Correlation time of its slow error, s.
    double wander_time_s;
    // One-sigma of its white error, rad.
    double noise_rad;
} HovernavMagnetometerModel;

// Errors of a barometric height.
typedef struct HovernavBaroModel {
    // One-sigma of its white error, m.
    double noise_m;
    // One-sigma of its slow error, m.
    double wander_m;
    // Correlation time of its slow error, s.
    double wander_time_s;
} HovernavBaroModel;

// When a measurement is refused, and when a filter that refuses everything is reopened.
typedef struct HovernavGateModel {
    // Innovations beyond this many one-sigma are refused.
    double sigmas;
    // Refused after an absence or after trouble with the inertial samples, s.
    double recovery_s;
    // Positions refused that jumped while velocity goes on agreeing, s.
    double fault_s;
    // Anything else refused without a break, s.
    double lockout_s;
} HovernavGateModel;

// Errors of a distance to the ground, and of the ground.
typedef struct HovernavRangeModel {
    // Shortest distance that the sensor measures, m.
    double least_m;
    // Longest distance that the sensor measures, m.
    double most_m;
    // Readings below this quality, 0 to 1, are not used.
    double least_quality;
    // One-sigma of its white error where a reading does not say, m.
    double noise_m;
    // Share of the distance that adds to it.
    double noise_share;
    // One-sigma by which the ground rises or falls over a metre, m.
    double ground_walk_m;
} HovernavRangeModel;

// A rangefinder that looks at the ground.
typedef struct HovernavRangefinder {
    // The sensor from the point of the solution, body axes, m.
    double lever_arm_m[3];
    // Where its beam leads, body axes, of length one; 0, 0, 1 is straight down.
    double beam[3];
    // What it measures, and how the ground varies.
    struct HovernavRangeModel model;
} HovernavRangefinder;

// Errors of the heading of two antennas.
typedef struct HovernavAntennaHeadingModel {
    // Shortest time between two uses, s.
    double interval_s;
    // One-sigma where a reading does not say, rad.
    double sigma_rad;
    // Least one-sigma, rad.
    double floor_rad;
    // Share of the one-sigma that wanders slowly, 0 to 1.
    double wander_share;
    // Correlation time of what wanders, s.
    double wander_time_s;
    // A baseline that differs by more than this from the one that is mounted, m, is refused.
    double length_tolerance_m;
} HovernavAntennaHeadingModel;

// The second of two GPS antennas that give a heading.
typedef struct HovernavSecondAntenna {
    // From the first antenna to the second, body axes, m; all zero where the headings are of the vehicle itself.
    double baseline_m[3];
    // How good its heading is.
    struct HovernavAntennaHeadingModel model;
} HovernavSecondAntenna;

// A notch at the speed of a rotor: takes its vibration out of the inertial samples before anything hears them. What
// is slow comes out of it width_hz / (2 pi frequency_hz^2) seconds late, and the samples are dated back by that.
typedef struct HovernavNotch {
    // Speed of the rotor, turns a second, Hz; 0 until hovernav_push_rotor_speed() tells it.
    double frequency_hz;
    // Width of the notch at half power, Hz, the same at each harmonic.
    double width_hz;
    // What appears below this in the samples, Hz, is left in: the vehicle moves there itself.
    double least_hz;
    // How many multiples of the speed are taken out, 1 to 4; 0 for no notch, and then frequency_hz is 0.
    uint32_t harmonics;
} HovernavNotch;

// What is good enough to fly by: one-sigma and times.
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
    // Without an accepted fix for this long, s, the estimate is by dead reckoning.
    double dead_reckoning_s;
    // Fixes that are refused for this long, s, deny the estimate.
    double disagreement_s;
    // A value must be trusted this long, s, before a better mode is flown on it again.
    double recovery_s;
} HovernavHealthLimits;

// Everything about the estimator. hovernav_default_config() fills it in; change what is known better.
typedef struct HovernavConfig {
    // The inertial unit from the point of the solution (such as the centre of gravity), body axes, m.
    double imu_lever_arm_m[3];
    // The GPS antenna from the same point, body axes, m.
    double antenna_lever_arm_m[3];
    // 1 if the unit's own attitude is used once aligned, else 0.
    uint32_t use_attitude;
    // 1 if the magnetometer is used where the unit's own attitude is not, else 0.
    uint32_t use_magnetometer;
    // 1 if the barometer is used, else 0.
    uint32_t use_baro;
    // 1 if the rangefinder is used, else 0.
    uint32_t use_rangefinder;
    // 1 if the heading of two antennas is used, else 0.
    uint32_t use_second_antenna;
    // How it starts.
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
    // The rangefinder.
    struct HovernavRangefinder rangefinder;
    // The second antenna.
    struct HovernavSecondAntenna second_antenna;
    // The notch before the estimator.
    struct HovernavNotch notch;
    // What hovernav_get_health() finds good enough.
    struct HovernavHealthLimits health;
} HovernavConfig;

// Which value of a configuration is out of its range. Texts are UTF-8 and end with a zero byte.
typedef struct HovernavFault {
    // The field, named from the configuration on: "imu.gap_s". An array, or the gains of one regulator, are
    // one field.
    char what[HOVERNAV_FAULT_TEXT];
    // What was found.
    double found;
    // What would have been right, in words.
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

// Where the sticks stand in a steady hover and how the vehicle hangs in it.
typedef struct HovernavTrim {
    // The controls.
    struct HovernavSticks sticks;
    // Roll, rad.
    double roll_rad;
    // Pitch, rad.
    double pitch_rad;
} HovernavTrim;

// Range and speed that the autopilot keeps to, each control for itself.
typedef struct HovernavStickLimits {
    // Lowest, -1 to 0.
    struct HovernavSticks lowest;
    // Highest, 0 to 1.
    struct HovernavSticks highest;
    // Fastest, full travels (of 1) a second; above 0.
    struct HovernavSticks rate_per_s;
} HovernavStickLimits;

// How set-points are flown.
typedef struct HovernavGuidance {
    // Horizontal speed per distance from the place, 1/s.
    double position_gain_per_s;
    // Vertical speed per height missing, 1/s.
    double height_gain_per_s;
    // Fastest horizontal speed, m/s.
    double speed_mps;
    // Fastest climb and descent, m/s.
    double climb_mps;
    // Hardest horizontal acceleration asked for, m/s^2.
    double acceleration_mps2;
    // Hardest vertical acceleration asked for, m/s^2.
    double climb_acceleration_mps2;
    // Fastest turn, rad/s.
    double yaw_rate_radps;
} HovernavGuidance;

// How modes give way to each other.
typedef struct HovernavTransfer {
    // Time constant by which the difference between two modes' commands fades, s.
    double fade_s;
    // The same when the pilot takes over, s.
    double hand_back_s;
    // Time constant by which the sticks go to trim when attitude is not known, s.
    double neutral_s;
    // A stick moved further than this is the pilot's override.
    double override_travel;
    // How long attitude is held without velocity before the descent begins, s.
    double patience_s;
    // Sink rate of the descent, m/s.
    double descent_mps;
    // Stick taken off the trimmed collective in a descent without vertical velocity.
    double descent_collective;
    // Time constant by which trim is learned in a steady hover, s.
    double trim_s;
} HovernavTransfer;

// Gains of a PID controller; units are the command's over the error's, with s where they say so.
typedef struct HovernavPidGains {
    // Command per error.
    double proportional;
    // Command per error and s.
    double integral_per_s;
    // Command per rate of change of the measured value, s.
    double derivative_s;
    // Time constant of the low-pass on the derivative, s; from 0.
    double derivative_filter_s;
    // How fast the integral follows a command that was limited, s; above 0.
    double tracking_time_s;
} HovernavPidGains;

// Gains of the yaw regulator: measured are r, psi; the hidden states are two.
typedef struct HovernavYawGains {
    // Stick per measured state, row by control.
    double measured[1][2];
    // Stick per hidden state.
    double hidden[1][2];
    // Stick per command under way.
    double pending[1][1];
    // Stick per s of measured error.
    double integral_per_s[1][2];
    // How the hidden states follow, over a sample, from themselves.
    double hidden_from_hidden[2][2];
    // From the measured ones.
    double hidden_from_measured[2][2];
    // And from the command that acts.
    double hidden_from_pending[2][1];
    // How fast the integrals follow a command that was limited, s.
    double tracking_time_s;
} HovernavYawGains;

// Gains of the roll and pitch regulator: measured are p, q, phi, theta, u, v; the hidden states are six;
// the controls are lateral and longitudinal cyclic.
typedef struct HovernavRollPitchGains {
    // Stick per measured state, row by control.
    double measured[2][6];
    // Stick per hidden state.
    double hidden[2][6];
    // Stick per command under way.
    double pending[2][2];
    // Stick per s of measured error.
    double integral_per_s[2][6];
    // How the hidden states follow, over a sample, from themselves.
    double hidden_from_hidden[6][6];
    // From the measured ones.
    double hidden_from_measured[6][6];
    // And from the command that acts.
    double hidden_from_pending[6][2];
    // How fast the integrals follow a command that was limited, s.
    double tracking_time_s;
} HovernavRollPitchGains;

// Gains of the attitude regulator, for when velocity is not known: measured are p, q, phi, theta.
typedef struct HovernavAttitudeGains {
    // Stick per measured state, row by control.
    double measured[2][4];
    // Stick per hidden state.
    double hidden[2][6];
    // Stick per command under way.
    double pending[2][2];
    // Stick per s of measured error.
    double integral_per_s[2][4];
    // How the hidden states follow, over a sample, from themselves.
    double hidden_from_hidden[6][6];
    // From the measured ones.
    double hidden_from_measured[6][4];
    // And from the command that acts.
    double hidden_from_pending[6][2];
    // How fast the integrals follow a command that was limited, s.
    double tracking_time_s;
} HovernavAttitudeGains;

// Every gain of the autopilot, at the sample period they were designed for.
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

// Everything about the autopilot. hovernav_default_autopilot_config() fills it in but for the gains,
// which do nothing until a design's are put in.
typedef struct HovernavAutopilotConfig {
    // The loop's period, s, for which the gains were designed.
    double period_s;
    // Trim to begin with; better is learned in flight.
    struct HovernavTrim trim;
    // Range and rate of the commands.
    struct HovernavStickLimits limits;
    // How set-points are flown.
    struct HovernavGuidance guidance;
    // What is good enough to fly on.
    struct HovernavHealthLimits health;
    // How modes give way to each other.
    struct HovernavTransfer transfer;
    // The gains.
    struct HovernavGains gains;
} HovernavAutopilotConfig;

// What a receiver's fix must keep to.
typedef struct HovernavFixLimits {
    // 1 if a fix whose height is held or assumed is refused, else 0.
    uint32_t need_three_dimensions;
    // Fewest satellites used, 0 to 255.
    uint32_t min_satellites;
    // Greatest dilution of precision of position.
    double max_position_dilution;
    // Greatest horizontal dilution of precision.
    double max_horizontal_dilution;
    // Greatest one-sigma of horizontal position, m.
    double max_horizontal_sigma_m;
    // Greatest one-sigma of height, m.
    double max_vertical_sigma_m;
    // Greatest one-sigma of velocity on any axis, m/s.
    double max_velocity_sigma_mps;
    // Fastest the vehicle can go over ground, m/s.
    double max_ground_speed_mps;
    // Fastest it can climb or sink, m/s.
    double max_vertical_speed_mps;
    // Farthest that position may be from where the top speed leads since the last good fix, m.
    double max_jump_m;
    // Latest that a fix may arrive after its time, compared with the most prompt of late, s.
    double max_delay_s;
} HovernavFixLimits;

// What is on the two serial lines: a Crossbow DMU-HDX-AHRS, and a receiver. Who has only one of them
// leaves the other as it is and never calls its function.
typedef struct HovernavLinesConfig {
    // Which packets the unit is to send: one of HOVERNAV_DMU_.
    uint32_t dmu_mode;
    // Seconds from one request for a packet to the next; 0 lets the unit send as fast as it can.
    double dmu_cycle_s;
    // From the moment of a sample to the arrival of its packet's last byte, s.
    double dmu_latency_s;
    // Rated range of the gyros, deg/s.
    double rate_range_degps;
    // Rated range of the accelerometers, standard gravity.
    double accel_range_g;
    // 1 for an accelerometer whose word counts along its axis, -1 against it: x, y, z.
    int32_t accel_signs[3];
    // The receiver's language: one of HOVERNAV_GPS_.
    uint32_t gps_protocol;
    // Fixes a second, 1 to 10, to set the receiver to; 0 leaves it as it is.
    uint32_t gps_rate_hz;
    // How much earlier than its arrival a fix is valid, s.
    double gps_latency_s;
    // 1 if geoid_separation_m counts, for a receiver that does not send it, else 0.
    uint32_t has_geoid_separation;
    // The geoid's height above the ellipsoid at the site, m.
    double geoid_separation_m;
    // Which fixes are good enough.
    struct HovernavFixLimits fix_limits;
} HovernavLinesConfig;

// One sample of the inertial unit, body axes forward, right, down.
typedef struct HovernavImuSample {
    // When the rates were sampled, or the increments ended, ns.
    int64_t time_ns;
    // HOVERNAV_IMU_ flags added up; 0 for rates and nothing else.
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

// A satellite fix: of the antenna, at the time it was true (its arrival less its latency), on the
// clock of the inertial samples.
typedef struct HovernavFix {
    // When it was true, ns.
    int64_t time_ns;
    // HOVERNAV_FIX_ flags added up; 0 for a position and nothing else.
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

// Position, velocity and attitude at one moment, biases removed, with one-sigma. Position and velocity
// are those of the point that the lever arms of the configuration are measured from.
typedef struct HovernavSolution {
    // The inertial sample it holds at, ns.
    int64_t time_ns;
    // Geodetic latitude, WGS-84, degrees, north positive.
    double latitude_deg;
    // Longitude, degrees, east positive.
    double longitude_deg;
    // Height above the ellipsoid, m.
    double height_m;
    // Velocity over ground north, east, down, m/s.
    double velocity_ned_mps[3];
    // The same in body axes: u, v, w, m/s.
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

// What of the estimate is good enough to fly by, and why not.
typedef struct HovernavHealth {
    // Roll, pitch and heading.
    HovernavTrust attitude;
    // Velocity, all axes.
    HovernavTrust velocity;
    // Position.
    HovernavTrust position;
    // What is wrong with roll, pitch and angular rates.
    HovernavDistrust tilt_reason;
    // What is wrong with the heading.
    HovernavDistrust heading_reason;
    // What is wrong with horizontal velocity.
    HovernavDistrust velocity_reason;
    // What is wrong with vertical velocity.
    HovernavDistrust vertical_velocity_reason;
    // What is wrong with position.
    HovernavDistrust position_reason;
    // 1 if velocity and position are by dead reckoning, for want of fixes.
    uint32_t dead_reckoning;
    // The last accepted fix then, ns.
    int64_t dead_reckoning_since_ns;
} HovernavHealth;

// One axis of an update.
typedef struct HovernavInnovation {
    // What was compared.
    HovernavChannel channel;
    // What became of it.
    HovernavVerdict verdict;
    // Measured less predicted, in the channel's unit.
    double innovation;
    // Its predicted one-sigma, in the channel's unit.
    double sigma;
} HovernavInnovation;

// Something worth telling that came of a measurement.
typedef struct HovernavNotice {
    // What it tells, and so which of the fields below count.
    HovernavNoticeKind kind;
    // Of which aid.
    HovernavAid aid;
    // Why it was not used.
    HovernavUnusedReason reason;
    // How many of `axes` there are.
    uint32_t axis_count;
    // When, ns.
    int64_t time_ns;
    // As the kind says.
    double value;
    // As the kind says.
    double sigma;
    // The axes of an update, in the order they were taken.
    struct HovernavInnovation axes[HOVERNAV_AXES];
} HovernavNotice;

// What one step of the autopilot goes by.
typedef struct HovernavAutopilotInputs {
    // The moment of the step, on the clock of the samples, ns.
    int64_t now_ns;
    // 1 if the pilot's sticks are received, else 0.
    uint32_t has_pilot;
    // The pilot's switch: 1 if the autopilot shall fly, else 0.
    uint32_t engage;
    // The pilot's sticks. Where one is not finite, all are taken for not received.
    struct HovernavSticks pilot;
} HovernavAutopilotInputs;

// The result of one step of the autopilot.
typedef struct HovernavAutopilotOutputs {
    // Where the controls go, -1 to 1; while the pilot flies as far as the pilot's go, to 1.25.
    struct HovernavSticks sticks;
    // What it is doing.
    HovernavMode mode;
    // Why the mode changed in this step, if it did.
    HovernavModeReason reason;
    // What was not good enough.
    HovernavDistrust distrust;
} HovernavAutopilotOutputs;

// What the vehicle shall do; the kind says which fields count.
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

// What came of a line's bytes.
typedef struct HovernavLineResult {
    // Bytes to write to the same line now: the first reply_length of reply.
    uint8_t reply[HOVERNAV_REPLY];
    // How many.
    uint32_t reply_length;
    // Samples or fixes that went to the estimator.
    uint32_t used;
    // Packets or fixes that were left out: values that cannot be, no usable time, not good enough.
    uint32_t refused;
    // 1 if the unit's link has begun to start over, else 0.
    uint32_t lost;
    // Of the inertial unit: until when to read next, ns. Call again then, with or without bytes.
    int64_t read_until_ns;
} HovernavLineResult;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The text of a status: static, ends with a zero byte, never null.
const char *hovernav_status_text(int32_t status);

// Bytes of memory that an object of this library takes: at most HOVERNAV_SIZE.
size_t hovernav_size(void);

// Alignment of that memory, bytes: at most HOVERNAV_ALIGNMENT.
size_t hovernav_alignment(void);

// The library's version, "0.1.0": static, ends with a zero byte.
const char *hovernav_version(void);

// Whether header and library fit: call it with HOVERNAV_ABI. HOVERNAV_STATUS_ABI_MISMATCH if they do
// not. hovernav_default_config() checks the same.
HovernavStatus hovernav_check_abi(uint32_t abi);

// Creates an object in `memory`, of `size` bytes, at least hovernav_size(), aligned at least to
// hovernav_alignment(), and gives its address, which is that of the memory. The memory is the object's until
// hovernav_destroy(); nothing else is ever allocated. An object that was there before is gone. `fault`,
// unless null, receives which value of the configuration is out of range.
//
// HOVERNAV_STATUS_NULL_POINTER, _MISALIGNED, _MEMORY_TOO_SMALL or _OUT_OF_RANGE.
HovernavStatus hovernav_create(void *memory,
                               size_t size,
                               const struct HovernavConfig *config,
                               struct HovernavFault *fault,
                               struct Hovernav **created);

// Ends an object: its memory is the caller's again, and its address is no object any more. Null is
// taken for one that ended before.
//
// HOVERNAV_STATUS_NOT_CREATED where there is no object, _MISALIGNED.
HovernavStatus hovernav_destroy(struct Hovernav *nav);

// Fills `config` with the defaults: a consumer or tactical-grade MEMS unit on a vibrating vehicle, a
// stand-alone GPS, no lever arms. `abi` is HOVERNAV_ABI; where the library's is another, nothing is
// written and HOVERNAV_STATUS_ABI_MISMATCH comes back.
HovernavStatus hovernav_default_config(struct HovernavConfig *config,
                                       uint32_t abi);

// Whether one can navigate with `config`; `fault`, unless null, receives the first value that is out of
// its range.
HovernavStatus hovernav_check_config(const struct HovernavConfig *config,
                                     struct HovernavFault *fault);

// Fills `config` with `gains`, designed for `period_s`, and defaults for everything else. `abi` is
// HOVERNAV_ABI.
HovernavStatus hovernav_default_autopilot_config(struct HovernavAutopilotConfig *config,
                                                 double period_s,
                                                 const struct HovernavGains *gains,
                                                 uint32_t abi);

// Fills `config` with a unit of 200 deg/s and 4 g in angle mode, asked for a packet every 30.3 ms, and a
// receiver of NMEA whose fixes are 0.12 s old. `abi` is HOVERNAV_ABI.
HovernavStatus hovernav_default_lines_config(struct HovernavLinesConfig *config,
                                             uint32_t abi);

// Takes in a sample of the inertial unit. A sample that the estimator cannot use (not finite, not
// later than the one before) is told of by a notice, as everything that comes of it. After a gap the
// estimator goes on however long it was: a time that is wrong and far ahead is taken for one, and every
// sample up to it refused; hovernav_get_health() then finds the estimate stale, and the object has to be
// created anew.
HovernavStatus hovernav_push_imu(struct Hovernav *nav,
                                 const struct HovernavImuSample *sample);

// Takes in a fix. One that is later than the last inertial sample, by up to 10 s, waits for the sample
// after it. Velocities and one-sigmas that cannot be are told of by a notice, and so is a time that is not of
// the samples' clock.
//
// HOVERNAV_STATUS_OUT_OF_RANGE for what is no place on Earth: not finite, latitude beyond 90 degrees,
// longitude beyond 360, height beyond 100 km. HOVERNAV_STATUS_UNKNOWN_CODE for a flag that is none.
HovernavStatus hovernav_push_fix(struct Hovernav *nav,
                                 const struct HovernavFix *fix);

// Takes in a barometric height above any fixed level, m, up, true at `time_ns`; up to 100 km, else it is told
// of by a notice.
//
// HOVERNAV_STATUS_NOT_BUILT where the library was built without height-aids.
HovernavStatus hovernav_push_baro(struct Hovernav *nav,
                                  int64_t time_ns,
                                  double height_m);

// Takes in the field of a magnetometer apart from the inertial unit, three components in body axes,
// gauss, true at `time_ns`. Its length does not count.
HovernavStatus hovernav_push_magnetometer(struct Hovernav *nav,
                                          int64_t time_ns,
                                          const double *field_gauss);

// Takes in the speed of the rotor, turns a second, Hz, as it is now: the notch follows it from the next sample on. 0,
// a rotor that stands, leaves the notch where it is.
//
// HOVERNAV_STATUS_NO_NOTCH where the configuration has none; HOVERNAV_STATUS_OUT_OF_RANGE for a speed that is not
// finite, negative, or 10000 Hz and more.
HovernavStatus hovernav_push_rotor_speed(struct Hovernav *nav,
                                         double rotor_hz);

// Takes in a distance to the ground along the beam of the rangefinder, m, true at `time_ns`. `sigma_m`
// is its one-sigma, m, and `quality` how good the sensor takes it to be, from 0, not valid, to 1; NaN where it does
// not tell.
//
// HOVERNAV_STATUS_NOT_BUILT where the library was built without height-aids.
HovernavStatus hovernav_push_range(struct Hovernav *nav,
                                   int64_t time_ns,
                                   double range_m,
                                   double sigma_m,
                                   double quality);

// Takes in the heading of two GPS antennas, from the first to the second, clockwise from true north,
// rad, true at `time_ns`. `sigma_rad` is its one-sigma, rad, and `length_m` the length of the baseline as found, m;
// NaN where the receiver does not tell.
HovernavStatus hovernav_push_antenna_heading(struct Hovernav *nav,
                                             int64_t time_ns,
                                             double heading_rad,
                                             double sigma_rad,
                                             double length_m);

// Gives the solution at the last inertial sample; HOVERNAV_STATUS_NOT_YET until alignment has ended.
HovernavStatus hovernav_get_solution(struct Hovernav *nav,
                                     struct HovernavSolution *solution);

// Gives the joint covariance, 9 x 9, row by row, HOVERNAV_COVARIANCE numbers: of the attitude error (a
// small turn about north, east, down, rad), the velocity error (m/s) and the position error (m), north,
// east, down, of the inertial unit. HOVERNAV_STATUS_NOT_YET until alignment, and the search for a
// heading where there is one, have ended.
HovernavStatus hovernav_get_covariance(struct Hovernav *nav,
                                       double *covariance);

// Gives what of the estimate is good enough to fly by at `now_ns`, on the clock of the samples. Call
// it once a cycle: what comes back has to hold for a while before it counts.
HovernavStatus hovernav_get_health(struct Hovernav *nav,
                                   int64_t now_ns,
                                   struct HovernavHealth *health);

// Gives the oldest notice that waits and removes it; HOVERNAV_STATUS_NOT_YET when all are read. Twelve
// wait at most, more than one measurement can cause: call it after each push until then.
HovernavStatus hovernav_next_notice(struct Hovernav *nav,
                                    struct HovernavNotice *notice);

// Gives how many notices gave way to newer ones unread.
HovernavStatus hovernav_lost_notices(struct Hovernav *nav, uint32_t *lost);

// Starts an autopilot inside the object, or starts it anew; it has not taken over, the sticks at trim.
// `fault`, unless null, receives which value of the configuration cannot be flown; what flew before then
// goes on.
HovernavStatus hovernav_start_autopilot(struct Hovernav *nav,
                                        const struct HovernavAutopilotConfig *config,
                                        struct HovernavFault *fault);

// One step of the autopilot: call it once every period of its configuration. It flies on the solution as it
// stands less what measurements have just corrected, which is let in over about a second, so that no fix
// moves a stick by a step. Each call is taken for one period, whatever `now_ns` says: gains designed for
// another rate are other gains, and nothing here can tell. `now_ns` says how old the solution is, and how long
// a mode has lasted.
HovernavStatus hovernav_step_autopilot(struct Hovernav *nav,
                                       const struct HovernavAutopilotInputs *inputs,
                                       struct HovernavAutopilotOutputs *outputs);

// Says what the vehicle shall do from now on. Taking over resets it to HOVERNAV_SET_POINT_HOLD.
HovernavStatus hovernav_set(struct Hovernav *nav, const struct HovernavSetPoint *set_point);

// Starts the conversations on both lines, or starts them anew. `fault`, unless null, receives which
// value of the configuration cannot be.
HovernavStatus hovernav_start_lines(struct Hovernav *nav,
                                    const struct HovernavLinesConfig *config,
                                    int64_t now_ns,
                                    struct HovernavFault *fault);

// Takes `length` bytes that were read from the inertial unit's line, of which the last came at `now_ns`;
// none when the time that the last call returned was reached without any. Its samples go to the
// estimator.
HovernavStatus hovernav_push_dmu_bytes(struct Hovernav *nav,
                                       const uint8_t *bytes,
                                       size_t length,
                                       int64_t now_ns,
                                       struct HovernavLineResult *result);

// Takes `length` bytes that were read from the receiver's line and came at `now_ns`; none when the line
// has fallen silent behind an epoch, which ends it. Its fixes go to the estimator where they are good
// enough.
HovernavStatus hovernav_push_gps_bytes(struct Hovernav *nav,
                                       const uint8_t *bytes,
                                       size_t length,
                                       int64_t now_ns,
                                       struct HovernavLineResult *result);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HOVERNAV_H */
