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

Status check_core(std::string_view option, int cpu) {
  if (cpu < 0 || loop::may_stay_on(cpu)) return Status::good();
  return Status::error(fmt::format(
      "{}: this program cannot stay on core {}; accepted: a core that is online and in its cpuset, such as {}", option,
      cpu, cores_without(-1).back()));
}

}  // namespace tactus::session
