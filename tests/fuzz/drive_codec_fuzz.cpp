// Any frames to the decoders of all drive families: an answer has finite figures.
#include <cmath>
#include <cstdlib>

#include "hal/drives/drive_codec.h"

using namespace tactus::hal;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 7) return 0;
  const auto family = static_cast<DriveFamily>(data[0] % 6);
  const DriveAxis axis{.id = data[1] & 0x7fu,
                       .answer_id = 0x11,
                       .position_range_rad = 12.5,
                       .speed_range_rad_per_s = 30,
                       .torque_range_Nm = 10,
                       .damping_range_Nms_per_rad = 5};
  DriveFrame frame;
  for (unsigned i = 0; i < 4; ++i) frame.id |= static_cast<std::uint32_t>(data[2 + i]) << (8 * i);
  frame.extended = (data[6] & 1) != 0;
  frame.id &= frame.extended ? 0x1fffffffu : 0x7ffu;
  for (std::size_t i = 7; i < size && frame.size < 64; ++i) frame.put({data[i]});
  DriveAnswer answer;
  if (codec_of(family).decode(axis, frame, answer) != DriveDecode::kAnswer) return 0;
  if (!std::isfinite(answer.position_rad) || !std::isfinite(answer.speed_rad_per_s) || !std::isfinite(answer.torque_Nm))
    std::abort();
  return 0;
}
