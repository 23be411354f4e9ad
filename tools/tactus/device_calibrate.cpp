// tactus device calibrate: signs, offsets and ranges of an arm of drives, found at zero force while a person moves it.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "hal/device_class.h"
#include "hal/device_file.h"
#include "hal/drives/drive_setup.h"
#include "hal/drives/drive_socket.h"
#include "hal/drives/simulated_drives.h"
#include "rt/text/read_file.h"
#include "tools/device/calibration.h"
#include "tools/device/free_arm.h"
#include "tools/json_report.h"
#include "tools/tactus/device.h"
#include "tools/tactus/help_texts.h"

namespace tactus::tools {
namespace {

using hal::AxisVector;

struct CalibrateCommand {
  std::string device{"drives"}, device_file, simulated, out;
  bool json{false};
};

// Who moves the tool: a person at a terminal, or the hand of the simulated arm.
class Mover {
 public:
  virtual ~Mover() = default;
  virtual Status hold(const Posed& pose) = 0;  // returns when the tool is there
  virtual Status begin_tour() = 0;             // through the whole workspace
  virtual Result<bool> touring() = 0;
};

class Person final : public Mover {
 public:
  Status hold(const Posed& pose) override {
    fmt::print(stderr, "Hold the tool still {}, then press Enter. ", device::words_of(pose));
    return enter();
  }
  Status begin_tour() override {
    fmt::print(stderr, "Move the tool along all stops of its workspace, then press Enter. ");
    return Status::good();
  }
  Result<bool> touring() override {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (::poll(&input, 1, 0) <= 0) return true;
    if (Status status = enter(); !status.ok()) return status;
    return false;
  }

 private:
  Status enter() {
    std::string line;
    return std::getline(std::cin, line) ? Status::good() : Status::error("the input ended before the calibration");
  }
};

// The hand that holds the simulated tool. Its path takes kStep_s for each pose: half to go there, half to rest.
class SimulatedHand final : public Mover {
 public:
  static constexpr double kStep_s = 2, kPeriod_s = 1e-3;

  static hal::HandModel hand_to(const std::vector<Posed>& poses) {
    std::vector<hal::HandWaypoint> path;
    for (std::size_t i = 0; i < poses.size(); ++i)
      for (const double into_s : {0.0, 0.5 * kStep_s})  // arrives, then rests
        path.push_back(
            {kStep_s * static_cast<double>(i) + into_s, poses[i].position, rotation_vector_of(poses[i].rotation)});
    return {hal::HandParameters{}, path};
  }

  SimulatedHand(hal::SimulatedDrives& world, std::size_t poses) : world_(world), poses_(poses) {}

  Status hold(const Posed&) override {
    // Late in the step: the tool is at rest.
    const double until_s = kStep_s * static_cast<double>(step_++) + 0.9 * 0.5 * kStep_s;
    while (time_s() < until_s) world_.advance();
    return Status::good();
  }
  Status begin_tour() override { return Status::good(); }
  Result<bool> touring() override { return time_s() < kStep_s * static_cast<double>(poses_); }

 private:
  double time_s() const { return kPeriod_s * static_cast<double>(world_.tick()); }

  hal::SimulatedDrives& world_;
  std::size_t poses_, step_{0};
};

int refuse(const std::string& text, int exit_code = kExitBadInput) {
  return complain("tactus device calibrate: " + text, exit_code);
}

struct Found {
  std::vector<device::AxisCalibration> axes;
  AxisVector low_rad{}, high_rad{};

