// Runs a session as a service: log, control socket, systemd's notifications and watchdog, and a configuration that can
// be reloaded during the run.
//
// Thread: created and updated by the main thread; the control socket's thread calls reload. The haptic thread reads one
// atomic number, requests(). Bound: one update every 200 ms or so, from the run's hooks.
#pragma once

#include <memory>

#include "tools/service/configuration.h"
#include "tools/service/control_server.h"
#include "tools/service/monitor.h"

namespace tactus::service {

// What the services of all hands of a run have in common: the configuration that may change, and systemd. The service
// is ready, and its watchdog is fed, only while every hand's loop is alive.
//
// Thread: reload by any; the rest by the main thread.
class SharedService {
 public:
  SharedService(const Configuration& configuration, std::filesystem::path file, unsigned hands)
      : configuration_(configuration),
        file_(std::move(file)),
        rearm_(configuration.run.rearm),
        log_interval_s_(configuration.log_interval_s),
        alive_(hands, false) {}

  bool can_reload() const noexcept { return !file_.empty(); }
  // Reads the file again. Error: nothing was changed, and why.
  Status reload(std::string& said);
  bool rearm() const noexcept { return rearm_.load(); }
  double log_interval_s() const noexcept { return log_interval_s_.load(); }
  unsigned reloads() const noexcept { return reloads_.load(); }  // so far

  // Of every hand in turn, hand by hand from 0; notifies systemd after the last.
  void tell_alive(unsigned hand, bool alive);

 private:
  Configuration configuration_;
  std::filesystem::path file_;
  std::atomic<bool> rearm_;
  std::atomic<double> log_interval_s_;
  std::atomic<unsigned> reloads_{0};
  std::vector<bool> alive_;  // by hand
  bool ready_{false};
};

class RunService {
 public:
  // Without a socket in `configuration` there is no control server. `can_reset`: the run has a global world. `name`:
  // for the log, with the hand. `watchable`: must outlive the service.
  static Result<std::unique_ptr<RunService>> open(const Configuration& configuration,
                                                  std::shared_ptr<SharedService> shared, std::atomic<bool>& stop,
                                                  bool can_reset, RunName name, const Watchable& watchable = {});
  ~RunService();

  // OperatorBit, for RealtimeHooks.
  std::atomic<std::uint32_t>& requests() noexcept { return requests_; }
  // Logs changes, updates the control socket and systemd, and clears a latched fault if so configured.
  void look(const session::LiveStatus& live, double elapsed_s);
  // Logs a message of the run, such as why it was not armed.
  void say(const std::string& line);

 private:
  RunService(std::shared_ptr<SharedService> shared, RunName name);

  std::shared_ptr<SharedService> shared_;
  RunName name_;
  std::atomic<std::uint32_t> requests_{0};
  EventLog log_;
  Monitor monitor_;
  unsigned reloads_logged_{0};
  double fault_since_s_{-1}, elapsed_s_{0};
  std::unique_ptr<ControlServer> control_;  // last: its thread uses the others
};

}  // namespace tactus::service
