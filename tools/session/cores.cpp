#include "tools/session/cores.h"

#include <fmt/format.h>

#include "rt/thread/realtime_setup.h"

namespace tactus::session {

std::vector<int> cores_without(int spare_cpu) {
  std::vector<int> cpus = loop::allowed_cpus();
  if (cpus.empty()) return {0};
  std::erase(cpus, spare_cpu);
  if (cpus.empty()) cpus.push_back(spare_cpu);
  return cpus;
}

int core_of_hand(int cpu, std::size_t hand) {
  if (cpu >= 0) return cpu;
  const std::vector<int> allowed = loop::allowed_cpus();
  return allowed.empty() ? -1 : allowed[allowed.size() - 1 - hand % allowed.size()];
}

Status check_core(std::string_view option, int cpu) {
  if (cpu < 0 || loop::may_stay_on(cpu)) return Status::good();
  return Status::error(fmt::format(
      "{}: this program cannot stay on core {}; accepted: a core that is online and in its cpuset, such as {}", option,
      cpu, core_of_hand(-1)));
}

}  // namespace tactus::session
