#include "tools/device/new_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hal/drives/bus_load.h"
#include "hal/profiles.h"
#include "rt/text/split.h"

namespace tactus::device {
namespace {

struct Family {
  const char* name;
  double torque_range_Nm, position_range_rad, speed_range_rad_per_s, counts_per_turn;  // 0: it has no such field
  bool answers_on_own_id;                                                              // answer_id in the file
};

// Of one product each: DM4310, AK80-9, mini-cheetah, RS00, moteus with its own encoder, ODrive with 8192 counts.
// Sources differ for CubeMars and RobStride: the file says that the maker's figures go here.
constexpr std::array<Family, 6> kFamilies{{{"damiao", 10, 12.5, 30, 0, true},
                                           {"cubemars", 18, 12.5, 50, 0, true},
                                           {"mini_cheetah", 18, 12.5, 65, 0, true},
                                           {"robstride", 17, 12.566, 50, 0, false},
                                           {"moteus", 3, 0, 0, 16384, false},
                                           {"odrive", 3, 0, 0, 8192, false}}};
constexpr const char* kFirmware = "firmware";
constexpr double kFirmwareCounts = 65536, kStageCounts_per_m = 100000;

const Family* family_of(const std::string& name) noexcept {
  const auto found = std::find_if(kFamilies.begin(), kFamilies.end(), [&](const Family& f) { return name == f.name; });
  return found == kFamilies.end() ? nullptr : &*found;
}

bool has_drives(const NewDescription& d) { return d.family != kFirmware; }
bool has_links(const NewDescription& d) { return d.kind != "stage"; }
bool has_rotation(const NewDescription& d) { return d.kind != "point_arm"; }
bool has_fields(const NewDescription& d) {
  const Family* family = family_of(d.family);
  return family != nullptr && family->position_range_rad > 0;
}
bool has_counts(const NewDescription& d) { return !has_fields(d); }
bool always(const NewDescription&) { return true; }

constexpr Question kQuestions[] = {
    {"--upper-arm", "length of the upper arm, from axis to axis", "m", &NewDescription::upper_arm_m, has_links},
    {"--forearm", "length of the forearm, from its axis to the tool", "m", &NewDescription::forearm_m, has_links},
    {"--radius", "radius of the workspace about the centre, where the stops are", "m", &NewDescription::radius_m,
     always},
    {"--peak-force", "largest force at the tool, everywhere in the workspace", "N", &NewDescription::peak_force_N,
     always},
    {"--peak-torque", "largest torque at the tool", "N m", &NewDescription::peak_torque_Nm, has_rotation},
    {"--mass", "apparent mass at the tool, motors included: the smallest over the directions", "kg",
     &NewDescription::mass_kg, always},
    {"--inertia", "apparent inertia of the tool about its centre", "kg m2", &NewDescription::inertia_kg_m2,
     has_rotation},
    {"--damping", "viscous damping at the tool, the smallest; 0.5 is a common estimate", "N s/m",
     &NewDescription::damping_Ns_per_m, always},
    {"--friction", "dry friction at the tool", "N", &NewDescription::coulomb_friction_N, always},
    {"--ratio", "turns of the shaft that a drive reports per turn of its axis", "", &NewDescription::ratio, has_drives},
    {"--torque-range", "torque that a drive's frame spans, and that may be asked of it", "N m",
     &NewDescription::torque_range_Nm, has_drives},
    {"--position-range", "angle that a drive's frame spans to each side", "rad", &NewDescription::position_range_rad,
     has_fields},
    {"--speed-range", "speed that a drive's frame spans to each side", "rad/s", &NewDescription::speed_range_rad_per_s,
     has_fields},
    {"--counts", "encoder counts per turn", "", &NewDescription::counts_per_turn, has_counts},
};

unsigned axes_of(const NewDescription& d) { return d.kind == "point_arm" ? 3 : 6; }

std::string drives_text(const NewDescription& d) {
  const Family& family = *family_of(d.family);
  const std::vector<std::string> buses = text::split(d.buses, ',');
  std::string text = fmt::format("[drives]\nfamily = \"{}\"\nbuses = [\"{}\"]\nwatchdog_ms = {:g}\n", d.family,
                                 fmt::join(buses, "\", \""), d.watchdog_ms);
  if (d.family == "moteus") text += "data_bit_per_s = 5000000\n";
  const unsigned count = axes_of(d),
                 each = (count + static_cast<unsigned>(buses.size()) - 1) / static_cast<unsigned>(buses.size());
  for (unsigned i = 0; i < count; ++i) {
    text += fmt::format("\n[[drives.axis]]\nbus = {}\nid = {}\n", i / each, i + 1);
    if (family.answers_on_own_id) text += fmt::format("answer_id = {}\n", i + 17);
    text += fmt::format("sign = 1  # tactus device calibrate finds sign and offset\noffset_rad = 0\nratio = {:g}\n",
                        d.ratio);
    text += fmt::format("torque_range_Nm = {:g}\n", d.torque_range_Nm);
    if (family.position_range_rad > 0)
      text += fmt::format("position_range_rad = {:g}\nspeed_range_rad_per_s = {:g}\n", d.position_range_rad,
                          d.speed_range_rad_per_s);
    else
      text += fmt::format("counts_per_turn = {:g}\n", d.counts_per_turn);
  }
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

Status check_choices(const NewDescription& d) {
  if (d.kind != "point_arm" && d.kind != "wristed_arm" && d.kind != "stage")
    return Status::error(fmt::format("--kind: '{}' is none; accepted: point_arm, wristed_arm, stage", d.kind));
  if (has_drives(d) && family_of(d.family) == nullptr)
    return Status::error(
        fmt::format("--family: '{}' is none; accepted: damiao, cubemars, mini_cheetah, robstride, moteus, odrive, or "
                    "firmware for a device on tactus' wire",
                    d.family));
  if (d.name.empty() || d.name.find_first_of("\"\\\n") != std::string::npos)
    return Status::error("--name: accepted: a short name without quotes");
  if (d.buses.find_first_of("\"\\\n") != std::string::npos)
    return Status::error("--buses: accepted: such as can0,can1");
  return Status::good();
}

void complete(NewDescription& d) {
  const Family* family = family_of(d.family);
  const auto fill = [](double& value, double usual) { value = value == 0 ? usual : value; };
  if (family == nullptr) return fill(d.counts_per_turn, kFirmwareCounts);
  fill(d.torque_range_Nm, family->torque_range_Nm);
  fill(d.position_range_rad, family->position_range_rad);
  fill(d.speed_range_rad_per_s, family->speed_range_rad_per_s);
  fill(d.counts_per_turn, family->counts_per_turn);
}

std::string description_text(const NewDescription& d) {
  const bool rotation = has_rotation(d);
  std::string text =
      "# Written by `tactus device new`. Lines with 'estimate' wait for a measurement: hal/README.md says how.\n";
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
