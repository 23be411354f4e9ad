#include "tools/timing/budget.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "rt/base/hash.h"
#include "rt/text/read_file.h"
#include "tools/json_text.h"
#include "tools/version/provenance.h"

namespace tactus::timing {
namespace {

using nlohmann::ordered_json;

constexpr unsigned kFormat = 2;

std::string line_of(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::string seal_of(const ordered_json& unsealed) {
  Fnv1a hash;
  hash.add_text(json_text(unsealed));
  return fmt::format("{:016x}", hash.value());
}

ordered_json buckets_json(const Histogram& h) {
  ordered_json list = ordered_json::array();
  for (std::uint32_t i = 0; i < Histogram::kBuckets; ++i)
    if (h.in_bucket(i) > 0) list.push_back({Histogram::upper_bound_ns(i), h.in_bucket(i)});
  return list;
}

// The first property that differs; empty: same machine.
std::string other_machine(const Machine& certified, const Machine& here) {
  const auto differs = [](const char* what, const std::string& then, const std::string& now) {
    return fmt::format("it was measured on the {} '{}', here it is '{}'", what, then, now);
  };
  if (certified.cpu_model != here.cpu_model) return differs("CPU", certified.cpu_model, here.cpu_model);
  if (certified.cores != here.cores)
    return differs("number of cores", std::to_string(certified.cores), std::to_string(here.cores));
  if (certified.kernel != here.kernel) return differs("kernel", certified.kernel, here.kernel);
  if (certified.boot_line != here.boot_line) return differs("boot line", certified.boot_line, here.boot_line);
  if (certified.governor != here.governor) return differs("frequency governor", certified.governor, here.governor);
  return "";
}

}  // namespace

Machine this_machine(int cpu) {
  utsname kernel{};
  uname(&kernel);
  return {.cpu_model = cpu_model(),
          .kernel = fmt::format("{} {}", kernel.release, kernel.version),
          .boot_line = line_of("/proc/cmdline"),
          .governor = line_of(fmt::format("/sys/devices/system/cpu/cpu{}/cpufreq/scaling_governor", cpu)),
          .cores = static_cast<unsigned>(sysconf(_SC_NPROCESSORS_ONLN))};
}

std::string budget_text(const TimingResult& r, const Machine& machine) {
  if (r.verdict() == TimingVerdict::kBad) return {};
  const double period_us = 1e6 / r.options.run.rate_Hz;
  const double worst_us = static_cast<double>(r.statistics.compute.max_ns()) * 1e-3;
  const Histogram& wake = r.statistics.stages[static_cast<std::size_t>(TimedStage::kWake)];
  ordered_json j{{"tactus", "budget"},
                 {"format", kFormat},
                 {"machine",
                  {{"cpu_model", machine.cpu_model},
                   {"cores", machine.cores},
                   {"kernel", machine.kernel},
                   {"boot_line", machine.boot_line},
                   {"governor", machine.governor}}},
                 {"settings",
                  {{"cpu", r.options.run.cpu},
                   {"priority", r.options.run.priority},
                   {"rate_Hz", r.options.run.rate_Hz},
                   {"members", r.statistics.members_max},
                   {"sub_steps", r.options.sub_steps},
                   {"ratio", r.options.ratio}}},
                 {"verdict", name_of(r.verdict())},
                 {"degraded", r.summary.degraded()},
                 {"ticks", r.statistics.ticks},
                 {"contacts", r.statistics.contacts_max},
                 {"border_contacts", r.statistics.border_max},
                 {"computing_worst_us", worst_us},
                 {"computing_p99_99_us", static_cast<double>(r.statistics.compute.percentile_ns(99.99)) * 1e-3},
                 {"margin", std::max(0.0, 1 - worst_us / period_us)},
                 {"wake_p50_us", static_cast<double>(wake.percentile_ns(50)) * 1e-3},
                 {"wake_p99_9_us", static_cast<double>(wake.percentile_ns(99.9)) * 1e-3},
                 {"wake_worst_us", static_cast<double>(wake.max_ns()) * 1e-3},
                 {"computing_histogram_upper_ns_count", buckets_json(r.statistics.compute)}};
  for (const auto& step : r.summary.setup.steps) j["setup"][step.name] = step.ok;
  j["seal"] = seal_of(j);
  return json_text(j, 1) + "\n";
}

Result<Budget> read_budget(const std::string& text, const std::string& name) {
  const auto bad = [&](const std::string& what) {
    return Status::error(fmt::format("{}: {}; accepted: a file that `tactus timing --certify` wrote", name, what));
  };
  ordered_json j = ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (j.is_discarded() || !j.is_object() || j.value("tactus", ordered_json()) != "budget") return bad("is no budget");
  if (j.value("format", ordered_json()) != kFormat) return bad("has another format");
  const ordered_json seal = j.value("seal", ordered_json());
  j.erase("seal");
  if (!seal.is_string() || seal.get<std::string>() != seal_of(j)) return bad("was changed after it was signed off");
  // A valid seal means that this program wrote the text, so every key exists.
  Budget budget;
  const ordered_json& machine = j["machine"];
  budget.machine = {.cpu_model = machine["cpu_model"],
                    .kernel = machine["kernel"],
                    .boot_line = machine["boot_line"],
                    .governor = machine["governor"],
                    .cores = machine["cores"]};
  const ordered_json& settings = j["settings"];
  budget.rate_Hz = settings["rate_Hz"];
  budget.members = settings["members"];
  budget.sub_steps = settings["sub_steps"];
  budget.priority = settings["priority"];
  budget.worst_us = j["computing_worst_us"];
  budget.margin = j["margin"];
  budget.wake_p50_us = j["wake_p50_us"];
  budget.wake_p99_9_us = j["wake_p99_9_us"];
  budget.wake_worst_us = j["wake_worst_us"];
  budget.verdict = j["verdict"];
  return budget;
}

Result<Budget> load_budget(const std::string& path) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  const auto text = text::read_file(path, kMaxBytes);
  if (!text || text->size() > kMaxBytes)
    return Status::error(fmt::format("{}: {}; accepted: a file of `tactus timing --certify`", path,
                                     text ? "more than 1 MB" : "cannot be read"));
  return read_budget(*text, path);
}

BudgetAnswer check_budget(const Budget& budget, const Machine& machine, const BudgetRequest& request) {
  BudgetAnswer answer;
  const auto refuse = [&](const std::string& why) {
    answer.refusal = why + "; measure again with `tactus timing --certify`, or run without --budget";
    return answer;
  };
  if (const std::string other = other_machine(budget.machine, machine); !other.empty())
    return refuse("the budget is not this machine's: " + other);
  if (budget.verdict != "good")
    return refuse(fmt::format("the budget was signed off with the verdict '{}'", budget.verdict));
  if (request.rate_Hz > budget.rate_Hz)
    return refuse(fmt::format("{:g} Hz are asked for, {:g} Hz were measured", request.rate_Hz, budget.rate_Hz));
  if (request.sub_steps > budget.sub_steps)
    return refuse(fmt::format("{} sub-steps are asked for, {} were measured", request.sub_steps, budget.sub_steps));
  if (request.priority < budget.priority)
    return refuse(fmt::format("priority {} is asked for, {} was measured", request.priority, budget.priority));
  if (request.members > budget.members) {
    answer.fewer_members = budget.members;
    answer.note = fmt::format("budget: {} members are asked for, {} were measured: runs with {}", request.members,
                              budget.members, budget.members);
  }
  return answer;
}

}  // namespace tactus::timing
