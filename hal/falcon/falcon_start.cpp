#include "hal/falcon/falcon_start.h"

#include <fmt/format.h>

#include <algorithm>

#include "rt/base/hash.h"
#include "rt/text/read_file.h"

namespace tactus::hal {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kLargestImage = 64u << 10, kPiece = 62;
constexpr unsigned kGreetings = 100, kAsks = 5;
constexpr milliseconds kAnswer{100}, kEcho{500};
constexpr std::uint16_t kDtrOn = 0x0101, kDtrOff = 0x0100, kRtsOff = 0x0200;
constexpr std::uint16_t kSlow = 0x4138, kLoading = 0x15, kRunning = 0x02;

// Reads exactly as many bytes. False: fewer came in time.
bool read_all(FalconPort& port, std::span<std::uint8_t> bytes, milliseconds longest) {
  std::size_t have = 0;
  for (unsigned tries = 0; have < bytes.size() && tries < bytes.size() + 8; ++tries) {
    const int count = port.read(bytes.subspan(have), longest);
    if (count < 0) return false;
    if (count == 0) break;
    have += static_cast<std::size_t>(count);
  }
  return have == bytes.size();
}

bool set_running(FalconPort& port) {
  return port.control(FtdiRequest::kLatency, 1) && port.control(FtdiRequest::kDivisor, kRunning) &&
         port.control(FtdiRequest::kData, 8) && port.control(FtdiRequest::kFlow, 0) &&
         port.control(FtdiRequest::kEvent, 0x0100 | '>') && port.control(FtdiRequest::kReset, 1) &&
         port.control(FtdiRequest::kReset, 2);
}

bool answers(FalconPort& port) {
  FalconScanner scanner;
  FalconState state;
  for (unsigned i = 0; i < kAsks; ++i)
    if (exchange_falcon(port, {}, scanner, state, kAnswer)) return true;
  return false;
}

// The boot program's greeting: 0A 43 0D is answered by 0A 44 2C 0D, sometimes after a zero.
bool greet(FalconPort& port) {
  constexpr std::uint8_t kAsk[] = {0x0a, 0x43, 0x0d}, kWanted[] = {0x0a, 0x44, 0x2c, 0x0d};
  for (unsigned i = 0; i < kGreetings; ++i) {
    std::uint8_t answer[5]{};
    if (!port.write(kAsk)) return false;
    std::size_t have = 0;
    while (have < 5) {
      const int count = port.read(std::span(answer).subspan(have), milliseconds(20));
      if (count < 0) return false;
      if (count == 0) break;
      have += static_cast<std::size_t>(count);
      const std::size_t skip = answer[0] == 0 ? 1 : 0;
      if (have >= skip + 4 && std::equal(std::begin(kWanted), std::end(kWanted), answer + skip)) return true;
    }
  }
  return false;
}

bool load_once(FalconPort& port, std::span<const std::uint8_t> image) {
  const bool ready = port.control(FtdiRequest::kReset, 1) && port.control(FtdiRequest::kReset, 2) &&
                     port.control(FtdiRequest::kLatency, 16) && port.control(FtdiRequest::kDivisor, kSlow) &&
                     port.control(FtdiRequest::kData, 8) && port.control(FtdiRequest::kFlow, 0) &&
                     port.control(FtdiRequest::kModem, kRtsOff) && port.control(FtdiRequest::kModem, kDtrOff) &&
                     port.control(FtdiRequest::kModem, kDtrOn);
  if (!ready || !greet(port)) return false;
  std::uint8_t echo[kPiece];
  constexpr std::uint8_t kBegin[] = {0x41};
  if (!port.control(FtdiRequest::kModem, kDtrOff) || !port.control(FtdiRequest::kDivisor, kLoading) ||
      !port.write(kBegin) || !read_all(port, std::span(echo).first(1), kEcho) || echo[0] != kBegin[0])
    return false;
  for (std::size_t at = 0; at < image.size(); at += kPiece) {
    const auto piece = image.subspan(at, std::min(kPiece, image.size() - at));
    const auto back = std::span(echo).first(piece.size());
    if (!port.write(piece) || !read_all(port, back, kEcho) || !std::equal(piece.begin(), piece.end(), back.begin()))
      return false;
  }
  return set_running(port) && answers(port);
}

}  // namespace

Result<std::vector<std::uint8_t>> load_falcon_image(const std::filesystem::path& path) {
  const std::string image = text::read_file(path, kLargestImage).value_or("");
  if (!image.empty() && image.size() <= kLargestImage) return std::vector<std::uint8_t>(image.begin(), image.end());
  return Status::error(fmt::format("{}: {}; accepted: the Falcon's firmware image, of 1 to {} bytes", path.string(),
                                   image.empty() ? "cannot be read, or is empty" : "too long", kLargestImage));
}

std::string falcon_checksum(std::span<const std::uint8_t> image) {
  return fmt::format("{:016x}", fnv1a(std::as_bytes(image)));
}

Status start_falcon(FalconPort& port, std::span<const std::uint8_t> image) {
  if (set_running(port) && answers(port)) return Status::good();
  if (image.empty())
    return Status::error(
        "no firmware runs in the Falcon; accepted: falcon:FILE with its firmware image, which comes with the maker's "
        "driver (often called nvent_firmware.bin)");
  for (unsigned i = 0; i < kFalconLoads; ++i)
    if (load_once(port, image)) return Status::good();
  return Status::error(
      fmt::format("the firmware image (checksum {}) was not taken in {} attempts; unplug the Falcon's "
                  "supply and USB, plug both in, and see that the file is a Falcon's image",
                  falcon_checksum(image), kFalconLoads));
}

Status wait_until_homed(FalconPort& port, std::chrono::milliseconds longest) {
  FalconScanner scanner;
  FalconState state;
  const auto deadline = std::chrono::steady_clock::now() + longest;
  constexpr unsigned kInARow = 100;  // coordinates jump when a bit comes
  for (unsigned homed = 0; homed < kInARow;) {
    if (!exchange_falcon(port, {.blue = homed > 0, .red = homed == 0}, scanner, state, kAnswer))
      return Status::error("the Falcon stopped answering; unplug it and plug it in");
    homed = state.homed == 7 ? homed + 1 : 0;
    if (homed == 0 && std::chrono::steady_clock::now() > deadline)
      return Status::error(
          "the Falcon is not homed; pull the grip out fully, then push it in fully, until the light "
          "turns from red to blue, and start again");
  }
  return Status::good();
}

bool exchange_falcon(FalconPort& port, const FalconRequest& request, FalconScanner& scanner, FalconState& state,
                     std::chrono::milliseconds longest) noexcept {
  if (!port.write(encode_falcon(request))) return false;
  std::array<std::uint8_t, 64> bytes;
  bool found = false;
  for (unsigned reads = 0; reads < 4 && !found; ++reads) {
    const int count = port.read(bytes, longest);
    if (count <= 0) return false;
    for (int i = 0; i < count; ++i) found = scanner.take(bytes[static_cast<unsigned>(i)], state) || found;
  }
  return found;
}

}  // namespace tactus::hal
