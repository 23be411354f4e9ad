// Test bench of the checks: the link, the device on it, the description it is compared with, and functions to
// communicate with it. A check receives the device in IDLE without fault, and may leave it in any state.
// Thread: normal. Units in the names.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "firmware/registers.h"
#include "hal/profiles.h"
#include "tools/hil/analysis.h"
#include "tools/hil/provoke.h"

namespace tactus::hil {

struct HilOptions {
  double rate_Hz{1000};
  double force_N{0};        // largest force that a check may command; 0: none
  bool stepped{false};      // no clock: the link is stepped tick by tick
  bool judge_timing{true};  // false: times are shown and not judged
  bool can{false};          // the link is a CAN bus
  bool own_clock{true};     // false: the device's clock is that of the periods of this program
  std::uint64_t soak_frames{0};
  double quiet_s{5};  // duration of the exchange from which losses, times and clocks are determined
  loop::SetupRequest setup;
};

// The exchange at rest, used by several checks.
struct QuietExchange {
  ExchangeResult result;
  FrameCounts counts;
  RoundTrip times;
};

class Bench {
 public:
  // Receives the completed fraction of an exchange, 0 to 1.
  using Progress = std::function<void(double share)>;

  Bench(hal::AnyLink& link, const hal::DeviceProfile& profile, Provoker& provoker, const HilOptions& options);

  const HilOptions& options() const noexcept { return options_; }
  const hal::DeviceProfile& profile() const noexcept { return profile_; }
  Provoker& provoker() noexcept { return provoker_; }
  hal::AnyLink& link() noexcept { return link_; }
  std::int64_t period_ns() const noexcept { return settings_.period_ns; }
  std::uint64_t ticks(double seconds) const noexcept;
  const loop::SetupReport& setup() const noexcept { return setup_; }  // of the last exchange in real time
  void on_progress(Progress progress) { progress_ = std::move(progress); }

  Result<ExchangeResult> exchange(std::span<const ExchangePhase> plan, const Director& director = {}, bool keep = true);
  // Run at the first call; later calls return the same result.
  const Result<QuietExchange>& quiet();
  // Brings the device to IDLE without fault; re-arms if necessary. Error, one line: the device does not get there.
  Status settle();

  // Sends one request. Error: no answer, or the reason of a refusal.
  Result<firmware::ServiceMessage> call(firmware::Operation operation, std::uint16_t number, std::uint32_t value = 0);
  Result<std::uint32_t> read(std::uint16_t number);
  Status write(std::uint16_t number, std::uint32_t value);

 private:
  hal::AnyLink& link_;
  hal::DeviceProfile profile_;
  Provoker& provoker_;
  HilOptions options_;
  ExchangeSettings settings_;
  Conversation conversation_;
  loop::SetupReport setup_;
  std::optional<Result<QuietExchange>> quiet_;
  Progress progress_;
  std::uint8_t tag_{0};
};

// Time limit for an answer. The device answers once a period; the rest is a margin for a busy machine.
inline constexpr std::chrono::milliseconds kAnswer{500};

// "BRAKE, fault 2 (e-stop)": a state frame as text.
std::string describe(const firmware::StateFrame& frame);

}  // namespace tactus::hil
