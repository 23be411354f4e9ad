#include "tools/device/new_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hal/drives/bus_load.h"
#include "hal/drives/drive_check.h"
#include "hal/profiles.h"
#include "rt/text/split.h"

namespace tactus::device {
namespace {

struct Family {
  const char* name;
  double torque_range_Nm, position_range_rad, speed_range_rad_per_s, counts_per_turn;  // 0: it has no such field
  bool answers_on_own_id;                                                              // answer_id in the file
  double arm_ratio;        // of the capstans: a drive without a gear needs more than one with it
  unsigned drives_of_bus;  // as many as a bus carries at 1 kHz
  unsigned rate_of_six_Hz;
};

// Of one product each: DM4310, AK80-9, mini-cheetah, RS00, moteus with its own encoder, ODrive with 8192 counts.
// Sources differ for CubeMars and RobStride: the file says that the maker's figures go here.
constexpr std::array<Family, 6> kFamilies{{{"damiao", 10, 12.5, 30, 0, true, 1, 3, 1000},
                                           {"cubemars", 18, 12.5, 50, 0, true, 1, 3, 1000},
                                           {"mini_cheetah", 18, 12.5, 65, 0, true, 1, 3, 1000},
                                           {"robstride", 17, 12.566, 50, 0, false, 1, 2, 900},
                                           {"moteus", 3, 0, 0, 16384, false, 4, 4, 1000},
                                           {"odrive", 3, 0, 0, 8192, false, 4, 3, 1000}}};
constexpr double kBelt_rad_per_m = 30;  // of a stage: pulleys of 33 mm
// Damping closed in the drives, at the axis: enough for walls, and too little to be felt as viscous.
constexpr double kArmDamping_Nms_per_rad = 0.1, kStageDamping_Ns_per_m = 3, kWristDamping_Nms_per_rad = 0.0025;
constexpr double kMoteusDampingRange_Nms_per_rad = 0.5;
constexpr const char* kFirmware = "firmware";
constexpr double kFirmwareCounts = 65536, kStageCounts_per_m = 100000;

const Family* family_of(const std::string& name) noexcept {
  const auto found = std::find_if(kFamilies.begin(), kFamilies.end(), [&](const Family& f) { return name == f.name; });
  return found == kFamilies.end() ? nullptr : &*found;
}

bool has_links(const NewDescription& d) { return d.kind != "stage"; }
bool has_rotation(const NewDescription& d) { return d.kind != "point_arm"; }
bool has_fields(const NewDescription& d) {
  const Family* family = family_of(d.family);
  return family != nullptr && family->position_range_rad > 0;
}
bool has_counts(const NewDescription& d) { return !has_fields(d); }
bool damps(const NewDescription& d) { return has_drives(d) && d.family != "odrive"; }
bool wrist_damps(const NewDescription& d) { return damps(d) && has_rotation(d); }
bool has_drives_in_wrist(const NewDescription& d) { return has_drives(d) && has_rotation(d); }
bool always(const NewDescription&) { return true; }

// In the order of the fields.
constexpr Question kQuestions[] = {
    {"--upper-arm", "length of the upper arm, from axis to axis", "m", &NewDescription::upper_arm_m, has_links},
    {"--forearm", "length of the forearm, from its axis to the tool", "m", &NewDescription::forearm_m, has_links},
    {"--radius", "radius of the workspace about the centre, where the stops are", "m", &NewDescription::radius_m,
     always},
    {"--peak-force", "largest force at the tool, everywhere in the workspace", "N", &NewDescription::peak_force_N,
     always},
    {"--peak-torque", "largest torque at the tool", "N m", &NewDescription::peak_torque_Nm, has_rotation},
    {"--mass", "apparent mass at the tool, motors included: the smallest over all directions", "kg",
     &NewDescription::mass_kg, always},
    {"--inertia", "apparent inertia of the tool about its centre", "kg m2", &NewDescription::inertia_kg_m2,
     has_rotation},
    {"--damping", "smallest viscous damping at the tool; 0.5 is a common estimate", "N s/m",
     &NewDescription::damping_Ns_per_m, always},
    {"--friction", "dry friction at the tool", "N", &NewDescription::coulomb_friction_N, always},
    {"--ratio", "turns of the shaft that a drive reports, per turn of its axis; of a stage: rad per m", "",
     &NewDescription::ratio, has_drives},
    {"--wrist-ratio", "turns of the shaft that a drive reports, per turn of its axis: of the last three axes", "",
     &NewDescription::wrist_ratio, has_drives_in_wrist},
    {"--drive-damping", "damping that a drive itself applies; the gain check counts it; 0: none", "N m s/rad",
     &NewDescription::drive_damping, damps},
    {"--wrist-drive-damping", "damping that each of the last three drives itself applies", "N m s/rad",
     &NewDescription::wrist_drive_damping, wrist_damps},
    {"--torque-range", "full scale of the torque in a drive's frame, and the largest torque command", "N m",
     &NewDescription::torque_range_Nm, has_drives},
    {"--position-range", "full scale of the angle in a drive's frame, to each side", "rad",
     &NewDescription::position_range_rad, has_fields},
    {"--speed-range", "full scale of the speed in a drive's frame, to each side", "rad/s",
     &NewDescription::speed_range_rad_per_s, has_fields},
    {"--counts", "encoder counts per turn", "", &NewDescription::counts_per_turn, has_counts},
};

unsigned axes_of(const NewDescription& d) { return d.kind == "point_arm" ? 3 : 6; }

std::string axis_text(const NewDescription& d, const Family& family, unsigned axis, std::size_t buses) {
  const unsigned each = (axes_of(d) + static_cast<unsigned>(buses) - 1) / static_cast<unsigned>(buses);
  const bool wrist = axis >= 3;
  std::string text = fmt::format("\n[[drives.axis]]\nbus = {}\nid = {}\n", axis / each, axis + 1);
  if (family.answers_on_own_id) text += fmt::format("answer_id = {}\n", axis + 17);
  text += fmt::format("sign = 1  # tactus device calibrate finds sign and offset\noffset_rad = 0\nratio = {:g}\n",
                      wrist ? d.wrist_ratio : d.ratio);
  text += fmt::format("torque_range_Nm = {:g}\n", d.torque_range_Nm);
  if (family.position_range_rad > 0)
    text += fmt::format("position_range_rad = {:g}\nspeed_range_rad_per_s = {:g}\n", d.position_range_rad,
                        d.speed_range_rad_per_s);
  else
    text += fmt::format("counts_per_turn = {:g}\n", d.counts_per_turn);
  if (!damps(d)) return text;
  const double damping = wrist ? d.wrist_drive_damping : d.drive_damping;
  if (d.family == "moteus")
    text += fmt::format("damping_range_Nms_per_rad = {:g}  # the configured kd, in N m s/rad\n",
                        kMoteusDampingRange_Nms_per_rad);
  return text + fmt::format(
                    "damping_Nms_per_rad = {0:g}  # in the drive; the gain check counts it\n"
                    "brake_damping_Nms_per_rad = {0:g}\n",
                    damping);
}

std::string drives_text(const NewDescription& d) {
  const std::vector<std::string> buses = text::split(d.buses, ',');
  std::string text = fmt::format("[drives]\nfamily = \"{}\"\nbuses = [\"{}\"]\nwatchdog_ms = {:g}\n", d.family,
                                 fmt::join(buses, "\", \""), d.watchdog_ms);
  if (d.family == "moteus") text += "data_bit_per_s = 5000000\n";
  for (unsigned i = 0; i < axes_of(d); ++i) text += axis_text(d, *family_of(d.family), i, buses.size());
  return text;
}

std::string encoders_text(const NewDescription& d) {
  if (d.kind == "stage")
    return fmt::format("[encoders]\ncounts_per_m = [{0:g}, {0:g}, {0:g}]\ncounts_per_turn = [{1:g}, {1:g}, {1:g}]\n",
                       kStageCounts_per_m, d.counts_per_turn);
  const std::vector<std::string> counts(axes_of(d), fmt::format("{:g}", d.counts_per_turn));
  return fmt::format("[encoders]\ncounts_per_turn = [{}]\n", fmt::join(counts, ", "));
}

}  // namespace

std::span<const Question> questions() noexcept { return kQuestions; }

bool has_drives(const NewDescription& d) { return d.family != kFirmware; }

Status check_kind(const NewDescription& d) {
  if (d.kind == "point_arm" || d.kind == "wristed_arm" || d.kind == "stage") return Status::good();
  return Status::error(fmt::format("--kind: '{}' is none; accepted: point_arm, wristed_arm, stage", d.kind));
}

Status check_family(const NewDescription& d) {
  if (!has_drives(d) || family_of(d.family) != nullptr) return Status::good();
  return Status::error(
      fmt::format("--family: '{}' is none; accepted: damiao, cubemars, mini_cheetah, robstride, moteus, odrive, or "
                  "firmware for a device on tactus' wire",
                  d.family));
}

Status check_buses(const NewDescription& d) {
  if (d.buses.empty() || !has_drives(d)) return Status::good();
  const auto refuse = [&](const std::string& why) {
    return Status::error(
        fmt::format("--buses: '{}' {}; accepted: one CAN interface or two, such as can0,can1", d.buses, why));
  };
  if (d.buses.find_first_of("\"\\\n") != std::string::npos) return refuse("has quotes");
  const std::vector<std::string> buses = text::split(d.buses, ',');
  if (buses.size() > hal::kMaxBuses) return refuse(fmt::format("names {} of them", buses.size()));
  const Status status = hal::check_bus_names(buses);
  return status.ok() ? status : refuse(status.message());
}

Status check_choices(const NewDescription& d) {
  for (const Status& status : {check_kind(d), check_family(d), check_buses(d)})
    if (!status.ok()) return status;
  if (d.name.empty() || d.name.find_first_of("\"\\\n") != std::string::npos)
    return Status::error("--name: accepted: a short name without quotes");
  return Status::good();
}

void complete(NewDescription& d) {
  const Family* family = family_of(d.family);
  const auto fill = [](auto& value, auto usual) { value = value == 0 ? usual : value; };
  const bool six = axes_of(d) > 3, belts = d.kind == "stage";
  fill(d.rate_Hz, family != nullptr && six ? family->rate_of_six_Hz : 1000u);
  if (family == nullptr) return fill(d.counts_per_turn, kFirmwareCounts);
  if (d.buses.empty()) d.buses = axes_of(d) > family->drives_of_bus ? "can0,can1" : "can0";
  fill(d.torque_range_Nm, family->torque_range_Nm);
  fill(d.position_range_rad, family->position_range_rad);
  fill(d.speed_range_rad_per_s, family->speed_range_rad_per_s);
  fill(d.counts_per_turn, family->counts_per_turn);
  fill(d.ratio, belts ? kBelt_rad_per_m : family->arm_ratio);
  const auto damp = [](double& value, double at_axis, double ratio) {
    value = value < 0 ? at_axis / (ratio * ratio) : value;
  };
  damp(d.drive_damping, belts ? kStageDamping_Ns_per_m : kArmDamping_Nms_per_rad, d.ratio);
  damp(d.wrist_drive_damping, kWristDamping_Nms_per_rad, d.wrist_ratio);
}

std::string description_text(const NewDescription& d) {
  const bool rotation = has_rotation(d);
  std::string text =
      "# Written by `tactus device new`. Lines with 'estimate' need a measurement: see hal/devices/README.md.\n";
  text += fmt::format("name = \"{}\"\n\n[kinematics]\nkind = \"{}\"\n", d.name, d.kind);
  if (has_links(d)) text += fmt::format("upper_arm_m = {:g}\nforearm_m = {:g}\n", d.upper_arm_m, d.forearm_m);
  text += fmt::format("\n[workspace]\nradius_m = {:g}\nmax_speed_m_per_s = 1  # estimate\n", d.radius_m);
  if (rotation) text += "max_angular_speed_rad_per_s = 10  # estimate\n";
  text += fmt::format("\n[limits]\npeak_force_N = {0:g}\ncontinuous_force_N = {1:g}  # estimate\n", d.peak_force_N,
                      0.35 * d.peak_force_N);
  if (rotation)
    text += fmt::format("peak_torque_Nm = {:g}\ncontinuous_torque_Nm = {:g}  # estimate\n", d.peak_torque_Nm,
                        0.35 * d.peak_torque_Nm);
  text += fmt::format(
      "\n[mechanics]\nmass_kg = {:g}\ndamping_Ns_per_m = {:g}\ncoulomb_friction_N = {:g}\n"
      "brake_damping_Ns_per_m = 1  # estimate; used by --device sim alone\n",
      d.mass_kg, d.damping_Ns_per_m, d.coulomb_friction_N);
  if (rotation)
    text += fmt::format(
        "inertia_kg_m2 = {:g}\ndamping_Nms_per_rad = 0.002  # estimate\ncoulomb_friction_Nm = 0.005  # estimate\n"
        "brake_damping_Nms_per_rad = 0.05  # estimate; used by --device sim alone\n",
        d.inertia_kg_m2);
  text += "\n" + (has_drives(d) ? drives_text(d) : encoders_text(d));
  return text + "\n[link]\ntransport_delay_ticks = 1  # tactus hil measures it\n";
}

std::vector<std::string> consequences(const hal::DeviceDescription& description, unsigned rate_Hz) {
  const hal::DeviceProfile profile = hal::make_profile(description);
  const hal::AxisKinds kinds = hal::axes_of(description.kind);
  std::vector<std::string> lines;
  for (unsigned i = 0; i < kinds.prismatic + kinds.rotary; ++i) {
    const bool prismatic = i < kinds.prismatic;
    lines.push_back(fmt::format("axis {}: at most {:.3g} {}, {:.3g} {}; quantum {:.2g} {}", i, profile.bounds.effort[i],
                                prismatic ? "N" : "N m", profile.bounds.rate[i], prismatic ? "m/s" : "rad/s",
                                profile.quantum[i], prismatic ? "m" : "rad"));
  }
  lines.push_back(fmt::format("tool: position quantum {:.2g} m at worst", profile.properties.position_quantum_m));
  const std::int64_t period_ns = 1'000'000'000 / rate_Hz;
  for (unsigned bus = 0; bus < description.drives.buses.size(); ++bus) {
    const auto time_ns = static_cast<double>(hal::bus_time_ns(description.drives, bus));
    lines.push_back(fmt::format("bus {}: {:.0f} % loaded at {} Hz", description.drives.buses[bus],
                                100 * time_ns / static_cast<double>(period_ns), rate_Hz));
  }
  return lines;
}

}  // namespace tactus::device
