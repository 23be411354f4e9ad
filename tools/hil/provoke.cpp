#include "tools/hil/provoke.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>

namespace tactus::hil {
namespace {

class ByCommand final : public Provoker {
 public:
  explicit ByCommand(std::string command) : command_(std::move(command)) {}
  Status set(const std::string& fault, bool on) override {
    const std::string line = fmt::format("{} {} {}", command_, fault, on ? "on" : "off");
    const int status = std::system(line.c_str());
    if (status != -1 && WIFEXITED(status) && WEXITSTATUS(status) == 0) return Status::good();
    return Status::error(
        fmt::format("`{}` ended with {}", line, status != -1 && WIFEXITED(status) ? WEXITSTATUS(status) : status));
  }

 private:
  std::string command_;
};

class ByPerson final : public Provoker {
 public:
  Status set(const std::string& fault, bool on) override {
    if (fault == "estop") return ask(on ? "Press the e-stop now." : "Release the e-stop now.");
    if (fault == "unplug") return ask(on ? "Pull the device's cable out now." : "Plug the device in again now.");
    return Status::error("a person cannot do that: give --provoke COMMAND");
  }
  std::chrono::seconds patience() const override { return std::chrono::seconds(60); }

 private:
  static Status ask(const char* text) {
    fmt::print(stderr, "\r\033[K>>> {}\n", text);
    return Status::good();
  }
};

class Nobody final : public Provoker {
 public:
  Status set(const std::string&, bool) override {
    return Status::error("nobody is there to do it: run it on a terminal, or give --provoke COMMAND");
  }
};

}  // namespace

std::unique_ptr<Provoker> provoke_by_command(const std::string& command) {
  return std::make_unique<ByCommand>(command);
}
std::unique_ptr<Provoker> provoke_by_person() { return std::make_unique<ByPerson>(); }
std::unique_ptr<Provoker> provoke_nothing() { return std::make_unique<Nobody>(); }

}  // namespace tactus::hil
