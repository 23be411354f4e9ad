// Errors of set-up code: a Status, or a Result that contains a value or the reason why there is none.
//
// The message is one line that names what failed, what was found and what to do; users see it unchanged.
// Thread: [setup] only, and normal-priority threads: messages are on the heap. Never in a tick, whose errors are the
// fault and status bits of rt/base/status.h. Bound: no function throws; value() of an error is our own bug and asserts.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "rt/base/check.h"

namespace tactus {

class [[nodiscard]] Status {
 public:
  static Status good() { return Status(); }
  static Status error(std::string message) {
    Status status;
    status.failed_ = true;
    status.message_ = std::move(message);
    return status;
  }

  bool ok() const noexcept { return !failed_; }
  // Empty if ok.
  const std::string& message() const noexcept { return message_; }

 private:
  Status() = default;
  bool failed_{false};
  std::string message_;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)), status_(Status::good()) {}  // NOLINT(google-explicit-constructor)
  Result(Status error) : status_(std::move(error)) {                      // NOLINT(google-explicit-constructor)
    TACTUS_CHECK(!status_.ok(), 0, 0);                                    // a good status contains no value
  }

  bool ok() const noexcept { return value_.has_value(); }
  const std::string& message() const noexcept { return status_.message(); }
  const Status& status() const noexcept { return status_; }

  T& value() & noexcept {
    check();
    return *value_;
  }
  const T& value() const& noexcept {
    check();
    return *value_;
  }
  T&& value() && noexcept {
    check();
    return *std::move(value_);
  }

 private:
  void check() const noexcept { TACTUS_CHECK(value_.has_value(), 0, 0); }

  std::optional<T> value_;
  Status status_;
};

}  // namespace tactus
