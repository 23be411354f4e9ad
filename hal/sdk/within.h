// A call of a maker's library that may never return, with a deadline.
//
// The call runs on a thread of its own. After the deadline the thread is detached and keeps what it owns; a call cannot
// be aborted from outside. Thread: [setup].
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "rt/base/result.h"

namespace tactus::hal {

// `call` must own what it uses. Error after the deadline: `late`, and the time that was waited.
template <class T>
Result<T> within(std::chrono::seconds longest, const std::string& late, std::function<Result<T>()> call) {
  struct Shared {
    std::mutex mutex;
    std::condition_variable done;
    std::optional<Result<T>> result;
  };
  const auto shared = std::make_shared<Shared>();
  std::thread([shared, call = std::move(call)] {
    auto result = call();
    const std::lock_guard lock(shared->mutex);
    shared->result.emplace(std::move(result));
    shared->done.notify_one();
  }).detach();
  std::unique_lock lock(shared->mutex);
  if (!shared->done.wait_for(lock, longest, [&] { return shared->result.has_value(); }))
    return Status::error(late + " after " + std::to_string(longest.count()) + " s; unplug it, and plug it in again");
  return std::move(*shared->result);
}

}  // namespace tactus::hal
