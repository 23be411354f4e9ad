// tactus run SCENE: runs a scene in real or virtual time.
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "sim/model/choice_names.h"
#include "tactus/tactus.h"
#include "tools/doctor/system_view.h"
#include "tools/json_report.h"
#include "tools/library/access.h"
#include "tools/publication/publication.h"
#include "tools/service/run_service.h"
#include "tools/session/realtime_run.h"
#include "tools/tactus/commands.h"
#include "tools/timing/budget.h"

namespace tactus::tools {
namespace {

constexpr double kDefaultVirtual_s = 10;

std::atomic<bool> g_stop{false};  // set by SIGINT and SIGTERM
void ask_to_stop(int) { g_stop.store(true); }

struct RunCommand {
  Options options;
  double duration_s{0};
  bool virtual_time{false};
  std::string world_cpus;
  std::filesystem::path scene, record, budget, config, control;
  service::Configuration configuration;
  bool json{false};
};

// Converts an error of the library to an exit status, by its kind.
int complain_of(const Error& error) {
  if (error.kind() == Error::Kind::kFile) return complain_of_each(error.message(), kExitBadInput);
  return complain("tactus run: " + error.message(),
                  error.kind() == Error::Kind::kMachine ? kExitMachineCannot : kExitBadInput);
}

Error complete_options(RunCommand& command) {
  Options& o = command.options;
  const auto wrong = [](std::string text) { return Error(Error::Kind::kOption, std::move(text)); };
  const auto world_cpus = doctor::parse_cpu_list(command.world_cpus);
  if (!world_cpus)
    return wrong(
        fmt::format("--world-cpu: '{}' is none; accepted: numbers of cores, such as 2 or 1,3-4", command.world_cpus));
  o.world_cpus = *world_cpus;
  o.real_time = !command.virtual_time;
  if (command.virtual_time && command.duration_s == 0) command.duration_s = kDefaultVirtual_s;
  if (command.virtual_time && !command.control.empty())
    return wrong("--control: a virtual clock waits for nobody; accepted: without --virtual-time");
  return library::Access::check(o, command.duration_s);
}

// On a terminal the next line overwrites this one.
void show_live(const session::LiveStatus& live, double elapsed_s, bool terminal, std::uint64_t& last_ticks,
               double& last_s) {
  const std::uint64_t ticks = live.ticks.load(std::memory_order_relaxed);
  const double rate_Hz = elapsed_s > last_s ? static_cast<double>(ticks - last_ticks) / (elapsed_s - last_s) : 0;
  last_ticks = ticks;
  last_s = elapsed_s;
  const std::uint32_t status = live.status.load(std::memory_order_relaxed);
  std::string notes;
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    const auto name = name_of(static_cast<StatusBit>(1u << bit));
    if (((status >> bit) & 1u) != 0 && !name.empty()) notes += fmt::format(" {}", name);
  }
  const auto fault = static_cast<Fault>(live.fault.load(std::memory_order_relaxed));
  if (fault != Fault::kNone) notes = fmt::format(" FAULT {} (Enter re-arms)", static_cast<unsigned>(fault));
  fmt::print(stderr,
             "{}{:6.1f} s {:5.0f} Hz  force {:5.2f} N  members {:3}  contacts {:3}  border {:3}  overruns {} |{:.80}{}",
             terminal ? "\r\033[K" : "", elapsed_s, rate_Hz, live.force_N.load(std::memory_order_relaxed),
             live.members.load(std::memory_order_relaxed), live.contacts.load(std::memory_order_relaxed),
             live.border.load(std::memory_order_relaxed), live.overruns.load(std::memory_order_relaxed), notes,
             terminal ? "" : "\n");
}

// Requests by Enter, or r and Enter; none if standard input is closed.
std::uint32_t asked_on_keyboard() {
  pollfd in{STDIN_FILENO, POLLIN, 0};
  if (isatty(STDIN_FILENO) == 0 || poll(&in, 1, 0) <= 0 || (in.revents & POLLIN) == 0) return 0;
  char line[256];
  const ssize_t count = read(STDIN_FILENO, line, sizeof line);
  if (count <= 0) return 0;
  return line[0] == 'r' ? loop::kReset : loop::kRearm;
}

// What watchers of this run see; null, and said, where the machine has no such memory.
std::shared_ptr<publication::Publication> make_publication(session::Session& session) {
  auto made = publication::Publication::create(
      session.scene, session.options.period_s(),
      to_tape_text(session.options, session.device->properties(), session.scene.name, session.scene.source));
  if (!made.ok()) {
    fmt::print(stderr, "tactus run: nobody can watch: {}\n", made.message());
    return nullptr;
  }
  std::shared_ptr<publication::Publication> publication = std::move(made).value();
  session.shown = {publication->tap(), &publication->watchers(), publication};
  return publication;
}

// With a configuration it is a service: events in a log instead of a status line.
Result<session::RunSummary> run_in_real_time(session::Session& session, const RunCommand& command) {
  const bool json = command.json, logged = !command.config.empty();
  std::shared_ptr<publication::Publication> publication;  // the service's watchers are of it
  std::unique_ptr<service::RunService> service;
  session::RealtimeHooks hooks;
  if (logged || !command.control.empty()) {
    service::Configuration configuration = command.configuration;
    if (!command.control.empty()) configuration.socket = command.control;
    service::Watchable watchable;
    if (!configuration.socket.empty()) publication = make_publication(session);
    if (publication != nullptr) {
      watchable = {publication->descriptor(), &publication->watchers()};
      hooks.taps.stepped = &publication::Publication::stepped;
      hooks.taps.context = publication.get();
    }
    auto opened = service::RunService::open(configuration, command.config, g_stop, session.global != nullptr,
                                            {session.options.scene, sim::source_hash(session.scene.source)}, watchable);
    if (!opened.ok()) return opened.status();
    service = std::move(opened).value();
  }
  // Also without a tape: a fault saves the last seconds.
  session.options.record = command.record;
  if (const Status status = session.record(command.record.string()); !status.ok()) return status;
  session.options.duration_s = command.duration_s;
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  std::signal(SIGPIPE, SIG_IGN);  // the run continues if the reader of the status lines ends
  const bool terminal = isatty(STDERR_FILENO) != 0 && !logged;
  std::uint64_t last_ticks = 0;
  double last_s = 0, next_line_s = 0;
  std::uint64_t faults_told = 0;
  if (service != nullptr) hooks.requests = &service->requests();
  hooks.show = [&](const session::LiveStatus& live, double elapsed_s) {
    if (service != nullptr) service->look(live, elapsed_s);
    if (logged) return true;
    // Printed in full on its own line when it latches; the status line only shows its number.
    const std::uint64_t faults = live.fault_count.load(std::memory_order_relaxed);
    const std::string fault = fault_line(live);
    if (!fault.empty() && faults > faults_told) {
      fmt::print(stderr, "{}tactus run: FAULT at {:.1f} s: {}\n", terminal ? "\r\033[K" : "", elapsed_s, fault);
      faults_told = faults;
    }
    // On a terminal the line moves; in a log it comes every two seconds.
    if (terminal || (!json && elapsed_s >= next_line_s)) {
      show_live(live, elapsed_s, terminal, last_ticks, last_s);
      next_line_s += 2;
    }
    return true;
  };
  hooks.asked = asked_on_keyboard;
  hooks.say = [&](const std::string& line) {
    if (service != nullptr) service->say(line);
    if (!logged) fmt::print(stderr, "{}tactus run: {}\n", terminal ? "\r\033[K" : "", line);
  };
  auto summary = session::run_realtime(session, hooks, g_stop);
  if (terminal) fmt::print(stderr, "\r\033[K");
  return summary;
}

Result<session::RunSummary> run_in_virtual_time(Session& session, const RunCommand& command) {
  constexpr std::uint64_t kStride = 50;  // ticks between two progress checks
  if (!command.record.empty())
    if (const Error error = session.record(command.record)) return Status::error(error.message());
  const auto ticks = static_cast<std::uint64_t>(std::llround(command.duration_s * command.options.rate_Hz));
  const bool terminal = isatty(STDERR_FILENO) != 0;
  while (session.ticks_done() < ticks && !g_stop.load(std::memory_order_relaxed)) {
    if (const Error error = session.step(std::min(kStride, ticks - session.ticks_done())))
      return Status::error(error.message());
    if (terminal && session.ticks_done() % 500 == 0)
      fmt::print(stderr, "\r\033[Kvirtual time {:.1f} of {:.1f} s", session.time_s(), command.duration_s);
  }
  if (terminal) fmt::print(stderr, "\r\033[K");
  return library::Access::summary(session);
}

// Compares the run with the budget measured on this machine; may lower the cap of members.
int keep_budget(RunCommand& command, const sim::Scene& scene) {
  if (command.budget.empty()) return kExitGood;
  Options& o = command.options;
  if (command.virtual_time)
    return complain("tactus run: --budget: is of real time; accepted: without --virtual-time", kExitBadInput);
  const auto budget = timing::load_budget(command.budget.string());
  if (!budget.ok()) return complain("tactus run: --budget: " + budget.message(), kExitBadInput);
  const unsigned members = o.members != 0 ? o.members : scene.members;
  const int cpu = o.cpu >= 0 ? o.cpu : timing::cores_without(-1).back();
  const auto answer = timing::check_budget(budget.value(), timing::this_machine(cpu),
                                           {o.rate_Hz, members, scene.solver.sub_steps, o.priority});
  if (!answer.refusal.empty()) return complain("tactus run: --budget: " + answer.refusal, kExitMachineCannot);
  if (answer.fewer_members) o.members = *answer.fewer_members;
  o.late_s = 1e-6 * budget.value().wake_p99_9_us;
  if (!answer.note.empty()) fmt::print(stderr, "tactus run: {}\n", answer.note);
  return kExitGood;
}

// Applies the configuration where no option overrides it.
Status read_configuration(const CLI::App& app, RunCommand& command) {
  if (command.config.empty()) return Status::good();
  auto read = service::load_configuration(command.config);
  if (!read.ok()) return read.status();
  command.configuration = std::move(read).value();
  const session::RunOptions& from = command.configuration.run;
  Options& o = command.options;
  const auto given = [&](const char* option) { return app.count(option) > 0; };
  if (!given("SCENE")) command.scene = from.scene;
  if (!given("--device")) o.device = from.device;
  if (!given("--device-file")) o.device_file = from.device_file;
  if (!given("--gpio")) o.gpio = from.gpio;
  if (!given("--rate")) o.rate_Hz = from.rate_Hz;
  if (!given("--ratio")) o.ratio = from.ratio;
  if (!given("--members")) o.members = from.members;
  if (!given("--cpu")) o.cpu = from.cpu;
  if (!given("--priority")) o.priority = from.priority;
  if (!given("--world-threads")) o.world_threads = from.world_threads;
  if (!given("--world-cpu")) command.world_cpus = fmt::format("{}", fmt::join(from.world_cpus, ","));
  if (!given("--budget")) command.budget = command.configuration.budget;
  o.arm_at_start = from.arm_at_start;
  return Status::good();
}

int run_scene(const CLI::App& app, RunCommand& command) {
  if (const Status status = read_configuration(app, command); !status.ok())
    return complain_of_each(status.message(), kExitBadInput);
  if (command.scene.empty())
    return complain("tactus run: SCENE is required; accepted: see tactus run --help", kExitBadInput);
  if (const Error error = complete_options(command)) return complain_of(error);
  Scene scene;
  if (const Error error = scene.load(command.scene)) return complain_of(error);
  for (const std::string& line : scene.warnings()) fmt::print(stderr, "{}\n", line);
  if (const int exit_code = keep_budget(command, library::Access::scene(scene)); exit_code != kExitGood)
    return exit_code;
  Session session;
  if (const Error error = library::Access::open(session, scene, command.options)) return complain_of(error);
  session::Session& inner = library::Access::session(session);
  const std::string lowered = lowered_text(inner.summary().gains);
  if (!lowered.empty())
    fmt::print(stderr, "tactus run: {}: the most that --coupling {} bears at ratio {}\n", lowered,
               command.options.coupling, inner.ratio);
  auto summary = command.virtual_time ? run_in_virtual_time(session, command) : run_in_real_time(inner, command);
  if (!summary.ok()) return complain("tactus run: " + summary.message(), kExitMachineCannot);
  if (command.json) {
    auto object = to_json(summary.value());
    object["scene_warnings"] = scene.warnings();
    fmt::print("{}\n", report_text(object, 2));
  } else {
    fmt::print("{}", to_text(summary.value()));
  }
  // A service stopped on request exits with success; its log contains the faults of the run.
  if (!command.config.empty() && g_stop.load(std::memory_order_relaxed)) return kExitGood;
  return summary.value().exit_code();
}

void add_options(CLI::App& app, RunCommand& command) {
  Options& o = command.options;
  app.add_option("SCENE", command.scene, "the scene, such as sim/scenes/card_house.toml; or --config names it");
  app.add_option(
      "--config", command.config,
      "a deployment's configuration, see `tactus config check --help`: what no option says it says, and the\n"
      "run logs events instead of a status line");
  app.add_option("--control", command.control, "serve `tactus control` at this path");
  app.add_option("--device", o.device, "sim, usb, usb:SERIAL, can:IFACE or can:IFACE:NODE")->capture_default_str();
  app.add_option("--device-file", o.device_file, "describes a real device; default: the scene's profile");
  app.add_option("--gpio", o.gpio, "lines beside the link: e-stop, drive enable, probe, heartbeat");
  app.add_option("--coupling", o.coupling,
                 fmt::format("{}. interpolation delays the\n"
                             "proxy by a global step: where the scene's stiffness is too much for that, it is lowered "
                             "and said",
                             fmt::join(sim::coupling_names(), ", ")))
      ->capture_default_str();
  app.add_flag("--keep-gains", o.keep_gains,
               "the scene's gains or none: refuse them, with the limit, where the coupling is\n"
               "not stable with them");
  app.add_option("--border", o.border,
                 fmt::format("of the sub-world: {}; replay is the paper's", fmt::join(sim::border_names(), ", ")))
      ->capture_default_str();
  app.add_option("--order", o.order, "in which the contact graph is cut: best-first or breadth-first")
      ->capture_default_str();
  app.add_option("--reach", o.reach, "of the boundary cube: two-cycles or paper")->capture_default_str();
  app.add_option("--accuracy", o.accuracy,
                 "fast: half the scene's members and sub-steps; balanced: as it says; accurate: twice of both")
      ->capture_default_str();
  app.add_option("--rate", o.rate_Hz, "haptic ticks a second [Hz]")->capture_default_str();
  app.add_option("--ratio", o.ratio, "haptic ticks per global step; default: the scene's");
  app.add_option("--members", o.members, "most bodies in the sub-world, the proxy included; default: by the accuracy");
  app.add_option("--duration", command.duration_s, "seconds to run; default: until stopped, in virtual time 10");
  app.add_option("--cpu", o.cpu, "core of the haptic thread; default: the last one allowed")
      ->check(CLI::Range(0, 1023));
  app.add_option("--world-threads", o.world_threads,
                 "threads that share the steps of the global world; the results are the same bits")
      ->capture_default_str();
  app.add_option("--world-precision", o.world_precision,
                 "of the global world: double, or mixed, where its contacts are solved in single precision")
      ->capture_default_str();
  app.add_option("--world-cpu", command.world_cpus,
                 "cores of the global world, one for each of its threads, such as 2 or 1,3-4; default: any.\n"
                 "More threads than one want cores of their own, that of the haptic thread not among them");
  app.add_option("--priority", o.priority, "SCHED_FIFO priority of the haptic thread; 0: stay a normal thread")
      ->capture_default_str();
  app.add_flag("--virtual-time", command.virtual_time, "one thread on a virtual clock: the same bits every time");
  app.add_option("--record", command.record, "write a tape here, for `tactus replay`");
  app.add_option("--budget", command.budget,
                 "hold the run against this file of `tactus timing --certify`: refused on another machine, at a\n"
                 "higher rate or with more sub-steps than measured; with more members it runs with fewer");
  app.add_flag("--rearm", o.rearm, "take a latched fault back by itself after a second; else Enter does");
  app.add_option("--inject", o.inject,
                 "faults, as KIND@TICK[+TICKS][:AMOUNT],...: lost, late, duplicated, corrupted, nan, wild,\n"
                 "teleport, frozen, unplugged, estop; of the world: stall; of the operator: reset@TICK");
  app.add_option("--seed", o.seed, "of what is random in injected faults")->capture_default_str();
  app.add_flag("--json", command.json, "one JSON object on stdout, units in the keys");
}

}  // namespace

