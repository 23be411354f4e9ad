#include "tools/tactus/run_hands.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "sim/loader/scene_load.h"
#include "tools/json_report.h"
#include "tools/service/paced_run.h"
#include "tools/service/run_service.h"
#include "tools/session/distinct_devices.h"
#include "tools/session/find_description.h"
#include "tools/session/inject_script.h"
#include "tools/session/realtime_run.h"
#include "tools/session/virtual_run.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/keyboard.h"
#include "tools/tactus/run_figures.h"
#include "tools/tactus/shown_run.h"
#include "tools/tactus/status_line.h"
#include "tools/tactus/stop_signals.h"
#include "tools/tactus/viewer_process.h"

namespace tactus::tools {
namespace {

Status check_count(const char* option, std::size_t given, unsigned hands) {
  if (given <= 1 || given == hands) return Status::good();
  return Status::error(fmt::format("{}: {} for {} hands; accepted: one, or one for each", option, given, hands));
}

const std::string& of_hand(const std::vector<std::string>& values, unsigned hand) {
  static const std::string none;
  return values.empty() ? none : values.size() == 1 ? values.front() : values[hand];
}

Result<std::vector<session::Hardware>> open_devices(const sim::Scene& scene,
                                                    const std::vector<session::RunOptions>& options) {
  std::vector<hal::DeviceProfile> profiles;
  for (unsigned hand = 0; hand < scene.hands(); ++hand) {
    const std::string& name = sim::scene_of_hand(scene, hand).device.profile;
    auto profile = session::find_description(name, options[hand].device_file);
    if (!profile.ok()) return Status::error(fmt::format("hand {}: {}", hand + 1, profile.message()));
    profiles.push_back(std::move(profile).value());
  }
  return session::open_hardware(options, profiles, options.front().gpio);
}

// Service, viewer and shared memory of one hand.
struct Watched {
  std::shared_ptr<ShownRun> shown;  // null without a socket, or if the machine has no shared memory for watchers
  std::unique_ptr<service::RunService> service;
  std::unique_ptr<ViewerProcess> viewer;

  // `pacing`: of virtual time; null: real time.
  static Result<Watched> open(session::Session& session, const HandsCommand& command,
                              const std::shared_ptr<service::SharedService>& common, service::Pacing* pacing) {
    Watched watched;
    service::Configuration configuration = command.configuration;
    configuration.socket = session::file_of_hand(command.control, session.options.hand);
    service::Watchable watchable;
    watchable.pacing = pacing;
    if (session.simulated() != nullptr) watchable.hand = &session.hand_input;
    if (!configuration.socket.empty()) watched.shown = ShownRun::make(session);
    if (watched.shown != nullptr) watched.shown->add_to(watchable);
    if (watched.shown != nullptr && pacing != nullptr) watched.shown->paced_by(*pacing);
    auto service = service::RunService::open(
        configuration, common, g_stop, /*can_reset=*/true,
        {session.options.scene, sim::source_hash(session.scene.source), session.options.hand + 1}, watchable);
    if (!service.ok()) return service.status();
    watched.service = std::move(service).value();
    return watched;
  }

  // Call when the run's records exist.
  Status start_viewer(const std::filesystem::path& socket) {
    auto started = ViewerProcess::start(socket);
    if (!started.ok()) return started.status();
    viewer = std::move(started).value();
    return Status::good();
  }

