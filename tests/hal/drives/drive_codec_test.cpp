// The codecs of drives: byte vectors computed by the families' documents, round trips over the whole range, any bytes.
#include "hal/drives/drive_codec.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "hal/drives/bus_load.h"
#include "hal/drives/mit_codec.h"
#include "hal/drives/moteus_codec.h"
#include "hal/drives/odrive_codec.h"
#include "hal/drives/robstride_codec.h"

using namespace tactus;
using namespace tactus::hal;

namespace {

constexpr double kPi = 3.14159265358979323846;

const DriveAxis kDm4310{.id = 1,
                        .answer_id = 0x11,
                        .position_range_rad = 12.5,
                        .speed_range_rad_per_s = 30,
                        .torque_range_Nm = 10,
                        .damping_range_Nms_per_rad = 5};
const DriveAxis kRs00{.id = 1,
                      .position_range_rad = 4 * kPi,
                      .speed_range_rad_per_s = 50,
                      .torque_range_Nm = 17,
                      .damping_range_Nms_per_rad = 5};
const DriveAxis kMoteus{.id = 1, .torque_range_Nm = 2, .damping_range_Nms_per_rad = 0.5};
const DriveAxis kOdrive{.id = 3, .torque_range_Nm = 2};

struct FamilyAxis {
  DriveFamily family;
  DriveAxis axis;
};
const FamilyAxis kAll[] = {{DriveFamily::kDamiao, kDm4310},      {DriveFamily::kCubeMars, kDm4310},
                           {DriveFamily::kMiniCheetah, kDm4310}, {DriveFamily::kRobStride, kRs00},
                           {DriveFamily::kMoteus, kMoteus},      {DriveFamily::kOdrive, kOdrive}};

std::vector<unsigned> bytes_of(const DriveFrame& frame) { return {frame.bytes().begin(), frame.bytes().end()}; }
using Bytes = std::vector<unsigned>;

DriveFrame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> bytes, bool extended = false,
                    bool fd = false) {
  DriveFrame frame{.id = id, .extended = extended, .fd = fd};
  frame.put(bytes);
  return frame;
}

DriveFrame torque(const FamilyAxis& of, double torque_Nm, double damping = 0, bool round_up = false) {
  return codec_of(of.family).encode(of.axis, {DriveAction::kTorque, torque_Nm, damping, round_up});
}

DriveAnswer answer_of(const FamilyAxis& of, const DriveFrame& frame) {
  DriveAnswer answer;
  REQUIRE(codec_of(of.family).decode(of.axis, frame, answer) == DriveDecode::kAnswer);
  return answer;
}

// The 12 bits of the torque in an MIT command.
unsigned torque_field(const DriveFrame& frame) { return (frame.data[6] & 0xfu) << 8 | frame.data[7]; }

}  // namespace

TEST_CASE("an MIT command: zero, a torque, a torque with damping") {
  const FamilyAxis damiao{DriveFamily::kDamiao, kDm4310};
  CHECK(torque(damiao, 0).id == 1);
  CHECK_FALSE(torque(damiao, 0).extended);
  CHECK(bytes_of(torque(damiao, 0)) == Bytes{0x7f, 0xff, 0x7f, 0xf0, 0, 0, 0x07, 0xff});
  CHECK(bytes_of(torque(damiao, 1)) == Bytes{0x7f, 0xff, 0x7f, 0xf0, 0, 0, 0x08, 0xcc});
  // The makers' programs cut -2.5 N m to 0x5ff, half a quantum too low in the mean; the nearest step is 0x600.
  CHECK(bytes_of(torque(damiao, -2.5, 0.5)) == Bytes{0x7f, 0xff, 0x7f, 0xf0, 0, 0x19, 0x96, 0x00});
  CHECK(bytes_of(torque(damiao, 1e9)) == Bytes{0x7f, 0xff, 0x7f, 0xf0, 0, 0, 0x0f, 0xff});
  CHECK(bytes_of(torque(damiao, -1e9, 1e9)) == Bytes{0x7f, 0xff, 0x7f, 0xf0, 0, 0xff, 0xf0, 0x00});
}

