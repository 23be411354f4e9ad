#include "tools/tactus/status_line.h"

#include <fmt/format.h>

#include <cstdio>

namespace tactus::tools {

void show_live(const session::LiveStatus& live, double elapsed_s, bool terminal, std::uint64_t& last_ticks,
               double& last_s) {
  const std::uint64_t ticks = live.ticks.load(std::memory_order_relaxed);
  const double rate_Hz = elapsed_s > last_s ? static_cast<double>(ticks - last_ticks) / (elapsed_s - last_s) : 0;
  last_ticks = ticks;
  last_s = elapsed_s;
  const std::uint32_t status = live.status.load(std::memory_order_relaxed);
  std::string notes;
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    const auto name = name_of(static_cast<StatusBit>(1u << bit));
    if (((status >> bit) & 1u) != 0 && !name.empty()) notes += fmt::format(" {}", name);
  }
  const auto fault = static_cast<Fault>(live.fault.load(std::memory_order_relaxed));
  if (fault != Fault::kNone) notes = fmt::format(" FAULT {} (Enter re-arms)", static_cast<unsigned>(fault));
  fmt::print(stderr,
             "{}{:6.1f} s {:5.0f} Hz  force {:5.2f} N  members {:3}  contacts {:3}  border {:3}  overruns {} |{:.80}{}",
             terminal ? "\r\033[K" : "", elapsed_s, rate_Hz, live.force_N.load(std::memory_order_relaxed),
             live.members.load(std::memory_order_relaxed), live.contacts.load(std::memory_order_relaxed),
             live.border.load(std::memory_order_relaxed), live.overruns.load(std::memory_order_relaxed), notes,
             terminal ? "" : "\n");
}

void show_live(std::span<const session::LiveStatus* const> hands, double elapsed_s, bool terminal) {
  constexpr auto relaxed = std::memory_order_relaxed;
  std::string text;
  for (std::size_t hand = 0; hand < hands.size(); ++hand) {
    const session::LiveStatus& live = *hands[hand];
    const auto fault = static_cast<Fault>(live.fault.load(relaxed));
    text +=
        fmt::format(" | {}: {:5.2f} N  members {:3}  border {:3}  overruns {}{}", hand + 1, live.force_N.load(relaxed),
                    live.members.load(relaxed), live.border.load(relaxed), live.overruns.load(relaxed),
                    fault == Fault::kNone ? "" : fmt::format("  FAULT {}", static_cast<unsigned>(fault)));
  }
  fmt::print(stderr, "{}{:6.1f} s{}{}", terminal ? "\r\033[K" : "", elapsed_s, text, terminal ? "" : "\n");
}

}  // namespace tactus::tools
