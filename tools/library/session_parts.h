// Private data of a public Session: the parts of the run and the data of its views.
//
// Thread: the session's owner; any thread may write `requests` and `stop`; in real time, which is for one hand, the
// haptic thread writes the ring and the global world's thread the hand-over. Bound: everything is allocated when a
// session is opened.
#pragma once

#include <atomic>
#include <deque>
#include <optional>
#include <vector>

#include "rt/base/ring.h"
#include "tactus/session.h"
#include "tools/library/own_device.h"
#include "tools/library/state_view.h"
#include "tools/session/virtual_run.h"

namespace tactus {

struct Session::Parts {
  explicit Parts(unsigned count) : each(count) {}

  // Of one hand.
  struct Hand {
    library::OwnDevice* own{nullptr};          // held by the hand's session; null: not a device of the caller's
    std::optional<session::RunSummary> ended;  // summary of an ended run, with the result of closing its tape
    bool started{false};                       // the device was started
    std::atomic<std::uint32_t> requests{0};
    Tick last;
    std::vector<Tick> history;    // size: history_ticks
    std::size_t history_size{0};  // used elements, from the front
    // Orders the history after `written` ticks were written into it as a ring: the newest ones that fit, oldest first.
    void keep(std::uint64_t written);
  };

  std::uint64_t opening{0};  // number of the open() in this program; a saved state has the one of its session
  Scene scene;
  Options options;
  std::vector<session::RunOptions> run_options;  // by hand
  std::vector<Device*> devices;                  // the caller's, by hand; null: none. Empty: none at all

  std::optional<session::Hands> hands;
  std::vector<session::Session*> sessions;         // of `hands`
  std::deque<Hand> each;                           // by hand
  std::optional<session::VirtualRun> virtual_run;  // none in real time
  bool closed{false};
  bool in_monitor{false};
  std::atomic<bool> stop{false};

  library::StateView view;
  bool view_is_old{true};

  std::unique_ptr<Ring> ring;       // ticks of a real-time run
  std::uint64_t dropped_before{0};  // ticks that did not fit in the ring, until the last look
  std::unique_ptr<library::StateHandOver> hand_over;

  // Builds everything from the scene and the options. Errors name options as on the command line.
  Error build();
  Error start_devices();
  void end();  // stops the devices and closes the tapes
  bool ended() const noexcept { return each.front().ended.has_value(); }

  void step(std::uint64_t ticks);
  Error run(double duration_s, const Monitor& monitor);
  void look();
  session::RunSummary summary(unsigned hand) const;

 private:
  Error check() const;
  Error build_device(unsigned hand, session::Hardware& hardware);
  void make_real_time();
  std::uint64_t take_ticks();
  std::vector<std::uint32_t> asked_;  // OperatorBits of the tick, by hand
};

}  // namespace tactus
