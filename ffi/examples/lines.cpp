// Raw bytes of a receiver, samples of an inertial unit, and the hover autopilot, in C++17. A gust turns a
// vehicle at rest, and the sticks respond.
//
// The gains here only damp rates. A design for the vehicle gives usable gains:
//
//     hovernav design MODEL --out DIR --emit c

#include <hovernav.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

namespace {

constexpr double period_s = 0.03;

void must(HovernavStatus status, const char *what) {
    if (status != HOVERNAV_STATUS_OK) {
        std::fprintf(stderr, "%s: %s\n", what, hovernav_status_text(status));
        std::exit(1);
    }
}

// The object and its memory, for as long as they are used.
class Navigator {
  public:
    explicit Navigator(const HovernavConfig &config) {
        HovernavFault fault;
        if (hovernav_create(memory.data(), memory.size(), &config, &fault, &nav) !=
            HOVERNAV_STATUS_OK) {
            std::fprintf(stderr, "%s: found %g, expected %s\n", fault.what, fault.found,
                         fault.expected);
            std::exit(1);
        }
    }
    ~Navigator() { hovernav_destroy(nav); }
    Navigator(const Navigator &) = delete;
    Navigator &operator=(const Navigator &) = delete;
    Hovernav *get() const { return nav; }

  private:
    alignas(HOVERNAV_ALIGNMENT) std::array<unsigned char, HOVERNAV_SIZE> memory;
    Hovernav *nav = nullptr;
};

std::string sentence(const std::string &body) {
    unsigned sum = 0;
    for (unsigned char byte : body)
        sum ^= byte;
    char end[8];
    std::snprintf(end, sizeof end, "*%02X\r\n", sum);
    return "$" + body + end;
}

// The output of a receiver at rest in second `second`.
std::string nmea(int second) {
    char time[16], body[128];
    std::snprintf(time, sizeof time, "1200%02d.00", second);
    std::snprintf(body, sizeof body, "GPGGA,%s,4806.0000,N,01136.0000,E,1,09,0.9,473.0,M,47.0,M,,",
                  time);
    std::string text = sentence(body);
    std::snprintf(body, sizeof body, "GPRMC,%s,A,4806.0000,N,01136.0000,E,0.0,0.0,010625,,,A",
                  time);
    return text + sentence(body);
}

HovernavGains damping() {
    HovernavGains gains{};
    gains.heave.tracking_time_s = 1.0;
    gains.yaw.tracking_time_s = gains.roll_pitch.tracking_time_s = 1.0;
    gains.attitude.tracking_time_s = 1.0;
    gains.yaw.measured[0][0] = 0.2;
    gains.roll_pitch.measured[0][0] = gains.roll_pitch.measured[1][1] = 0.1;
    gains.attitude.measured[0][0] = gains.attitude.measured[1][1] = 0.1;
    return gains;
}

} // namespace

int main() {
    HovernavConfig config;
    must(hovernav_default_config(&config, HOVERNAV_ABI), "defaults");
    auto navigator = std::make_unique<Navigator>(config);
    Hovernav *nav = navigator->get();

    HovernavLinesConfig lines;
    must(hovernav_default_lines_config(&lines, HOVERNAV_ABI), "defaults of the lines");
    lines.gps_protocol = HOVERNAV_GPS_NMEA;
    must(hovernav_start_lines(nav, &lines, 0, nullptr), "hovernav_start_lines");

    HovernavAutopilotConfig autopilot;
    const HovernavGains gains = damping();
    must(hovernav_default_autopilot_config(&autopilot, period_s, &gains, HOVERNAV_ABI), "defaults");
    must(hovernav_start_autopilot(nav, &autopilot, nullptr), "hovernav_start_autopilot");

    HovernavAutopilotOutputs outputs{};
    unsigned fixes = 0;
    for (int cycle = 0; cycle < 1000; cycle++) {
        const int64_t now_ns = cycle * int64_t{30'000'000};
        const double rate_radps = cycle > 990 ? 0.3 : 0.0;

        HovernavImuSample sample{};
        sample.time_ns = now_ns;
        sample.has = HOVERNAV_IMU_ATTITUDE;
        sample.gyro[0] = rate_radps;
        // A unit in flight vibrates; one that repeats the same sample counts as frozen.
        sample.accel[0] = 0.01 * (cycle % 5 - 2);
        sample.accel[2] = -9.81;
        must(hovernav_push_imu(nav, &sample), "hovernav_push_imu");

        if (cycle % 33 == 32) {
            const std::string bytes = nmea(cycle / 33);
            HovernavLineResult result;
            must(hovernav_push_gps_bytes(nav, reinterpret_cast<const uint8_t *>(bytes.data()),
                                         bytes.size(), now_ns, &result),
                 "hovernav_push_gps_bytes");
            fixes += result.used;
        }

        HovernavAutopilotInputs inputs{};
        inputs.now_ns = now_ns;
        inputs.has_pilot = 1;
        inputs.engage = cycle > 300;
        must(hovernav_step_autopilot(nav, &inputs, &outputs), "hovernav_step_autopilot");
    }
    HovernavSolution solution;
    must(hovernav_get_solution(nav, &solution), "hovernav_get_solution");
    std::printf("%u fixes, height %.1f m, mode %u, lateral %.3f\n", fixes, solution.height_m,
                static_cast<unsigned>(outputs.mode), outputs.sticks.lateral);
    // Left, against the turn.
    return outputs.sticks.lateral < 0.0 ? 0 : 1;
}
