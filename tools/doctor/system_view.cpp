#include "tools/doctor/system_view.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <pwd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

#include "rt/thread/realtime_setup.h"

namespace tactus::doctor {
namespace {

std::uint64_t hard_limit(__rlimit_resource resource) {
  rlimit limit{};
  getrlimit(resource, &limit);
  return limit.rlim_max == RLIM_INFINITY ? ~std::uint64_t{0} : std::uint64_t{limit.rlim_max};
}

ProcessFacts facts_of_this_process() {
  ProcessFacts facts;
  facts.rtprio_limit = hard_limit(RLIMIT_RTPRIO);
  facts.memlock_limit_B = hard_limit(RLIMIT_MEMLOCK);
  facts.may_set_priority = loop::has_capability(CAP_SYS_NICE);
  facts.may_lock_memory = loop::has_capability(CAP_IPC_LOCK);
  if (const std::vector<int> allowed = loop::allowed_cpus(); !allowed.empty()) {
    facts.cpus_allowed = static_cast<std::uint32_t>(allowed.size());
    facts.last_allowed_cpu = allowed.back();
  }
  const passwd* user = getpwuid(geteuid());
  facts.user = user != nullptr ? user->pw_name : std::to_string(geteuid());
  return facts;
}

// One `name value` per line; missing names keep their defaults.
Result<ProcessFacts> recorded_facts(const std::filesystem::path& file) {
  ProcessFacts facts;
  std::ifstream in(file);
  std::string name, value;
  while (in >> name >> value) {
    if (name == "user") {
      facts.user = value;
      continue;
    }
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (value == "unlimited")
      number = ~std::uint64_t{0};
    else if (error != std::errc{} || end != value.data() + value.size())
      return Status::error(file.string() + ": " + name + ": '" + value +
                           "' is no number; accepted: digits or unlimited");
    if (name == "rtprio_limit")
      facts.rtprio_limit = number;
    else if (name == "memlock_limit_B")
      facts.memlock_limit_B = number;
    else if (name == "may_set_priority")
      facts.may_set_priority = number != 0;
    else if (name == "may_lock_memory")
      facts.may_lock_memory = number != 0;
    else if (name == "cpus_allowed")
      facts.cpus_allowed = static_cast<std::uint32_t>(number);
    else if (name == "last_allowed_cpu")
      facts.last_allowed_cpu = static_cast<int>(number);
    else
      return Status::error(file.string() + ": no such fact: " + name +
                           "; accepted: rtprio_limit, memlock_limit_B, may_set_priority, may_lock_memory, "
                           "cpus_allowed, last_allowed_cpu, user");
  }
  return facts;
}

}  // namespace

Result<SystemView> SystemView::open(const std::filesystem::path& root) {
  SystemView view;
  view.root_ = root.lexically_normal();
  if (view.is_this_machine()) {
    view.process_ = facts_of_this_process();
    return view;
  }
  std::error_code error;
  if (!std::filesystem::is_directory(root, error))
    return Status::error(root.string() +
                         ": no such folder; accepted: a recorded tree with proc, sys and process in it");
  auto facts = recorded_facts(root / "process");
  if (!facts.ok()) return facts.status();
  view.process_ = std::move(facts).value();
  return view;
}

std::filesystem::path SystemView::at(const std::string& path) const {
  return root_ / std::filesystem::path(path).relative_path();
}

std::optional<std::string> SystemView::read(const std::string& path) const {
  std::ifstream in(at(path));
  if (!in) return std::nullopt;
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad()) return std::nullopt;
  std::string out = std::move(text).str();
  while (!out.empty() && (out.back() == '\n' || out.back() == '\0')) out.pop_back();
  return out;
}

std::vector<std::string> SystemView::list(const std::string& path) const {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator it(at(path), error), end; !error && it != end; it.increment(error))
    names.push_back(it->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

bool SystemView::exists(const std::string& path) const {
  std::error_code error;
  return std::filesystem::exists(at(path), error);
}

bool SystemView::writable(const std::string& path) const { return access(at(path).c_str(), W_OK) == 0; }

std::optional<std::uint64_t> SystemView::read_word(const std::string& path, std::uint64_t offset) const {
  const int file = ::open(at(path).c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  std::uint64_t word = 0;
  const ssize_t got = pread(file, &word, sizeof word, static_cast<off_t>(offset));
  close(file);
  if (got != sizeof word) return std::nullopt;
  return word;
}

std::optional<std::vector<int>> parse_cpu_list(const std::string& text) {
  std::vector<int> cpus;
  std::stringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    int first = 0;
    const char* end = part.data() + part.size();
    auto read = std::from_chars(part.data(), end, first);
    int last = first;
    if (read.ec == std::errc{} && read.ptr != end && *read.ptr == '-') read = std::from_chars(read.ptr + 1, end, last);
    if (read.ec != std::errc{} || read.ptr != end || first < 0 || last < first || last > 65535) return std::nullopt;
    for (int cpu = first; cpu <= last; ++cpu) cpus.push_back(cpu);
  }
  return cpus;
}

}  // namespace tactus::doctor
