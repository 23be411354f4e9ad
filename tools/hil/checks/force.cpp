// Checks of force: a command that the device must limit, and small forces that it must produce.
#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "tools/hil/check.h"
#include "tools/hil/latch.h"

namespace tactus::hil {
namespace {

namespace number = firmware::number;
using firmware::Limit;
using firmware::State;

// Above a limit of zero, but small in case a device ignores its limit.
constexpr double kAboveLimit_N = 1.0;
constexpr std::uint64_t kPush = 20;  // ticks; once forward, twice back, once forward: the tool ends where it began
constexpr double kMaxBackwards_m = 1e-3;

// Sets the force limit for its lifetime.
class LoweredLimit {
 public:
  static Result<LoweredLimit> make(Bench& bench, float limit_N) {
    const auto before = bench.read(number::kMaxForce);
    if (!before.ok()) return before.status();
    if (const Status status = bench.write(number::kMaxForce, std::bit_cast<std::uint32_t>(limit_N)); !status.ok())
      return status;
    LoweredLimit lowered(bench, before.value());
    const auto now = bench.read(number::kMaxForce);
    if (!now.ok()) return now.status();
    if (now.value() != std::bit_cast<std::uint32_t>(limit_N))
      return Status::error("the force limit was written, and reads back as before");
    return lowered;
  }
  LoweredLimit(LoweredLimit&& other) noexcept : bench_(std::exchange(other.bench_, nullptr)), before_(other.before_) {}
  LoweredLimit& operator=(LoweredLimit&&) = delete;
  ~LoweredLimit() {
    if (bench_ != nullptr) (void)restore();
  }
  Status restore() { return std::exchange(bench_, nullptr)->write(number::kMaxForce, before_); }

 private:
  LoweredLimit(Bench& bench, std::uint32_t before) : bench_(&bench), before_(before) {}
  Bench* bench_;
  std::uint32_t before_;
};

// A device that compensates the arm's weight would let it fall with a force limit of zero.
bool carries_its_arm(Bench& bench) {
  for (unsigned i = 0; i < 16; ++i) {
    const auto term = bench.read(static_cast<std::uint16_t>(number::kGravityAmplitude + i));
    if (term.ok() && std::bit_cast<float>(term.value()) != 0.0f) return true;
  }
  return false;
}

Vec3d along(unsigned axis, double size) {
  return {axis == 0 ? size : 0.0, axis == 1 ? size : 0.0, axis == 2 ? size : 0.0};
}

}  // namespace

CheckFinding check_saturation(Bench& bench) {
  CheckFinding finding;
  finding.threshold = "every frame in FORCE reports limit 70, none before";
  if (carries_its_arm(bench)) return skipped("the device carries its arm's weight: without force it would fall");
  auto lowered = LoweredLimit::make(bench, 0.0f);
  if (!lowered.ok()) return bad(lowered.message(), finding.threshold);
  const ExchangePhase plan[] = {{.ticks = 60, .wanted = State::kForce},
                                {.ticks = 100, .wanted = State::kForce, .force_N = {kAboveLimit_N, 0, 0}},
                                {.ticks = 20}};
  const auto result = bench.exchange(plan);
  const Status restored = lowered.value().restore();
  if (!result.ok()) return bad(result.message(), finding.threshold);
  if (!restored.ok()) return bad("the force limit could not be set back: " + restored.message(), finding.threshold);
  const std::span<const Record> records = result.value().records;
  if (std::string reason = never_forced(records, 0); !reason.empty()) return bad(std::move(reason), finding.threshold);
  unsigned cut = 0, frames = 0, early = 0;
  for (const Record& record : in_phases(records, 1, 1).subspan(5)) {
    if (record.got != Got::kFresh) continue;
    ++frames;
    if ((record.state.limits & bit_of(Limit::kForce)) != 0) ++cut;
  }
  for (const Record& record : in_phases(records, 0, 0))
    if (record.got == Got::kFresh && (record.state.limits & bit_of(Limit::kForce)) != 0) ++early;
  finding.measured = fmt::format("{:g} N against a limit of 0 N: cut in {} of {} frames", kAboveLimit_N, cut, frames);
  if (cut < frames || frames == 0) finding.reason = "a force above the limit was not reported as cut";
  if (early > 0) finding.reason = "it reports a cut where no force was asked for";
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

CheckFinding check_force(Bench& bench) {
  const double size = std::min(bench.options().force_N, bench.profile().properties.max_force_N);
  CheckFinding finding;
  finding.threshold =
      fmt::format("{:g} N along each axis: FORCE throughout, not backwards by {:g} mm", size, 1e3 * kMaxBackwards_m);
  for (unsigned axis = 0; axis < 3; ++axis) {
    const ExchangePhase plan[] = {{.ticks = 60, .wanted = State::kForce},
                                  {.ticks = kPush, .wanted = State::kForce, .force_N = along(axis, size)},
                                  {.ticks = 2 * kPush, .wanted = State::kForce, .force_N = along(axis, -size)},
                                  {.ticks = kPush, .wanted = State::kForce, .force_N = along(axis, size)},
                                  {.ticks = 60, .wanted = State::kForce},
                                  {.ticks = 20}};  // a real device in FORCE brakes if frames stop
    const auto result = bench.exchange(plan);
    if (!result.ok()) return bad(result.message(), finding.threshold);
    const std::span<const Record> records = result.value().records;
    if (std::string reason = never_forced(records, 4); !reason.empty())
      return bad(fmt::format("axis {}: {}", axis, reason), finding.threshold);
    const Vec3d start = in_phases(records, 0, 0).back().position_m;
    const Vec3d pushed = in_phases(records, 1, 1).back().position_m;
    const double moved_m = dot(pushed - start, along(axis, 1));
    finding.measured += fmt::format("{}{} {:+.2f} mm", axis > 0 ? ", " : "", "xyz"[axis], 1e3 * moved_m);
    finding.figures.push_back({fmt::format("moved_{}_m", "xyz"[axis]), moved_m});
    if (moved_m < -kMaxBackwards_m)
      finding.reason =
          fmt::format("pushed along {}, it goes backwards: a motor or an encoder is wired the wrong way", "xyz"[axis]);
  }
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

}  // namespace tactus::hil
