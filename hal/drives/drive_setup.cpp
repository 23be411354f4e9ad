#include "hal/drives/drive_setup.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "hal/drives/drive_faults.h"
#include "hal/drives/mit_codec.h"
#include "hal/drives/moteus_codec.h"
#include "hal/drives/odrive_codec.h"
#include "hal/drives/robstride_codec.h"

namespace tactus::hal {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds kListen{20};        // how long to listen for drives that send without a request
constexpr milliseconds kSilence{15};       // provokes a watchdog of kLongestWatchdog_s
constexpr milliseconds kHeartbeat{250};    // an ODrive's comes every 100 ms
constexpr milliseconds kFeed{1};           // between the commands that keep a watchdog quiet
constexpr milliseconds kMoteusStart{100};  // from stopped to position mode: 10 to 15 ms

enum class Purpose : std::uint8_t { kPrepare, kCompare };

// Requests to one drive, and its answers.
class Talk {
 public:
  Talk(const DriveDescription& drives, unsigned number, DriveBus& bus)
      : axis(drives.axes[number]),
        codec(codec_of(drives.family)),
        family(drives.family),
        watchdog_s(drives.watchdog_s),
        number_(number),
        bus_(bus) {}

  Status error(const std::string& what) const {
    return Status::error(fmt::format("axis {} (drive {}): {}", number_, axis.id, what));
  }
  void tell(const DriveFrame& frame) { (void)bus_.send(frame); }
  void tell(DriveAction action) {
    const DriveFrame frame = codec.encode(axis, {.action = action});
    if (frame.size > 0) tell(frame);
  }

  // Calls `take` for each frame until it returns true: it was the answer. False: none came within `patience`.
  template <class F>
  bool hear(milliseconds patience, F&& take) {
    const std::int64_t deadline = bus_.now_ns() + nanoseconds(patience).count();
    ReceivedDriveFrame received;
    for (;;) {
      while (bus_.receive(received))
        if (take(received.frame)) return true;
      const std::int64_t left = deadline - bus_.now_ns();
      if (left <= 0) return false;
      bus_.wait(nanoseconds(left));
    }
  }
  template <class F>
  bool ask(const DriveFrame& request, F&& take) {
    tell(request);
    return hear(kDriveAnswer, take);
  }
  // Waits for the next answer; `with_mode`: for the next one with a mode. CubeMars and mini-cheetah report none.
  bool sample(milliseconds patience, DriveAnswer& answer, bool with_mode) {
    return hear(patience, [&](const DriveFrame& frame) {
      DriveAnswer one;
      if (codec.decode(axis, frame, one) != DriveDecode::kAnswer) return false;
      if (with_mode && !one.has_mode) return false;
      answer = one;
      return true;
    });
  }
  // As sample() with a mode; sends `fed` to the drive once a millisecond meanwhile.
  bool sample_fed(milliseconds patience, DriveAction fed, DriveAnswer& answer) {
    for (milliseconds waited{0}; waited < patience; waited += kFeed) {
      tell(fed);
      if (sample(kFeed, answer, true)) return true;
    }
    return false;
  }
  Status reports(std::uint32_t code, const char* then) const {
    return error(fmt::format("reports {}; {}", describe_drive_code(family, code), then));
  }
  void be_silent(milliseconds time) {
    (void)hear(time, [](const DriveFrame&) { return false; });
  }

  const DriveAxis& axis;
  const DriveCodec& codec;
  DriveFamily family;
  double watchdog_s;