  void look(const session::LiveStatus& live, double elapsed_s) {
    service->look(live, elapsed_s);
    if (shown != nullptr) shown->look(live);
  }
};
using AllWatched = std::vector<Watched>;  // by hand; empty without control sockets and log

Result<AllWatched> watch_all(session::Hands& hands, const HandsCommand& command, service::Pacing* pacing) {
  AllWatched all;
  if (command.control.empty() && command.config.empty()) return all;
  const auto common = std::make_shared<service::SharedService>(command.configuration, command.config, hands.count());
  for (unsigned hand = 0; hand < hands.count(); ++hand) {
    auto watched = Watched::open(hands[hand], command, common, pacing);
    if (!watched.ok()) return watched.status();
    all.push_back(std::move(watched).value());
  }
  return all;
}

Status start_viewers(AllWatched& all, const HandsCommand& command) {
  for (unsigned hand = 0; hand < all.size() && command.view; ++hand)
    if (const Status status = all[hand].start_viewer(session::file_of_hand(command.control, hand)); !status.ok())
      return status;
  return Status::good();
}

void end_all(AllWatched& all, const std::vector<session::RunSummary>& summaries) {
  for (std::size_t hand = 0; hand < all.size(); ++hand)
    if (all[hand].shown != nullptr) all[hand].shown->end(summaries[hand]);
}

void stepped(void* all, const sim::GlobalWorld& world) noexcept {
  for (const Watched& watched : *static_cast<AllWatched*>(all))
    if (watched.shown != nullptr) ShownRun::stepped(watched.shown.get(), world);
}

session::HandHooks hooks_of(Watched& watched) {
  session::HandHooks hooks;
  hooks.requests = &watched.service->requests();
  if (watched.shown != nullptr)
    hooks.began = [shown = watched.shown](const loop::SetupReport& setup) { shown->take_setup(setup); };
  return hooks;
}

Result<std::vector<session::RunSummary>> run_in_real_time(session::Hands& hands, const HandsCommand& command) {
  const bool logged = !command.config.empty();
  const bool terminal = isatty(STDERR_FILENO) != 0 && !logged;
  auto watched = watch_all(hands, command, nullptr);
  if (!watched.ok()) return watched.status();
  AllWatched& all = watched.value();
  session::HandsHooks hooks;
  for (Watched& each : all) hooks.hands.push_back(hooks_of(each));
  if (!all.empty()) hooks.stepped = {&stepped, &all};
  if (const Status status = start_viewers(all, command); !status.ok()) return status;
  // Also without a tape: a fault saves the last seconds.
  if (const Status status = hands.record(command.record); !status.ok()) return status;
  std::vector<std::uint64_t> faults_told(hands.count(), 0);
  double next_line_s = 0;
  hooks.show = [&](std::span<const session::LiveStatus* const> live, double elapsed_s) {
    for (std::size_t hand = 0; hand < live.size(); ++hand) {
      if (!all.empty()) all[hand].look(*live[hand], elapsed_s);
      if (logged) continue;
      const std::uint64_t faults = live[hand]->fault_count.load(std::memory_order_relaxed);
      const std::string fault = fault_line(*live[hand]);
      if (fault.empty() || faults <= faults_told[hand]) continue;
      fmt::print(stderr, "{}tactus run: hand {}: FAULT at {:.1f} s: {}\n", terminal ? "\r\033[K" : "", hand + 1,
                 elapsed_s, fault);
      faults_told[hand] = faults;
    }
    if (terminal || (!command.json && !logged && elapsed_s >= next_line_s)) {
      show_live(live, elapsed_s, terminal);
      next_line_s += 2;
    }
    return true;
  };
  hooks.asked = asked_on_keyboard;
  hooks.say = [&](const std::string& line) {
    if (!all.empty()) all.front().service->say(line);
    if (logged) return;
    fmt::print(stderr, "{}tactus run: {}\n", terminal ? "\r\033[K" : "", line);
  };
  auto summaries = session::run_realtime(hands, hooks, g_stop);
  if (summaries.ok()) end_all(all, summaries.value());
  if (terminal) fmt::print(stderr, "\r\033[K");
  return summaries;
}

// In virtual time with control sockets: watched, and at the pace that one of the pages asks for.
Result<std::vector<session::RunSummary>> run_at_pace(session::Hands& hands, const HandsCommand& command,
                                                     std::uint64_t ticks) {
  service::Pacing pacing;
  pacing.pace.store(command.pace);
  auto watched = watch_all(hands, command, &pacing);
  if (!watched.ok()) return watched.status();
  AllWatched& all = watched.value();
  if (const Status status = hands.record(command.record); !status.ok()) return status;
  if (const Status status = start_viewers(all, command); !status.ok()) return status;
  service::PacedHandsHooks hooks{
      .pacing = pacing, .requests = {}, .stop = g_stop, .stepped = {&stepped, &all}, .look = {}};
  for (Watched& each : all) hooks.requests.push_back(&each.service->requests());
  hooks.look = [&](std::span<const session::LiveStatus* const> live, double elapsed_s) {
    for (std::size_t hand = 0; hand < live.size(); ++hand) all[hand].look(*live[hand], elapsed_s);
  };
  auto summaries = service::run_paced(hands, hooks, ticks);
  if (summaries.ok()) end_all(all, summaries.value());
  return summaries;
}

Result<std::vector<session::RunSummary>> run(session::Hands& hands, const HandsCommand& command) {
  const session::RunOptions& options = command.options;
  if (!options.virtual_time) return run_in_real_time(hands, command);
  const bool watched = !command.control.empty();
  const double duration_s = options.duration_s == 0 && !watched ? kDefaultVirtual_s : options.duration_s;
  const auto ticks = static_cast<std::uint64_t>(std::llround(duration_s * options.rate_Hz));
  if (watched) return run_at_pace(hands, command, ticks);
  if (!command.record.empty() || !command.figures.empty())
    if (const Status status = hands.record(command.record); !status.ok()) return status;
  return session::run_virtual(hands, ticks,
                              [](const session::Hands&) { return !g_stop.load(std::memory_order_relaxed); });
}

// By hand; null without --figures.
using FiguresOfHands = std::vector<std::unique_ptr<exporting::Figures>>;

Status take_figures_of(session::Hands& hands, const HandsCommand& command, FiguresOfHands& figures) {
  for (session::Session* session : hands.sessions()) {
    auto taken = take_figures(*session, command.figures);
    if (!taken.ok()) return taken.status();
    figures.push_back(std::move(taken).value());
  }
  return Status::good();
}

nlohmann::json to_json(const std::vector<session::RunSummary>& summaries, const FiguresOfHands& figures) {
  nlohmann::json hands = nlohmann::json::array();
  std::size_t worst = 0;
  for (std::size_t hand = 0; hand < summaries.size(); ++hand) {
    hands.push_back(session::to_json(summaries[hand]));
    add_figures(hands.back(), figures[hand].get());
    if (session::judge(summaries[hand]).level() > session::judge(summaries[worst]).level()) worst = hand;
  }
  nlohmann::json object;
  for (const char* key : {"scene", "scene_file", "scene_hash", "real_time"}) object[key] = hands[0][key];
  for (const char* key : {"verdict", "level", "exit_code"}) object[key] = hands[worst][key];
  object["hands"] = std::move(hands);
  return object;
}

}  // namespace

Result<std::vector<session::RunOptions>> options_of_hands(const HandsCommand& command) {
  const unsigned hands = command.scene.hands();
  const EachHand& each = command.each;
  const Status counts[] = {check_count("--device", each.devices.size(), hands),
                           check_count("--device-file", each.device_files.size(), hands),
                           check_count("--inject", each.injects.size(), hands),
                           check_count("--cpu", each.cpus.size(), hands)};
  for (const Status& status : counts)
    if (!status.ok()) return Status::error(fmt::format("{}: {}", command.scene.name, status.message()));
  std::vector<session::RunOptions> options(hands, command.options);
  for (unsigned hand = 0; hand < hands; ++hand) {
    session::RunOptions& o = options[hand];
    if (!each.devices.empty()) o.device = of_hand(each.devices, hand);
    o.device_file = of_hand(each.device_files, hand);
    o.inject = hand < each.injects.size() ? each.injects[hand] : "";
    o.cpu = hand < each.cpus.size() ? each.cpus[hand] : -1;
    if (const Status status = session::check_options(o); !status.ok())
      return Status::error(fmt::format("hand {}: {}", hand + 1, status.message()));
  }
  for (unsigned hand = 1; hand < hands; ++hand) {
    const auto script = session::split_inject_script(options[hand].inject);
    if (script.ok() && (!script.value().stalls.empty() || !script.value().resets.empty()))
      return Status::error(
          fmt::format("hand {}: --inject: {}: stall and reset are of all hands' world and operator; accepted: in the "
                      "first --inject",
                      hand + 1, options[hand].inject));
  }
  std::vector<session::NamedDevice> named;
  for (const session::RunOptions& o : options) named.push_back({o.device, o.device_file});
  if (Status status = session::check_distinct(named, command.scene.device.profile); !status.ok()) return status;
  return options;
}

int run_hands(const HandsCommand& command) {
  const auto options = options_of_hands(command);
  if (!options.ok()) return complain("tactus run: " + options.message(), kExitBadInput);
  auto hardware = open_devices(command.scene, options.value());
  if (!hardware.ok()) return complain("tactus run: " + hardware.message(), kExitMachineCannot);
  FiguresOfHands figures;  // the hands' recorders write into them
  auto hands = session::Hands::create(command.scene, options.value(), std::move(hardware).value());
  if (!hands.ok()) return complain("tactus run: " + hands.message(), kExitBadInput);
  for (unsigned hand = 0; hand < hands.value().count(); ++hand) {
    const session::RunSummary summary = hands.value()[hand].summary();
    if (summary.gains.lowered())
      fmt::print(stderr, "tactus run: hand {}: {}: {}\n", hand + 1, lowered_text(summary.gains),
                 lowered_why(summary.options, summary.ratio));
  }
  for (unsigned hand = 0; hand < hands.value().count() && command.by_pointer; ++hand)
    (void)hands.value()[hand].rest_hand();
  if (const Status status = take_figures_of(hands.value(), command, figures); !status.ok())
    return complain("tactus run: " + status.message(), kExitBadInput);
  stop_on_signals();
  std::signal(SIGPIPE, SIG_IGN);  // the run continues if the reader of the status lines ends
  const auto summaries = run(hands.value(), command);
  if (!summaries.ok()) return complain("tactus run: " + summaries.message(), kExitMachineCannot);
  if (command.json) {
    auto object = to_json(summaries.value(), figures);
    object["scene_warnings"] = command.warnings;
    fmt::print("{}\n", report_text(object, 2));
  } else {
    for (std::size_t hand = 0; hand < figures.size(); ++hand) {
      fmt::print("{}", session::to_text(summaries.value()[hand]));
      print_figures(figures[hand].get());
    }
  }
  // As with one hand: a service stopped on request exits with success; its log contains the faults.
  if (!command.config.empty() && g_stop.load(std::memory_order_relaxed)) return kExitGood;
  int exit_code = kExitGood;
  for (const session::RunSummary& summary : summaries.value()) exit_code = std::max(exit_code, summary.exit_code());
  return exit_code;
}

}  // namespace tactus::tools
