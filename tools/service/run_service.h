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

class RunService {
 public:
  // `file` is the one that `configuration` came from: reload reads it again. Without a socket in it there is no control
  // server.
  // `can_reset`: the run has a global world. `name`: for the log. `watchable`: must outlive the service.
  static Result<std::unique_ptr<RunService>> open(const Configuration& configuration, const std::filesystem::path& file,
                                                  std::atomic<bool>& stop, bool can_reset, RunName name,
                                                  const Watchable& watchable = {});
  ~RunService();

  // OperatorBit, for RealtimeHooks.
  std::atomic<std::uint32_t>& requests() noexcept { return requests_; }
  // Logs changes, updates the control socket and systemd, and clears a latched fault if so configured.
  void look(const session::LiveStatus& live, double elapsed_s);
  // Logs a message of the run, such as why it was not armed.
  void say(const std::string& line);

 private:
  RunService(const Configuration& configuration, std::filesystem::path file, RunName name);
  Status reload(std::string& said);

  Configuration configuration_;
  std::filesystem::path file_;
  RunName name_;
  std::atomic<std::uint32_t> requests_{0};
  std::atomic<bool> rearm_;
  std::atomic<double> log_interval_s_;
  std::atomic<bool> reloaded_{false};  // to be logged
  EventLog log_;
  Monitor monitor_;
  bool ready_{false};
  double fault_since_s_{-1}, elapsed_s_{0};
  std::unique_ptr<ControlServer> control_;  // last: its thread uses the others
};

}  // namespace tactus::service
