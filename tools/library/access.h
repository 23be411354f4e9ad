// What the program, the tests and other parts of the house may have of the public classes: their inside, and messages
// that name options as the command line does (--rate) and not as the library does (rate_Hz).
// Thread: as the public calls of the same name.
#pragma once

#include "rt/base/result.h"
#include "tactus/session.h"
#include "tools/session/session.h"

namespace tactus::library {

// What a public Options says, or which word is none.
Result<session::RunOptions> run_options(const Options& options, double duration_s = 0);

// A message of the command line in the words of the library.
std::string in_own_words(std::string message);

struct Access {
  // Ranges and combinations of the options alone. `duration_s`: of the run, 0 until stopped.
  static Error check(const Options& options, double duration_s);
  static Error open(Session& session, const Scene& scene, const Options& options, Device* device = nullptr);
  static const sim::Scene& scene(const Scene& scene);  // not of an empty one
  static const std::filesystem::path& file(const Scene& scene);
  static session::Session& session(Session& session);    // of an open one
  static session::RunSummary summary(Session& session);  // of one that was opened; ends a tape
};

}  // namespace tactus::library
