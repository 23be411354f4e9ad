// What a public Session holds: the run's parts, and what its views show.
//
// Thread: the session's owner, but `requests` and `stop`, which any thread may write; in real time the haptic thread
// writes the ring, the global world's thread the hand-over. Bound: what is here is allocated when a session is opened.
#pragma once

#include <atomic>
#include <optional>

#include "rt/base/ring.h"
#include "tactus/session.h"
#include "tools/library/own_device.h"
#include "tools/library/state_view.h"
#include "tools/session/virtual_run.h"

namespace tactus {

struct Session::Parts {
  Scene scene;
  Options options;
  session::RunOptions run_options;
  Device* device{nullptr};  // the caller's; null: there is none

  std::unique_ptr<session::Session> session;
  library::OwnDevice* own{nullptr};                // in it
  std::optional<session::VirtualRun> virtual_run;  // none in real time
  std::optional<session::RunSummary> ended;        // of a run that is over, with what became of its tape
  bool started{false};                             // the device has
  bool closed{false};
  bool in_monitor{false};
  std::atomic<std::uint32_t> requests{0};
  std::atomic<bool> stop{false};

  Tick last;
  std::vector<Tick> history;    // as long as history_ticks
  std::size_t history_size{0};  // of it, from the front
  library::StateView view;
  bool view_is_old{true};

  std::unique_ptr<Ring> ring;       // of ticks, in real time
  std::uint64_t dropped_before{0};  // ticks that it had no room for, at the last look
  std::unique_ptr<library::StateHandOver> hand_over;

  // Everything from the scene and the options; in the words of the command line where it fails.
  Error build();
  Error start_device();
  void end();  // the device is told, the tape is closed

  void step(std::uint64_t ticks);
  Error run(double duration_s, const Monitor& monitor);
  void look();
  session::RunSummary summary() const;

 private:
  Error build_device(session::Hardware& hardware);
  void make_real_time();
  std::uint64_t take_ticks();
};

}  // namespace tactus
