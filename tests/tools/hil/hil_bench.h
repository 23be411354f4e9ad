// The suite of `tactus hil` on a simulated device, behind a link that can inject wrong frames.
#pragma once

#include <catch2/catch.hpp>
#include <memory>

#include "tools/hil/simulated_bench.h"
#include "tools/hil/suite.h"

namespace tactus::test {

inline constexpr std::int64_t kHilPeriod_ns = 1'000'000;

// Faults of a device or a cable. Each function gets the number of the frame since the link's start, or the command, and
// may be null.
struct Tampering {
  std::function<bool(std::uint64_t)> lose_state{};                          // true: the frame does not arrive
  std::function<void(std::uint64_t, firmware::StateFrame&)> alter_state{};  // its checksum is computed again
  std::function<bool(std::uint64_t)> repeat_state{};                        // true: the frame before arrives instead
  std::function<bool(const firmware::CommandFrame&)> supersede_command{};   // true: a newer one is sent instead
};

class TamperedLink {
 public:
  TamperedLink(const hal::DeviceProfile& profile, Tampering tampering)
      : bench(profile, kHilPeriod_ns), tampering_(std::move(tampering)) {}

  hal::ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    hal::ReceivedFrame frame = bench.receive(buffer);
    const std::uint64_t n = count_++;
    if (frame.size == 0) return frame;
    const auto bytes = buffer.first<firmware::kStateFrameSize>();
    firmware::StateFrame state;
    if (tampering_.alter_state && firmware::decode_state(bytes, state) == firmware::DecodeError::kNone) {
      tampering_.alter_state(n, state);
      firmware::encode_state(state, bytes);
    }
    if (tampering_.repeat_state && tampering_.repeat_state(n)) std::copy(last_.begin(), last_.end(), bytes.begin());
    std::copy(bytes.begin(), bytes.end(), last_.begin());
    if (tampering_.lose_state && tampering_.lose_state(n)) {
      ++lost_;
      return hal::ReceivedFrame{};
    }
    return frame;
  }
  bool send(std::span<const std::byte> frame) noexcept {
    firmware::CommandFrame command;
    if (tampering_.supersede_command && firmware::decode_command(frame, command) == firmware::DecodeError::kNone &&
        tampering_.supersede_command(command)) {
      ++superseded_;
      return true;
    }
    return bench.send(frame);
  }
  bool connected() const noexcept { return bench.connected(); }
  hal::LinkCounters counters() const noexcept {
    hal::LinkCounters counters = bench.counters();
    counters.received -= lost_;
    counters.send_superseded += superseded_;
    return counters;
  }
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds timeout) {
    return bench.call(request, timeout);
  }

  hil::SimulatedBench bench;

 private:
  Tampering tampering_;
  std::uint64_t count_{0}, lost_{0}, superseded_{0};
  std::array<std::byte, firmware::kStateFrameSize> last_{};
};

// A device, a bench around it and the suite's request, stepped without a clock.
struct HilBench {
  explicit HilBench(Tampering tampering = {}, hil::HilOptions o = {}, const char* profile_name = "virtuose6d")
      : profile(*hal::find_profile(profile_name)),
        link(std::make_unique<TamperedLink>(profile, std::move(tampering))),
        provoker(link.as<TamperedLink>()->bench),
        options(o),
        bench(link, profile, provoker, stepped(options)) {}

  // Runs one check, with the checks that it needs before and after it, and returns its finding.
  hil::CheckFinding check(const char* name) {
    const auto report = run_suite(bench, {{name}, true}, {});
    REQUIRE(report.checks.size() == 1);
    INFO(name << ": " << report.checks.front().finding.reason);
    return report.checks.front().finding;
  }

  static hil::HilOptions& stepped(hil::HilOptions& options) {
    options.stepped = true;
    return options;
  }

  hal::DeviceProfile profile;
  hal::AnyLink link;
  hil::ProvokeSimulated provoker;
  hil::HilOptions options;
  hil::Bench bench;
};

inline double figure(const hil::CheckFinding& finding, const std::string& name) {
  for (const hil::Figure& f : finding.figures)
    if (f.name == name) return f.value;
  FAIL("no figure " << name);
  return 0;
}

}  // namespace tactus::test
