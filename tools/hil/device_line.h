// Puts the name of a device, with what was measured of it, into a configuration (the file of `tactus run --config`).
//
// Thread: normal; pure.
#pragma once

#include <string>

#include "rt/base/result.h"

namespace tactus::hil {

// How the comment begins that is written above the name; the next measurement replaces it.
inline constexpr const char* kMeasuredNote = "# force gain measured with a kitchen scale";

// `text` with `name` in its [device] table and `note`, a comment's line without its end, above it; the other lines do
// not change. An empty text becomes a file with that table alone. Error, one line: the text is no TOML, or it has its
// device in another form, which a person has to change.
Result<std::string> with_device_name(const std::string& text, const std::string& name, const std::string& note);

}  // namespace tactus::hil
