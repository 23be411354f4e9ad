#include "tools/service/configuration.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "hal/device_class.h"
#include "rt/haptics/coupling/snapshot.h"
#include "rt/text/read_file.h"
#include "rt/text/table_reader.h"
#include "sim/model/choice_names.h"
#include "sim/model/scene.h"
#include "sim/worker_pool.h"
#include "tools/doctor/system_view.h"

namespace tactus::service {
namespace {

constexpr std::size_t kLongestText = 1024;
constexpr std::size_t kLongestSocket = 107;  // limit of sockaddr_un

template <class T>
text::Range range_of(const char* noun, const session::Range<T>& range) {
  return {noun, static_cast<double>(range.least), static_cast<double>(range.most)};
}

class ConfigurationReader {
 public:
  ConfigurationReader(const text::TomlNode& root, Configuration& into, std::filesystem::path folder,
                      const std::optional<std::vector<int>>& cores, text::Diagnostics& diagnostics)
      : root_(&root, "", diagnostics), c_(into), folder_(std::move(folder)), cores_(cores), diagnostics_(diagnostics) {}

  void read() {
    root_.require("scene", "the path of a scene file");
    c_.run.scene = path(root_, "scene");
    read_device();
    read_rates();
    read_cores();
    read_limits();
    read_control();
    text::TableReader log = table("log");
    c_.log_interval_s = log.number("interval_s", c_.log_interval_s, {"an interval", 0.1, 3600});
    log.finish();
    root_.finish();
    for (const std::string& mistake : mistakes_of_options())
      diagnostics_.add(
          {.where = "the file", .what = "does not go together: " + mistake, .accepted = "see tactus run --help"});
  }

 private:
  text::TableReader table(const char* key) { return {root_.table(key), fmt::format("[{}]", key), diagnostics_}; }

  std::filesystem::path path(text::TableReader& t, const char* key) {
    const std::string text = t.text(key, "", kLongestText);
    return text.empty() ? std::filesystem::path() : folder_ / text;
  }

  // Reports an invalid name at its line and continues with `otherwise`.
  std::string device_name(text::TableReader& t, const std::string& otherwise) {
    const std::string name = t.text("name", otherwise, kLongestText), mistake = hal::device_mistake(name);
    if (mistake.empty()) return name;
    t.mistake("name", mistake, hal::accepted_devices());
    return otherwise;
  }

  void read_device() {
    const std::span<const text::TomlNode> tables = root_.tables("device", sim::kMaxHands);
    if (tables.size() > 1) return read_devices(tables);
    text::TableReader t(tables.empty() ? nullptr : &tables.front(), "[device]", diagnostics_);
    c_.run.device = device_name(t, c_.run.device);
    c_.run.device_file = path(t, "file");
    c_.run.gpio = t.text("gpio", "", kLongestText);
    t.refuse("core", "is of several devices", "[cores] haptic");
    t.finish();
  }

  void read_devices(std::span<const text::TomlNode> tables) {
    for (const text::TomlNode& node : tables) {
      text::TableReader t(&node, fmt::format("[device.{}]", c_.devices.size() + 1), diagnostics_);
      ConfiguredDevice choice;
      choice.name = device_name(t, choice.name);
      choice.file = path(t, "file");
      const unsigned core = t.count("core", 0, range_of("a core", session::kCores));
      if (t.has("core")) choice.core = static_cast<int>(core);
      if (t.has("core")) must_be_there(t, "core", choice.core);
      if (c_.devices.empty())
        c_.run.gpio = t.text("gpio", "", kLongestText);
      else
        t.refuse("gpio", "the lines are of all hands", "gpio of the first [[device]]");
      t.finish();
      c_.devices.push_back(std::move(choice));
    }
    c_.run.device = c_.devices.front().name;
    c_.run.device_file = c_.devices.front().file;
  }

  // Those of the options of each device, each once.
  std::vector<std::string> mistakes_of_options() const {
    std::vector<std::string> all = option_mistakes(c_.run);
    for (const ConfiguredDevice& choice : c_.devices) {
      session::RunOptions own = c_.run;
      own.device = choice.name;
      own.device_file = choice.file;
      for (std::string& mistake : option_mistakes(own))
        if (std::find(all.begin(), all.end(), mistake) == all.end()) all.push_back(std::move(mistake));
    }
    return all;
  }

  void read_rates() {
    text::TableReader t = table("rates");
    c_.run.rate_Hz = t.number("rate_Hz", c_.run.rate_Hz, range_of("a rate", session::kRates_Hz));
    const unsigned ratio = t.count("ratio", 10, range_of("a ratio", session::kRatios));
    if (t.has("ratio")) c_.run.ratio = ratio;
    t.finish();
  }

