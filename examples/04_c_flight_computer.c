// A recorded flight through the estimator, in C: the same solution as in Rust, to the last bit.
//
//     cargo build --release -p hovernav-ffi
//     cc -std=c11 -Iffi/include examples/04_c_flight_computer.c -Ltarget/release -lhovernav_c -lm
//     LD_LIBRARY_PATH=target/release ./a.out datasets/heli-hover [SAMPLES [ROTOR_HZ]]
//
// ROTOR_HZ removes the vibration of a rotor and its second harmonic from the samples.
//
// In main(), the code between reading a row and the end of the loop is that of a flight computer.

#include <hovernav.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROW 1024
static const double RAD_PER_DEG = 3.14159265358979323846 / 180.0;

// All the memory of the object.
static _Alignas(HOVERNAV_ALIGNMENT) unsigned char memory[HOVERNAV_SIZE];

static FILE *open_table(const char *directory, const char *name) {
    char path[4096], header[ROW];
    if (snprintf(path, sizeof path, "%s/%s", directory, name) >= (int)sizeof path) {
        fprintf(stderr, "%s: the path is too long\n", directory);
        exit(1);
    }
    FILE *file = fopen(path, "r");
    if (file == NULL || fgets(header, sizeof header, file) == NULL) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(1);
    }
    return file;
}

// The next row's numbers; 0 at the end.
static int next_row(FILE *file, double *numbers, int count) {
    char row[ROW];
    if (fgets(row, sizeof row, file) == NULL)
        return 0;
    char *at = row;
    for (int i = 0; i < count; i++) {
        char *end;
        numbers[i] = strtod(at, &end);
        if (end == at) {
            fprintf(stderr, "expected %d numbers, found: %s", count, row);
            exit(1);
        }
        at = *end == ',' ? end + 1 : end;
    }
    return 1;
}

static int64_t nanoseconds(double seconds) { return llround(seconds * 1e9); }

static void must(HovernavStatus status, const char *what) {
    if (status != HOVERNAV_STATUS_OK) {
        fprintf(stderr, "%s: %s\n", what, hovernav_status_text(status));
        exit(1);
    }
}

// t_s, gyro x y z, accel x y z, roll, pitch, yaw, field x y z
static HovernavImuSample sample_of(const double *row) {
    HovernavImuSample sample = {
        .time_ns = nanoseconds(row[0]),
        .has = HOVERNAV_IMU_ATTITUDE | HOVERNAV_IMU_MAGNETIC_FIELD,
        .roll_rad = row[7] * RAD_PER_DEG,
        .pitch_rad = row[8] * RAD_PER_DEG,
        .yaw_rad = row[9] * RAD_PER_DEG,
    };
    memcpy(sample.gyro, &row[1], sizeof sample.gyro);
    memcpy(sample.accel, &row[4], sizeof sample.accel);
    memcpy(sample.magnetic_field_gauss, &row[10], sizeof sample.magnetic_field_gauss);
    return sample;
}

// t_s, latitude, longitude, height, velocity north east down, sigma h v, velocity's sigma h v
static HovernavFix fix_of(const double *row) {
    return (HovernavFix){
        .time_ns = nanoseconds(row[0]),
        .has = HOVERNAV_FIX_POSITION_SIGMA | HOVERNAV_FIX_HORIZONTAL_VELOCITY |
               HOVERNAV_FIX_DOWN_VELOCITY | HOVERNAV_FIX_VELOCITY_SIGMA,
        .latitude_deg = row[1],
        .longitude_deg = row[2],
        .height_m = row[3],
        .velocity_ned_mps = {row[4], row[5], row[6]},
        .position_sigma_m = {row[7], row[7], row[8]},
        .velocity_sigma_mps = {row[9], row[9], row[10]},
    };
}

