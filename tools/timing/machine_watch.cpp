#include "tools/timing/machine_watch.h"

#include <unistd.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "rt/base/clock.h"
#include "rt/text/read_file.h"
#include "tools/session/stolen_time.h"

namespace tactus::timing {
namespace {

constexpr std::size_t kMaxProcBytes = 1 << 20;

std::string text_of(const std::string& path) { return text::read_file(path, kMaxProcBytes).value_or(""); }

template <class T>
std::optional<T> difference(const std::optional<T>& before, const std::optional<T>& after) {
  if (!before || !after || *after < *before) return std::nullopt;
  return *after - *before;
}

std::optional<InterruptCounts> difference(const std::optional<InterruptCounts>& before,
                                          const std::optional<InterruptCounts>& after) {
  if (!before || !after) return std::nullopt;
  return InterruptCounts{after->timer - before->timer, after->devices - before->devices,
                         after->kernel - before->kernel};
}

}  // namespace

// The columns are the cores that are online, in the order of the first line.
std::optional<InterruptCounts> parse_interrupts(const std::string& proc_interrupts, int cpu) {
  std::istringstream lines(proc_interrupts);
  std::string line, word;
  if (!std::getline(lines, line)) return std::nullopt;
  std::size_t column = 0, columns = 0;
  std::istringstream heads(line);
  const std::string wanted = "CPU" + std::to_string(cpu);
  bool found = false;
  while (heads >> word) {
    if (word == wanted) {
      column = columns;
      found = true;
    }
    ++columns;
  }
  if (!found) return std::nullopt;
  InterruptCounts counts;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string name;
    if (!(words >> name)) continue;
    std::uint64_t value = 0;
    bool there = true;
    for (std::size_t i = 0; i <= column && there; ++i) there = static_cast<bool>(words >> value);
    if (!there) continue;  // ERR and MIS have one number for all cores
    if (name == "LOC:")
      counts.timer += value;
    else if (name.front() >= '0' && name.front() <= '9')
      counts.devices += value;
    else
      counts.kernel += value;
  }
  return counts;
}

std::optional<std::uint64_t> parse_wait_ns(const std::string& schedstat) {
  std::istringstream words(schedstat);
  std::uint64_t ran_ns = 0, waited_ns = 0;
  if (!(words >> ran_ns >> waited_ns)) return std::nullopt;
  return waited_ns;
}

void MachineHistory::add(const MachineLook& look) {
  looks_.push_back(look);
  if (looks_.size() > kKept) looks_.pop_front();
}

std::optional<MachineChange> MachineHistory::around(std::int64_t from_ns, std::int64_t to_ns) const {
  const MachineLook *before = nullptr, *after = nullptr;
  for (const MachineLook& look : looks_) {
    if (look.at_ns <= from_ns) before = &look;
    if (look.at_ns >= to_ns && after == nullptr) after = &look;
  }
  if (before == nullptr || after == nullptr) return std::nullopt;
  MachineChange change{.span_ns = after->at_ns - before->at_ns,
                       .interrupts = difference(before->interrupts, after->interrupts),
                       .stolen_ms = difference(before->stolen_ms, after->stolen_ms),
                       .waited_ns = difference(before->waited_ns, after->waited_ns)};
  for (const MachineLook& look : looks_) {
    if (look.at_ns < from_ns || look.at_ns > after->at_ns || !look.noise) continue;
    if (!change.noise) change.noise.emplace();
    for (Noise noise : *look.noise) {
      const std::int64_t end_ns = std::min(noise.from_ns + noise.duration_ns, to_ns);
      noise.from_ns = std::max(noise.from_ns, from_ns);
      noise.duration_ns = end_ns - noise.from_ns;
      if (noise.duration_ns > 0) change.noise->push_back(std::move(noise));
    }
  }
  return change;
}

MachineLook look_at_machine(int cpu, int thread_id) {
  MachineLook look;
  look.interrupts = parse_interrupts(text_of("/proc/interrupts"), cpu);
  if (const auto time = session::cpu_time_now(cpu))
    look.stolen_ms = time->stolen * 1000 / static_cast<std::uint64_t>(sysconf(_SC_CLK_TCK));
  if (thread_id > 0)
    look.waited_ns = parse_wait_ns(text_of("/proc/self/task/" + std::to_string(thread_id) + "/schedstat"));
  look.at_ns = MonotonicClock::now_ns();  // after reading the counts, which are therefore older
  return look;
}

}  // namespace tactus::timing
