#include "hal/device_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "firmware/can_codec.h"
#include "hal/drive_table.h"
#include "rt/text/read_file.h"
#include "rt/text/table_reader.h"

namespace tactus::hal {
namespace {

using text::Range;

constexpr Range kLink{"the length of a link", 0.01, 5}, kRadius{"a radius", 0.005, 5};
constexpr Range kSpeed{"a speed", 0.01, 20}, kAngularSpeed{"an angular speed", 0.1, 200};
constexpr Range kPeakForce{"a peak force", 0.1, 500}, kPeakTorque{"a peak torque", 0.01, 100};
constexpr Range kContinuous{"a continuous limit", 0, 500};
constexpr Range kMass{"an apparent mass", 1e-3, 100}, kInertia{"an apparent inertia", 1e-7, 10};
constexpr Range kDamping{"a damping", 0, 1000}, kFriction{"a friction", 0, 100};
constexpr Range kCounts{"a number of encoder counts", 1, 1e9};

// A required number of the description.
struct Figure {
  const char* key;
  double* value;
  const Range& range;
};

class DeviceReader {
 public:
  DeviceReader(const text::TomlNode& root, DeviceDescription& device, text::Diagnostics& diagnostics)
      : root_(&root, "", diagnostics), device_(device), diagnostics_(diagnostics) {}

  void read() {
    root_.require("name", "a short name in quotes");
    device_.name = root_.text("name", "", 40);
    read_kinematics();
    read_figures();
    read_plant();
    if (root_.has("drives"))
      read_drives(root_.table("drives"), device_, diagnostics_);
    else
      read_encoders();
    read_link();
    root_.finish();
    if (diagnostics_.ok()) check_together();
  }

 private:
  text::TableReader table(const char* key) { return {root_.table(key), fmt::format("[{}]", key), diagnostics_}; }

  // Every table is required: a device with unknown limits cannot be driven safely.
  text::TableReader needed_table(const char* key) {
    root_.require(key, fmt::format("a table [{}]", key).c_str());
    return table(key);
  }

  void read_figure(text::TableReader& t, const Figure& figure) {
    if (t.require(figure.key, fmt::format("a number >= {:g} and <= {:g}", figure.range.low, figure.range.high).c_str()))
      *figure.value = t.number(figure.key, *figure.value, figure.range);
  }

  // Figures of rotation; not read for a device without rotation.
  void read_rotary(text::TableReader& t, const Figure& figure) {
    if (device_.has_rotation())
      read_figure(t, figure);
    else
      t.refuse(figure.key, "a point_arm neither senses nor turns the tool's rotation", "leave it out");
  }

  void read_kinematics() {
    text::TableReader t = needed_table("kinematics");
    t.require("kind", "wristed_arm, point_arm, stage");
    const std::string kind = t.word("kind", "wristed_arm", {"wristed_arm", "point_arm", "stage"});
    device_.kind = kind == "stage"       ? KinematicsKind::kStage
                   : kind == "point_arm" ? KinematicsKind::kPointArm
                                         : KinematicsKind::kWristedArm;
    if (device_.kind == KinematicsKind::kStage) {
      t.refuse("upper_arm_m", "a stage has no links", "leave it out");
      t.refuse("forearm_m", "a stage has no links", "leave it out");
    } else {
      read_figure(t, {"upper_arm_m", &device_.links.upper_m, kLink});
      read_figure(t, {"forearm_m", &device_.links.forearm_m, kLink});
    }
    t.finish();
  }

  void read_figures() {
    DeviceDescription& d = device_;
    text::TableReader workspace = needed_table("workspace");
    read_figure(workspace, {"radius_m", &d.workspace_radius_m, kRadius});
    read_figure(workspace, {"max_speed_m_per_s", &d.max_speed_m_per_s, kSpeed});
    read_rotary(workspace, {"max_angular_speed_rad_per_s", &d.max_angular_speed_rad_per_s, kAngularSpeed});
    workspace.finish();

    text::TableReader limits = needed_table("limits");
    read_figure(limits, {"peak_force_N", &d.peak_force_N, kPeakForce});
    read_figure(limits, {"continuous_force_N", &d.continuous_force_N, kContinuous});
    read_rotary(limits, {"peak_torque_Nm", &d.peak_torque_Nm, kPeakTorque});
    read_rotary(limits, {"continuous_torque_Nm", &d.continuous_torque_Nm, kContinuous});
    limits.finish();

    text::TableReader mechanics = needed_table("mechanics");
    read_figure(mechanics, {"mass_kg", &d.mass_kg, kMass});
    read_figure(mechanics, {"damping_Ns_per_m", &d.damping_Ns_per_m, kDamping});
    read_figure(mechanics, {"coulomb_friction_N", &d.coulomb_friction_N, kFriction});
    read_figure(mechanics, {"brake_damping_Ns_per_m", &d.brake_damping_Ns_per_m, kDamping});
    read_rotary(mechanics, {"inertia_kg_m2", &d.inertia_kg_m2, kInertia});
    read_rotary(mechanics, {"damping_Nms_per_rad", &d.damping_Nms_per_rad, kDamping});
    read_rotary(mechanics, {"coulomb_friction_Nm", &d.coulomb_friction_Nm, kFriction});
    read_rotary(mechanics, {"brake_damping_Nms_per_rad", &d.brake_damping_Nms_per_rad, kDamping});
    mechanics.finish();
  }

