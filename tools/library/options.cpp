#include <fmt/format.h>

#include "sim/model/choice_names.h"
#include "tools/library/access.h"

namespace tactus::library {
namespace {

constexpr std::uint32_t kMaxHistoryTicks = 1'000'000;

// Longer entries first, so that a shorter one which is their prefix does not match first.
constexpr std::pair<std::string_view, std::string_view> kOwnWords[] = {
    {"without --virtual-time", "with real_time = true"},
    {"--virtual-time", "real_time = false"},
    {"--world-precision", "world_precision"},
    {"--world-threads", "world_threads"},
    {"--world-cpu", "world_cpus"},
    {"--device-file", "device_file"},
    {"--keep-gains", "keep_gains"},
    {"--duration", "duration_s"},
    {"--accuracy", "accuracy"},
    {"--coupling", "coupling"},
    {"--priority", "priority"},
    {"--members", "members"},
    {"--border", "border"},
    {"--device", "device"},
    {"--inject", "inject"},
    {"--order", "order"},
    {"--ratio", "ratio"},
    {"--reach", "reach"},
    {"--gpio", "gpio"},
    {"--rate", "rate_Hz"},
};

template <class T>
Status read_word(const char* option, const std::string& word, std::optional<T> found, std::string_view accepted,
                 T& value) {
  if (!found) return Status::error(fmt::format("{}: '{:.64}' is none; accepted: {}", option, word, accepted));
  value = *found;
  return Status::good();
}

Status read_words(const Options& from, session::RunOptions& to) {
  const Status statuses[] = {
      read_word("--coupling", from.coupling, sim::parse_coupling_scheme(from.coupling),
                fmt::format("{}", fmt::join(sim::coupling_names(), ", ")), to.coupling),
      read_word("--border", from.border, sim::parse_border_mode(from.border),
                fmt::format("{}", fmt::join(sim::border_names(), ", ")), to.border),
      read_word("--order", from.order, sim::parse_cut_order(from.order), "best-first, breadth-first", to.order),
      read_word("--reach", from.reach, sim::parse_reach(from.reach), "two-cycles, paper", to.reach),
      read_word("--world-precision", from.world_precision, sim::parse_precision(from.world_precision), "double, mixed",
                to.world_precision),
      read_word("--accuracy", from.accuracy, session::parse_accuracy(from.accuracy), "fast, balanced, accurate",
                to.accuracy),
  };
  for (const Status& status : statuses)
    if (!status.ok()) return status;
  return Status::good();
}

}  // namespace

Result<session::RunOptions> run_options(const Options& from, double duration_s) {
  session::RunOptions to;
  if (const Status status = read_words(from, to); !status.ok()) return status;
  to.virtual_time = !from.real_time;
  to.device = from.device;
  to.device_file = from.device_file;
  to.gpio = from.gpio;
  to.rate_Hz = from.rate_Hz;
  to.ratio = from.ratio;
  to.members = from.members;
  to.keep_gains = from.keep_gains;
  to.late_s = from.late_s;
  to.world_threads = from.world_threads;
  to.world_cpus = from.world_cpus;
  to.cpu = from.cpu;
  to.priority = from.priority;
  to.arm_at_start = from.arm_at_start;
  to.rearm = from.rearm;
  to.inject = from.inject;
  to.seed = from.seed;
  to.duration_s = duration_s;
  if (const Status status = session::check_options(to); !status.ok()) return status;
  if (!(from.late_s >= 0 && from.late_s <= 1))
    return Status::error(fmt::format("late_s: {} is out of range; accepted: 0 to 1 s", from.late_s));
  if (from.history_ticks < 1 || from.history_ticks > kMaxHistoryTicks)
    return Status::error(
        fmt::format("history_ticks: {} is out of range; accepted: 1 to {}", from.history_ticks, kMaxHistoryTicks));
  return to;
}

std::string in_own_words(std::string message) {
  for (const auto& [theirs, own] : kOwnWords)
    for (std::size_t at = 0; (at = message.find(theirs, at)) != std::string::npos; at += own.size())
      message.replace(at, theirs.size(), own);
  return message;
}

Error Access::check(const Options& options, double duration_s) {
  const auto read = run_options(options, duration_s);
  return read.ok() ? Error() : Error(Error::Kind::kOption, read.message());
}

}  // namespace tactus::library
