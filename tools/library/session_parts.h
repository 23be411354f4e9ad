// Private data of a public Session: the parts of the run and the data of its views.
//
// Thread: the session's owner; any thread may write `requests` and `stop`; in real time the haptic thread writes the
// ring and the global world's thread the hand-over. Bound: everything is allocated when a session is opened.
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
  std::uint64_t opening{0};  // number of the open() in this program: whose a saved state is
  Scene scene;
  Options options;
  session::RunOptions run_options;
  Device* device{nullptr};  // the caller's; null: none

  std::unique_ptr<session::Session> session;
  library::OwnDevice* own{nullptr};                // held by `session`
  std::optional<session::VirtualRun> virtual_run;  // none in real time
  std::optional<session::RunSummary> ended;        // summary of an ended run, with the result of closing its tape
  bool started{false};                             // the device was started
  bool closed{false};
  bool in_monitor{false};
  std::atomic<std::uint32_t> requests{0};
  std::atomic<bool> stop{false};

  Tick last;
  std::vector<Tick> history;    // size: history_ticks
  std::size_t history_size{0};  // used elements, from the front
  library::StateView view;
  bool view_is_old{true};

  std::unique_ptr<Ring> ring;       // ticks of a real-time run
  std::uint64_t dropped_before{0};  // ticks that did not fit in the ring, until the last look
  std::unique_ptr<library::StateHandOver> hand_over;

  // Builds everything from the scene and the options. Errors name options as on the command line.
  Error build();
  Error start_device();
  void end();  // stops the device and closes the tape

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
