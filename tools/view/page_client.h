// A client of `tactus view` that takes what a page takes and acknowledges each message, without drawing anything.
//
// Thread: construction, destruction: one; the messages are taken on a thread of its own; counts [any]. Bound: one
// message at a time. Error, one line: no server listens there, or the page is refused.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "rt/base/result.h"

namespace tactus::view {

class PageClient {
 public:
  // `address`: as `tactus view` prints it, with the token in its fragment. Returns once the scene has come.
  static Result<std::unique_ptr<PageClient>> open(const std::string& address);
  virtual ~PageClient() = default;
  PageClient(const PageClient&) = delete;
  PageClient& operator=(const PageClient&) = delete;

  // Messages with bodies, and bytes of all messages, so far.
  std::uint64_t frames() const noexcept { return frames_.load(std::memory_order_relaxed); }
  std::uint64_t bytes() const noexcept { return bytes_.load(std::memory_order_relaxed); }

 protected:
  PageClient() = default;
  std::atomic<std::uint64_t> frames_{0}, bytes_{0};
};

}  // namespace tactus::view