TEST_CASE("an MIT frame has no zero torque: rounded to both sides in turn, the mean is zero") {
  const FamilyAxis damiao{DriveFamily::kDamiao, kDm4310};
  const double quantum = 2 * 10.0 / 4095;
  const auto sent = [&](bool up) { return value_of_field(torque_field(torque(damiao, 0, 0, up)), 10, 12); };
  CHECK(sent(false) == Approx(-quantum / 2));
  CHECK(sent(true) == Approx(quantum / 2));
  // So is the desired speed, on which the drive's damping acts.
  CHECK(bytes_of(torque(damiao, 0, 0, true)) == Bytes{0x80, 0x00, 0x80, 0x00, 0, 0, 0x08, 0x00});
}

TEST_CASE("MIT special frames: enable, disable, clear, and never the one that moves the drive's zero") {
  const auto encoded = [](DriveFamily family, DriveAction action) {
    return bytes_of(codec_of(family).encode(kDm4310, {action, 0, 0, false}));
  };
  CHECK(encoded(DriveFamily::kDamiao, DriveAction::kEnable) == Bytes{255, 255, 255, 255, 255, 255, 255, 0xfc});
  CHECK(encoded(DriveFamily::kDamiao, DriveAction::kDisable) == Bytes{255, 255, 255, 255, 255, 255, 255, 0xfd});
  CHECK(encoded(DriveFamily::kDamiao, DriveAction::kClear) == Bytes{255, 255, 255, 255, 255, 255, 255, 0xfb});
  // Where there is no such frame, and for a poll, it is a command of zeros.
  CHECK(encoded(DriveFamily::kCubeMars, DriveAction::kClear) == bytes_of(torque({DriveFamily::kCubeMars, kDm4310}, 0)));
  CHECK(encoded(DriveFamily::kDamiao, DriveAction::kPoll) == bytes_of(torque({DriveFamily::kDamiao, kDm4310}, 0)));
  DriveAxis braked = kDm4310;
  braked.brake_damping_Nms_per_rad = 0.5;
  CHECK(bytes_of(kDamiaoCodec.encode(braked, {DriveAction::kBrake, 3, 4, false})) ==
        Bytes{0x7f, 0xff, 0x7f, 0xf0, 0, 0x19, 0x97, 0xff});
}

TEST_CASE("an MIT answer: position, speed, torque, and Damiao's status") {
  const FamilyAxis damiao{DriveFamily::kDamiao, kDm4310};
  const DriveAnswer middle = answer_of(damiao, frame_of(0x11, {0x11, 0x80, 0x00, 0x80, 0x08, 0x00, 30, 31}));
  CHECK(middle.position_rad == Approx(12.5 / 65535));
  CHECK(middle.speed_rad_per_s == Approx(30.0 / 4095));
  CHECK(middle.torque_Nm == Approx(10.0 / 4095));
  CHECK((middle.has_mode && middle.mode == DriveMode::kEnabled && middle.fault == 0));
  const DriveAnswer end = answer_of(damiao, frame_of(0x11, {0x01, 0xff, 0xff, 0xff, 0xff, 0xff, 30, 31}));
  CHECK((end.position_rad == Approx(12.5) && end.speed_rad_per_s == Approx(30) && end.torque_Nm == Approx(10)));
  CHECK(end.mode == DriveMode::kDisabled);
  for (const auto& [status, mode] : {std::pair{0x9, DriveMode::kFaulted}, {0xd, DriveMode::kTimedOut}}) {
    const auto first = static_cast<std::uint8_t>(status << 4 | 1);
    const DriveAnswer answer = answer_of(damiao, frame_of(0x11, {first, 0x80, 0, 0x80, 0x08, 0, 30, 31}));
    CHECK((answer.mode == mode && answer.fault == static_cast<std::uint32_t>(status)));
  }
}

