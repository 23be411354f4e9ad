// A session in virtual time as Python drives it: the library's Session, the hand that Python leads, and the ticks that
// look() has not returned yet. A view of its memory shares it, so that the memory lives as long as the view.
//
// Thread: one call at a time, see Run::Call; step() computes without the GIL, and takes it for a hand that is a
// function. Bound: history_ticks ticks that were not looked at; the oldest are dropped first, and counted.
#pragma once

#include <pybind11/numpy.h>

#include <atomic>
#include <exception>
#include <memory>
#include <optional>

#include "tactus/session.h"
#include "tools/python/hand_device.h"

namespace tactus::python {

// Targets of the hand for a block of ticks, a row each: position, or position and rotation.
struct Targets {
  std::vector<HandPose> rows;
  // Raises OptionError: another shape, or a number that is not finite. Rotations are normalised.
  static Targets from(const pybind11::handle& value);
};

// What Run::save gives to Python.
struct Saved {
  SavedState session;
  std::optional<HandDevice::State> hand;
};

class Run {
 public:
  // `hand`: None, the scene's own script; a callable; "targets". Raises.
  Run(const Scene& scene, const pybind11::object& hand, const Options& options);

  // While it lives no other thread, and no hand, can call the run: they get a UseError.
  class Call {
   public:
    Call(const Run& run, const char* name);
    ~Call() { run_.busy_.store(false, std::memory_order_release); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    const Run& run_;
  };

  void step(std::uint64_t ticks);
  void step(const Targets& targets);
  void reset();
  Saved save() const;
  void restore(const Saved& saved);

  // The ticks since the last look.
  std::vector<Tick> look();
  std::uint64_t ticks_lost() const noexcept { return lost_of_look_; }
  // Its views show NaN from now on, roles 255 and members 4294967295: the scene was replaced.
  void leave_views();

  Session& session() noexcept { return session_; }
  const Session& session() const noexcept { return session_; }
  // Said before a view of the bodies is given away: from then on each step refreshes it.
  void show_bodies() noexcept { shown_ = true; }

 private:
  bool ask(const HandAsked& asked, HandPose& target) noexcept;
  bool ask_function(const HandAsked& asked, HandPose& target);
  void keep_ticks();
  void end_with_error_of_hand();

  std::unique_ptr<HandDevice> hand_;  // outlives the session
  Session session_;
  pybind11::object function_;
  const Targets* block_{nullptr};
  std::size_t next_row_{0};
  std::exception_ptr error_of_hand_;
  std::vector<Tick> unseen_;
  std::uint64_t lost_{0}, lost_of_look_{0};
  bool shown_{false};
  mutable std::atomic<bool> busy_{false};
};

}  // namespace tactus::python
