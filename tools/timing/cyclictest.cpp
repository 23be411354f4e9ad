#include "tools/timing/cyclictest.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <cinttypes>
#include <cstdio>

namespace tactus::timing {

std::string cyclictest_command(const CyclictestRun& run) {
  std::string command = fmt::format("exec cyclictest -v -N -m -t1 -d0 -a{} -p{} -i{:.0f} -D{}", run.cpu, run.priority,
                                    run.period_us, run.seconds);
  if (run.main_cpu >= 0) command += fmt::format(" --mainaffinity={}", run.main_cpu);
  return command + " 2>/dev/null";
}

bool add_cyclictest_line(const std::string& line, std::uint64_t skip, Histogram& wake) {
  unsigned thread = 0;
  std::uint64_t count = 0;
  std::int64_t latency_ns = 0;
  if (std::sscanf(line.c_str(), " %u: %" SCNu64 ": %" SCNd64, &thread, &count, &latency_ns) != 3) return false;
  if (count >= skip) wake.record(latency_ns);
  return true;
}

Status run_cyclictest(const CyclictestRun& run, std::uint64_t skip, Histogram& wake) {
  FILE* output = popen(cyclictest_command(run).c_str(), "re");
  if (output == nullptr) return Status::error("cyclictest: no process to be had");
  char line[256];
  std::uint64_t samples = 0;
  while (std::fgets(line, sizeof line, output) != nullptr) samples += add_cyclictest_line(line, skip, wake) ? 1 : 0;
  const int status = pclose(output);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
    return Status::error("cyclictest: no such program here; install it (Debian: rt-tests)");
  if (samples == 0)
    return Status::error("cyclictest: measured nothing; it needs the right to SCHED_FIFO and to lock memory");
  return Status::good();
}

}  // namespace tactus::timing
