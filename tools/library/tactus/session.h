/// \file
/// Runs a scene with a device: the main class of the library, which `tactus run` also uses.
///
/// Virtual time: the caller's thread computes each tick. Real time: run() starts its own threads. Units: SI, in the
/// names. Frame: world, unless a description says device frame. Source: L. Glondu, M. Marchal, G. Dumont, "A new
/// coupling scheme for haptic rendering of rigid bodies interactions based on a haptic sub-world using a contact
/// graph".
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tactus/device.h"
#include "tactus/error.h"
#include "tactus/options.h"
#include "tactus/scene.h"
#include "tactus/state.h"
#include "tactus/summary.h"
#include "tactus/tick.h"

namespace tactus {

/// Operator requests to a running session.
enum class Request : std::uint32_t {
  kArm = 1u << 0,         ///< force on, faded in over 0.2 s
  kRearm = 1u << 1,       ///< clears a latched fault, then as kArm; no effect without a fault
  kDisarm = 1u << 2,      ///< force off
  kResetScene = 1u << 4,  ///< next trial: the force fades out, all bodies return to their initial state, the force
                          ///< fades in. Not with `direct`
};

/// State of a real-time run, passed to a Monitor.
struct Progress {
  std::span<const Tick> ticks;  ///< ticks since the last call, oldest first; valid until the monitor returns
  std::uint64_t ticks_lost{0};  ///< ticks missing from this call, because more than Options::history_ticks passed
  std::uint64_t overruns{0};    ///< ticks past their deadline, since the start
  double elapsed_s{0};          ///< wall clock, since the start
};

/// Observes a real-time run; returns false to end it. Called about 30 times a second by the thread that called run(), a
/// normal one. It may allocate, print and take long; the haptic thread is not affected.
using Monitor = std::function<bool(const Progress&)>;

/// State of a session in virtual time, for Session::restore; copies share it. Megabytes for a large scene.
class SavedState {
 public:
  /// Nothing is saved.
  SavedState() = default;
  /// True before Session::save.
  bool empty() const noexcept { return state_ == nullptr; }

 private:
  friend class Session;
  struct State;
  std::shared_ptr<const State> state_;
};

/// A run of a scene with a device, or with a device for each of several hands.
///
/// Hands: a scene with several [[proxy]] has as many hands, numbered from 0, and a device for each; virtual time only.
/// Each hand has a sub-world of its own; what one does reaches the others through the global world. Calls with the
/// parameter `hand` are of that hand; for a number that is not below hands() they return what they return of a session
/// that is not open.
/// Thread: all calls from one thread at a time, except request() and stop(): any thread may call these two while the
/// session is not being opened, moved or destroyed. Several sessions are independent. On a session that is not open,
/// calls return an Error (kUse) and views are empty.
/// Views: the spans of bodies(), roles(), members(), contacts(), border_contacts() and ticks() point into the session's
/// memory; nothing is copied. That memory stays at its address until the session is opened again, moved from or
/// destroyed. A call updates it, so the content of an older span changes with the next call of the same name.
class Session {
 public:
  Session() noexcept;                      ///< not open
  ~Session();                              ///< same as close()
  Session(Session&& other) noexcept;       ///< `other` is not open afterwards
  Session& operator=(Session&&) noexcept;  ///< closes this session first

  /// Builds everything that a run needs; may take seconds for a large scene. Closes this session first if it is open.
  /// \param scene_file as Scene::load
  /// \param options how to run it
  /// \return kFile, kOption or kMachine; after an error the session is not open
  Error open(const std::filesystem::path& scene_file, const Options& options = {});
  /// Same, with a scene that has already been read.
  Error open(const Scene& scene, const Options& options = {});
  /// Same, with the caller's device, which must outlive the session.
  Error open(const Scene& scene, const Options& options, Device& device);
  /// Same, with several hands: `devices` has one for each hand of the scene, which must outlive the session; null: the
  /// simulated one.
  Error open(const Scene& scene, const Options& options, std::span<Device* const> devices);
  /// True after a successful open(), until close().
  bool is_open() const noexcept;
  /// Number of hands; 0 if the session was not opened.
  unsigned hands() const noexcept;

  /// Writes a tape of all following ticks, for replay_tape and `tactus replay`. Call it before the first tick. With
  /// several hands a tape each: `my.tape` of the first, `my.2.tape` of the second.
  ///
  /// A recorded run() that ends with a fault latched, or lost a tick to its own work, also leaves its last seconds in
  /// `tactus-fault.tape` in the working directory, in place of an earlier one: the *flight recorder* of summary().
  ///
  /// \param tape file; overwritten if it exists
  /// \return kUse: not open, or a tick has been computed; kFile: the file cannot be written
  Error record(const std::filesystem::path& tape);

