#include "tools/tactus/keyboard.h"

#include <poll.h>
#include <unistd.h>

#include "rt/loop/haptic_loop.h"

namespace tactus::tools {

std::uint32_t asked_on_keyboard() {
  pollfd in{STDIN_FILENO, POLLIN, 0};
  if (isatty(STDIN_FILENO) == 0 || poll(&in, 1, 0) <= 0 || (in.revents & POLLIN) == 0) return 0;
  char line[256];
  const ssize_t count = read(STDIN_FILENO, line, sizeof line);
  if (count <= 0) return 0;
  return line[0] == 'r' ? loop::kReset : loop::kRearm;
}

}  // namespace tactus::tools
