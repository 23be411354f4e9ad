#include "tools/tactus/hil_calibrate.h"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <filesystem>
#include <optional>

#include "rt/text/read_file.h"
#include "rt/text/toml.h"
#include "tools/hil/device_line.h"
#include "tools/hil/held_force.h"
#include "tools/hil/scale_calibration.h"
#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/stop_signals.h"

namespace tactus::tools {
namespace {

using std::chrono::milliseconds;

// How long a force is held for a reading: motors get warm.
constexpr milliseconds kReading{30'000}, kForever{-1};
constexpr unsigned kMostWrong = 5;  // lines in a row
constexpr std::size_t kLongestLine = 256;

// Lines of stdin, with a time limit: a force is held meanwhile. Ends early when that force does.
class Lines {
 public:
  enum class Got { kLine, kLate, kEnd };

  explicit Lines(const hil::HeldForce& force) : force_(force) {}

  // Drops what was typed before the question.
  void forget() {
    if (isatty(STDIN_FILENO) == 0) return;
    (void)tcflush(STDIN_FILENO, TCIFLUSH);
    waiting_.clear();
  }

  Got next(std::string& line, milliseconds longest) {
    const auto began = std::chrono::steady_clock::now();
    for (;;) {
      if (const std::size_t end = waiting_.find('\n'); end != std::string::npos) {
        line = waiting_.substr(0, end);
        waiting_.erase(0, end + 1);
        return Got::kLine;
      }
      if (g_stop.load() || waiting_.size() > kLongestLine || !force_.trouble().ok()) return Got::kEnd;
      if (longest != kForever && std::chrono::steady_clock::now() - began > longest) return Got::kLate;
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (::poll(&input, 1, 100) <= 0) continue;
      char bytes[kLongestLine];
      const ssize_t count = ::read(STDIN_FILENO, bytes, sizeof bytes);
      if (count <= 0) return Got::kEnd;
      waiting_.append(bytes, static_cast<std::size_t>(count));
    }
  }

 private:
  const hil::HeldForce& force_;
  std::string waiting_;
};

// A failure and its exit status.
struct Ended {
  std::string why;
  int exit_code{kExitBadInput};
};

class Conversation {
 public:
  explicit Conversation(const hil::HeldForce& force) : force_(force), lines_(force) {}

  // False: the input ended.
  bool wait_for_enter(const std::string& question) {
    fmt::print(stderr, "{}", question);
    lines_.forget();
    std::string line;
    return lines_.next(line, kForever) == Lines::Got::kLine;
  }

  // On failure sets `ended` and returns nullopt.
  std::optional<double> grams(const std::string& question, milliseconds longest, Ended& ended) {
    fmt::print(stderr, "{}", question);
    for (unsigned wrong = 0; wrong < kMostWrong; ++wrong) {
      std::string line;
      const Lines::Got got = lines_.next(line, longest);
      if (const Status status = force_.trouble(); !status.ok()) {
        ended = {status.message(), kExitMachineCannot};
        return std::nullopt;
      }
      if (got == Lines::Got::kLate) {
        ended = {fmt::format("no reading came within {} s, so the force was ended", longest.count() / 1000)};
        return std::nullopt;
      }
      if (got == Lines::Got::kEnd) break;
      if (const auto value = hil::parse_grams(line)) return value;
      fmt::print(stderr, "'{:.32}' is no reading; accepted: grams from -100 to 5000, such as 51: ", line);
    }
    ended = {"the input ended, or no line was a reading"};
    return std::nullopt;
  }

 private:
  const hil::HeldForce& force_;
  Lines lines_;
};

// On failure sets `ended` and returns nullopt.
std::optional<hil::GainResult> measure(hil::HeldForce& force, hil::ScaleCalibration& pushes, Ended& ended) {
  Conversation person(force);
  fmt::print(
      stderr,
      "Put the scale below the grip, with a cup or some books on it, so that the grip rests on them near the\n"
      "middle of its workspace; switch the scale on and let go of the grip. Nothing pushes before you press Enter; "
      "Ctrl-C ends it.\n");
  const auto rest_g = person.grams("What does the scale show [g]? ", kForever, ended);
  if (!rest_g) return std::nullopt;
  for (unsigned push = 1; !pushes.done(); ++push) {
    const double command_N = pushes.next_command_N();
    const std::string question =
        fmt::format("Push {} of {}: Enter pushes the grip down with {:.2f} N, if its gain is right. ", push,
                    hil::ScaleCalibration::kPushes_N.size(), command_N);
    if (!person.wait_for_enter(question)) {
      ended = {"the input ended before the last push"};
      return std::nullopt;
    }
    if (const Status status = force.push(command_N); !status.ok()) {
      ended = {status.message(), kExitMachineCannot};
      return std::nullopt;
    }
    const auto shown_g = person.grams("What does the scale show now [g]? ", kReading, ended);
    if (!shown_g) return std::nullopt;
    if (const Status status = force.push(0); !status.ok()) {
      ended = {status.message(), kExitMachineCannot};
      return std::nullopt;
    }
    if (std::string doubt = pushes.take((*shown_g - *rest_g) * hil::ScaleCalibration::kWeight_N_per_g);
        !doubt.empty()) {
      ended = {std::move(doubt), kExitVerdictBad};
      return std::nullopt;
    }
  }
  const auto after_g = person.grams("The force is off. What does the scale show [g]? ", kForever, ended);
  if (!after_g) return std::nullopt;
  return pushes.result((*after_g - *rest_g) * hil::ScaleCalibration::kWeight_N_per_g);
}

std::string date_of_today() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm date{};
  (void)gmtime_r(&now, &date);
  return fmt::format("{:04}-{:02}-{:02}", date.tm_year + 1900, date.tm_mon + 1, date.tm_mday);
}

int write_gain(const GainCalibration& c, const std::string& name, const std::string& note) {
  std::string text;
  if (std::filesystem::exists(c.out)) {
    const auto found = text::read_file(c.out, text::kMaxTomlBytes);
    if (!found) return complain_after(fmt::format("tactus hil: --out: {} cannot be read", c.out), kExitBadInput);
    text = *found;
  }
  const auto changed = hil::with_device_name(text, name, note);
  if (!changed.ok())
    return complain_after(fmt::format("tactus hil: --out: {}: {}", c.out, changed.message()), kExitBadInput);
  return write_file(c.out, changed.value());
}

int finish(const GainCalibration& c, const hil::GainResult& result) {
  const std::string name = fmt::format("{}:{}", c.choice.device_class->name,
                                       c.choice.device_class->with_force_gain(c.choice.address, result.gain_per_Nm));
  const std::string date = date_of_today();
  const bool good = result.doubt.empty();
  if (c.json)
    fmt::print("{}\n", report_text(nlohmann::ordered_json{{"gain_per_Nm", result.gain_per_Nm},
                                                          {"spread", result.spread},
                                                          {"offset_N", result.offset_N},
                                                          {"date", date},
                                                          {"device", name},
                                                          {"doubt", result.doubt},
                                                          {"good", good}},
                                   2));
  else
    fmt::print("gain {:.0f} motor values per N m, readings within {:.1f} % of a line\n", result.gain_per_Nm,
               100 * result.spread);
  if (!good) return complain_after("tactus hil: " + result.doubt + "; nothing is written", kExitVerdictBad);
  if (!c.json) fmt::print("--device {}\n", name);
  if (c.out.empty()) return kExitGood;
  const std::string note = fmt::format("{} on {}: {:.0f} motor values per N m, within {:.1f} %", hil::kMeasuredNote,
                                       date, result.gain_per_Nm, 100 * result.spread);
  if (const int exit_code = write_gain(c, name, note); exit_code != kExitGood) return exit_code;
  if (!c.json) fmt::print("{} has it\n", c.out);
  return kExitGood;
}

}  // namespace

int calibrate_gain(const GainCalibration& c) {
  stop_on_signals();
  hil::ScaleCalibration pushes(c.choice.device_class->force_gain(c.choice.address),
                               c.under_test.device.properties().max_force_N);
  Ended ended;
  std::optional<hil::GainResult> result;
  {
    hil::HeldForce force(c.under_test, {0, 0, -1});
    result = measure(force, pushes, ended);
  }
  if (result) return finish(c, *result);
  return complain("tactus hil: " + ended.why + "; nothing is written", ended.exit_code);
}

}  // namespace tactus::tools
