/// \file
/// Version of the library.
///
/// Thread: any normal one.
#pragma once

#include <string>

namespace tactus {

/// "0.1.0 (commit 0123456789ab)"; with "-dirty" if the source was changed since that commit.
std::string version();

}  // namespace tactus