  void read_cores() {
    text::TableReader t = table("cores");
    const unsigned core = t.count("haptic", 0, range_of("a core", session::kCores));
    if (c_.devices.size() > 1) t.refuse("haptic", "is of one hand", "core in each [[device]]");
    if (t.has("haptic")) c_.run.cpu = static_cast<int>(core);
    if (t.has("haptic")) must_be_there(t, "haptic", c_.run.cpu);
    c_.run.priority = static_cast<int>(
        t.count("priority", static_cast<unsigned>(c_.run.priority), range_of("a priority", session::kPriorities)));
    c_.run.world_threads = t.count("world_threads", 1, {"a number of threads", 1, sim::kMaxWorldThreads});
    const auto cpus = doctor::parse_cpu_list(t.text("world", "", kLongestText));
    if (cpus)
      c_.run.world_cpus = *cpus;
    else
      t.mistake("world", "is no list of cores", "numbers of cores, such as \"2\" or \"1,3-4\"");
    for (const int cpu : c_.run.world_cpus) must_be_there(t, "world", cpu);
    t.finish();
  }

  void must_be_there(text::TableReader& t, const char* key, int cpu) {
    if (!cores_ || std::find(cores_->begin(), cores_->end(), cpu) != cores_->end()) return;
    t.mistake(key, fmt::format("this machine has no core {}", cpu), fmt::format("one of {}", fmt::join(*cores_, ", ")));
  }

  void read_limits() {
    text::TableReader t = table("limits");
    const unsigned members = t.count("members", 64, {"a number of members", 1, haptics::kMaxMembers});
    if (t.has("members")) c_.run.members = members;
    c_.budget = path(t, "budget");
    t.finish();
  }

  void read_control() {
    text::TableReader t = table("control");
    c_.socket = t.text("socket", "", kLongestText);
    if (!c_.socket.empty() && (!c_.socket.is_absolute() || c_.socket.native().size() > kLongestSocket))
      t.mistake("socket", fmt::format("'{:.64}' is no place for a socket", c_.socket.string()),
                fmt::format("an absolute path of up to {} characters, such as /run/tactus/control", kLongestSocket));
    c_.run.arm_at_start = t.flag("arm_at_start", false);  // the motors move only on request
    c_.run.rearm = t.flag("rearm", c_.run.rearm);
    t.finish();
  }

  text::TableReader root_;
  Configuration& c_;
  std::filesystem::path folder_;
  const std::optional<std::vector<int>>& cores_;
  text::Diagnostics& diagnostics_;
};

}  // namespace

ConfigurationReading read_configuration(std::string_view text, std::string_view name,
                                        const std::optional<std::vector<int>>& cores) {
  text::Diagnostics diagnostics;
  diagnostics.name = std::string(name);
  ConfigurationReading reading;
  text::TomlNode root;
  if (text.size() > kMaxConfigurationBytes)
    diagnostics.add({.where = "the file",
                     .what = fmt::format("longer than {} bytes", kMaxConfigurationBytes),
                     .accepted = "a configuration"});
  else if (text::read_toml(text, root, diagnostics))
    ConfigurationReader(root, reading.configuration, std::filesystem::path(name).parent_path(), cores, diagnostics)
        .read();
  if (!diagnostics.ok()) reading.mistakes = diagnostics.message();
  return reading;
}

ConfigurationReading read_configuration(const std::filesystem::path& path,
                                        const std::optional<std::vector<int>>& cores) {
  const auto text = text::read_file(path, kMaxConfigurationBytes);
  if (!text)
    return {{},
            path.string() +
                ": the file: cannot be read; accepted: the path of a configuration, such as "
                "/etc/tactus/tactus.toml"};
  return read_configuration(*text, path.string(), cores);
}

Result<Configuration> parse_configuration(std::string_view text, std::string_view name) {
  const ConfigurationReading reading = read_configuration(text, name, std::nullopt);
  if (!reading.mistakes.empty()) return Status::error(reading.mistakes);
  return reading.configuration;
}

Result<Configuration> load_configuration(const std::filesystem::path& path) {
  const ConfigurationReading reading = read_configuration(path, std::nullopt);
  if (!reading.mistakes.empty()) return Status::error(reading.mistakes);
  return reading.configuration;
}

std::string needs_restart(const Configuration& before, const Configuration& after) {
  std::string keys;
  const auto compare = [&](const char* key, bool same) {
    if (!same) keys += (keys.empty() ? "" : ", ") + std::string(key);
  };
  const session::RunOptions &a = before.run, &b = after.run;
  compare("scene", a.scene == b.scene);
  compare("[device]", a.device == b.device && a.device_file == b.device_file && a.gpio == b.gpio &&
                          before.devices == after.devices);
  compare("[rates]", a.rate_Hz == b.rate_Hz && a.ratio == b.ratio);
  compare("[cores]", a.cpu == b.cpu && a.priority == b.priority && a.world_threads == b.world_threads &&
                         a.world_cpus == b.world_cpus);
  compare("[limits]", a.members == b.members && before.budget == after.budget);
  compare("[control] socket", before.socket == after.socket);
  compare("[control] arm_at_start", a.arm_at_start == b.arm_at_start);
  return keys;
}

}  // namespace tactus::service
