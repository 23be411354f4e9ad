// The controller's side of the shared memory (layout.h): writes ticks, poses and contacts while a watcher is attached.
//
// Ticks come from where the tape takes them, frames from the global thread after a step, at most kMaxFrames_Hz a
// second; with the direct coupling, which has no global world, from the flight recorder. Without a watcher nothing is
// packed: what it costs is one atomic load. The writer never waits for a reader, and no reader can write. Thread:
// construction [setup]; tap: the tape's drain; stepped: the global world's thread; watchers: [any]; say: one, normal.
// The haptic thread writes nothing here. Frame: world. Units: SI. Bound: memory by the number of bodies, allocated at
// creation: 9 MB and 63 bytes a body. Errors: of the operating system, at creation.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/tape/tape_drain.h"
#include "sim/global_world.h"
#include "tools/publication/layout.h"

namespace tactus::publication {

inline constexpr double kMaxFrames_Hz = 60;

class Publication {
 public:
  // `text`: the text of a tape's header.
  static Result<std::unique_ptr<Publication>> create(const sim::Scene& scene, double period_s, const std::string& text);
  ~Publication();
  Publication(const Publication&) = delete;
  Publication& operator=(const Publication&) = delete;

  // For a watcher: the memory, open for reading only. This object keeps the descriptor.
  int descriptor() const noexcept { return read_only_; }
  // Number of watchers; the server that passes the descriptor on counts them.
  std::atomic<std::uint32_t>& watchers() noexcept { return watchers_; }
  const std::atomic<std::uint32_t>& watchers() const noexcept { return watchers_; }

  // For the drain: takes tick records, their times, and bodies of the direct coupling.
  loop::RecordTap tap() noexcept { return {&Publication::taken, this}; }
  // For the global world's thread; `self` is the publication.
  static void stepped(void* self, const sim::GlobalWorld& world) noexcept;

  // The state of the run (StateSlot); by the thread that watches the run. A text that does not fit is left out, and
  // the one before stays.
  void say(std::string_view state) noexcept;

  std::uint64_t frames() const noexcept { return frames_; }  // written so far
  std::uint64_t ticks() const noexcept { return ticks_; }

 private:
  Publication(int memory, int read_only, std::byte* bytes, const Header& header);
  static void taken(void* self, std::uint32_t kind, std::span<const std::byte> payload) noexcept;
  void take_tick(std::span<const std::byte> payload) noexcept;
  void take_times(std::span<const std::byte> payload) noexcept;
  void take_bodies(std::span<const std::byte> payload) noexcept;
  void write_tick() noexcept;
  std::uint32_t device_in(const sim::GlobalWorld& world) const noexcept;
  void pack(const sim::GlobalWorld& world) noexcept;
  void pack_roles(const sim::GlobalWorld& world) noexcept;
  void pack_contacts(const sim::GlobalWorld& world) noexcept;
  void add_contact(const physics::Contact& contact, const sim::GlobalWorld& world, double per_s) noexcept;
  void write_frame() noexcept;

  int memory_, read_only_;
  std::byte* bytes_;
  Header header_;
  std::atomic<std::uint32_t> watchers_{0};
  std::uint64_t frames_{0}, ticks_{0}, states_{0};
  // A tick whose stage times have not arrived; written with them, or when the next tick arrives.
  std::optional<TickEntry> pending_;
  std::int64_t next_frame_ns_{0};
  BodyId proxy_{kNoBody};
  std::vector<std::uint32_t> place_of_;  // by body id: its place among the moving bodies
  // The frame that is being packed; capacities are reserved.
  FrameHead head_;
  std::vector<Position> positions_;
  std::vector<Rotation> rotations_;
  std::vector<std::uint8_t> roles_, in_component_;
  std::vector<ContactForce> contacts_;
};

}  // namespace tactus::publication
