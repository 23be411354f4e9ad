// Source of the doctor's data: this machine, or a recorded tree of files.
//
// Files of /proc, /sys, /dev and /etc are read below a root: "/" is this machine, any other folder a recorded tree, so
// that every finding can be tested, also those that cannot occur on this machine. Data from system calls (limits and
// capabilities of the process) is in ProcessFacts; a recorded tree may hold it in a file `process`, one `name value`
// per line. Thread: normal. Nothing here changes the machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rt/base/result.h"

namespace tactus::doctor {

struct ProcessFacts {
  std::uint64_t rtprio_limit{0};     // highest SCHED_FIFO priority that the user may request
  std::uint64_t memlock_limit_B{0};  // ~0: no limit
  bool may_set_priority{false};      // root or CAP_SYS_NICE
  bool may_lock_memory{false};       // root or CAP_IPC_LOCK
  std::uint32_t cpus_allowed{0};     // number of cores on which this process may run
  int last_allowed_cpu{-1};
  std::string user;
};

class SystemView {
 public:
  // `root` "/" asks the running kernel; any other folder must hold a recorded tree.
  static Result<SystemView> open(const std::filesystem::path& root);

  // The file's text without its last newline; empty if it cannot be read.
  std::optional<std::string> read(const std::string& path) const;
  // Names in a folder, sorted; empty if the folder does not exist.
  std::vector<std::string> list(const std::string& path) const;
  bool exists(const std::string& path) const;
  bool writable(const std::string& path) const;
  // Eight bytes of a file at an offset, such as a machine-specific register.
  std::optional<std::uint64_t> read_word(const std::string& path, std::uint64_t offset) const;

  const ProcessFacts& process() const { return process_; }
  bool is_this_machine() const { return root_ == "/"; }

 private:
  std::filesystem::path at(const std::string& path) const;

  std::filesystem::path root_;
  ProcessFacts process_;
};

// Parses the kernel's format of core sets, such as "0-2,5"; empty for any other text.
std::optional<std::vector<int>> parse_cpu_list(const std::string& text);

}  // namespace tactus::doctor