  void widen(const AxisVector& angle_rad) noexcept {
    for (unsigned i = 0; i < axes.size(); ++i) {
      low_rad[i] = std::min(low_rad[i], angle_rad[i]);
      high_rad[i] = std::max(high_rad[i], angle_rad[i]);
    }
  }
};

Result<Found> go_through(const hal::DeviceProfile& profile, const hal::DriveBuses& buses, Mover& mover) {
  device::FreeArm arm(profile.description.drives, buses);
  const auto held = [&](const Posed& pose) -> Result<AxisVector> {
    if (Status status = mover.hold(pose); !status.ok()) return status;
    return arm.read();
  };
  const auto centre = held({});
  if (!centre.ok()) return centre.status();
  std::vector<device::HeldPose> moves;
  for (const Posed& pose : device::calibration_poses(profile)) {
    const auto angles = held(pose);
    if (!angles.ok()) return angles.status();
    moves.push_back({pose, angles.value()});
  }
  Found found{device::calibrate(profile, centre.value(), moves), centre.value(), centre.value()};
  for (const device::HeldPose& move : moves) found.widen(move.angle_rad);
  if (Status status = mover.begin_tour(); !status.ok()) return status;
  for (;;) {
    const auto touring = mover.touring();
    if (!touring.ok()) return touring.status();
    if (!touring.value()) return found;
    const auto angles = arm.poll();
    if (!angles.ok()) return angles.status();
    found.widen(angles.value());
    buses[0]->wait(device::FreeArm::kPause);
  }
}

// The verdict per axis; false: something has to be put right.
bool judge(Found& found, const hal::DriveDescription& drives) {
  bool good = true;
  for (unsigned i = 0; i < found.axes.size(); ++i) {
    device::AxisCalibration& axis = found.axes[i];
    const double share = device::range_share(drives.axes[i], found.low_rad[i], found.high_rad[i]);
    if (axis.doubt.empty() && share > device::kUsableShare)
      axis.doubt = fmt::format(
          "it turned to {:.0f} % of its position range and may wrap: set its zero elsewhere with the "
          "maker's tool, or widen the range",
          100 * share);
    good = good && axis.doubt.empty();
  }
  return good;
}

void show(const CalibrateCommand& c, const Found& found, const hal::DriveDescription& drives, bool good) {
  auto list = nlohmann::ordered_json::array();
  for (unsigned i = 0; i < found.axes.size(); ++i) {
    const device::AxisCalibration& axis = found.axes[i];
    if (!c.json)
      fmt::print(
          "axis {} (drive {}): sign {:g}, offset {:.4f} rad, from {:.3f} to {:.3f} rad, ratio about {:.2f}{}{}\n", i,
          drives.axes[i].id, axis.sign, axis.offset_rad, found.low_rad[i], found.high_rad[i], axis.ratio_seen,
          axis.doubt.empty() ? "" : ": ", axis.doubt);
    list.push_back(nlohmann::ordered_json{{"axis", i},
                                          {"sign", axis.sign},
                                          {"offset_rad", axis.offset_rad},
                                          {"low_rad", found.low_rad[i]},
                                          {"high_rad", found.high_rad[i]},
                                          {"ratio_seen", axis.ratio_seen},
                                          {"doubt", axis.doubt}});
  }
  if (c.json) fmt::print("{}\n", report_text(nlohmann::ordered_json{{"axes", list}, {"good", good}}, 2));
}

int finish(const CalibrateCommand& c, Found found, const hal::DeviceProfile& profile) {
  const hal::DriveDescription& drives = profile.description.drives;
  bool good = judge(found, drives);
  show(c, found, drives, good);
  if (!good) return complain_after("tactus device calibrate: nothing is written: see above", kExitVerdictBad);
  const auto text = text::read_file(c.device_file, hal::kMaxDeviceFileBytes);
  const std::string calibrated = device::with_calibration(text.value_or(""), found.axes);
  if (const auto parsed = hal::parse_device_description(calibrated, c.device_file); !parsed.ok())
    return complain_of_each(parsed.message(), kExitVerdictBad);
  return write_file(c.out, calibrated);
}

int calibrate_simulated(const CalibrateCommand& c, const hal::DeviceProfile& profile) {
  const auto real = c.simulated.empty() ? Result<hal::DeviceProfile>(profile) : hal::load_device_file(c.simulated);
  if (!real.ok()) return complain_of_each(real.message(), kExitBadInput);
  if (real.value().description.drives.axes.size() != profile.description.drives.axes.size())
    return refuse("--simulated: it has another number of drives");
  std::vector<Posed> poses{{}};
  for (const Posed& pose : device::calibration_poses(profile)) poses.push_back(pose);
  for (const Posed& pose : device::calibration_poses(profile))
    poses.push_back({pose.position * -1.8, conjugate(pose.rotation)});
  hal::SimulatedDrives world(real.value(), SimulatedHand::hand_to(poses), 1'000'000);
  const hal::DriveBuses buses = world.make_buses();
  const auto prepared = hal::prepare_drives(real.value().description.drives, buses);
  if (!prepared.ok()) return refuse(prepared.message(), kExitMachineCannot);
  world.restart_clock();
  SimulatedHand hand(world, poses.size());
  auto found = go_through(profile, buses, hand);
  if (!found.ok()) return refuse(found.message(), kExitMachineCannot);
  return finish(c, std::move(found).value(), profile);
}

int calibrate_real(const CalibrateCommand& c, const hal::DeviceProfile& profile, const std::string& address) {
  const hal::DriveDescription& drives = profile.description.drives;
  const auto interfaces = address.empty() ? drives.buses : hal::find_device_class("drives")->can_interfaces(address);
  if (interfaces.size() != drives.buses.size())
    return refuse(fmt::format("{} interfaces for the description's {} buses", interfaces.size(), drives.buses.size()));
  const auto buses = hal::open_drive_sockets(drives, interfaces);
  if (!buses.ok()) return refuse(buses.message(), kExitMachineCannot);
  const auto prepared = hal::prepare_drives(drives, buses.value());
  if (!prepared.ok()) return refuse(prepared.message(), kExitMachineCannot);
  if (!c.json) fmt::print("{}\n", fmt::join(prepared.value(), ", "));
  Person person;
  auto found = go_through(profile, buses.value(), person);
  if (!found.ok()) return refuse(found.message(), kExitMachineCannot);
  return finish(c, std::move(found).value(), profile);
}

int run_calibrate(const CalibrateCommand& c) {
  const auto profile = hal::load_device_file(c.device_file);
  if (!profile.ok()) return complain_of_each(profile.message(), kExitBadInput);
  if (profile.value().description.drives.empty())
    return refuse(
        c.device_file +
        " has no [drives]; accepted: an arm of drives. A device on tactus' wire is homed by its own firmware: "
        "tactus device ask --device usb execute home 2");
  const auto choice = hal::choose_device(c.device);
  if (!choice.ok()) return refuse(choice.message());
  const std::string_view name = choice.value().device_class->name;
  if (name == "drives-sim") return calibrate_simulated(c, profile.value());
  if (name != "drives")
    return refuse(fmt::format("--device: {} has no drives; accepted: drives, drives-sim", c.device));
  if (!c.simulated.empty()) return refuse("--simulated goes with --device drives-sim");
  return calibrate_real(c, profile.value(), choice.value().address);
}

}  // namespace

void add_device_calibrate_command(CLI::App& device, int& exit_code) {
  auto command = std::make_shared<CalibrateCommand>();
  CLI::App* app =
      device.add_subcommand("calibrate", "Measure the signs, offsets and ranges of an arm of drives, at zero force.");
  app->footer(
      "No drive is enabled while the tool is moved. A moteus and an ODrive are enabled without torque for some\n"
      "milliseconds when they are opened, to test their watchdog. The program asks you to hold the tool at the\n"
      "centre of the workspace, then to move it a step along x, y and z (with a wrist also to turn it), then along\n"
      "all stops. The pose at the centre gives the offsets, the steps give the signs; the measured ratio must agree\n"
      "with the description's within a third. With drives-sim a simulated hand moves the tool.\n"
      "Exit status: 0 good; 1 an axis is in doubt, and nothing is written; 2 bad usage; 3 a drive does not answer.\n\n"
      "Examples:\n"
      "  tactus device calibrate --device drives --device-file my_arm.toml --out my_arm.toml\n"
      "  tactus device calibrate --device drives-sim --device-file hal/devices/point_arm_drives.toml --out new.toml");
  app->add_option("--device", command->device, "device: drives, drives:IFACE, drives:IFACE,IFACE, or drives-sim")
      ->capture_default_str();
  app->add_option("--device-file", command->device_file, help::kDeviceFile)->required();
  app->add_option("--simulated", command->simulated,
                  "file that describes the simulated arm of drives-sim; default: --device-file");
  app->add_option("--out", command->out, "write the description with the measured signs and offsets to this file");
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, &exit_code] { exit_code = run_calibrate(*command); });
}

}  // namespace tactus::tools
