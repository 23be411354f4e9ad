// Runs the work of a thread of normal priority and returns an exception as a status; uncaught it would end the program.
// Thread: the one whose work it is. Bound: the work's.
#pragma once

#include <exception>

#include "rt/base/result.h"

namespace tactus {

template <class Work>
Status caught(Work&& work) noexcept {
  try {
    work();
    return Status::good();
  } catch (const std::exception& error) { return Status::error(error.what()); } catch (...) {
    return Status::error("unknown");
  }
}

}  // namespace tactus
