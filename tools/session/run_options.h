// What a run is asked to be: the options of `tactus run`, and the header text by which a tape brings them back.
// Thread: normal. Units in the names.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/haptics/coupling/coupling_scheme.h"
#include "rt/haptics/device.h"
#include "rt/physics/border/border_contact.h"
#include "sim/exchange/extraction.h"

namespace tactus::session {

// Three points of what accuracy costs (`tactus experiment accuracy-cost`): what pays most is a sub-world with room for
// all that hangs together with the proxy, then sub-steps.
enum class Accuracy {
  kFast,      // half of the scene's members, half of its sub-steps where they still resolve its contacts
  kBalanced,  // as the scene says
  kAccurate,  // twice its members and its sub-steps
};
std::string_view name_of(Accuracy accuracy) noexcept;  // fast, balanced, accurate
std::optional<Accuracy> parse_accuracy(std::string_view word) noexcept;

// RunOptions::device where a program brings its own; on a tape, too. No choice of the command line.
inline constexpr const char* kGivenDevice = "own";

struct RunOptions {
  std::filesystem::path scene;
  std::string device{"sim"};          // see device_choice.h
  bool given_device{false};           // the caller brings the device; `device` is what people call it
  std::filesystem::path device_file;  // describes a real device; empty: the scene's profile does
  std::string gpio;                   // lines beside the link: e-stop, drive enable, probe, heartbeat; empty: none
  haptics::CouplingScheme coupling{haptics::CouplingScheme::kSubWorld};
  physics::BorderMode border{physics::BorderMode::kGhost};
  sim::CutOrder order{sim::CutOrder::kBestFirst};
  sim::Reach reach{sim::Reach::kTwoCycles};
  bool all_members{false};  // every dynamic body a member from tick 0
  double rate_Hz{1000};
  unsigned ratio{0};    // 0: the scene's
  unsigned members{0};  // 0: the scene's, by the accuracy
  Accuracy accuracy{Accuracy::kBalanced};
  double duration_s{0};       // 0: until stopped; virtual time needs one
  int cpu{-1};                // -1: the last core that this process may use
  unsigned world_threads{1};  // of the global world
  physics::SweepPrecision world_precision{physics::SweepPrecision::kSingle};
  std::vector<int> world_cpus;  // one for each of them; empty: any
  int priority{80};             // SCHED_FIFO
  bool keep_gains{false};       // the scene's gains, or refuse: none is lowered for the coupling
  double late_s{0};             // how late this machine wakes the loop; the coupling's gains must bear it
  bool virtual_time{false};
  bool arm_at_start{true};  // force from the first good sample on; else when an operator asks for it
  bool rearm{false};        // take a latched fault back by itself, one second after it latched
  std::string inject;       // faults of device, link and world, by script
  std::filesystem::path record;
  std::uint64_t seed{1};  // of the simulated device's link
  // Of a tape that is replayed: the device that it was made with, which is not opened then.
  std::optional<haptics::DeviceProperties> taped_device;

  double period_s() const noexcept { return 1.0 / rate_Hz; }
};

// Ranges and combinations. One line for each mistake: the option, what was given, what is accepted. check_options: the
// first of them.
std::vector<std::string> option_mistakes(const RunOptions& options);
Status check_options(const RunOptions& options);

// The header text of a tape: who made it, of which scene (its file and the hash of its text), the options that the
// haptic thread's results depend on, the device's properties, and the scene's own text.
std::string to_tape_text(const RunOptions& options, const haptics::DeviceProperties& device,
                         const std::string& scene_name, const std::string& scene_source);

struct TapeSettings {
  RunOptions options;
  std::string scene_name, scene_source;
  std::string made_by;                 // version of the program; empty: it does not say
  std::string scene_file, scene_hash;  // as given then; of scene_source
};
Result<TapeSettings> from_tape_text(const std::string& text);

}  // namespace tactus::session
