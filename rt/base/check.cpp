#include "rt/base/check.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace tactus {
namespace {

void print_and_abort(const CheckFailure& f) noexcept {
  std::fprintf(stderr, "tactus: internal error: %s:%d: %s (%.17g, %.17g)\n", f.file, f.line, f.expression, f.a, f.b);
  std::abort();
}

std::atomic<CheckHandler> g_handler{&print_and_abort};

}  // namespace

CheckHandler set_check_handler(CheckHandler handler) noexcept { return g_handler.exchange(handler); }

void check_failed(const CheckFailure& failure) noexcept {
  g_handler.load()(failure);
  std::abort();
}

}  // namespace tactus