TEST_CASE("an MIT answer of another drive is foreign, a short one is malformed") {
  DriveAnswer answer;
  const auto decode = [&](DriveFamily family, const DriveFrame& frame) {
    return codec_of(family).decode(kDm4310, frame, answer);
  };
  CHECK(decode(DriveFamily::kDamiao, frame_of(0x12, {0x11, 0x80, 0, 0x80, 8, 0, 1, 1})) == DriveDecode::kForeign);
  CHECK(decode(DriveFamily::kDamiao, frame_of(0x11, {0x12, 0x80, 0, 0x80, 8, 0, 1, 1})) == DriveDecode::kForeign);
  CHECK(decode(DriveFamily::kDamiao, frame_of(0x11, {0x11, 0x80, 0, 0x80, 8, 0})) == DriveDecode::kMalformed);
  CHECK(decode(DriveFamily::kDamiao, frame_of(0x11, {0x11, 0x80, 0, 0x80, 8, 0, 1, 1}, true)) == DriveDecode::kForeign);
  CHECK(decode(DriveFamily::kMiniCheetah, frame_of(0x11, {1, 0x80, 0, 0x80, 8, 0})) == DriveDecode::kAnswer);
  CHECK(decode(DriveFamily::kMiniCheetah, frame_of(0x11, {1, 0x80, 0, 0x80, 8})) == DriveDecode::kMalformed);
  CHECK(decode(DriveFamily::kCubeMars, frame_of(0x11, {1, 0x80, 0, 0x80, 8, 0, 40, 3})) == DriveDecode::kAnswer);
  CHECK((answer.fault == 3 && answer.mode == DriveMode::kFaulted));
  CHECK(decode(DriveFamily::kCubeMars, frame_of(0x11, {1, 0x80, 0, 0x80, 8, 0})) == DriveDecode::kMalformed);
}

TEST_CASE("Damiao's registers: requests, and answers that are no sample") {
  CHECK(damiao_read(1, DamiaoRegister::kPositionRange) == frame_of(0x7ff, {1, 0, 0x33, 21, 0, 0, 0, 0}));
  CHECK(damiao_write(1, DamiaoRegister::kTimeout, 200) == frame_of(0x7ff, {1, 0, 0x55, 9, 200, 0, 0, 0}));
  std::uint32_t value = 0;
  const DriveFrame answer = frame_of(0x11, {1, 0, 0x33, 9, 200, 0, 0, 0});
  CHECK(parse_damiao_register(kDm4310, DamiaoRegister::kTimeout, answer, value));
  CHECK(value == 200);
  CHECK_FALSE(parse_damiao_register(kDm4310, DamiaoRegister::kMasterId, answer, value));
  DriveAnswer sample;
  CHECK(kDamiaoCodec.decode(kDm4310, answer, sample) == DriveDecode::kForeign);
  CHECK_FALSE(sample.has_position);
}

TEST_CASE("RobStride: an exact zero, a torque in the identifier, damping") {
  const FamilyAxis robstride{DriveFamily::kRobStride, kRs00};
  CHECK(torque(robstride, 0) == frame_of(0x017fff01, {0x7f, 0xff, 0x7f, 0xff, 0, 0, 0, 0}, true));
  CHECK(torque(robstride, 1, 0.5) == frame_of(0x01878601, {0x7f, 0xff, 0x7f, 0xff, 0, 0, 0x19, 0x99}, true));
  CHECK(torque(robstride, -1e9).id == 0x01000001);
  CHECK(torque(robstride, 1e9).id == 0x01fffe01);
  const auto encoded = [](DriveAction action) { return kRobStrideCodec.encode(kRs00, {action, 0, 0, false}); };
  CHECK(encoded(DriveAction::kPoll) == frame_of(0x1100fd01, {0x19, 0x70, 0, 0, 0, 0, 0, 0}, true));
  CHECK(encoded(DriveAction::kEnable) == frame_of(0x0300fd01, {0, 0, 0, 0, 0, 0, 0, 0}, true));
  CHECK(encoded(DriveAction::kDisable) == frame_of(0x0400fd01, {0, 0, 0, 0, 0, 0, 0, 0}, true));
  CHECK(encoded(DriveAction::kClear) == frame_of(0x0400fd01, {1, 0, 0, 0, 0, 0, 0, 0}, true));
}

