#include "tools/version/version.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <tactus_commit.h>

#include "rt/tape/tape.h"
#include "rt/thread/realtime_setup.h"

namespace tactus {

namespace {

#if defined(__clang__)
constexpr const char* kCompiler = __VERSION__;  // begins with its name
#else
constexpr const char* kCompiler = "gcc " __VERSION__;
#endif

}  // namespace

std::string version() { return TACTUS_VERSION " (commit " TACTUS_COMMIT ")"; }

std::string version_text() {
  utsname kernel{};
  uname(&kernel);
  return fmt::format("tactus {}\nbuilt for    {}, by {}\ntape format  {}\nkernel       {}, {}", version(),
                     loop::tape_isa_tag(), kCompiler, loop::kTapeVersion, kernel.release,
                     loop::kernel_is_preempt_rt() ? "PREEMPT_RT" : "not PREEMPT_RT");
}

}  // namespace tactus
