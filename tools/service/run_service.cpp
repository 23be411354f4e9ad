#include "tools/service/run_service.h"

#include <fmt/format.h>

#include <algorithm>

#include "rt/loop/haptic_loop.h"
#include "tools/service/notify.h"

namespace tactus::service {
namespace {

// A latched fault is cleared this long after it latched, as by --rearm.
constexpr double kRearmAfter_s = 1.0;

}  // namespace

Status SharedService::reload(std::string& said) {
  const auto read = load_configuration(file_);
  if (!read.ok()) return Status::error("nothing was changed: " + read.message());
  const Configuration& after = read.value();
  if (const std::string keys = needs_restart(configuration_, after); !keys.empty())
    return Status::error("nothing was changed: a restart is needed for " + keys);
  rearm_.store(after.run.rearm);
  log_interval_s_.store(after.log_interval_s);
  reloads_.fetch_add(1);
  said = fmt::format("rearm {}, log interval {:g} s", after.run.rearm, after.log_interval_s);
  return Status::good();
}

void SharedService::tell_alive(unsigned hand, bool alive) {
  alive_[hand] = alive;
  if (hand + 1 < alive_.size() || std::find(alive_.begin(), alive_.end(), false) != alive_.end()) return;
  if (!ready_) (void)notify("READY=1");
  ready_ = true;
  if (watchdog_period_s() > 0) (void)notify("WATCHDOG=1");
}

RunService::RunService(std::shared_ptr<SharedService> shared, RunName name)
    : shared_(std::move(shared)),
      name_(std::move(name)),
      log_(stderr, EventLog::to_journal(), shared_->log_interval_s()),
      monitor_(log_, name_) {
  log_.set_hand(name_.hand);
}

Result<std::unique_ptr<RunService>> RunService::open(const Configuration& configuration,
                                                     std::shared_ptr<SharedService> shared, std::atomic<bool>& stop,
                                                     bool can_reset, RunName name, const Watchable& watchable) {
  std::unique_ptr<RunService> service(new RunService(shared, std::move(name)));
  if (!configuration.socket.empty()) {
    ControlServer::Reload reload;
    if (shared->can_reload()) reload = [shared](std::string& said) { return shared->reload(said); };
    auto control =
        ControlServer::open(configuration.socket, service->requests_, stop, std::move(reload), can_reset, watchable);
    if (!control.ok()) return control.status();
    service->control_ = std::move(control).value();
    session::LiveStatus not_yet;  // initial state, for requests before the loop runs
    not_yet.status.store(kNotArmed, std::memory_order_relaxed);
    service->control_->tell(state_json(not_yet, 0, 0, service->name_));
  }
  return service;
}

RunService::~RunService() { (void)notify("STOPPING=1"); }

void RunService::say(const std::string& line) { log_.event(LogLevel::kWarning, "run", {{"text", line}}, elapsed_s_); }

void RunService::look(const session::LiveStatus& live, double elapsed_s) {
  elapsed_s_ = elapsed_s;
  log_.set_interval(shared_->log_interval_s());
  if (const unsigned reloads = shared_->reloads(); reloads != reloads_logged_) {
    reloads_logged_ = reloads;
    log_.event(LogLevel::kNotice, "reloaded",
               {{"rearm", shared_->rearm() ? "true" : "false"},
                {"interval_s", fmt::format("{:g}", shared_->log_interval_s())}},
               elapsed_s);
  }
  monitor_.look(live, elapsed_s);
  if (control_ != nullptr) {
    const auto braked = static_cast<std::uint32_t>(haptics::DeviceState::kBrake);
    control_->tell_latched(live.fault.load(std::memory_order_relaxed) != 0 ||
                           live.device_state.load(std::memory_order_relaxed) == braked);
  }
  if (control_ != nullptr) control_->tell(state_json(live, elapsed_s, monitor_.rate_Hz(), name_));
  shared_->tell_alive(name_.hand > 0 ? name_.hand - 1 : 0, monitor_.alive());
  if (live.fault.load(std::memory_order_relaxed) == 0) {
    fault_since_s_ = -1;
  } else if (fault_since_s_ < 0) {
    fault_since_s_ = elapsed_s;
  } else if (shared_->rearm() && elapsed_s - fault_since_s_ >= kRearmAfter_s) {
    requests_.fetch_or(loop::kRearm, std::memory_order_relaxed);
    fault_since_s_ = -1;
  }
}

}  // namespace tactus::service