  // Every figure is optional: see PlantFigures.
  void read_plant() {
    text::TableReader t = table("plant");
    const auto read = [&](const char* key, std::optional<double>& value, const Range& range) {
      if (const double number = t.number(key, 0, range); t.has(key)) value = number;
    };
    const auto read_rotary = [&](const char* key, std::optional<double>& value, const Range& range) {
      if (device_.has_rotation())
        read(key, value, range);
      else
        t.refuse(key, "a point_arm neither senses nor turns the tool's rotation", "leave it out");
    };
    PlantFigures& p = device_.plant;
    read("mass_kg", p.mass_kg, kMass);
    read("damping_Ns_per_m", p.damping_Ns_per_m, kDamping);
    read("coulomb_friction_N", p.coulomb_friction_N, kFriction);
    read("stop_radius_m", p.stop_radius_m, kRadius);
    read_rotary("inertia_kg_m2", p.inertia_kg_m2, kInertia);
    read_rotary("damping_Nms_per_rad", p.damping_Nms_per_rad, kDamping);
    read_rotary("coulomb_friction_Nm", p.coulomb_friction_Nm, kFriction);
    t.finish();
  }

  void read_encoders() {
    const AxisKinds axes = axes_of(device_.kind);
    text::TableReader t = needed_table("encoders");
    if (axes.prismatic > 0)
      read_counts(t, "counts_per_m", 0, axes.prismatic, device_.counts_per_m);
    else
      t.refuse("counts_per_m", "an arm has no prismatic axes", "counts_per_turn");
    read_counts(t, "counts_per_turn", axes.prismatic, axes.rotary, device_.counts_per_turn);
    t.finish();
  }

  void read_counts(text::TableReader& t, const char* key, unsigned first, unsigned axes, AxisVector& counts) {
    const std::string accepted =
        fmt::format("{} numbers >= {:g} and <= {:g}, one for each axis in order", axes, kCounts.low, kCounts.high);
    if (!t.require(key, accepted.c_str())) return;
    const auto items = t.array(key, kAxisCount);
    if (!items.empty() && items.size() != axes)
      t.mistake(key, fmt::format("{} entries for {} axes", items.size(), axes), accepted);
    if (items.size() != axes) return;
    for (unsigned i = 0; i < axes; ++i) {
      const text::TomlNode& item = items[i];
      const bool number = item.kind == text::TomlKind::kInteger || item.kind == text::TomlKind::kNumber;
      if (number && item.number >= kCounts.low && item.number <= kCounts.high)
        counts[first + i] = item.number;
      else
        diagnostics_.add({.line = item.line,
                          .column = item.column,
                          .where = fmt::format("[encoders] {}", key),
                          .what = fmt::format("{} is not {}", item.shown(), kCounts.noun),
                          .accepted = accepted});
    }
  }

  void read_link() {
    text::TableReader t = needed_table("link");
    const Range delay{"a delay in ticks", 1, kMaxDeviceDelayTicks}, node{"a CAN node", 1, firmware::kMaxCanNode};
    t.require("transport_delay_ticks", fmt::format("a whole number from 1 to {}", kMaxDeviceDelayTicks).c_str());
    device_.transport_delay_ticks = t.count("transport_delay_ticks", device_.transport_delay_ticks, delay);
    device_.usb_serial = t.text("usb_serial", "", 64);
    device_.can_node = t.count("can_node", device_.can_node, node);
    t.finish();
  }

  void check_together() {
    const DescriptionMistake found = find_mistake(device_);
    if (found.table != nullptr) return table(found.table).mistake(found.key, found.what, found.accepted);
    if (!device_.drives.empty()) check_drives(root_.table("drives"), device_, diagnostics_);
  }

  text::TableReader root_;
  DeviceDescription& device_;
  text::Diagnostics& diagnostics_;
};

Status refused(const text::Diagnostics& diagnostics) { return Status::error(diagnostics.message()); }

}  // namespace

Result<DeviceDescription> parse_device_description(std::string_view text, std::string_view name) {
  text::Diagnostics diagnostics;
  diagnostics.name = std::string(name);
  DeviceDescription device;
  text::TomlNode root;
  if (text.size() > kMaxDeviceFileBytes)
    diagnostics.add({.where = "the file",
                     .what = fmt::format("longer than {} bytes", kMaxDeviceFileBytes),
                     .accepted = "a device description"});
  else if (text::read_toml(text, root, diagnostics))
    DeviceReader(root, device, diagnostics).read();
  if (!diagnostics.ok()) return refused(diagnostics);
  return device;
}

Result<DeviceProfile> load_device_file(const std::filesystem::path& path) {
  const auto text = text::read_file(path, kMaxDeviceFileBytes);
  if (!text)
    return Status::error(path.string() +
                         ": the file: cannot be read; accepted: the path of a device description, such as "
                         "hal/devices/virtuose6d.toml");
  const auto description = parse_device_description(*text, path.string());
  if (!description.ok()) return description.status();
  return make_profile(description.value());
}

}  // namespace tactus::hal