 private:
  unsigned number_;
  DriveBus& bus_;
};

const char* const kSilent = "does not answer; is it powered, are bit rate, bus and id those of the description?";

// --- Damiao

Status read(Talk& talk, DamiaoRegister number, std::uint32_t& value) {
  const bool answered = talk.ask(damiao_read(talk.axis.id, number), [&](const DriveFrame& frame) {
    return parse_damiao_register(talk.axis, number, frame, value);
  });
  return answered ? Status::good() : talk.error(kSilent);
}

// Writes the value if the register has another one, and reads it back. With Purpose::kCompare it writes nothing: a
// different value is an error.
Status hold(Talk& talk, DamiaoRegister number, std::uint32_t wanted, Purpose purpose) {
  std::uint32_t value = 0;
  if (Status status = read(talk, number, value); !status.ok()) return status;
  if (value != wanted && purpose == Purpose::kPrepare) {
    talk.tell(damiao_write(talk.axis.id, number, wanted));
    talk.be_silent(milliseconds(2));
    if (Status status = read(talk, number, value); !status.ok()) return status;
  }
  if (value == wanted) return Status::good();
  return talk.error(fmt::format("register {} is {} instead of {}; {}", static_cast<unsigned>(number), value, wanted,
                                purpose == Purpose::kPrepare ? "it does not keep what is written"
                                                             : "the drive has restarted: end the run and start again"));
}

Status same_range(Talk& talk, DamiaoRegister number, double described, const char* key) {
  std::uint32_t value = 0;
  if (Status status = read(talk, number, value); !status.ok()) return status;
  const auto range = static_cast<double>(std::bit_cast<float>(value));
  if (std::abs(range - described) <= 1e-4 * described) return Status::good();
  return talk.error(fmt::format("register {} is {:g}, the description's {} is {:g}; write the drive's into it",
                                static_cast<unsigned>(number), range, key, described));
}

Status go_through_damiao(Talk& talk, Purpose purpose, std::string& identity) {
  std::uint32_t value = 0;
  if (Status status = read(talk, DamiaoRegister::kMasterId, value); !status.ok()) return status;
  if (value != talk.axis.answer_id)
    return talk.error(fmt::format("register 7 is {}, the description's answer_id is {}", value, talk.axis.answer_id));
  const auto timeout = static_cast<std::uint32_t>(std::lround(talk.watchdog_s / kDamiaoTimeoutStep_s));
  const DriveAxis& axis = talk.axis;
  Status status = same_range(talk, DamiaoRegister::kPositionRange, axis.position_range_rad, "position_range_rad");
  if (status.ok())
    status = same_range(talk, DamiaoRegister::kSpeedRange, axis.speed_range_rad_per_s, "speed_range_rad_per_s");
  if (status.ok()) status = same_range(talk, DamiaoRegister::kTorqueRange, axis.torque_range_Nm, "torque_range_Nm");
  if (status.ok()) status = hold(talk, DamiaoRegister::kControlMode, 1, purpose);
  if (status.ok()) status = hold(talk, DamiaoRegister::kTimeout, timeout, purpose);
  if (!status.ok()) return status;
  identity = fmt::format("Damiao {}", talk.axis.id);
  if (purpose == Purpose::kCompare) return Status::good();
  talk.tell(DriveAction::kDisable);
  talk.tell(DriveAction::kClear);
  talk.be_silent(milliseconds(2));
  talk.tell(DriveAction::kPoll);  // zero torque and gains: a drive applies its stored command as soon as it is enabled
  DriveAnswer answer;
  if (!talk.sample(kDriveAnswer, answer, true)) return talk.error(kSilent);
  if (answer.mode == DriveMode::kDisabled) return Status::good();
  return talk.reports(answer.fault, "it stays after it was cleared: mend what it names");
}

// --- CubeMars, mini-cheetah: they have nothing to read

Status go_through_mit(Talk& talk, Purpose purpose, std::string& identity) {
  identity = fmt::format("{} {}", talk.codec.name, talk.axis.id);
  if (purpose == Purpose::kCompare) return Status::good();
  talk.tell(DriveAction::kDisable);
  talk.be_silent(milliseconds(2));
  talk.tell(DriveAction::kPoll);
  DriveAnswer answer;
  if (!talk.sample(kDriveAnswer, answer, false)) return talk.error(kSilent);
  if (answer.fault == 0) return Status::good();
  return talk.reports(answer.fault, "mend what it names");
}

// --- RobStride

Status read(Talk& talk, RobStrideParameter index, std::uint32_t& value) {
  bool known = false;
  const bool answered = talk.ask(robstride_read(talk.axis.id, index), [&](const DriveFrame& frame) {
    return parse_robstride_parameter(talk.axis, index, frame, value, known);
  });
  if (!answered) return talk.error(kSilent);
  if (known) return Status::good();
  return talk.error(fmt::format("its firmware has no parameter {:#06x}; update it", static_cast<unsigned>(index)));
}

Status hold(Talk& talk, RobStrideParameter index, std::uint32_t wanted, Purpose purpose) {
  std::uint32_t value = 0;
  if (purpose == Purpose::kPrepare) {
    talk.tell(robstride_write(talk.axis.id, index, wanted));
    talk.be_silent(milliseconds(2));
  }
  if (Status status = read(talk, index, value); !status.ok()) return status;
  if (value == wanted) return Status::good();
  return talk.error(fmt::format("parameter {:#06x} is {} instead of {}; {}", static_cast<unsigned>(index), value,
                                wanted,
                                purpose == Purpose::kPrepare ? "it does not keep what is written"
                                                             : "the drive has restarted: end the run and start again"));
}

Status go_through_robstride(Talk& talk, Purpose purpose, std::string& identity) {
  std::uint64_t chip = 0;
  if (!talk.ask(robstride_ask_id(talk.axis.id),
                [&](const DriveFrame& frame) { return parse_robstride_id(talk.axis, frame, chip); }))
    return talk.error(kSilent);
  identity = fmt::format("RobStride {} {:016x}", talk.axis.id, chip);
  if (purpose == Purpose::kPrepare) {
    talk.tell(DriveAction::kClear);
    talk.be_silent(milliseconds(2));
  }
  const auto timeout = static_cast<std::uint32_t>(std::lround(talk.watchdog_s / kRobStrideTimeoutStep_s));
  if (Status status = hold(talk, RobStrideParameter::kRunMode, 0, purpose); !status.ok()) return status;
  if (Status status = hold(talk, RobStrideParameter::kTimeout, timeout, purpose); !status.ok()) return status;
  if (purpose == Purpose::kCompare) return Status::good();
  const auto limit = std::bit_cast<std::uint32_t>(static_cast<float>(talk.axis.torque_range_Nm));
  return hold(talk, RobStrideParameter::kTorqueLimit, limit, purpose);
}

// --- moteus

Status read(Talk& talk, MoteusRegister number, std::int32_t& value) {
  const bool answered = talk.ask(moteus_read(talk.axis.id, number, 1), [&](const DriveFrame& frame) {
    return parse_moteus_register(talk.axis, number, frame, value);
  });
  return answered ? Status::good() : talk.error(kSilent);
}

// Sends enable commands until the drive is in position mode. Before that its watchdog does not count, so a time-out
// that it reports is of an earlier run and proves nothing.
Status start_moteus(Talk& talk) {
  DriveAnswer answer;
  talk.tell(DriveAction::kDisable);
  talk.be_silent(milliseconds(2));
  for (milliseconds waited{0}; waited < kMoteusStart; waited += kFeed) {
    talk.tell(DriveAction::kEnable);  // without torque
    if (!talk.sample(kDriveAnswer, answer, true)) return talk.error(kSilent);
    if (answer.mode == DriveMode::kEnabled) return Status::good();
    if (answer.mode == DriveMode::kFaulted) return talk.reports(answer.fault, "mend what it names");
    talk.be_silent(kFeed);
  }
  return talk.error("does not go into position mode; look at it with the maker's tool");
}

Status provoke_moteus_watchdog(Talk& talk) {
  if (Status status = start_moteus(talk); !status.ok()) {
    talk.tell(DriveAction::kDisable);
    return status;
  }
  talk.be_silent(kSilence);
  talk.tell(DriveAction::kPoll);
  DriveAnswer answer;
  const bool answered = talk.sample(kDriveAnswer, answer, true);
  talk.tell(DriveAction::kDisable);
  talk.be_silent(milliseconds(2));
  if (!answered) return talk.error(kSilent);
  if (answer.mode == DriveMode::kTimedOut) return Status::good();
  if (answer.mode == DriveMode::kFaulted) return talk.reports(answer.fault, "look it up in its manual");
  return talk.error(
      "its watchdog did not act after 15 ms of silence; set servo.default_timeout_s and "
      "servo.timeout_mode = 15 with the maker's tool");
}

// The time-out mode must be the brake. With the factory's mode 12 the drive also reports mode 11 after a time-out, but
// it damps with the gain of the last command, which is 0 if that command had torque only.
Status check_timeout_mode(Talk& talk) {
  talk.tell(moteus_ask_configuration(talk.axis.id, kMoteusTimeoutMode));
  std::string told;
  for (int polls = 0; polls < 5 && told.find('\n') == std::string::npos; ++polls)
    (void)talk.ask(moteus_poll_text(talk.axis.id),
                   [&](const DriveFrame& frame) { return take_moteus_text(talk.axis, frame, told); });
  int number = 0;
  const auto [end, error] = std::from_chars(told.data(), told.data() + told.size(), number);
  if (error != std::errc()) return Status::good();  // the drive did not answer: only the provoked time-out is known
  if (number == kMoteusBrake) return Status::good();
  return talk.error(fmt::format("{} is {}; set it to {}, brake, with the maker's tool: conf set {} {}, conf write",
                                kMoteusTimeoutMode, number, kMoteusBrake, kMoteusTimeoutMode, kMoteusBrake));
}

Status go_through_moteus(Talk& talk, const DriveDescription& drives, Purpose purpose, std::string& identity) {
  std::int32_t model = 0, firmware = 0, map = 0, home = 0, serial[3]{};
  Status status = read(talk, MoteusRegister::kModel, model);
  if (status.ok()) status = read(talk, MoteusRegister::kFirmware, firmware);
  if (status.ok()) status = read(talk, MoteusRegister::kRegisterMap, map);
  for (unsigned i = 0; i < 3 && status.ok(); ++i) {
    const auto number = static_cast<std::uint16_t>(static_cast<unsigned>(MoteusRegister::kSerial1) + i);
    status = read(talk, static_cast<MoteusRegister>(number), serial[i]);
  }
  if (status.ok()) status = read(talk, MoteusRegister::kHomeState, home);
  if (!status.ok()) return status;
  if (map != 5) return talk.error(fmt::format("has register map {}, this program knows 5; update its firmware", map));
  if (home < 2 && !drives.held_at_centre)
    return talk.error(
        "does not know its output position; give it an output encoder, or say held_at_centre = true and "
        "hold the tool at its centre when the arm is opened");
  const auto hex = [](std::int32_t value) { return fmt::format("{:08x}", static_cast<std::uint32_t>(value)); };
  identity = fmt::format("moteus {} model {:#x} firmware {:#x} serial {}-{}-{}", talk.axis.id, model, firmware,
                         hex(serial[0]), hex(serial[1]), hex(serial[2]));
  if (purpose == Purpose::kCompare) return Status::good();
  status = check_timeout_mode(talk);
  return status.ok() ? provoke_moteus_watchdog(talk) : status;
}

// --- ODrive

const char* const kNoHeartbeat = "sends no heartbeat; is it powered, are bit rate and node those of the description?";

// Enters closed loop and sends commands without torque, then none for kSilence, then commands again: only a watchdog of
// at most kSilence has acted. CANSimple cannot report the time that the watchdog is set to.
Status provoke_odrive_watchdog(Talk& talk) {
  DriveAnswer answer;
  talk.tell(odrive_torque_mode(talk.axis.id));
  talk.tell(DriveAction::kEnable);
  // The first heartbeat may have been sent before the command.
  for (int heartbeats = 0; heartbeats < 3 && answer.mode != DriveMode::kEnabled && answer.fault == 0; ++heartbeats)
    if (!talk.sample_fed(kHeartbeat, DriveAction::kBrake, answer)) return talk.error(kNoHeartbeat);
  if (answer.fault != 0)
    return talk.reports(answer.fault,
                        "it came while it was sent a command every millisecond; look it up in its manual");
  if (answer.mode != DriveMode::kEnabled)
    return talk.error("does not go into closed loop; calibrate it, and let it, with the maker's tool");
  talk.be_silent(kSilence);
  if (!talk.sample_fed(kHeartbeat, DriveAction::kBrake, answer)) return talk.error(kNoHeartbeat);
  if (answer.mode == DriveMode::kEnabled)
    return talk.error(
        "its watchdog is off, or longer than 15 ms; with the maker's tool: axis.config.watchdog_timeout = 0.01, "
        "axis.config.enable_watchdog = True, and save");
  if ((answer.fault & (kOdriveWatchdog05 | kOdriveWatchdog06)) != 0) return Status::good();
  return answer.fault == 0 ? talk.error("left closed loop without its watchdog's error; look it up in its manual")
                           : talk.reports(answer.fault, "its watchdog was to act; look it up in its manual");
}

Status go_through_odrive(Talk& talk, Purpose purpose, std::string& identity) {
  identity = fmt::format("ODrive node {}", talk.axis.id);
  if (purpose == Purpose::kCompare) return Status::good();
  DriveAnswer answer;
  talk.tell(DriveAction::kClear);
  // Waits for two heartbeats: the first may have been sent before the command.
  for (int heartbeats = 0; heartbeats < 2; ++heartbeats)
    if (!talk.sample(kHeartbeat, answer, true)) return talk.error(kNoHeartbeat);
  if (answer.fault != 0) return talk.reports(answer.fault, "clear it with the maker's tool");
  const Status provoked = provoke_odrive_watchdog(talk);
  talk.tell(DriveAction::kDisable);
  talk.tell(DriveAction::kClear);
  return provoked;
}

Status go_through(const DriveDescription& drives, unsigned axis, DriveBus& bus, Purpose purpose,
                  std::string& identity) {
  Talk talk(drives, axis, bus);
  switch (drives.family) {
    case DriveFamily::kDamiao:
      return go_through_damiao(talk, purpose, identity);
    case DriveFamily::kRobStride:
      return go_through_robstride(talk, purpose, identity);
    case DriveFamily::kMoteus:
      return go_through_moteus(talk, drives, purpose, identity);
    case DriveFamily::kOdrive:
      return go_through_odrive(talk, purpose, identity);
    default:
      return go_through_mit(talk, purpose, identity);
  }
}

// A drive that answers without a request is commanded by another host.
Status listen(const DriveDescription& drives, const DriveBuses& buses) {
  if (drives.family == DriveFamily::kOdrive) return Status::good();  // it sends cyclically
  for (unsigned i = 0; i < drives.axes.size(); ++i) {
    Talk talk(drives, i, *buses[drives.axes[i].bus]);
    DriveAnswer answer;
    if (talk.sample(i == 0 ? kListen : milliseconds(1), answer, false))
      return talk.error("answers although nobody asked; does another program drive it?");
  }
  return Status::good();
}

Result<std::vector<std::string>> go_through_all(const DriveDescription& drives, const DriveBuses& buses,
                                                Purpose purpose) {
  std::vector<std::string> identities;
  for (unsigned i = 0; i < drives.axes.size(); ++i) {
    std::string identity;
    if (Status status = go_through(drives, i, *buses[drives.axes[i].bus], purpose, identity); !status.ok())
      return status;
    identities.push_back(std::move(identity));
  }
  return identities;
}

}  // namespace

Result<std::vector<std::string>> prepare_drives(const DriveDescription& drives, const DriveBuses& buses) {
  if (Status status = listen(drives, buses); !status.ok()) return status;
  return go_through_all(drives, buses, Purpose::kPrepare);
}

Status compare_drives(const DriveDescription& drives, const DriveBuses& buses,
                      const std::vector<std::string>& identities) {
  const auto now = go_through_all(drives, buses, Purpose::kCompare);
  if (!now.ok()) return now.status();
  for (std::size_t i = 0; i < identities.size() && i < now.value().size(); ++i)
    if (now.value()[i] != identities[i])
      return Status::error(fmt::format(
          "axis {} (drive {}): it is {}, this run began with {}; connect that one again, or end the run and start it "
          "with this one",
          i, drives.axes[i].id, now.value()[i], identities[i]));
  return Status::good();
}

}  // namespace tactus::hal
