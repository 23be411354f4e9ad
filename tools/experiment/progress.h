// Displays the progress of an experiment: one line on a terminal; in a log one line every half minute. Thread: one.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace tactus::experiment {

// Called with a description of the current work; may be empty.
using Progress = std::function<void(const std::string& doing)>;

// A line on stderr that each call overwrites and the last copy's destructor erases. If stderr is not a terminal: a new
// line, at most every 30 s.
Progress terminal_progress();

// Estimates the remaining time from the rate so far: "scene pile, seed 3 of 20, about 40 s left".
class WorkProgress {
 public:
  // `work`: total work, in any unit. `progress` must outlive this.
  WorkProgress(const Progress& progress, double work) : progress_(progress), work_(work) {}
  WorkProgress(const Progress&& progress, double work) = delete;  // a temporary would not outlive this
  // `done`: of the work, so far.
  void say(const std::string& doing, double done) const;

 private:
  const Progress& progress_;
  double work_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
};

}  // namespace tactus::experiment
