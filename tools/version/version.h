// Which tactus this is. Thread: [any]. Bound: none.
#pragma once

#include <string>

namespace tactus {

// "0.1.0 (commit 0123456789ab)"; "-dirty" where the source was changed since.
std::string version();
// For people: the version, what it was built for, and the kernel that it runs on, a line each.
std::string version_text();

}  // namespace tactus
