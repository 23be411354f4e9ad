// Texts of --help that several commands share: the same option has the same text in every command. A flag, or an option
// that names a file to write, begins with a verb: what the program then does. Another option says what its value is,
// with the unit; then range and default, where CLI11 does not print them. Thread: [setup].
#pragma once

#include <string>

#include "hal/device_class.h"

namespace tactus::tools::help {

inline constexpr const char* kJson = "print the result as one JSON object, with units, on standard output";
inline constexpr const char* kOverwrite = "replace existing files";
inline constexpr const char* kTape = "tape that `tactus run --record` wrote";
inline constexpr const char* kSocket = "control socket of the run";

// Of the device and the haptic thread.
inline constexpr const char* kProfile = "built-in description of the device: virtuose6d or desk3d";
inline constexpr const char* kDeviceFile = "file that describes the device";  // and its default
inline constexpr const char* kCpu = "core of the haptic thread; default: the last core that this process may use";
inline constexpr const char* kPriority = "SCHED_FIFO priority of the haptic thread; 0: normal scheduling";
inline constexpr const char* kBudget = "budget file of `tactus timing --certify`";  // and what the command does with it

// Of the simulation.
inline constexpr const char* kRate = "rate of the haptic loop [Hz]";
inline constexpr const char* kRatio = "haptic ticks per global step";
inline constexpr const char* kMembers = "largest number of bodies in the sub-world, proxy included";
inline constexpr const char* kOrder =
    "order in which bodies of the contact graph become members: best-first or breadth-first";
inline constexpr const char* kPrecision =
    "double, or mixed (contacts are solved in single precision);\ndefault: as in a run, mixed above 200 moving bodies";

// Of experiments and sweeps.
inline constexpr const char* kScenes = "scenes, separated by commas; default: all";
inline constexpr const char* kSeeds =
    "number of hand motions for each scene; they press and slide slightly differently";
inline constexpr const char* kWorkers =
    "number of processes on this machine (needs the Python module);\nthe figures do not depend on it";
inline constexpr const char* kScheduler =
    "address of a scheduler of Dask distributed whose workers compute, such as tcp://127.0.0.1:8786;\n"
    "each worker has tactus at the same path, of the same version and instruction set";
inline constexpr const char* kTrustNetwork =
    "accept a scheduler that is neither on loopback nor TLS; it runs the code of any client that connects";

// A list of `text`, with the values when the option is not given.
inline std::string list_of(const std::string& text, const char* by_default) {
  return text + ", separated by commas; default: " + by_default;
}

// `what`: the device, and what the command does with it.
inline std::string devices(const std::string& what = "device") {
  return what + ", one of:\n" + hal::described_devices();
}

}  // namespace tactus::tools::help
