// Faults of a stand-in for whole programs, set by the environment: TACTUS_STAND_IN_FAULT is KIND@MOMENT; the fault
// begins at the moment and stays. TACTUS_STAND_IN_END names a file into which the stand-in writes, when the device is
// closed, whether its forces were on.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace stand_in_script {

// begins(): true once, at the moment: `rest`, after kCalls exchanges; `on`, when the forces are on; else when the force
// is above 0.
class Script {
 public:
  bool begins(bool on, bool pushes) {
    if (over_ || kind().empty()) return false;
    const std::string_view moment = text().substr(text().find('@') + 1);
    over_ = moment == "rest" ? ++calls_ == kCalls : moment == "on" ? on : pushes;
    return over_;
  }
  static std::string_view kind() { return text().substr(0, text().find('@')); }

 private:
  static constexpr unsigned kCalls = 400;  // more than the start makes
  static std::string_view text() {
    const char* const found = std::getenv("TACTUS_STAND_IN_FAULT");
    return found != nullptr ? found : "";
  }

  bool over_{false};
  unsigned calls_{0};
};

inline void tell_end(bool forces_on) {
  const char* const path = std::getenv("TACTUS_STAND_IN_END");
  if (path == nullptr) return;
  if (std::FILE* const file = std::fopen(path, "w")) {
    std::fputs(forces_on ? "forces on\n" : "forces off\n", file);
    std::fclose(file);
  }
}

}  // namespace stand_in_script
