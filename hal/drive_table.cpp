#include "hal/drive_table.h"

#include <fmt/format.h>

#include "hal/drives/drive_check.h"
#include "hal/drives/drive_codec.h"

namespace tactus::hal {
namespace {

using text::Range;

constexpr Range kTorque{"a torque", 1e-3, 1000}, kAngle{"an angle", 0.1, 1000}, kMotorSpeed{"a speed", 0.1, 1000};
constexpr Range kRatio{"a ratio", 1e-3, 1000}, kOffset{"an offset", -1000, 1000}, kSign{"a sign", -1, 1};
constexpr Range kMotorDamping{"a damping", 0, 1000}, kDampingRange{"a damping", 1e-6, 1000};
constexpr Range kEncoderCounts{"a number of encoder counts", 1, 1e9};
constexpr DriveFamily kFamilies[] = {DriveFamily::kDamiao,    DriveFamily::kCubeMars, DriveFamily::kMiniCheetah,
                                     DriveFamily::kRobStride, DriveFamily::kMoteus,   DriveFamily::kOdrive};

std::string where_of(std::size_t axis) { return fmt::format("[drives.axis.{}]", axis); }

class DriveReader {
 public:
  DriveReader(const text::TomlNode* drives, DeviceDescription& device, text::Diagnostics& diagnostics)
      : table_(drives, "[drives]", diagnostics), device_(device), drives_(device.drives), diagnostics_(diagnostics) {}

  void read() {
    read_family();
    read_buses();
    const auto items = table_.array("axis", kAxisCount);
    table_.require("axis", "one table [[drives.axis]] for each axis in order");
    for (std::size_t i = 0; i < items.size(); ++i) read_axis(items[i], i);
    table_.finish();
    const AxisKinds kinds = axes_of(device_.kind);
    for (unsigned i = 0; i < drives_.axes.size() && diagnostics_.ok(); ++i) {
      AxisVector& counts = i < kinds.prismatic ? device_.counts_per_m : device_.counts_per_turn;
      const double per_turn = drive_counts_per_turn(drives_.family, drives_.axes[i]);
      counts[i] = i < kinds.prismatic ? per_turn / kTurn_rad : per_turn;
    }
  }

 private:
  void read_family() {
    const char* const all = "damiao, cubemars, mini_cheetah, robstride, moteus, odrive";
    table_.require("family", all);
    const std::string family =
        table_.word("family", "damiao", {"damiao", "cubemars", "mini_cheetah", "robstride", "moteus", "odrive"});
    for (const DriveFamily one : kFamilies)
      if (codec_of(one).name == family) drives_.family = one;
    const bool set_by_hand = drives_.family == DriveFamily::kCubeMars || drives_.family == DriveFamily::kMiniCheetah;
    if (set_by_hand)
      table_.require("watchdog_ms", "at most 10, as it was set in the drives by the maker's tool: it cannot be read");
    drives_.watchdog_s = 1e-3 * table_.number("watchdog_ms", 10, {"a watchdog", 1, 1000});
    drives_.full_effort_s = 1e-3 * table_.number("full_effort_ms", 4, {"a time", 0.1, 100});
    if (drives_.family == DriveFamily::kMoteus)
      drives_.held_at_centre = table_.flag("held_at_centre", false);
    else
      table_.refuse("held_at_centre", "a key of moteus", "leave it out");
  }

