/// \file
/// Which tactus this is.
///
/// Thread: any normal one.
#pragma once

#include <string>

namespace tactus {

/// "0.1.0 (commit 0123456789ab)"; with "-dirty" where the source was changed since.
std::string version();

}  // namespace tactus
