// A tape at any of its ticks: its signals as recorded, its bodies as the loop had them when it is run again.
//
// Members come from the replayed loop in every tick, bodies outside from the rebuilt world of the cycle
// (world_history.h), or they are unknown. A tick is the same however it is reached: by playing on, or from the keyframe
// before it.
// Thread: one, normal, with denormals flushed; it starts one to rebuild the world. Frame: world. Units: SI. Bound: a
// seek reads kTicksBefore ticks and runs at most a keyframe interval of them.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tools/publication/watcher.h"
#include "tools/view/tape_index.h"
#include "tools/view/world_history.h"

namespace tactus::view {

inline constexpr std::uint64_t kTicksBefore = 4000;  // that come with a seek, for the plots

class TapeShow {
 public:
  // Error, one line: as of replay; and of a tape without a tick that can be shown.
  static Result<std::unique_ptr<TapeShow>> open(const std::string& path);

  const session::OpenTape& tape() const noexcept { return tape_; }
  const sim::Scene& scene() const noexcept { return session_->scene; }
  const TapeIndex& index() const noexcept { return index_; }
  double period_s() const noexcept { return tape_.settings.options.period_s(); }
  const WorldHistory& history() const noexcept { return *history_; }
  // Of the whole tape, by the rules of `tactus run`: those that can be judged from a tape. Empty: the world outside is
  // still being rebuilt.
  const std::optional<session::RunVerdict>& verdict();

  std::uint64_t tick() const noexcept { return tick_; }  // that is shown
  bool at_end() const noexcept { return tick_ >= index_.last_tick; }

  // Goes to the first tick at or after `tick`; the ticks before it and itself are appended. False: none is left, or the
  // file cannot be read.
  bool seek(std::uint64_t tick, std::vector<publication::TickEntry>& ticks);
  // Plays the next tick and appends it. False: there is none.
  bool step(std::vector<publication::TickEntry>& ticks);
  bool adopted() const noexcept { return adopted_; }  // in this tick a cycle began

  // The bodies and contact forces of the shown tick.
  void take_frame(publication::Frame& frame) const;

 private:
  TapeShow(session::OpenTape tape, std::unique_ptr<session::Session> session);
  bool next_tick(bool play, publication::TickEntry& entry);
  void add_members(publication::Frame& frame) const;
  void add_contacts(publication::Frame& frame) const;

  session::OpenTape tape_;
  std::unique_ptr<session::Session> session_;
  session::RunningSummary counts_;  // before the player takes the session's loop
  TapeIndex index_;
  std::optional<session::RunVerdict> verdict_;
  session::TapePlayer player_;
  std::vector<std::uint32_t> place_of_;  // by body id: its place among the moving bodies
  std::size_t bodies_{0};                // moving ones
  std::unique_ptr<WorldHistory> history_;
  std::uint64_t tick_{0};
  bool played_{false}, adopted_{false};
};

}  // namespace tactus::view