  void read_buses() {
    table_.require("buses", "the CAN interfaces, such as [\"can0\"]");
    for (const text::TomlNode& item : table_.array("buses", kMaxBuses)) {
      if (item.kind == text::TomlKind::kText)
        drives_.buses.push_back(item.text);
      else
        diagnostics_.add({.line = item.line,
                          .column = item.column,
                          .where = "[drives] buses",
                          .what = item.shown() + " is not text",
                          .accepted = "such as \"can0\""});
    }
    drives_.bit_per_s = table_.count("bit_per_s", 1'000'000, {"a bit rate", 10'000, 1'000'000});
    const bool fd = codec_of(drives_.family).needs_fd;
    if (fd)
      drives_.data_bit_per_s = table_.count("data_bit_per_s", 5'000'000, {"a bit rate", 1'000'000, 8'000'000});
    else
      table_.refuse("data_bit_per_s", fmt::format("{} is driven over classic CAN", codec_of(drives_.family).name),
                    "leave it out");
  }

  void read_figure(text::TableReader& t, const char* key, double& value, const Range& range) {
    if (t.require(key, fmt::format("a number >= {:g} and <= {:g}", range.low, range.high).c_str()))
      value = t.number(key, value, range);
  }

  void read_axis(const text::TomlNode& item, std::size_t number) {
    text::TableReader t(&item, where_of(number), diagnostics_);
    DriveAxis axis;
    axis.bus = t.count("bus", 0, {"a bus", 0, kMaxBuses - 1});
    t.require("id", "the drive's id on its bus");
    axis.id = t.count("id", 1, {"an id", 0, 0x7ff});
    axis.sign = t.number("sign", 1, kSign);
    axis.ratio = t.number("ratio", 1, kRatio);
    axis.offset_rad = t.number("offset_rad", 0, kOffset);
    read_figure(t, "torque_range_Nm", axis.torque_range_Nm, kTorque);
    read_ranges(t, axis);
    axis.damping_Nms_per_rad = t.number("damping_Nms_per_rad", 0, kMotorDamping);
    axis.brake_damping_Nms_per_rad = t.number("brake_damping_Nms_per_rad", 0, kMotorDamping);
    t.finish();
    drives_.axes.push_back(axis);
  }

  void read_ranges(text::TableReader& t, DriveAxis& axis) {
    const bool mit = drives_.family == DriveFamily::kDamiao || drives_.family == DriveFamily::kCubeMars ||
                     drives_.family == DriveFamily::kMiniCheetah;
    const bool has_fields = mit || drives_.family == DriveFamily::kRobStride;
    const std::string leave = fmt::format("{} has no such field", codec_of(drives_.family).name);
    if (mit) {
      t.require("answer_id", "the identifier on which the drive answers");
      axis.answer_id = t.count("answer_id", 0x7fe, {"an identifier", 1, 0x7fe});
    } else {
      t.refuse("answer_id", leave, "leave it out");
    }
    if (has_fields) {
      read_figure(t, "position_range_rad", axis.position_range_rad, kAngle);
      read_figure(t, "speed_range_rad_per_s", axis.speed_range_rad_per_s, kMotorSpeed);
      t.refuse("counts_per_turn", "the quantum is that of the frame's field", "leave it out");
    } else {
      t.refuse("position_range_rad", leave, "leave it out");
      t.refuse("speed_range_rad_per_s", leave, "leave it out");
      read_figure(t, "counts_per_turn", axis.counts_per_turn, kEncoderCounts);
    }
    axis.damping_range_Nms_per_rad = t.number(
        "damping_range_Nms_per_rad", codec_of(drives_.family).default_damping_range_Nms_per_rad, kDampingRange);
  }

  text::TableReader table_;
  DeviceDescription& device_;
  DriveDescription& drives_;
  text::Diagnostics& diagnostics_;
};

}  // namespace

void read_drives(const text::TomlNode* drives, DeviceDescription& device, text::Diagnostics& diagnostics) {
  DriveReader(drives, device, diagnostics).read();
}

void check_drives(const text::TomlNode* drives, const DeviceDescription& device, text::Diagnostics& diagnostics) {
  const DriveMistake found = find_drive_mistake(make_profile(device));
  if (found.key == nullptr) return;
  text::TableReader table(drives, "[drives]", diagnostics);
  if (found.axis < 0) return table.mistake(found.key, found.what, found.accepted);
  const auto number = static_cast<std::size_t>(found.axis);
  const auto items = table.array("axis", kAxisCount);
  text::TableReader(&items[number], where_of(number), diagnostics).mistake(found.key, found.what, found.accepted);
}

}  // namespace tactus::hal