TEST_CASE("RobStride: answers contain motor, faults and mode in the identifier, and report a missing parameter") {
  const FamilyAxis robstride{DriveFamily::kRobStride, kRs00};
  const DriveAnswer runs = answer_of(robstride, frame_of(0x028001fd, {0xff, 0xfe, 0x7f, 0xff, 0, 0, 1, 0x2c}, true));
  CHECK(runs.position_rad == Approx(4 * kPi));
  CHECK(runs.speed_rad_per_s == 0.0);
  CHECK(runs.torque_Nm == Approx(-17));
  CHECK((runs.mode == DriveMode::kEnabled && runs.fault == 0));
  const DriveAnswer hot = answer_of(robstride, frame_of(0x028401fd, {0x7f, 0xff, 0x7f, 0xff, 0x7f, 0xff, 0, 0}, true));
  CHECK((hot.mode == DriveMode::kFaulted && hot.fault == 4));
  const DriveAnswer polled = answer_of(robstride, frame_of(0x110001fd, {0x19, 0x70, 0, 0, 0, 0, 0x80, 0x3f}, true));
  CHECK((polled.has_position && polled.position_rad == 1.0 && !polled.has_mode));
  DriveAnswer answer;
  CHECK(kRobStrideCodec.decode(kRs00, frame_of(0x110101fd, {0x19, 0x70, 0, 0, 0, 0, 0, 0}, true), answer) ==
        DriveDecode::kMalformed);
  std::uint32_t value = 1;
  bool known = true;
  CHECK(parse_robstride_parameter(kRs00, RobStrideParameter::kTimeout,
                                  frame_of(0x110101fd, {0x28, 0x70, 0, 0, 0, 0, 0, 0}, true), value, known));
  CHECK_FALSE(known);
  CHECK(robstride_write(1, RobStrideParameter::kTimeout, 200) ==
        frame_of(0x1200fd01, {0x28, 0x70, 0, 0, 200, 0, 0, 0}, true));
}

TEST_CASE("moteus: a torque command with its query, and the actions") {
  const FamilyAxis moteus{DriveFamily::kMoteus, kMoteus};
  CHECK(torque(moteus, 0.25) == frame_of(0x8001, {0x01, 0x00, 0x0a, 0x01, 0x20, 0x80, 0x0d, 0x22, 0x00, 0x00, 0x80,
                                                  0x3e, 0x06, 0x23, 0x00, 0x00, 0x00, 0x00, 0x05, 0x27, 0x0a, 0x00,
                                                  0x11, 0x00, 0x1f, 0x01, 0x11, 0x0f, 0x50, 0x50, 0x50, 0x50},
                                         true, true));
  CHECK(u16_at(torque(moteus, 0, 0.25), 16) == 16383);  // half of the configured damping
  CHECK(torque(moteus, 1e9).data[11] == 0x40);          // cut to 2 N m
  const auto encoded = [](DriveAction action) { return kMoteusCodec.encode(kMoteus, {action, 0, 0, false}); };
  CHECK(encoded(DriveAction::kPoll) == frame_of(0x8001, {0x11, 0, 0x1f, 1, 0x11, 0x0f}, true, true));
  CHECK(encoded(DriveAction::kBrake) ==
        frame_of(0x8001, {1, 0, 15, 0x11, 0, 0x1f, 1, 0x11, 0x0f, 0x50, 0x50, 0x50}, true, true));
  CHECK(encoded(DriveAction::kDisable).data[2] == 0);
  CHECK(moteus_read(5, MoteusRegister::kModel, 3) == frame_of(0x8005, {0x1b, 0x80, 0x02}, true, true));
}

