/// \file
/// How a scene is run: the options of `tactus run`, with the same names, words and defaults.
///
/// A plain value, read when a session is opened; what is out of its range, or does not go together, is an Error of
/// Session::open that says what is accepted. Thread: any. Units: in the names.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tactus {

/// How a scene is run. Each is the option of `tactus run` of the same name.
struct Options {
  /// False: in virtual time, tick by tick, by Session::tick and Session::step; the same options, scene and device give
  /// the same bits. True: in real time, by Session::run.
  bool real_time{false};

  /// The device: `sim`, `usb`, `usb:SERIAL`, `can:IFACE` or `can:IFACE:NODE`. The last four need real time. Where
  /// Session::open is given a Device, that is it, and this must stay `sim`.
  std::string device{"sim"};
  /// Describes a device on USB or CAN; empty: the scene's profile does.
  std::string device_file;
  /// Lines beside the device's link, such as `chip=gpiochip0,estop=3-low`; empty: none. Real time only.
  std::string gpio;

  /// How device and world meet: `sub-world`, `direct`, `interpolation`, `static`, `plane`, `planes` or `linearised`.
  std::string coupling{"sub-world"};
  /// Border of the sub-world: `ghost`, `capped`, `replay`, `filtered` or `frozen`.
  std::string border{"ghost"};
  /// In which order the contact graph is cut at the cap of members: `best-first` or `breadth-first`.
  std::string order{"best-first"};
  /// Reach of the boundary cube about the proxy: `two-cycles` or `paper`.
  std::string reach{"two-cycles"};
  /// `fast`: half of the scene's members and sub-steps; `balanced`: as it says; `accurate`: twice of both.
  std::string accuracy{"balanced"};
  /// Of the global world: `double`, or `mixed`, where its contacts are solved in single precision.
  std::string world_precision{"mixed"};

  double rate_Hz{1000};  ///< ticks a second, 100 to 10000
  unsigned ratio{0};     ///< ticks in a step of the global world, 1 to 100; 0: the scene's
  unsigned members{0};   ///< most bodies in the sub-world, 1 to 256; 0: the scene's, by the accuracy
  /// The scene's gains of the coupling, or an Error: none is lowered to what `coupling` bears.
  bool keep_gains{false};
  /// How late this machine wakes the loop [s]; the coupling's gains must bear it. 0: not at all.
  double late_s{0};

  unsigned world_threads{1};    ///< that share the global world's steps, 1 to 64; the bits stay the same
  std::vector<int> world_cpus;  ///< a core for each of them; empty: any
  int cpu{-1};                  ///< core of the haptic thread; -1: the last one allowed. Real time only
  int priority{80};             ///< SCHED_FIFO of the haptic thread, 0 to 98; 0: a normal thread. Real time only

  /// Force from the first good sample on; false: when Request::kArm asks for it.
  bool arm_at_start{true};
  /// Takes a latched fault back by itself, a second after it latched.
  bool rearm{false};
  /// Faults by script, as `KIND@TICK[+TICKS][:AMOUNT],...`, see `tactus run --help`; empty: none.
  std::string inject;
  /// Of what is random in injected faults.
  std::uint64_t seed{1};

  /// Ticks that Session::ticks and a Monitor can look back at, 1 to 1000000. Each takes 360 bytes.
  std::uint32_t history_ticks{4000};
};

}  // namespace tactus
