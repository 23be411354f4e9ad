/// \file
/// Options of a run: those of `tactus run`, with the same names, values and defaults.
///
/// A plain value, read when a session is opened. Values out of range and combinations that are not allowed are an Error
/// of Session::open that states what is accepted. Thread: any. Units: in the names.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tactus {

/// Options of a run. Each is the option of `tactus run` of the same name.
struct Options {
  /// False: virtual time, tick by tick, with Session::tick and Session::step; the same options, scene and device give
  /// bit-identical results. True: real time, with Session::run.
  bool real_time{false};

  /// The device, as `tactus run --device` accepts it. A device that is not simulated needs real time. If
  /// Session::open receives a Device, that device is used and this must stay `sim`.
  std::string device{"sim"};
  /// File that describes the device; empty: the scene's profile is used.
  std::string device_file;
  /// GPIO lines used in addition to the device's link, such as `chip=gpiochip0,estop=3-low`; empty: none. Real time
  /// only.
  std::string gpio;

  /// Coupling scheme between device and world: `sub-world`, `direct`, `interpolation`, `static`, `plane`, `planes` or
  /// `linearised`.
  std::string coupling{"sub-world"};
  /// Border of the sub-world: `ghost`, `capped`, `replay`, `filtered` or `frozen`.
  std::string border{"ghost"};
  /// Order in which the contact graph is traversed until the cap of members is reached: `best-first` or
  /// `breadth-first`.
  std::string order{"best-first"};
  /// Rule for the size of the boundary cube around the proxy: `two-cycles` or `paper`.
  std::string reach{"two-cycles"};
  /// `fast`: half of the scene's members and sub-steps; `balanced`: the scene's; `accurate`: twice both.
  std::string accuracy{"balanced"};
  /// Precision of the global world: `double`, or `mixed` (with more than 200 moving bodies contacts are solved in
  /// single precision).
  std::string world_precision{"mixed"};

  double rate_Hz{1000};  ///< ticks a second, 100 to 10000
  unsigned ratio{0};     ///< ticks per step of the global world, 1 to 100; 0: the scene's
  unsigned members{0};   ///< maximum number of bodies in the sub-world, 1 to 256; 0: the scene's, scaled by `accuracy`
  /// True: use the scene's coupling gains or return an Error; they are not lowered to the limit of `coupling`.
  bool keep_gains{false};
  /// Wake-up latency of this machine [s]; the coupling's gains must be stable with it.
  double late_s{0};

  unsigned world_threads{
      1};  ///< threads that share the steps of the global world, 1 to 64; results do not depend on it
  std::vector<int> world_cpus;  ///< one core per thread of world_threads; empty: any
  int cpu{-1};                  ///< core of the haptic thread; -1: the last one allowed. Real time only
  int priority{80};             ///< SCHED_FIFO of the haptic thread, 0 to 98; 0: a normal thread. Real time only

  /// True: force from the first good sample on; false: after Request::kArm.
  bool arm_at_start{true};
  /// True: clears a latched fault automatically, one second after it latched.
  bool rearm{false};
  /// Script of injected faults, as `KIND@TICK[+TICKS][:AMOUNT],...`, see `tactus run --help`; empty: none. With
  /// several hands: of the first.
  std::string inject;
  /// The same of the second hand and those after it, in their order; shorter: none.
  std::vector<std::string> more_injects;
  /// Seed of the random numbers of injected faults.
  std::uint64_t seed{1};

  /// Length of the history of Session::ticks and of a Monitor [ticks], 1 to 1000000; 360 bytes each.
  std::uint32_t history_ticks{4000};
};

}  // namespace tactus
