/// \file
/// A scene under a device: the front door of the library, and the one that `tactus run` goes through.
///
/// In virtual time the caller ticks; in real time run() has threads of its own. Units: SI, in the names. Frame: world,
/// but for what is the device's. Source: L. Glondu, M. Marchal, G. Dumont, "A new coupling scheme for haptic rendering
/// of rigid bodies interactions based on a haptic sub-world using a contact graph".
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

/// What a person asks of a session that runs.
enum class Request : std::uint32_t {
  kArm = 1u << 0,         ///< force on, from nothing to all over 0.2 s
  kRearm = 1u << 1,       ///< a latched fault is taken back, then as kArm; without a fault nothing
  kDisarm = 1u << 2,      ///< force off
  kResetScene = 1u << 4,  ///< the next trial: the force fades, all bodies go back, the force returns. Not with `direct`
};

/// What a Monitor sees of a run in real time.
struct Progress {
  std::span<const Tick> ticks;  ///< done since the last look, oldest first; valid until the monitor returns
  std::uint64_t ticks_lost{0};  ///< that this look lacks: more than Options::history_ticks went by
  std::uint64_t overruns{0};    ///< ticks past their deadline, since the start
  double elapsed_s{0};          ///< wall clock, since the start
};

/// Looks at a run in real time; returns false to end it. Called by the thread that called run(), a normal one, about 30
/// times a second: it may take its time, allocate and print, and the haptic thread does not notice.
using Monitor = std::function<bool(const Progress&)>;

/// A scene under a device.
///
/// Thread: all calls by one thread at a time, but request() and stop(), which any thread may call while the session is
/// not being opened, moved or destroyed; several sessions are independent. A session that is not open does nothing: its
/// calls give an Error (kUse), its views are empty.
/// Views: the spans of bodies(), roles(), members(), contacts(), border_contacts() and ticks() are of the session's own
/// memory, without a copy. That memory stays where it is until the session is opened anew, moved from or destroyed; the
/// call brings it up to date, so of a span that was kept the content changes with the next call of the same name.
class Session {
 public:
  Session() noexcept;                      ///< not open
  ~Session();                              ///< as close()
  Session(Session&& other) noexcept;       ///< `other` is not open then
  Session& operator=(Session&&) noexcept;  ///< closes what was open here

  /// Builds everything that a run needs; may take seconds for a large scene. What was open before is closed first.
  /// \param scene_file as Scene::load
  /// \param options how to run it
  /// \return kFile, kOption or kMachine; the session is not open then
  Error open(const std::filesystem::path& scene_file, const Options& options = {});
  /// The same of a scene that was read before.
  Error open(const Scene& scene, const Options& options = {});
  /// The same with a device of one's own, which must outlive the session.
  Error open(const Scene& scene, const Options& options, Device& device);
  /// Open, and not closed since.
  bool is_open() const noexcept;

  /// Writes a tape of all that follows, for replay_tape and `tactus replay`. Before the first tick.
  ///
  /// A recorded run() that ends with a fault latched, or lost a tick to its own work, also leaves its last seconds in
  /// `tactus-fault.tape` in the working directory, in place of an earlier one: the *flight recorder* of summary().
  ///
  /// \param tape is written over
  /// \return kUse: not open, or ticks have been; kFile: it cannot be written
  Error record(const std::filesystem::path& tape);

  /// One tick in virtual time: the device is read, the sub-world moves, the force is written; where a global step is
  /// due it is taken, too. Allocates nothing, but for a step that resets the scene and for a tape. \return
  /// kUse: not open, in real time, or ended; kMachine: the device did not start
  Error tick() { return step(1); }
  /// As many ticks; stop() ends them early. What the device's code throws or prints is not the library's.
  Error step(std::uint64_t ticks);

  /// Runs in real time and returns when it is over: after `duration_s`, or as the monitor or stop() says. Once for each
  /// open() or reset().
  /// \param duration_s 0: until told to end
  /// \param monitor looks at it; may be empty
  /// \return kUse, kOption: not open, in virtual time, done before, a bad duration; kMachine: threads or the device did
  /// not start. Faults and lost ticks are no errors: see summary()
  Error run(double duration_s, const Monitor& monitor = {});

  /// Begins from nothing with the same scene, options and device: the same bits again. A tape is ended.
  Error reset();
  /// Ends the session and its tape; last(), ticks(), summary() and state_hash() still show what was.
  /// \return kFile: the tape could not be written to its end
  Error close();

  /// [any] Asks for something, for the next tick.
  void request(Request request) noexcept;
  /// [any] Ends the step() or run() that is under way after its present tick; where none is, the next one before its
  /// first. May be called by a signal handler, a Device or another thread.
  void stop() noexcept;

  /// The newest tick; all zero before the first.
  const Tick& last() const noexcept;
  /// The ticks of the last step(), or the end of the last run(), oldest first; the newest Options::history_ticks at
  /// most.
  std::span<const Tick> ticks() const noexcept;
  /// Since open() or reset().
  std::uint64_t ticks_done() const noexcept;
  /// On the haptic clock: ticks_done() periods.
  double time_s() const noexcept;
  /// Of a tick.
  double period_s() const noexcept;

  /// All bodies by number. Members are as of the last tick, the others as of the last global step. In a Monitor: as of
  /// a global step not long ago; with the coupling `direct`, which has none, as at the start.
  std::span<const BodyState> bodies() const;
  /// Who simulates each body, by number; as of when bodies() is.
  std::span<const Role> roles() const;
  /// Bodies of the sub-world, ascending; as of when bodies() is.
  std::span<const BodyNumber> members() const;
  /// Points that press or overlap in the sub-world. Empty in a Monitor: there the haptic thread has them.
  std::span<const Contact> contacts() const;
  /// Points that press between members and outside bodies. Empty in a Monitor: there the haptic thread has them.
  std::span<const BorderContact> border_contacts() const;

  /// Of the sub-world: poses, velocities, contacts and couplings of its bodies. Equal for runs of the same bits. With
  /// the plane couplings the sub-world is the proxy alone. 0 in a Monitor.
  std::uint64_t state_hash() const noexcept;
  /// What was changed about what was asked for, such as gains lowered for the coupling; one line each.
  std::vector<std::string> notes() const;
  /// What the run amounts to so far. Empty in a Monitor: there the haptic thread has the books.
  Summary summary() const;

  /// That it was opened with.
  const Scene& scene() const noexcept;
  /// That it was opened with.
  const Options& options() const noexcept;

 private:
  friend struct library::Access;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tactus
