#include "tools/experiment/allocation_count.h"

#include <dlfcn.h>

namespace tactus::experiment {
namespace {

using Counter = std::uint64_t (*)();

Counter counter() noexcept {
  static const auto found = reinterpret_cast<Counter>(dlsym(RTLD_DEFAULT, "tactus_thread_allocations"));
  return found;
}

}  // namespace

bool allocations_are_counted() noexcept { return counter() != nullptr; }
std::uint64_t allocation_count() noexcept { return allocations_are_counted() ? counter()() : 0; }

}  // namespace tactus::experiment
