#include "firmware/boards/linux/linux_program.h"

#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <time.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>

namespace tactus::firmware {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::atomic<bool> stop_requested{false};
void request_stop(int) { stop_requested.store(true, std::memory_order_relaxed); }

std::string usage(std::string_view program, const char* purpose, std::span<const BoardOption> board_options) {
  std::string text = "usage: " + std::string(program) + " --mechanics FILE [OPTION VALUE]...\n" + purpose + "\n";
  const auto line = [&text](std::string_view name, std::string_view value, std::string_view meaning) {
    std::string left = "  --" + std::string(name) + " " + std::string(value);
    left.resize(left.size() < 24 ? 24 : left.size() + 1, ' ');
    text += left + std::string(meaning) + "\n";
  };
  line("mechanics", "FILE", "encoders, motors and limits of this board");
  for (const BoardOption& option : board_options) line(option.name, option.value, option.meaning);
  line("state", "FILE", "where the configuration is kept; if not given, nowhere");
  line("period-us", "N", "control period, 50 to 1000000; 1000 if not given");
  line("priority", "N", "SCHED_FIFO 1 to 99, 0 for a normal thread; 80 if not given");
  line("cpu", "N", "core to stay on; any if not given");
  line("periods", "N", "end after so many periods; on SIGINT or SIGTERM if not given");
  return text;
}

template <class Number>
bool read_number(std::string_view text, Number least, Number most, Number& out) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number < least || number > most) return false;
  out = number;
  return true;
}

// Sets one option. Returns what is wrong with its value; empty: nothing.
std::string take_option(std::string_view name, std::string_view value, std::span<const BoardOption> board_options,
                        ProgramOptions& options) {
  for (const BoardOption& option : board_options) {
    if (name == option.name) {
      *option.target = value;
      return "";
    }
  }
  const auto wrong = [&](const char* accepted) {
    return "--" + std::string(name) + ": '" + std::string(value) + "'; accepted: " + accepted;
  };
  if (name == "mechanics") {
    options.mechanics = value;
    return "";
  }
  if (name == "state") {
    options.state = value;
    return "";
  }
  if (name == "period-us")
    return read_number<std::uint32_t>(value, 50, 1'000'000, options.period_us) ? "" : wrong("50 to 1000000");
  if (name == "priority") return read_number(value, 0, 99, options.priority) ? "" : wrong("0 to 99");
  if (name == "cpu") return read_number(value, 0, CPU_SETSIZE - 1, options.cpu) ? "" : wrong("a core's number");
  if (name == "periods")
    return read_number<std::uint64_t>(value, 0, ~std::uint64_t{0}, options.periods) ? "" : wrong("a number from 0");
  return "unknown option '--" + std::string(name) + "'; --help lists them";
}

void add_refusal(std::string& text, const std::string& what) { text += (text.empty() ? "" : "; ") + what; }

}  // namespace

ParsedArguments parse_arguments(int argc, const char* const* argv, const char* purpose,
                                std::span<const BoardOption> board_options, ProgramOptions& options) {
  const std::string_view path = argc > 0 ? argv[0] : "";
  const std::string program(path.substr(path.rfind('/') + 1));  // npos + 1 is 0
  const auto bad = [&program](const std::string& what) { return ParsedArguments{false, 2, program + ": " + what}; };
  for (int i = 1; i < argc; i += 2) {
    const std::string_view argument = argv[i];
    if (argument == "--help" || argument == "-h") return {false, 0, usage(program, purpose, board_options)};
    if (!argument.starts_with("--")) return bad("'" + std::string(argument) + "' is no option; --help lists them");
    if (i + 1 >= argc) return bad(std::string(argument) + " needs a value; --help says which");
    const std::string wrong = take_option(argument.substr(2), argv[i + 1], board_options, options);
    if (!wrong.empty()) return bad(wrong);
  }
  if (options.mechanics.empty()) return bad("--mechanics FILE is missing: it says where encoders and motors are");
  return {true, 0, ""};
}

std::string make_realtime(int priority, int cpu) {
  std::string refused;
  if (cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(cpu), &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0)
      add_refusal(refused, "cpu " + std::to_string(cpu) + ": " + std::strerror(errno) + ", choose one that is online");
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    add_refusal(refused, std::string("locking memory: ") + std::strerror(errno) + ", give CAP_IPC_LOCK");
  if (priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = priority;
    if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0)
      add_refusal(refused, "SCHED_FIFO " + std::to_string(priority) + ": " + std::strerror(errno) +
                               ", give CAP_SYS_NICE or an rtprio limit");
  }
  return refused;
}

const std::atomic<bool>& stop_on_signals() {
  struct sigaction action {};
  action.sa_handler = &request_stop;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return stop_requested;
}

std::int64_t now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * kSecond_ns + now.tv_nsec;
}

Pace::Pace(std::uint32_t period_us) noexcept
    : period_ns_(static_cast<std::int64_t>(period_us) * 1000), deadline_ns_(now_ns()) {}

void Pace::wait() noexcept {
  deadline_ns_ += period_ns_;
  const std::int64_t before_ns = now_ns();
  if (before_ns >= deadline_ns_) {  // overrun: skip to the next future deadline
    const std::int64_t missed = (before_ns - deadline_ns_) / period_ns_ + 1;
    deadline_ns_ += missed * period_ns_;
    counters_.skipped += static_cast<std::uint64_t>(missed);
  }
  timespec until{};
  until.tv_sec = static_cast<time_t>(deadline_ns_ / kSecond_ns);
  until.tv_nsec = static_cast<long>(deadline_ns_ % kSecond_ns);
  // A signal ends the sleep: this period runs early, by less than one period, and then the loop checks the stop flag.
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  const std::int64_t late_ns = now_ns() - deadline_ns_;
  if (late_ns > counters_.max_late_ns) counters_.max_late_ns = late_ns;
  ++counters_.periods;
}

}  // namespace tactus::firmware