CLI::App* add_run_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* run = program.add_subcommand("run", "Feel a scene: the haptic loop, the global world and the device.");
  run->footer(
      "While it runs, a status line shows rate, force, members, contacts, overruns; Ctrl-C ends it, Enter re-arms "
      "after\n"
      "a fault, r and Enter reset the scene. Exit status: 0 good or degraded, or with --config told to "
      "stop;\n"
      "1 the verdict is bad: a fault is latched at the end, a tick was lost to the program's own work, or the "
      "simulation\n"
      "went wrong, by the rules in the README; 2 bad usage or scene; 3 the machine cannot do it.\n\n"
      "Examples:\n  tactus run sim/scenes/card_house.toml --duration 20\n"
      "  tactus run sim/scenes/pile700.toml --ratio 10 --json\n"
      "  tactus run sim/scenes/pile700.toml --cpu 3 --world-threads 2 --world-cpu 1-2\n"
      "  tactus run sim/scenes/pile700.toml --virtual-time --coupling static\n"
      "  tactus run sim/scenes/stack20.toml --inject lost@1000+20,stall@3000+50 --rearm --record my.tape");
  add_options(*run, *command);
  run->callback([command, run, &exit_code] { exit_code = run_scene(*run, *command); });
  return run;
}

}  // namespace tactus::tools
