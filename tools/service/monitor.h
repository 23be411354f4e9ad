// Publishes the state of a run five times a second: events of the log, state for the control socket, systemd's
// watchdog. Thread: one, normal. Time comes from the caller.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "tools/service/event_log.h"
#include "tools/session/realtime_run.h"

namespace tactus::service {

// Identity of a run, for its log and its state.
struct RunName {
  std::filesystem::path scene;
  std::string scene_hash;  // of its text
  unsigned hand{0};        // of several hands, from 1; 0: there is one
};

// One JSON object: version, scene, ticks, rate, force, members, contacts, overruns, late cycles, conditions, fault.
std::string state_json(const session::LiveStatus& live, double elapsed_s, double rate_Hz, const RunName& run = {});

class Monitor {
 public:
  explicit Monitor(EventLog& log, RunName name = {}) : log_(log), name_(std::move(name)) {}

  // Logs what has changed since the last call: the start, force on and off, overruns, a late world, a fault and its
  // end.
  void look(const session::LiveStatus& live, double elapsed_s);
  // True if the loop has ticked since the last call, for the watchdog.
  bool alive() const { return alive_; }
  double rate_Hz() const { return rate_Hz_; }

 private:
  EventLog& log_;
  RunName name_;
  bool started_{false}, alive_{false}, armed_{false};
  std::uint64_t ticks_{0}, overruns_{0}, late_cycles_{0};
  std::uint32_t fault_{0}, resets_{0};
  double last_s_{0}, rate_Hz_{0};
};

}  // namespace tactus::service
