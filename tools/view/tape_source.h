// One tape, or two in step with each other, with a clock that pages play, stop, move and slow down.
//
// All pages of a viewer look at the same moment. Thread: one, the server's, with denormals flushed. Bound: a look
// plays for kLook_ms at most: where the ticks take longer, the clock waits for them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/view/tape_show.h"
#include "tools/view/view_source.h"

namespace tactus::view {

class TapeSource final : public ViewSource {
 public:
  // One or two paths. Error, one line: as of replay.
  static Result<std::unique_ptr<TapeSource>> open(const std::vector<std::string>& paths);

  std::size_t views() const override { return shows_.size(); }
  const std::string& scene(std::size_t view) const override { return scenes_[view]; }
  Update look(std::size_t view, std::vector<publication::TickEntry>& ticks, publication::Frame& frame) override;
  std::string status() override;
  Answer ask(const PageMessage& message) override;
  void joined() override { seek_to_s_ = seek_to_s_.value_or(clock_s_); }

  // Moves the clock by `passed_s` of real time, as far as the ticks can be played within `budget_ns`. Public for tests.
  void advance(double passed_s, std::int64_t budget_ns);
  double clock_s() const noexcept { return clock_s_; }
  bool playing() const noexcept { return playing_; }

 private:
  struct Fresh {  // since the last look
    std::vector<publication::TickEntry> ticks;
    bool frame{true}, restarted{true};
    std::uint64_t cycles{0};  // rebuilt, at the last look
  };
  void seek(double to_s);
  bool step_to(double to_s, std::int64_t until_ns);
  void step_cycle();
  std::uint64_t tick_at(const TapeShow& show, double time_s) const;
  double end_s() const;
  double begin_s() const;
  std::string note(const TapeShow& show) const;
  static std::string judged(const TapeShow& show);

  std::vector<std::unique_ptr<TapeShow>> shows_;
  std::vector<std::string> scenes_;
  std::vector<Fresh> fresh_;
  bool playing_{false};
  double pace_{1};     // of real time; 0: as fast as it goes
  double clock_s_{0};  // the end of the shown tick
  std::optional<double> seek_to_s_;
  std::int64_t last_look_ns_{0};
};

}  // namespace tactus::view