TEST_CASE("the damping that the gain check counts is that of the frame, and never more than requested") {
  for (const FamilyAxis& of : kAll) {
    if (!codec_of(of.family).damps) continue;
    CAPTURE(codec_of(of.family).name);
    const bool own_range = of.family == DriveFamily::kMoteus || of.family == DriveFamily::kRobStride;
    const double range = own_range ? of.axis.damping_range_Nms_per_rad : 5;
    for (double asked = 1e-5; asked < 2 * range; asked *= 1.7) {
      const DriveFrame frame = torque(of, 0, asked);
      const double carried = of.family == DriveFamily::kMoteus ? u16_at(frame, 16) / 32767.0
                             : of.family == DriveFamily::kRobStride
                                 ? be16_at(frame, 6) / 65535.0
                                 : (frame.data[5] << 4 | frame.data[6] >> 4) / 4095.0;
      const double counted = sent_damping_Nms_per_rad(of.family, of.axis, asked);
      CHECK(counted == Approx(carried * range));
      CHECK(counted <= asked);
    }
  }
  CHECK(sent_damping_Nms_per_rad(DriveFamily::kOdrive, kOdrive, 1) == 0);
}

TEST_CASE("moteus: answers, short and extended identifiers, error sub-frames") {
  DriveFrame answer_frame = frame_of(0x100, {0x21, 0x00, 0x0a, 0x2f, 0x01}, false, true);
  answer_frame.put_f32(0.25f);
  answer_frame.put_f32(-1.5f);
  answer_frame.put_f32(0.125f);
  answer_frame.put({0x21, 0x0f, 0x00});
  const FamilyAxis moteus{DriveFamily::kMoteus, kMoteus};
  const DriveAnswer answer = answer_of(moteus, answer_frame);
  CHECK((answer.position_rad == Approx(kPi / 2) && answer.speed_rad_per_s == Approx(-3 * kPi)));
  CHECK((answer.torque_Nm == 0.125 && answer.mode == DriveMode::kEnabled && answer.fault == 0));
  answer_frame.data[2] = 1;
  answer_frame.data[19] = 33;
  CHECK((answer_of(moteus, answer_frame).mode == DriveMode::kFaulted && answer_of(moteus, answer_frame).fault == 33));
  answer_frame.data[2] = 11;
  CHECK(answer_of(moteus, answer_frame).mode == DriveMode::kTimedOut);
  for (const auto& [mode, is] : {std::pair{0, DriveMode::kDisabled},
                                 {2, DriveMode::kStarting},
                                 {3, DriveMode::kStarting},
                                 {4, DriveMode::kStarting},
                                 {9, DriveMode::kOther},
                                 {12, DriveMode::kOther},
                                 {13, DriveMode::kOther},
                                 {15, DriveMode::kOther}}) {
    answer_frame.data[2] = static_cast<std::uint8_t>(mode);
    CHECK(answer_of(moteus, answer_frame).mode == is);
  }

  DriveAxis ninth = kMoteus;
  ninth.id = 9;
  DriveAnswer other;
  CHECK(kMoteusCodec.decode(ninth, answer_frame, other) == DriveDecode::kForeign);
  answer_frame.id = 0x900;
  CHECK(kMoteusCodec.decode(ninth, answer_frame, other) == DriveDecode::kForeign);  // it would be extended
  answer_frame.extended = true;
  CHECK(kMoteusCodec.decode(ninth, answer_frame, other) == DriveDecode::kAnswer);

  for (const DriveFrame& broken :
       {frame_of(0x100, {0x30, 0x01, 0x02}, false, true), frame_of(0x100, {0x2f, 0x01, 0, 0}, false, true),
        frame_of(0x100, {0x21, 0x00, 0x0a}, false, true)})
    CHECK(kMoteusCodec.decode(kMoteus, broken, other) == DriveDecode::kMalformed);
  std::int32_t value = 0;
  CHECK(parse_moteus_register(kMoteus, MoteusRegister::kFirmware,
                              frame_of(0x100, {0x2a, 0x80, 0x02, 7, 0, 0, 0, 0x0b, 1, 0, 0}, false, true), value));
  CHECK(value == 0x10b);
}

