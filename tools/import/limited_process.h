// Runs work on untrusted input in a separate process: a crash, an endless loop or too much memory or output ends only
// that process.
//
// Thread: the only one of the program. Bound: Limits; the process is killed beyond them. Errors: one line that says
// which limit it was, or how the process ended.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rt/base/result.h"

namespace tactus::scene_import {

struct Limits {
  unsigned wall_s{120}, cpu_s{60};
  std::size_t memory_bytes{3u << 30};  // resident
  std::size_t answer_bytes{256u << 20};
};

// What the program prints. Its standard error is discarded.
Result<std::string> run_program(const std::vector<std::string>& words, const Limits& limits);

// What `work` returns, computed in a copy of this process.
Result<std::string> run_apart(const std::function<std::string()>& work, const Limits& limits);

}  // namespace tactus::scene_import
