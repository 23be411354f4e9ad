// The options of `tactus run`, and their storage in the header text of a tape.
// Thread: normal. Units in the names.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/result.h"
#include "rt/haptics/coupling/coupling_scheme.h"
#include "rt/haptics/coupling/snapshot.h"
#include "rt/haptics/device.h"
#include "rt/physics/border/border_contact.h"
#include "sim/exchange/extraction.h"

namespace tactus::session {

// Three settings of accuracy against computing time (`tactus experiment accuracy-cost`). Most effective is a cap of
// members that admits all bodies connected to the proxy by contacts, then more sub-steps.
enum class Accuracy {
  kFast,      // half of the scene's members; half of its sub-steps if these still resolve the contact frequency
  kBalanced,  // the scene's
  kAccurate,  // twice its members and its sub-steps
};
std::string_view name_of(Accuracy accuracy) noexcept;  // fast, balanced, accurate
std::optional<Accuracy> parse_accuracy(std::string_view word) noexcept;

// Accepted values, ends included, of options that several commands and files have.
template <class T>
struct Range {
  T least, most;
};
inline constexpr Range<double> kRates_Hz{100, 10000};
inline constexpr Range<unsigned> kRatios{1, 100};
inline constexpr Range<unsigned> kMemberCaps{1, haptics::kMaxMembers};
inline constexpr Range<int> kCores{0, 1023};  // what a cpu_set_t holds
inline constexpr Range<int> kPriorities{0, 98};

// Value of RunOptions::device when a program supplies its own device, also on a tape. Not accepted on the command line.
inline constexpr const char* kGivenDevice = "own";

// Above these stiffnesses two hands that hold one body are unstable, see shared_limit.h; world units.
struct SharedLimits {
  double stiffness_N_per_m{std::numeric_limits<double>::infinity()};
  double stiffness_Nm_per_rad{std::numeric_limits<double>::infinity()};
};

struct RunOptions {
  std::filesystem::path scene;
  unsigned hand{0}, hands{1};  // which of how many hands of the scene these options are of; the first is 0
  std::optional<SharedLimits> shared_limits;  // of several hands; set by the session, and on its tape
  std::string device{"sim"};                  // see hal/device_class.h
  bool given_device{false};                   // the caller supplies the device; `device` is its display name
  std::filesystem::path device_file;          // describes the device; empty: the scene's profile is used
  std::string gpio;                           // GPIO lines: e-stop, drive enable, probe, heartbeat; empty: none
  haptics::CouplingScheme coupling{haptics::CouplingScheme::kSubWorld};
  physics::BorderMode border{physics::kDefaultBorder};
  sim::CutOrder order{sim::CutOrder::kBestFirst};
  sim::Reach reach{sim::Reach::kTwoCycles};
  bool all_members{false};  // every dynamic body a member from tick 0
  double rate_Hz{1000};
  unsigned ratio{0};    // 0: the scene's
  unsigned members{0};  // 0: the scene's, scaled by `accuracy`
  Accuracy accuracy{Accuracy::kBalanced};
  double duration_s{0};       // 0: until stopped; required in virtual time
  int cpu{-1};                // -1: the last core that this process may use
  unsigned world_threads{1};  // of the global world
  physics::SweepPrecision world_precision{physics::SweepPrecision::kSingle};  // of large worlds: sim::sweep_precision
  std::vector<int> world_cpus;  // one core per thread of world_threads; empty: any
  int priority{80};             // SCHED_FIFO
  bool keep_gains{false};       // use the scene's gains or refuse; they are not lowered for the coupling scheme
  double late_s{0};             // s, wake-up latency of this machine; the coupling's gains must be stable with it
  bool virtual_time{false};
  bool arm_at_start{true};  // force from the first good sample on; otherwise when the operator arms
  bool rearm{false};        // clear a latched fault automatically, one second after it latched
  std::string inject;       // script of faults of device, link and world
  std::filesystem::path record;
  std::uint64_t seed{1};  // of the random faults of the simulated device's link
  // For a replay: properties of the device that the tape was made with. That device is not opened.
  std::optional<haptics::DeviceProperties> taped_device;

  double period_s() const noexcept { return 1.0 / rate_Hz; }
};

// Check ranges and combinations. One line for each mistake: the option, what was given, what is accepted. check_options
// returns the first.
std::vector<std::string> option_mistakes(const RunOptions& options);
Status check_options(const RunOptions& options);

// The header text of a tape: the program that wrote it, the scene (its file and the hash of its text), the options that
// the haptic thread's results depend on, the device's properties, and the scene's own text.
std::string to_tape_text(const RunOptions& options, const haptics::DeviceProperties& device,
                         const std::string& scene_name, const std::string& scene_source);

struct TapeSettings {
  RunOptions options;
  std::string scene_name, scene_source;
  std::string made_by;                 // version of the program; empty: not recorded
  std::string scene_file, scene_hash;  // path as given when recorded; hash of scene_source
  bool knows_world{false};             // false: an older tape, without the global world's precision
};
Result<TapeSettings> from_tape_text(const std::string& text);

}  // namespace tactus::session
