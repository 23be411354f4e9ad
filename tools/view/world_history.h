// The world outside of the sub-world for every cycle of a tape, rebuilt by a thread of its own while the tape is shown.
//
// The poses go to a temporary file without a name, so that going back costs a read. Where the world cannot be rebuilt,
// or no further, note() says why.
// Thread: construction and destruction: one; the rest [any]. Bound: kMaxBytes of the file; the rebuilding ends there.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "tools/publication/watcher.h"
#include "tools/session/world_rebuilder.h"

namespace tactus::view {

inline constexpr std::uint64_t kMaxBytes = std::uint64_t{2} << 30;

class WorldHistory {
 public:
  // `bodies`: moving bodies of the scene; `first_tick`: of the tape.
  WorldHistory(std::string path, std::size_t bodies, std::uint64_t first_tick);
  ~WorldHistory();
  WorldHistory(const WorldHistory&) = delete;
  WorldHistory& operator=(const WorldHistory&) = delete;

  // Positions, rotations and roles of all moving bodies when the snapshot of this cycle was made; of the roles
  // kIsAsleep alone. False: not rebuilt, or not yet.
  bool read(std::uint64_t cycle, publication::Frame& frame) const;

  std::uint64_t cycles() const noexcept { return cycles_.load(std::memory_order_acquire); }  // rebuilt so far
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }
  std::string note() const;  // why it ended before the tape did; empty: it did not
  // Of the rebuilt world at the tape's end; empty: it was not rebuilt so far.
  std::optional<sim::GlobalStatistics> statistics() const;

 private:
  void rebuild();
  Status run();
  Status take(const loop::TapeRecord& record);
  Status store(const sim::GlobalWorld& world);

  std::string path_;
  std::size_t bodies_, stride_;
  std::uint64_t first_tick_;
  int file_{-1};
  std::atomic<std::uint64_t> cycles_{0};
  std::atomic<bool> done_{false}, stop_{false};
  mutable std::mutex mutex_;
  std::string note_;
  std::optional<sim::GlobalStatistics> statistics_;
  std::unique_ptr<session::TapePlayer> player_;
  std::unique_ptr<session::WorldRebuilder> rebuilder_;
  std::vector<std::byte> bytes_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace tactus::view
