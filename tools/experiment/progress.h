// Says how far an experiment is: one line on a terminal, in a log a line every half minute. Thread: one.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace tactus::experiment {

// Called with what is being done now; may be empty.
using Progress = std::function<void(const std::string& doing)>;

// A line on stderr that each call overwrites, and that goes with the last copy. Where stderr is no terminal, a line of
// its own, not more often than every 30 s.
Progress terminal_progress();

// How long the rest takes where it goes on as it did: "scene pile, seed 3 of 20, about 40 s left".
class Pace {
 public:
  // `work`: all there is to do, in any unit. The progress must outlive this.
  Pace(const Progress& progress, double work) : progress_(progress), work_(work) {}
  // `done`: of the work, so far.
  void say(const std::string& doing, double done) const;

 private:
  const Progress& progress_;
  double work_;
  std::chrono::steady_clock::time_point start_{std::chrono::steady_clock::now()};
};

}  // namespace tactus::experiment
