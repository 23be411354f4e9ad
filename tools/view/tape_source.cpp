#include "tools/view/tape_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "rt/base/clock.h"
#include "rt/base/denormals.h"
#include "tools/json_text.h"
#include "tools/view/scene_text.h"

namespace tactus::view {
namespace {

constexpr std::int64_t kLook_ns = 12'000'000;
constexpr double kLongestPause_s = 0.1;  // the most real time between two looks that counts: the clock does not jump
constexpr double kWithinTick = 0.5;      // of a tick: times are of ticks' ends

}  // namespace

Result<std::unique_ptr<TapeSource>> TapeSource::open(const std::vector<std::string>& paths) {
  set_denormals_flush();
  auto source = std::make_unique<TapeSource>();
  for (const std::string& path : paths) {
    auto show = TapeShow::open(path);
    if (!show.ok()) return show.status();
    source->scenes_.push_back(scene_text(show.value()->scene(), show.value()->tape().settings));
    source->shows_.push_back(std::move(show).value());
  }
  source->fresh_.resize(paths.size());
  source->seek_to_s_ = source->begin_s();
  return source;
}

std::uint64_t TapeSource::tick_at(const TapeShow& show, double time_s) const {
  return static_cast<std::uint64_t>(std::max(0.0, std::floor(time_s / show.period_s() + kWithinTick) - 1));
}

double TapeSource::begin_s() const {
  double begin = 1e300;
  for (const auto& show : shows_)
    begin = std::min(begin, static_cast<double>(show->index().keyframes.front().tick + 1) * show->period_s());
  return begin;
}

double TapeSource::end_s() const {
  double end = 0;
  for (const auto& show : shows_)
    end = std::max(end, static_cast<double>(show->index().last_tick + 1) * show->period_s());
  return end;
}

void TapeSource::seek(double to_s) {
  clock_s_ = std::clamp(to_s, begin_s(), end_s());
  for (std::size_t i = 0; i < shows_.size(); ++i) {
    Fresh& fresh = fresh_[i];
    fresh.ticks.clear();
    fresh.frame = fresh.restarted = true;
    (void)shows_[i]->seek(tick_at(*shows_[i], clock_s_), fresh.ticks);
  }
}

// True: every tape has reached this time, or its end.
bool TapeSource::step_to(double to_s, std::int64_t until_ns) {
  for (bool behind = true; behind;) {
    behind = false;
    for (std::size_t i = 0; i < shows_.size(); ++i) {
      TapeShow& show = *shows_[i];
      if (show.at_end() || show.tick() >= tick_at(show, to_s)) continue;
      if (!show.step(fresh_[i].ticks)) continue;
      fresh_[i].frame = true;
      clock_s_ = std::max(clock_s_, static_cast<double>(show.tick() + 1) * show.period_s());
      behind = true;
    }
    if (behind && MonotonicClock::now_ns() > until_ns) return false;
  }
  return true;
}

void TapeSource::advance(double passed_s, std::int64_t budget_ns) {
  const bool unbounded = pace_ == 0;
  const double to_s = std::min(end_s(), unbounded ? end_s() : clock_s_ + pace_ * passed_s);
  // If playing takes longer than the budget, the clock stays at the last tick that was played.
  if (step_to(to_s, MonotonicClock::now_ns() + budget_ns)) clock_s_ = std::max(clock_s_, to_s);
  if (clock_s_ >= end_s() - 1e-9) playing_ = false;
}

void TapeSource::step_cycle() {
  TapeShow& first = *shows_.front();
  constexpr int kLongestCycle = 10'000;
  for (int i = 0; i < kLongestCycle && !first.at_end(); ++i) {
    (void)step_to(clock_s_ + first.period_s(), INT64_MAX);
    if (first.adopted()) return;
  }
}

ViewSource::Update TapeSource::look(std::size_t view, std::vector<publication::TickEntry>& ticks,
                                    publication::Frame& frame) {
  if (view == 0) {
    const std::int64_t now_ns = MonotonicClock::now_ns();
    const double passed_s = std::min(kLongestPause_s, 1e-9 * static_cast<double>(now_ns - last_look_ns_));
    last_look_ns_ = now_ns;
    if (seek_to_s_) seek(*seek_to_s_);
    seek_to_s_.reset();
    if (playing_) advance(passed_s, kLook_ns);
  }
  Fresh& fresh = fresh_[view];
  const std::uint64_t cycles = shows_[view]->history().cycles();
  // The world outside may have been rebuilt since the last look.
  const Update update{
      .lost = 0, .fresh = fresh.frame || (cycles != fresh.cycles && !playing_), .restarted = fresh.restarted};
  ticks.insert(ticks.end(), fresh.ticks.begin(), fresh.ticks.end());
  if (update.fresh) shows_[view]->take_frame(frame);
  fresh = {.ticks = {}, .frame = false, .restarted = false, .cycles = cycles};
  return update;
}

std::string TapeSource::note(const TapeShow& show) const {
  const TapeIndex& index = show.index();
  std::string text;
  if (index.damages != 0) text += fmt::format("{} damaged place(s): {}. ", index.damages, index.damage);
  if (index.gaps != 0) text += fmt::format("{} gap(s), where the disk was too slow. ", index.gaps);
  if (!haptics::traits_of(show.tape().settings.options.coupling).global_world)
    return text + "All moving bodies are members: the direct coupling has no world outside";
  const WorldHistory& history = show.history();
  if (!history.done()) return text + fmt::format("The world outside is being rebuilt: {} cycles", history.cycles());
  const std::string why = history.note();
  if (why.empty()) return text + fmt::format("The world outside is rebuilt: {} snapshots, as taped", history.cycles());
  if (history.cycles() == 0) return text + "Only the sub-world is shown: " + why;
  return text + fmt::format("The world outside is shown up to snapshot {}: {}", history.cycles(), why);
}

// Says which part of the tape, and which rules, the verdict covers.
std::string TapeSource::judged(const TapeShow& show) {
  std::string text = "of the whole tape";
  const bool outside = haptics::traits_of(show.tape().settings.options.coupling).global_world;
  if (outside && !show.history().statistics()) text += ", without the world outside";
  if (show.index().has_times) text += "; deadlines, own work and set-up are not on a tape";
  return text;
}

std::string TapeSource::status() {
  nlohmann::ordered_json tapes = nlohmann::ordered_json::array();
  for (const auto& show : shows_) {
    nlohmann::ordered_json faults = nlohmann::ordered_json::array();
    for (const TapeIndex::FaultMark& mark : show->index().faults)
      faults.push_back(static_cast<double>(mark.tick + 1) * show->period_s());
    nlohmann::ordered_json tape{{"path", show->tape().path}, {"faults_s", faults}, {"note", note(*show)}};
    if (const auto& verdict = show->verdict())
      tape["verdict"] = {{"level", session::name_of(verdict->level())},
                         {"verdict", verdict->line()},
                         {"why", verdict->text()},
                         {"of", judged(*show)}};
    tapes.push_back(std::move(tape));
  }
  return json_text(nlohmann::ordered_json{{"kind", "tape"},
                                          {"playing", playing_},
                                          {"pace", pace_},
                                          {"begin_s", begin_s()},
                                          {"end_s", end_s()},
                                          {"tapes", tapes}});
}

Answer TapeSource::ask(const PageMessage& message) {
  const double period_s = shows_.front()->period_s();
  const std::string& ask = message.ask;
  if (ask == "play") {
    if (clock_s_ >= end_s() - 1e-9) seek_to_s_ = begin_s();
    playing_ = true;
    return {true, "playing"};
  }
  if (ask == "pace") {
    pace_ = message.value;
    return {true, pace_ == 0 ? "as fast as it goes" : fmt::format("{:g} times real time", pace_)};
  }
  if (ask != "pause" && ask != "tick" && ask != "cycle" && ask != "back" && ask != "seek")
    return {false, "a tape cannot do that; accepted: play, pause, tick, cycle, back, seek, pace"};
  playing_ = playing_ && ask == "seek";
  if (ask == "tick") (void)step_to(clock_s_ + period_s, INT64_MAX);
  if (ask == "cycle") step_cycle();
  if (ask == "back") seek_to_s_ = clock_s_ - period_s;
  if (ask == "seek") seek_to_s_ = message.value;
  return {true, ask == "seek" ? "" : "paused"};
}

}  // namespace tactus::view