TEST_CASE("ODrive: torque, estimate, heartbeat, states") {
  const FamilyAxis odrive{DriveFamily::kOdrive, kOdrive};
  CHECK(torque(odrive, 0.5) == frame_of(0x06e, {0, 0, 0, 0x3f}));
  const DriveAnswer estimate = answer_of(odrive, frame_of(0x069, {0, 0, 0x80, 0x3e, 0, 0, 0xc0, 0xbf}));
  CHECK((estimate.position_rad == Approx(kPi / 2) && estimate.speed_rad_per_s == Approx(-3 * kPi)));
  CHECK_FALSE(estimate.has_mode);
  const DriveAnswer alive = answer_of(odrive, frame_of(0x061, {0, 0, 0, 0, 8, 0, 0, 0}));
  CHECK((alive.mode == DriveMode::kEnabled && !alive.has_position));
  const DriveAnswer lost = answer_of(odrive, frame_of(0x061, {0, 8, 0, 0, 1, 0, 0, 0}));
  CHECK((lost.mode == DriveMode::kFaulted && lost.fault == 0x800));
  const auto encoded = [](DriveAction action) { return kOdriveCodec.encode(kOdrive, {action, 0, 0, false}); };
  CHECK(encoded(DriveAction::kEnable) == frame_of(0x067, {8, 0, 0, 0}));
  CHECK(encoded(DriveAction::kDisable) == frame_of(0x067, {1, 0, 0, 0}));
  CHECK(encoded(DriveAction::kPoll).size == 0);
  CHECK(encoded(DriveAction::kBrake) == frame_of(0x06e, {0, 0, 0, 0}));
  CHECK(odrive_torque_mode(3) == frame_of(0x06b, {1, 0, 0, 0, 1, 0, 0, 0}));
}

TEST_CASE("every step of a field is a value that comes back as the same step") {
  for (const unsigned bits : {12u, 16u})
    for (const double range : {0.5, 10.0, 12.5, 4 * kPi})
      for (std::uint32_t field = 0; field < (1u << bits); ++field)
        for (const bool up : {false, true}) {
          const double value = value_of_field(field, range, bits);
          if (field_of(value, range, bits, up) != field) {
            CAPTURE(bits, range, field, up);
            REQUIRE(field_of(value, range, bits, up) == field);
          }
        }
}

TEST_CASE("a torque over its whole range is off by half a step at most, in every family") {
  std::mt19937 random(7);
  for (const FamilyAxis& of : kAll) {
    CAPTURE(codec_of(of.family).name);
    const double range = of.axis.torque_range_Nm;
    std::uniform_real_distribution<double> uniform(-range, range);
    double worst = 0;
    for (int i = 0; i < 100000; ++i) {
      const double asked = uniform(random);
      const DriveFrame frame = torque(of, asked);
      const double sent = of.family == DriveFamily::kRobStride ? ((frame.id >> 8 & 0xffffu) / 32767.0 - 1) * range
                          : of.family == DriveFamily::kMoteus  ? static_cast<double>(f32_at(frame, 8))
                          : of.family == DriveFamily::kOdrive  ? static_cast<double>(f32_at(frame, 0))
                                                               : value_of_field(torque_field(frame), range, 12);
      worst = std::max(worst, std::abs(sent - asked));
    }
    const double step = of.family == DriveFamily::kRobStride                                     ? range / 32767
                        : of.family == DriveFamily::kMoteus || of.family == DriveFamily::kOdrive ? range * 0x1p-23
                                                                                                 : 2 * range / 4095;
    CHECK(worst <= 0.5 * step * (1 + 1e-9));
    CHECK(worst > 0);
  }
}

TEST_CASE("what is not finite becomes no torque, in every family") {
  for (const FamilyAxis& of : kAll)
    for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
      CHECK(torque(of, wrong, wrong) == torque(of, 0, 0));
}

