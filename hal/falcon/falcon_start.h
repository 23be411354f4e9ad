// Starts a Falcon: loads the user's firmware image if none runs yet, waits until the device is homed.
//
// tactus has no image and fetches none: its licence does not allow that. The image runs until the device loses power.
// Thread: [setup]. Bound: kLoads attempts to load of some seconds each, then kHomingWait.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/falcon/falcon_packet.h"
#include "hal/falcon/falcon_port.h"
#include "rt/base/result.h"

namespace tactus::hal {

inline constexpr unsigned kFalconLoads = 10;
inline constexpr std::chrono::seconds kFalconHomingWait{20};

// 1 byte to 64 KiB. Error, one line: what is wrong with the file, and what is wanted.
Result<std::vector<std::uint8_t>> load_falcon_image(const std::filesystem::path& path);
// 64-bit FNV-1a, 16 hexadecimal digits: distinguishes images.
std::string falcon_checksum(std::span<const std::uint8_t> image);

// Checks once whether firmware runs; loads `image` if not (empty: an error says so). Error, one line.
Status start_falcon(FalconPort& port, std::span<const std::uint8_t> image);

// Exchanges packets without force until all axes are homed. Error, one line: what the person has to do.
Status wait_until_homed(FalconPort& port, std::chrono::milliseconds longest);

// One request and the answer to it. False: none within the time.
bool exchange_falcon(FalconPort& port, const FalconRequest& request, FalconScanner& scanner, FalconState& state,
                     std::chrono::milliseconds longest) noexcept;

}  // namespace tactus::hal
