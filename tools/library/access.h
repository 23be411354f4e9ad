// Access of the program, the tests and other internal code to the private parts of the public classes. Its messages
// name options as on the command line (--rate), not as in the library (rate_Hz).
// Thread: as the public calls of the same name.
#pragma once

#include "rt/base/result.h"
#include "tactus/session.h"
#include "tools/session/virtual_run.h"

namespace tactus::library {

// Converts public Options. Error: which word is not accepted.
Result<session::RunOptions> run_options(const Options& options, double duration_s = 0);

// Replaces the command line's option names in a message by the library's.
std::string in_own_words(std::string message);

struct Access {
  // Checks ranges and combinations of the options only. `duration_s`: of the run; 0: until stopped.
  static Error check(const Options& options, double duration_s);
  // `devices`: the caller's, one for each hand, null: the simulated one; or none at all.
  static Error open(Session& session, const Scene& scene, const Options& options,
                    std::span<Device* const> devices = {});
  static const sim::Scene& scene(const Scene& scene);  // `scene` must not be empty
  static const std::filesystem::path& file(const Scene& scene);
  static session::Session& session(Session& session);         // of the first hand; `session` must be open
  static session::VirtualRun& virtual_run(Session& session);  // `session` must be open, in virtual time
  static session::RunSummary summary(Session& session);  // the same; `session` must have been opened; closes the tape
};

}  // namespace tactus::library
