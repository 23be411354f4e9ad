#include "tools/session/stolen_time.h"

#include <sstream>

#include "rt/text/read_file.h"

namespace tactus::session {

// Columns: user nice system idle iowait irq softirq steal, then guest times, which user and nice already include.
std::optional<CpuTime> cpu_time(const std::string& proc_stat, int cpu) {
  const std::string wanted = cpu < 0 ? "cpu" : "cpu" + std::to_string(cpu);
  std::istringstream lines(proc_stat);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    if (!(words >> name) || name != wanted) continue;
    CpuTime time;
    for (int column = 0; column < 8; ++column) {
      std::uint64_t ticks = 0;
      if (!(words >> ticks)) return std::nullopt;
      time.all += ticks;
      time.stolen = ticks;  // the eighth column read is `steal`
    }
    return time;
  }
  return std::nullopt;
}

std::optional<CpuTime> cpu_time_now(int cpu) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  return cpu_time(text::read_file("/proc/stat", kMaxBytes).value_or(""), cpu);
}

std::optional<double> stolen_share(const std::optional<CpuTime>& before, const std::optional<CpuTime>& after) {
  if (!before || !after || after->all <= before->all || after->stolen < before->stolen) return std::nullopt;
  return static_cast<double>(after->stolen - before->stolen) / static_cast<double>(after->all - before->all);
}

}  // namespace tactus::session