int main(int count, char **arguments) {
    const char *directory = count > 1 ? arguments[1] : "datasets/heli-hover";
    long most = count > 2 ? atol(arguments[2]) : -1;
    double rotor_hz = count > 3 ? atof(arguments[3]) : 0.0;

    // The vehicle's settings from dataset.toml; all others keep their defaults.
    HovernavConfig config;
    must(hovernav_default_config(&config, HOVERNAV_ABI), "defaults");
    memcpy(config.imu_lever_arm_m, (double[]){0.03, -0.02, 0.28}, sizeof config.imu_lever_arm_m);
    memcpy(config.antenna_lever_arm_m, (double[]){-0.35, 0.0, 0.2},
           sizeof config.antenna_lever_arm_m);
    config.imu.angle_random_walk_rad = 2.25 * RAD_PER_DEG / 60.0;
    config.imu.velocity_random_walk_mps = 0.45 / 60.0;
    config.imu.gyro_bias_sigma_radps = 0.25 * RAD_PER_DEG;
    config.imu.accel_bias_sigma_mps2 = 0.09;
    config.imu.gyro_range_radps = 200.0 * RAD_PER_DEG;
    config.imu.accel_range_mps2 = 4.0 * 9.80665;
    config.alignment.declination_rad = 0.42 * RAD_PER_DEG;
    config.notch.frequency_hz = rotor_hz;
    config.notch.harmonics = rotor_hz > 0.0 ? 2 : 0;

    Hovernav *nav;
    HovernavFault fault;
    HovernavStatus status = hovernav_create(memory, sizeof memory, &config, &fault, &nav);
    if (status == HOVERNAV_STATUS_OUT_OF_RANGE) {
        fprintf(stderr, "%s: found %g, expected %s\n", fault.what, fault.found, fault.expected);
        return 1;
    }
    must(status, "hovernav_create");

    FILE *imu = open_table(directory, "imu.csv"), *gps = open_table(directory, "gps.csv");
    double imu_row[13], gps_row[11];
    int have_fix = next_row(gps, gps_row, 11);
    long samples = 0, solutions = 0, refused = 0;
    uint64_t hash = 14695981039346656037u; // FNV-1a over every solution
    HovernavSolution solution;

    while (samples != most && next_row(imu, imu_row, 13)) {
        HovernavImuSample sample = sample_of(imu_row);
        for (; have_fix && nanoseconds(gps_row[0]) < sample.time_ns;
             have_fix = next_row(gps, gps_row, 11)) {
            HovernavFix fix = fix_of(gps_row);
            must(hovernav_push_fix(nav, &fix), "hovernav_push_fix");
        }
        must(hovernav_push_imu(nav, &sample), "hovernav_push_imu");
        samples++;

        HovernavNotice notice;
        while (hovernav_next_notice(nav, &notice) == HOVERNAV_STATUS_OK)
            for (uint32_t axis = 0; axis < notice.axis_count; axis++)
                refused += notice.axes[axis].verdict == HOVERNAV_VERDICT_REJECTED;

        if (hovernav_get_solution(nav, &solution) == HOVERNAV_STATUS_OK) {
            const unsigned char *bytes = (const unsigned char *)&solution;
            for (size_t i = 0; i < sizeof solution; i++)
                hash = (hash ^ bytes[i]) * 1099511628211u;
            solutions++;
        }
    }
    fclose(imu);
    fclose(gps);
    if (solutions == 0) {
        fprintf(stderr, "%s: the estimator did not align in %ld samples\n", directory, samples);
        return 1;
    }

    double covariance[HOVERNAV_COVARIANCE];
    HovernavHealth health;
    must(hovernav_get_covariance(nav, covariance), "hovernav_get_covariance");
    must(hovernav_get_health(nav, solution.time_ns, &health), "hovernav_get_health");
    printf("%ld samples, %ld solutions, %ld axes refused, %016llx\n", samples, solutions, refused,
           (unsigned long long)hash);
    printf("u %.3f, v %.3f, w %.3f m/s +- %.3f, heading %.1f deg, velocity is %s\n",
           solution.velocity_body_mps[0], solution.velocity_body_mps[1],
           solution.velocity_body_mps[2], sqrt(covariance[3 * 9 + 3]),
           solution.yaw_rad / RAD_PER_DEG, health.velocity == HOVERNAV_TRUST_VALID ? "good" : "not");
    must(hovernav_destroy(nav), "hovernav_destroy");
    return 0;
}