  /// Computes one tick in virtual time: reads the device, advances the sub-world, writes the force, and takes a step of
  /// the global world if one is due. Does not allocate, except for a scene reset and a tape.
  /// \return kUse: not open, in real time, or ended; kMachine: the device did not start
  Error tick() { return step(1); }
  /// Computes `ticks` ticks; stop() ends it early. Exceptions and output of a Device's own code are not handled.
  Error step(std::uint64_t ticks);

  /// Runs in real time. Returns after `duration_s`, or when the monitor or stop() ends the run. May be called once
  /// after each open() or reset().
  /// \param duration_s 0: until the monitor or stop() ends it
  /// \param monitor observes the run; may be empty
  /// \return kUse, kOption: not open, in virtual time, already run, invalid duration; kMachine: threads or the device
  /// did not start. Faults and lost ticks are not errors: see summary()
  Error run(double duration_s, const Monitor& monitor = {});

  /// Restarts with the same scene, options and device; gives the same bits again. Closes the tape.
  Error reset();
  /// Ends the session and its tape; last(), ticks(), summary() and state_hash() keep their last values.
  /// \return kFile: the tape could not be written completely
  Error close();

  /// Saves everything that the following ticks depend on. A Device of the caller's own saves its state itself. Virtual
  /// time only.
  /// \param saved the result
  /// \return kUse: not open, in real time, or ended
  Error save(SavedState& saved) const;
  /// Continues from a state that this session saved, also after reset(); the ticks that follow give the same bits as
  /// they did then. last() is as it was, ticks() is empty.
  /// \return kUse: not open, in real time, ended, with a tape, or another session's state
  Error restore(const SavedState& saved);

  /// [any] Requests an action for the next tick. A scene reset of one hand resets the scene for all hands.
  void request(Request request, unsigned hand = 0) noexcept;
  /// [any] Ends the running step() or run() after its current tick; if none is running, the next one before its first
  /// tick. May be called by a signal handler, a Device or another thread.
  void stop() noexcept;

  /// The latest tick; all zero before the first.
  const Tick& last(unsigned hand = 0) const noexcept;
  /// The ticks of the last step() or run(), oldest first; at most the latest Options::history_ticks.
  std::span<const Tick> ticks(unsigned hand = 0) const noexcept;
  /// Number of ticks since open() or reset().
  std::uint64_t ticks_done() const noexcept;
  /// Haptic time: ticks_done() periods [s].
  double time_s() const noexcept;
  /// Period of a tick [s].
  double period_s() const noexcept;

  /// All bodies by number. Members of any hand are as of the last tick, the others as of the last global step. In a
  /// Monitor all are as of a recent global step; with the coupling `direct`, which has no global world, as at the
  /// start.
  std::span<const BodyState> bodies() const;
  /// Where each body is simulated, by number, from the view of one hand: for it, a member of another hand's sub-world
  /// is simulated by the global world. At the same time as bodies().
  std::span<const Role> roles(unsigned hand = 0) const;
  /// Bodies of the sub-world, ascending; as of when bodies() is. A body is a member of one hand's at most.
  std::span<const BodyNumber> members(unsigned hand = 0) const;
  /// Contact points of the sub-world with a force or an overlap. Empty in a Monitor: the haptic thread is using them.
  std::span<const Contact> contacts(unsigned hand = 0) const;
  /// Border contact points with a force, between members and outside bodies. Empty in a Monitor, as contacts().
  std::span<const BorderContact> border_contacts(unsigned hand = 0) const;

  /// Hash of the sub-world's state: poses, velocities, contacts and couplings of its bodies. Equal for bit-identical
  /// runs. With the plane couplings the sub-world is the proxy alone. 0 in a Monitor.
  std::uint64_t state_hash(unsigned hand = 0) const noexcept;
  /// Changes made to the requested settings, such as gains lowered for the coupling scheme; one line each.
  std::vector<std::string> notes(unsigned hand = 0) const;
  /// Statistics and verdict of the run so far. Empty in a Monitor: the haptic thread is using them.
  Summary summary(unsigned hand = 0) const;

  /// The scene that it was opened with.
  const Scene& scene() const noexcept;
  /// The options that it was opened with.
  const Options& options() const noexcept;

 private:
  friend struct library::Access;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tactus
