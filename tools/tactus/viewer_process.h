// The viewer of a run as a separate process, `tactus view --socket`: it has none of the run's privileges, and its
// failure does not affect the run.
//
// Thread: main. Bound: a viewer that does not end within a second of being asked is killed.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>

#include "rt/base/result.h"

namespace tactus::tools {

class ViewerProcess {
 public:
  // Starts it on the socket; it prints its address on standard error. Error: of the operating system.
  static Result<std::unique_ptr<ViewerProcess>> start(const std::filesystem::path& socket);
  // The same, silent: what it prints is read here. Error also: it ends before it has an address, or has none within
  // 10 s.
  static Result<std::unique_ptr<ViewerProcess>> start_silent(const std::filesystem::path& socket);
  // Of one that was started silent.
  const std::string& address() const noexcept { return address_; }
  ~ViewerProcess();
  ViewerProcess(const ViewerProcess&) = delete;
  ViewerProcess& operator=(const ViewerProcess&) = delete;

 private:
  // `output`: to read what it prints; -1: it is on standard error.
  explicit ViewerProcess(pid_t process, int output = -1) : process_(process), output_(output) {}
  static Result<std::unique_ptr<ViewerProcess>> start(const std::filesystem::path& socket, bool silent);
  Status read_address();

  pid_t process_;
  int output_;
  std::string address_;
};

}  // namespace tactus::tools