TEST_CASE("ten million frames of any bytes are an answer with finite figures, foreign or malformed") {
  std::mt19937_64 random(3);
  std::uint64_t answers = 0;
  for (int i = 0; i < 10'000'000; ++i) {
    const FamilyAxis& of = kAll[random() % std::size(kAll)];
    const std::uint64_t choice = random();
    DriveFrame frame;
    // Half of them on the identifiers of an answer, so that the contents are looked at.
    const std::uint32_t ours = of.family == DriveFamily::kRobStride
                                   ? 0x020001fdu | static_cast<std::uint32_t>(choice >> 40 << 16 & 0xff0000u)
                               : of.family == DriveFamily::kMoteus ? 0x100u
                               : of.family == DriveFamily::kOdrive ? ((choice & 2) != 0 ? 0x069u : 0x061u)
                                                                   : 0x11u;
    frame.id = (choice & 1) != 0 ? ours : static_cast<std::uint32_t>(random()) & 0x1fffffffu;
    frame.extended = of.family == DriveFamily::kRobStride;
    constexpr std::uint8_t kLengths[] = {8, 8, 8, 20, 0, 1, 5, 6, 7, 12, 24, 32, 64};
    frame.size = kLengths[(choice >> 8) % std::size(kLengths)];
    for (unsigned at = 0; at < frame.size; at += 8) {
      const std::uint64_t bits = random();
      for (unsigned k = 0; k < 8 && at + k < frame.size; ++k)
        frame.data[at + k] = static_cast<std::uint8_t>(bits >> (8 * k));
    }
    if ((choice & 4) != 0) frame.data[0] = (choice & 8) != 0 ? 0x01 : 0x21;
    DriveAnswer answer;
    if (codec_of(of.family).decode(of.axis, frame, answer) != DriveDecode::kAnswer) continue;
    ++answers;
    if (!(std::isfinite(answer.position_rad) && std::isfinite(answer.speed_rad_per_s) &&
          std::isfinite(answer.torque_Nm)))
      FAIL("not finite: " << codec_of(of.family).name);
  }
  CHECK(answers > 500'000);
}

TEST_CASE("the longest frames, in microseconds") {
  const auto us = [](const FrameShape& shape) {
    return 1e-3 * static_cast<double>(longest_frame_ns(shape, 1'000'000, 5'000'000));
  };
  CHECK(us({4, false, false}) == Approx(95));
  CHECK(us({8, false, false}) == Approx(135));
  CHECK(us({8, true, false}) == Approx(160));
  CHECK(us({20, false, true}) == Approx(81).margin(1));
  CHECK(us({32, false, true}) == Approx(105).margin(1));
  CHECK(us({32, true, true}) == Approx(128).margin(1));
  CHECK(us({64, false, true}) == Approx(169).margin(1));
}

TEST_CASE("a bus above nine tenths of its time is refused, with the largest rate that fits") {
  using Catch::Matchers::Contains;
  DriveDescription drives;
  drives.buses = {"can0"};
  drives.axes.assign(3, kDm4310);
  const std::chrono::nanoseconds period(1'000'000);
  CHECK(bus_time_ns(drives, 0) == 810'000);
  CHECK(check_bus_load(drives, period).ok());
  drives.axes.assign(4, kDm4310);
  const Status four = check_bus_load(drives, period);
  REQUIRE_FALSE(four.ok());
  CHECK_THAT(four.message(), Contains("can0") && Contains("108 %") && Contains("--rate 833"));
  CHECK(check_bus_load(drives, std::chrono::nanoseconds(1'000'000'000 / 833)).ok());
  CHECK_FALSE(check_bus_load(drives, std::chrono::nanoseconds(1'000'000'000 / 834)).ok());
  drives.buses = {"can0", "can1"};
  drives.axes[2].bus = drives.axes[3].bus = 1;
  CHECK(check_bus_load(drives, period).ok());
  drives.family = DriveFamily::kMoteus;
  drives.data_bit_per_s = 5'000'000;
  drives.axes.assign(6, kMoteus);
  for (unsigned i = 0; i < 6; ++i) drives.axes[i].bus = i / 3;
  CHECK(check_bus_load(drives, period).ok());
  for (DriveAxis& axis : drives.axes) axis.bus = 0;
  CHECK_THAT(check_bus_load(drives, period).message(), Contains("can0") && Contains("two buses"));
}
