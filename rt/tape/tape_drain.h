// Empties the loop's ring: into a tape while recording, and always into a history in memory that a fault dumps.
//
// The loop never waits for it and never wakes it: the drain looks by itself every so often. A ring of capacity B takes
// B / (bytes a tick) ticks of a stalled disk; what is lost then is counted and marked by a kTapeGap record. A disk that
// takes no more ends the tape, and nothing else.
// Thread: construction and all calls from normal-priority threads; start() adds a thread of its own, without it the
// owner calls drain() (virtual time). Bound: ring, history; the thread's stack is small because locked.
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

struct DrainSettings {
  std::size_t history_bytes{32u << 20};
  std::uint32_t keyframe_kind{0};
  std::uint32_t tick_kind{0};              // counted where they do not come on the tape
  std::chrono::milliseconds interval{10};  // between two looks
};

class TapeDrain {
 public:
  // The only consumer of the ring. `tape` is null when nothing is recorded.
  TapeDrain(Ring& ring, const DrainSettings& settings, std::unique_ptr<TapeWriter> tape = nullptr);
  ~TapeDrain() { (void)stop(); }
  TapeDrain(const TapeDrain&) = delete;
  TapeDrain& operator=(const TapeDrain&) = delete;

  Status start();  // its own thread, until stop()
  // Takes what is in the ring now, at most a ring full. Without start(), or between.
  void drain();
  // Ends the thread, drains the rest, closes the tape. The status is the tape's: the first error while recording.
  Status stop();

  // Writes the history, with what the ring holds now, as a tape. Any number of times.
  Status dump(const std::string& path, std::string_view text);

  struct Counts {
    std::uint64_t records{0};            // taken from the ring
    std::uint64_t bytes{0};              // of payload
    std::uint64_t lost{0};               // dropped at a full ring
    std::uint64_t not_kept{0};           // not in the history: no keyframe before them
    std::uint64_t ticks_not_written{0};  // of tick_kind: not on the tape for an error of it; final after stop()
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
  mutable std::mutex mutex_;  // all below; the loop never takes it
  std::condition_variable wake_;
  std::unique_ptr<TapeWriter> tape_;
  Status tape_status_{Status::good()};
  std::deque<std::uint64_t> waiting_ticks_;  // where each tick that is not in the file yet ends in it
  std::uint64_t ticks_not_written_{0};
  TapeHistory history_;
  std::vector<std::byte> payload_;
  std::uint64_t records_{0}, payload_bytes_{0}, lost_marked_{0};
  bool stop_{false};
  bool started_{false};
  unsigned long thread_{0};  // pthread_t
};

}  // namespace tactus::loop
