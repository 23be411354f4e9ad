// tactus run SCENE: runs a scene in real or virtual time.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "hal/device_class.h"
#include "tactus/tactus.h"
#include "tools/doctor/system_view.h"
#include "tools/experiment/shared_files.h"
#include "tools/json_report.h"
#include "tools/library/access.h"
#include "tools/private_folder.h"
#include "tools/service/paced_run.h"
#include "tools/service/run_service.h"
#include "tools/session/cores.h"
#include "tools/session/realtime_run.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/keyboard.h"
#include "tools/tactus/run_command.h"
#include "tools/tactus/run_figures.h"
#include "tools/tactus/run_hands.h"
#include "tools/tactus/shown_run.h"
#include "tools/tactus/status_line.h"
#include "tools/tactus/stop_signals.h"
#include "tools/tactus/viewer_process.h"
#include "tools/timing/budget.h"
#include "tools/view/server.h"

namespace tactus::tools {
namespace {

// Converts an error of the library to an exit status, by its kind.
int complain_of(const Error& error) {
  if (error.kind() == Error::Kind::kFile) return complain_of_each(error.message(), kExitBadInput);
  return complain("tactus run: " + error.message(),
                  error.kind() == Error::Kind::kMachine ? kExitMachineCannot : kExitBadInput);
}

Error complete_options(RunCommand& command) {
  Options& o = command.options;
  // Of the first hand; run_hands takes them all.
  if (!command.each.devices.empty()) o.device = command.each.devices.front();
  if (!command.each.device_files.empty()) o.device_file = command.each.device_files.front();
  if (!command.each.injects.empty()) o.inject = command.each.injects.front();
  if (!command.each.cpus.empty()) o.cpu = command.each.cpus.front();
  const auto wrong = [](std::string text) { return Error(Error::Kind::kOption, std::move(text)); };
  const auto world_cpus = doctor::parse_cpu_list(command.world_cpus);
  if (!world_cpus)
    return wrong(
        fmt::format("--world-cpu: '{}' is none; accepted: numbers of cores, such as 2 or 1,3-4", command.world_cpus));
  o.world_cpus = *world_cpus;
  o.real_time = !command.virtual_time;
  const bool attended = command.view || !command.control.empty();
  if (command.pace >= 0 && !(command.virtual_time && attended))
    return wrong("--pace: real time has its own; accepted: with --virtual-time and --control or --view");
  if (command.pace > 0 && (command.pace < service::kMinPace || command.pace > service::kMaxPace))
    return wrong(fmt::format("--pace: accepted: {:g} to {:g} times real time, or 0 for as fast as it goes",
                             service::kMinPace, service::kMaxPace));
  if (command.hand == "pointer" && o.device != "sim")
    return wrong("--hand pointer: a real device's hand is a person's; accepted: with --device sim");
  if (command.virtual_time && command.duration_s == 0 && !attended) command.duration_s = kDefaultVirtual_s;
  if (!command.virtual_time && !command.figures.empty())
    return wrong("--figures: is of virtual time; accepted: with --virtual-time, or `tactus export` of a tape");
  if (attended && !command.figures.empty())
    return wrong(
        "--figures: is of a run that nobody watches; accepted: without --control and --view, or `tactus export` of a "
        "tape");
  return library::Access::check(o, attended && command.duration_s == 0 ? kDefaultVirtual_s : command.duration_s);
}

// `shown`: null if the machine has no shared memory for watchers.
service::Watchable watchable_of(session::Session& session, ShownRun* shown) {
  service::Watchable watchable;
  if (session.simulated() != nullptr) watchable.hand = &session.hand_input;
  if (shown != nullptr) shown->add_to(watchable);
  return watchable;
}

// Starts the viewer that --view asks for; the control socket is served.
Status start_viewer(const RunCommand& command, std::unique_ptr<ViewerProcess>& viewer) {
  if (!command.view) return Status::good();
  auto started = ViewerProcess::start(command.control);
  if (!started.ok()) return started.status();
  viewer = std::move(started).value();
  return Status::good();
}

// With a configuration it is a service: events in a log instead of a status line.
Result<session::RunSummary> run_in_real_time(session::Session& session, const RunCommand& command) {
  const bool json = command.json, logged = !command.config.empty();
  std::shared_ptr<ShownRun> shown;  // declared before the service, whose watchers use it
  std::unique_ptr<service::RunService> service;
  session::RealtimeHooks hooks;
  if (logged || !command.control.empty()) {
    service::Configuration configuration = command.configuration;
    if (!command.control.empty()) configuration.socket = command.control;
    if (!configuration.socket.empty()) shown = ShownRun::make(session);
    if (shown != nullptr) {
      hooks.taps.stepped = &ShownRun::stepped;
      hooks.taps.context = shown.get();
      hooks.began = [&](const loop::SetupReport& setup) { shown->take_setup(setup); };
    }
    const auto shared = std::make_shared<service::SharedService>(configuration, command.config, 1);
    auto opened = service::RunService::open(configuration, shared, g_stop, session.global != nullptr,
                                            {session.options.scene, sim::source_hash(session.scene.source)},
                                            watchable_of(session, shown.get()));
    if (!opened.ok()) return opened.status();
    service = std::move(opened).value();
  }
  std::unique_ptr<ViewerProcess> viewer;
  if (const Status status = start_viewer(command, viewer); !status.ok()) return status;
  // Also without a tape: a fault saves the last seconds.
  session.options.record = command.record;
  if (const Status status = session.record(command.record.string()); !status.ok()) return status;
  session.options.duration_s = command.duration_s;
  stop_on_signals();
  std::signal(SIGPIPE, SIG_IGN);  // the run continues if the reader of the status lines ends
  const bool terminal = isatty(STDERR_FILENO) != 0 && !logged;
  std::uint64_t last_ticks = 0;
  double last_s = 0, next_line_s = 0;
  std::uint64_t faults_told = 0;
  if (service != nullptr) hooks.requests = &service->requests();
  hooks.show = [&](const session::LiveStatus& live, double elapsed_s) {
    if (service != nullptr) service->look(live, elapsed_s);
    if (shown != nullptr) shown->look(live);
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
  if (shown != nullptr && summary.ok()) shown->end(summary.value());
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

// In virtual time with a control socket: watched, and at the pace that is asked for.
Result<session::RunSummary> run_paced(Session& opened, const RunCommand& command) {
  session::Session& session = library::Access::session(opened);
  service::Pacing pacing;
  pacing.pace.store(command.pace >= 0 ? command.pace : command.view ? 1 : 0);
  std::atomic<std::uint32_t> requests{0};
  const auto shown = ShownRun::make(session);
  service::Watchable watchable = watchable_of(session, shown.get());
  watchable.pacing = &pacing;
  if (shown != nullptr) shown->paced_by(pacing);
  auto control =
      service::ControlServer::open(command.control, requests, g_stop, {}, session.global != nullptr, watchable);
  if (!control.ok()) return control.status();
  session.options.record = command.record;
  if (const Status status = session.record(command.record.string()); !status.ok()) return status;
  std::unique_ptr<ViewerProcess> viewer;
  if (const Status status = start_viewer(command, viewer); !status.ok()) return status;
  stop_on_signals();
  const service::RunName name{session.options.scene, sim::source_hash(session.scene.source)};
  service::PacedHooks hooks{.pacing = pacing, .requests = requests, .stop = g_stop, .look = {}};
  if (shown != nullptr) hooks.stepped = &ShownRun::stepped;
  hooks.context = shown.get();
  hooks.look = [&](const session::LiveStatus& live, double elapsed_s) {
    const double rate_Hz = elapsed_s > 0 ? static_cast<double>(live.ticks.load()) / elapsed_s : 0;
    control.value()->tell(service::state_json(live, elapsed_s, rate_Hz, name));
    control.value()->tell_latched(live.fault.load() != 0);
    if (shown != nullptr) shown->look(live);
  };
  const auto ticks = static_cast<std::uint64_t>(std::llround(command.duration_s * command.options.rate_Hz));
  auto summary = service::run_paced(session, library::Access::virtual_run(opened), hooks, ticks);
  if (shown != nullptr && summary.ok()) shown->end(summary.value());
  return summary;
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
  const int cpu = session::core_of_hand(o.cpu);
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
  std::vector<service::ConfiguredDevice> devices = command.configuration.devices;
  if (devices.empty()) devices.push_back({.name = from.device, .file = from.device_file, .core = from.cpu});
  EachHand each;
  for (const service::ConfiguredDevice& device : devices) {
    each.devices.push_back(device.name);
    each.device_files.push_back(device.file);
    each.cpus.push_back(device.core);
  }
  if (!given("--device")) command.each.devices = each.devices;
  if (!given("--device-file")) command.each.device_files = each.device_files;
  if (!given("--gpio")) o.gpio = from.gpio;
  if (!given("--rate")) o.rate_Hz = from.rate_Hz;
  if (!given("--ratio")) o.ratio = from.ratio;
  if (!given("--members")) o.members = from.members;
  if (!given("--cpu")) command.each.cpus = each.cpus;
  if (!given("--priority")) o.priority = from.priority;
  if (!given("--world-threads")) o.world_threads = from.world_threads;
  if (!given("--world-cpu")) command.world_cpus = fmt::format("{}", fmt::join(from.world_cpus, ","));
  if (!given("--budget")) command.budget = command.configuration.budget;
  o.arm_at_start = from.arm_at_start;
  return Status::good();
}

// Before the run: is there a page, and a socket to watch at?
int prepare_view(RunCommand& command, std::unique_ptr<PrivateFolder>& folder) {
  if (!command.view) return kExitGood;
  const auto files = view::load_files(experiment::shared_file("view"));
  if (!files.ok()) return complain("tactus run: --view: " + files.message(), kExitMachineCannot);
  if (!command.control.empty()) return kExitGood;
  auto made = PrivateFolder::make();
  if (!made.ok()) return complain("tactus run: --view: " + made.message(), kExitMachineCannot);
  folder = std::move(made).value();
  command.control = folder->path() / "control";
  return kExitGood;
}

Result<session::RunSummary> run_as_asked(Session& session, const RunCommand& command) {
  if (!command.virtual_time) return run_in_real_time(library::Access::session(session), command);
  return command.control.empty() ? run_in_virtual_time(session, command) : run_paced(session, command);
}

// The scene has several hands, or several devices were given.
int run_several(RunCommand& command, const Scene& scene) {
  if (!command.budget.empty())
    return complain("tactus run: --budget: certifies one haptic thread; accepted: with a scene that has one hand",
                    kExitBadInput);
  std::unique_ptr<PrivateFolder> folder;  // of the viewers' sockets
  if (const int exit_code = prepare_view(command, folder); exit_code != kExitGood) return exit_code;
  // Without a duration the run lasts until it is stopped. The options of virtual time must have one.
  const bool endless = command.duration_s == 0;
  auto options =
      library::run_options(command.options, endless && command.virtual_time ? kDefaultVirtual_s : command.duration_s);
  if (!options.ok()) return complain("tactus run: " + options.message(), kExitBadInput);
  if (endless) options.value().duration_s = 0;
  options.value().scene = command.scene;
  return run_hands({.scene = library::Access::scene(scene),
                    .options = std::move(options).value(),
                    .each = command.each,
                    .record = command.record,
                    .control = command.control.empty() ? command.configuration.socket : command.control,
                    .config = command.config,
                    .configuration = command.configuration,
                    .warnings = scene.warnings(),
                    .figures = command.figures,
                    .pace = command.pace >= 0 ? command.pace
                            : command.view    ? 1
                                              : 0,
                    .view = command.view,
                    .by_pointer = command.hand == "pointer",
                    .json = command.json});
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
  if (library::Access::scene(scene).hands() > 1 || command.each.devices.size() > 1) return run_several(command, scene);
  std::unique_ptr<PrivateFolder> folder;  // of the viewer's socket
  if (const int exit_code = prepare_view(command, folder); exit_code != kExitGood) return exit_code;
  if (const int exit_code = keep_budget(command, library::Access::scene(scene)); exit_code != kExitGood)
    return exit_code;
  std::unique_ptr<exporting::Figures> figures;  // the session's recorder writes into them
  Session session;
  if (const Error error = library::Access::open(session, scene, command.options)) return complain_of(error);
  session::Session& inner = library::Access::session(session);
  const std::string lowered = lowered_text(inner.summary().gains);
  if (!lowered.empty()) fmt::print(stderr, "tactus run: {}: {}\n", lowered, lowered_why(inner.options, inner.ratio));
  auto taken = take_figures(inner, command.figures);
  if (!taken.ok()) return complain("tactus run: " + taken.message(), kExitBadInput);
  figures = std::move(taken).value();
  if (figures != nullptr && command.record.empty())
    if (const Status status = inner.record(""); !status.ok())
      return complain("tactus run: " + status.message(), kExitMachineCannot);
  if (command.hand == "pointer") (void)inner.rest_hand();
  auto summary = run_as_asked(session, command);
  if (!summary.ok()) return complain("tactus run: " + summary.message(), kExitMachineCannot);
  if (command.json) {
    auto object = to_json(summary.value());
    object["scene_warnings"] = scene.warnings();
    add_figures(object, figures.get());
    fmt::print("{}\n", report_text(object, 2));
  } else {
    fmt::print("{}", to_text(summary.value()));
    print_figures(figures.get());
  }
  // A service stopped on request exits with success; its log contains the faults of the run.
  if (!command.config.empty() && g_stop.load(std::memory_order_relaxed)) return kExitGood;
  return summary.value().exit_code();
}

}  // namespace

CLI::App* add_run_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* run = program.add_subcommand("run", "Run a scene: the haptic loop, the global world and the device.");
  run->footer(
      "While it runs, a status line shows rate, force, members, contacts and overruns; Ctrl-C ends the run, Enter\n"
      "re-arms after a fault, r and Enter reset the scene. Exit status: 0 good or degraded, or with --config told\n"
      "to stop; 1 the verdict is bad, by the rules of tools/session/README.md: a fault is latched at the end, a\n"
      "tick was lost to the program's own work, or the simulation went wrong; 2 bad usage or scene; 3 the machine\n"
      "cannot do it.\n\n"
      "Examples:\n"
      "  tactus run sim/scenes/card_house.toml --duration 20\n"
      "  tactus run sim/scenes/pile700.toml --ratio 10 --json\n"
      "  tactus run sim/scenes/pile700.toml --cpu 3 --world-threads 2 --world-cpu 1-2\n"
      "  tactus run sim/scenes/pile700.toml --virtual-time --coupling static\n"
      "  tactus run sim/scenes/card_house.toml --view --hand pointer\n"
      "  tactus run tools/examples/two_hands.toml --device usb:0001 --device usb:0002 --cpu 2 --cpu 3\n"
      "  tactus run sim/scenes/stack20.toml --inject lost@1000+20,stall@3000+50 --rearm --record my.tape");
  add_run_options(*run, *command);
  run->callback([command, run, &exit_code] { exit_code = run_scene(*run, *command); });
  return run;
}

}  // namespace tactus::tools
