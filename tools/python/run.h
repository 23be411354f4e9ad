// A session in virtual time as Python drives it: the library's Session, the hands that Python leads, and the ticks that
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
#include <vector>

#include "tactus/session.h"
#include "tools/python/errors.h"
#include "tools/python/hand_device.h"

namespace tactus::python {

// Targets of a hand for a block of ticks, a row each: position, or position and rotation; or wrenches.
struct Targets {
  std::vector<HandWish> rows;
  // Raises OptionError: another shape, or a number that is not finite. Rotations are normalised.
  static Targets from(const pybind11::handle& value);
};

// The state that Run::save gives to Python.
struct Saved : ZeroedByPython {
  using ZeroedByPython::made;
  SavedState session;
  std::vector<std::optional<HandDevice::State>> hands;
};

class Run {
 public:
  // `hand`: None, the scene's own script; a callable; "targets"; or a list or tuple of these, one for each hand of the
  // scene. Raises.
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
  // One tick for each row. `targets`: (ticks, 3) or (ticks, 7) numbers, or (ticks, 6), wrenches; with several hands a
  // sequence of these, one for each hand, or None: it is led as without targets. Raises.
  void step(const pybind11::handle& targets);
  void reset();
  Saved save() const;
  void restore(const Saved& saved);

  // Of one hand, which must be there: the ticks since the last look.
  std::vector<Tick> look(unsigned hand);
  std::uint64_t ticks_lost(unsigned hand) const noexcept { return hands_[hand].lost_of_look; }
  // Fills its views with NaN, role 255 and member 4294967295: the scene was replaced.
  void leave_views();

  Session& session() noexcept { return session_; }
  const Session& session() const noexcept { return session_; }
  // Call before Python gets a view of the bodies: from then on each step refreshes it.
  void show_bodies() noexcept { shown_ = true; }

 private:
  struct Hand {
    std::unique_ptr<HandDevice> device;  // null: the scene's own script leads it
    pybind11::object function;
    std::optional<Targets> block;  // of the step that is under way
    std::size_t next_row{0};
    std::vector<Tick> unseen;
    std::uint64_t lost{0}, lost_of_look{0};
  };

  void lead(unsigned hand, const pybind11::handle& leader, const sim::Scene& scene, const Options& options);
  bool ask(Hand& hand, const HandAsked& asked, HandWish& wish) noexcept;
  bool ask_function(const Hand& hand, const HandAsked& asked, HandWish& wish);
  std::uint64_t take_targets(const pybind11::handle& targets);
  void keep_ticks(unsigned hand);
  void end_with_error_of_hand();
  void forget_ticks();

  std::vector<Hand> hands_;  // they outlive the session
  Session session_;
  std::exception_ptr error_of_hand_;
  bool shown_{false};
  mutable std::atomic<bool> busy_{false};
};

}  // namespace tactus::python
