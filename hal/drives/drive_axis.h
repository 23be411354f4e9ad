// The description of an arm whose axes are CAN drives: which drive moves which axis, and how its numbers are scaled.
//
// An axis coordinate q follows from the drive's own angle theta by q = sign (theta - offset) / ratio, and the drive's
// torque from the axis effort by tau_drive = sign tau_axis / ratio. `ratio` is turns of the shaft that the drive
// reports per turn of the axis (rad per m for a prismatic axis). Units: SI, of the drive's reported shaft unless the
// name says otherwise. Thread: [setup], plain values. Limits: kMaxBuses buses, one drive per axis.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tactus::hal {

enum class DriveFamily : std::uint8_t {
  kDamiao = 0,       // MIT frame, status in the answer, registers
  kCubeMars = 1,     // MIT frame, T-Motor/CubeMars AK: temperature and error in the answer
  kMiniCheetah = 2,  // MIT frame, answer without a status
  kRobStride = 3,    // RobStride and CyberGear, 29-bit identifiers
  kMoteus = 4,       // CAN FD
  kOdrive = 5,       // CANSimple
};
inline constexpr unsigned kDriveFamilies = 6;

inline constexpr unsigned kMaxBuses = 2;
inline constexpr double kTurn_rad = 2.0 * 3.14159265358979323846;

struct DriveAxis {
  unsigned bus{0};               // index into DriveDescription::buses
  unsigned id{1};                // of the drive: motor id, or node
  unsigned answer_id{0};         // MIT frames: the identifier on which the drive answers (its master id)
  double sign{1}, ratio{1};      // sign: 1 or -1
  double offset_rad{0};          // the drive's angle where the axis coordinate is zero
  double position_range_rad{0};  // the fields of a frame span +- these; 0: the family has no such field
  double speed_range_rad_per_s{0};
  double torque_range_Nm{0};            // also the largest torque that is commanded
  double damping_range_Nms_per_rad{0};  // largest damping gain of a frame; moteus: the configured kd
  double counts_per_turn{0};            // of the drive's encoder, where the frames do not have a quantum; else 0
  double damping_Nms_per_rad{0};        // in the drive, while there is force; counts as physical damping
  double brake_damping_Nms_per_rad{0};  // in the drive, in BRAKE; moteus shorts the motor instead

  friend bool operator==(const DriveAxis&, const DriveAxis&) = default;
};

struct DriveDescription {
  DriveFamily family{DriveFamily::kDamiao};
  std::vector<std::string> buses;      // CAN interfaces; the address of --device may name others
  std::uint32_t bit_per_s{1'000'000};  // nominal
  std::uint32_t data_bit_per_s{0};     // of CAN FD frames; 0: classic CAN
  double watchdog_s{0.01};             // of the drives, when their host falls silent
  double full_effort_s{0.004};         // shortest time in which an effort rises from zero to its largest
  bool held_at_centre{false};          // moteus without an output encoder: held at the centre when it is opened
  std::vector<DriveAxis> axes;         // in the order of the kinematics; empty: no arm of drives

  bool empty() const noexcept { return axes.empty(); }
  friend bool operator==(const DriveDescription&, const DriveDescription&) = default;
};

}  // namespace tactus::hal
