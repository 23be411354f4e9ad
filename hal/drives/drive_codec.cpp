#include "hal/drives/drive_codec.h"

#include <algorithm>
#include <cmath>

#include "hal/drives/mit_codec.h"
#include "hal/drives/moteus_codec.h"
#include "hal/drives/odrive_codec.h"
#include "hal/drives/robstride_codec.h"

namespace tactus::hal {

const DriveCodec& codec_of(DriveFamily family) noexcept {
  switch (family) {
    case DriveFamily::kDamiao:
      return kDamiaoCodec;
    case DriveFamily::kCubeMars:
      return kCubeMarsCodec;
    case DriveFamily::kMiniCheetah:
      return kMiniCheetahCodec;
    case DriveFamily::kRobStride:
      return kRobStrideCodec;
    case DriveFamily::kMoteus:
      return kMoteusCodec;
    case DriveFamily::kOdrive:
      break;
  }
  return kOdriveCodec;
}

double drive_counts_per_turn(DriveFamily family, const DriveAxis& axis) noexcept {
  if (codec_of(family).has_float_position) return axis.counts_per_turn * axis.ratio;
  const double steps = family == DriveFamily::kRobStride ? 65534 : 65535;
  return kTurn_rad * axis.ratio * steps / (2 * axis.position_range_rad);
}

double sent_damping_Nms_per_rad(DriveFamily family, const DriveAxis& axis, double damping) noexcept {
  const DriveCodec& codec = codec_of(family);
  if (!codec.damps) return 0;
  const bool has_own_range = family == DriveFamily::kRobStride || family == DriveFamily::kMoteus;
  const double range = has_own_range ? axis.damping_range_Nms_per_rad : codec.default_damping_range_Nms_per_rad;
  const double share = range > 0 ? std::clamp(damping / range, 0.0, 1.0) : 0.0;
  return std::floor(share * codec.damping_steps) / codec.damping_steps * range;
}

std::uint32_t field_of(double value, double range, unsigned bits, bool round_up) noexcept {
  const double top = static_cast<double>((1u << bits) - 1);
  const double share = std::isfinite(value) && range > 0 ? (value + range) / (2 * range) : 0.5;
  const double step = std::clamp(share * top, 0.0, top);
  const double nearest = round_up ? std::floor(step + 0.5) : std::ceil(step - 0.5);
  return static_cast<std::uint32_t>(nearest);
}

double value_of_field(std::uint32_t field, double range, unsigned bits) noexcept {
  return field * (2 * range / static_cast<double>((1u << bits) - 1)) - range;
}

}  // namespace tactus::hal
