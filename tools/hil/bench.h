// What the checks work with: the link and what is on it, the description it is compared with, and the ways to talk to
// it. A check gets the device IDLE and without fault, and may leave it as it likes.
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
  double force_N{0};        // the largest force that a check may ask for; 0: none
  bool stepped{false};      // no clock: the link is stepped tick by tick
  bool judge_timing{true};  // false: figures of time are shown and not judged
  bool can{false};          // the link is a CAN bus
  std::uint64_t soak_frames{0};
  double quiet_s{5};  // of the exchange that losses, times and clocks are read from
  loop::SetupRequest setup;
};

// The exchange at rest that several checks read.
struct QuietExchange {
  ExchangeResult result;
  FrameBook book;
  RoundTrip times;
};

class Bench {
 public:
  // Who sees how far an exchange is: 0 to 1.
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

  Result<ExchangeResult> exchange(std::span<const Phase> plan, const Director& director = {}, bool keep = true);
  // Run once, then remembered.
  const Result<QuietExchange>& quiet();
  // IDLE, without fault; re-arms where it must. One line where the device does not go there.
  Status settle();

  // One question. An error: no answer, or a refusal in words.
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

// How long an answer may take: the device answers once a period, the rest is for a machine that is busy.
inline constexpr std::chrono::milliseconds kAnswer{500};

// "BRAKE, fault 2 (e-stop)": what a state frame says, for people.
std::string describe(const firmware::StateFrame& frame);

}  // namespace tactus::hil
