#include "tools/timing/os_noise.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string_view>

namespace tactus::timing {
namespace {

struct Event {
  std::string_view name;  // as it stands in the trace, and as a folder
  Noise::Kind kind;
};
constexpr std::array<Event, 4> kEvents{{{"irq_noise", Noise::Kind::kInterrupt},
                                        {"softirq_noise", Noise::Kind::kInterrupt},
                                        {"nmi_noise", Noise::Kind::kInterrupt},
                                        {"thread_noise", Noise::Kind::kThread}}};
// The longest period that the kernel accepts, so that its thread disturbs least often.
constexpr const char* kTimerlatPeriod_us = "1000000";

std::string first_line_of(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  std::getline(file, text);
  return text;
}

// Writes in a single call, as these files require.
Status write_to(const std::string& path, std::string_view text) {
  const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  const bool good = file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  if (file >= 0) close(file);
  return good ? Status::good() : Status::error(fmt::format("{}: {}", path, strerrordesc_np(error)));
}

std::optional<std::int64_t> number_after(std::string_view text, std::string_view word) {
  const auto at = text.find(word);
  if (at == std::string_view::npos) return std::nullopt;
  std::int64_t value = 0;
  const char* begin = text.data() + at + word.size();
  if (std::from_chars(begin, text.data() + text.size(), value).ec != std::errc{}) return std::nullopt;
  return value;
}

// "12.345678" [s] as nanoseconds.
std::optional<std::int64_t> seconds_ns(std::string_view text) {
  const auto dot = text.find('.');
  std::int64_t whole = 0, micro = 0;
  if (dot == std::string_view::npos || text.size() - dot != 7) return std::nullopt;
  if (std::from_chars(text.data(), text.data() + dot, whole).ec != std::errc{} ||
      std::from_chars(text.data() + dot + 1, text.data() + text.size(), micro).ec != std::errc{})
    return std::nullopt;
  return whole * 1'000'000'000 + micro * 1'000;
}

}  // namespace

// `  TASK-PID [CPU] FLAGS SECONDS: EVENT: NAME:NUMBER start S duration N ns`; an nmi has no name. The time of the line
// is that of the end, and on the selected trace clock; the start is on the kernel's own clock.
std::optional<Noise> parse_noise(const std::string& line) {
  const std::string_view text(line);
  for (const Event& event : kEvents) {
    const std::string mark = fmt::format(": {}: ", event.name);
    const auto at = text.find(mark);
    if (at == std::string_view::npos) continue;
    const auto blank = text.rfind(' ', at);
    const auto end_ns = seconds_ns(text.substr(blank + 1, at - blank - 1));
    const std::string_view body = text.substr(at + mark.size());
    const auto duration_ns = number_after(body, "duration ");
    const auto start = body.find("start ");
    if (!end_ns || !duration_ns || start == std::string_view::npos) return std::nullopt;
    Noise noise{
        .kind = event.kind, .name = "nmi", .number = 0, .from_ns = *end_ns - *duration_ns, .duration_ns = *duration_ns};
    if (std::string_view who = body.substr(0, start); who.find(':') != std::string_view::npos) {
      const auto colon = who.rfind(':');
      noise.number = number_after(who.substr(colon), ":").value_or(0);
      who = who.substr(0, colon);
      who.remove_prefix(std::min(who.find_first_not_of(' '), who.size()));
      noise.name = std::string(who);
    }
    return noise;
  }
  return std::nullopt;
}

Result<std::unique_ptr<OsNoise>> OsNoise::start(int cpu, const std::string& tracefs) {
  std::unique_ptr<OsNoise> noise(new OsNoise);
  if (const Status status = noise->set_up(cpu, tracefs); !status.ok())
    return Status::error("the kernel's osnoise events cannot be had: " + status.message() +
                         "; they need root, CONFIG_TIMERLAT_TRACER, and: mount -t tracefs nodev /sys/kernel/tracing");
  return noise;
}

Status OsNoise::set_up(int cpu, const std::string& tracefs) {
  const std::string instance = tracefs + "/instances/tactus";
  if (mkdir(instance.c_str(), 0700) != 0 && errno != EEXIST)
    return Status::error(fmt::format("{}: {}", instance, strerrordesc_np(errno)));
  instance_ = instance;
  const std::string options = tracefs + "/osnoise/options";
  const bool without_thread = access(options.c_str(), F_OK) == 0;
  const auto share = [&](const std::string& file, const std::string& before, std::string_view text) {
    saved_.push_back({file, before});
    return write_to(file, text);
  };
  const std::string cpus = tracefs + "/osnoise/cpus", period = tracefs + "/osnoise/timerlat_period_us";
  if (const Status status = share(cpus, first_line_of(cpus), std::to_string(cpu)); !status.ok()) return status;
  if (const Status status = without_thread ? share(options, "OSNOISE_WORKLOAD", "NO_OSNOISE_WORKLOAD")
                                           : share(period, first_line_of(period), kTimerlatPeriod_us);
      !status.ok())
    return status;
  if (const Status status = write_to(instance + "/trace_clock", "mono"); !status.ok()) return status;
  for (const Event& event : kEvents)
    if (const Status status = write_to(fmt::format("{}/events/osnoise/{}/enable", instance, event.name), "1");
        !status.ok())
      return status;
  if (const Status status = write_to(instance + "/current_tracer", without_thread ? "osnoise" : "timerlat");
      !status.ok())
    return status;
  const std::string pipe = fmt::format("{}/per_cpu/cpu{}/trace_pipe", instance, cpu);
  pipe_ = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  return pipe_ >= 0 ? Status::good() : Status::error(fmt::format("{}: {}", pipe, strerrordesc_np(errno)));
}

OsNoise::~OsNoise() {
  if (pipe_ >= 0) close(pipe_);
  if (!instance_.empty()) (void)write_to(instance_ + "/current_tracer", "nop");
  for (auto each = saved_.rbegin(); each != saved_.rend(); ++each) (void)write_to(each->file, each->text);
  if (!instance_.empty()) (void)rmdir(instance_.c_str());
}

void OsNoise::take(const std::string& line, int except_thread, std::vector<Noise>& into) {
  auto noise = parse_noise(line);
  if (!noise) return;
  if (noise->kind == Noise::Kind::kThread && (noise->number == 0 || noise->number == except_thread)) return;
  into.push_back(std::move(*noise));
}

std::vector<Noise> OsNoise::read(int except_thread) {
  std::vector<Noise> found;
  std::array<char, 4096> buffer;
  for (ssize_t count = 0; (count = ::read(pipe_, buffer.data(), buffer.size())) > 0;) {
    rest_.append(buffer.data(), static_cast<std::size_t>(count));
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1)
      take(rest_.substr(begin, end - begin), except_thread, found);
    rest_.erase(0, begin);
  }
  return found;
}

}  // namespace tactus::timing
