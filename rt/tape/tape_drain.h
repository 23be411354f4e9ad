// Empties the loop's ring into a tape while recording, and always into a history in memory, which a fault dumps.
//
// The loop never waits for the drain and never wakes it: the drain polls at an interval. A ring of capacity B bridges B
// / (bytes per tick) ticks of a stalled disk; records lost beyond that are counted and marked by a kTapeGap record. A
// write error ends the tape and nothing else.
// Thread: construction and all calls from normal-priority threads; start() adds a thread; without it the owner calls
// drain() (virtual time). Bound: ring and history; the thread's stack is small because memory is locked.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/base/ring.h"
#include "rt/tape/tape.h"
#include "rt/tape/tape_history.h"

namespace tactus::loop {

// A callback for every record that the drain takes from the ring, before it goes to the tape. The draining thread calls
// it; the payload is valid during the call. Null: no callback.
struct RecordTap {
  void (*taken)(void* context, std::uint32_t kind, std::span<const std::byte> payload) noexcept {nullptr};
  void* context{nullptr};
};

struct DrainSettings {
  std::size_t history_bytes{32u << 20};
  std::uint32_t keyframe_kind{0};
  std::uint32_t tick_kind{0};              // kind of the tick records; those that do not reach the tape are counted
  std::chrono::milliseconds interval{10};  // between two polls of the ring
  RecordTap tap{};
  std::uint32_t tap_only_kind{0};  // kind of the records that neither tape nor history keeps; 0: none
};

class TapeDrain {
 public:
  // The only consumer of the ring. `tape`: null if nothing is recorded.
  TapeDrain(Ring& ring, const DrainSettings& settings, std::unique_ptr<TapeWriter> tape = nullptr);
  ~TapeDrain() { (void)stop(); }
  TapeDrain(const TapeDrain&) = delete;
  TapeDrain& operator=(const TapeDrain&) = delete;

  Status start();  // starts the drain's thread, until stop()
  // Takes the present content of the ring, at most one full ring. For use without start(), or in addition to it.
  void drain();
  // Ends the thread, drains the rest, closes the tape. Returns the tape's status: the first error while recording.
  Status stop();

  // Writes the history and the present content of the ring as a tape. May be called repeatedly.
  Status dump(const std::string& path, std::string_view text);

  struct Counts {
    std::uint64_t records{0};            // taken from the ring
    std::uint64_t bytes{0};              // of payload
    std::uint64_t lost{0};               // dropped because the ring was full
    std::uint64_t not_kept{0};           // not in the history: no keyframe before them
    std::uint64_t ticks_not_written{0};  // of tick_kind: lost by a write error of the tape; final after stop()
  };
  Counts counts() const;

 private:
  static void* enter(void* self) noexcept;
  void run();
  void drain_locked();
  void mark_gap(std::uint64_t lost);
  void take(std::uint32_t kind, std::span<const std::byte> payload);
  void write(std::uint32_t kind, std::span<const std::byte> payload);
  void forget_written_ticks();

  Ring& ring_;
  DrainSettings settings_;
  mutable std::mutex mutex_;  // protects all members below; the loop never takes it
  std::condition_variable wake_;
  std::unique_ptr<TapeWriter> tape_;
  Status tape_status_{Status::good()};
  std::deque<std::uint64_t> waiting_ticks_;  // end offset on the tape of each tick that is not yet in the file
  std::uint64_t ticks_not_written_{0};
  TapeHistory history_;
  std::vector<std::byte> payload_;
  std::uint64_t records_{0}, payload_bytes_{0}, lost_marked_{0};
  bool stop_{false};
  bool started_{false};
  unsigned long thread_{0};  // pthread_t
};

}  // namespace tactus::loop
