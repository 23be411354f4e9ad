/// \file
/// Error type of the library: the only way in which a call reports failure. The library uses no exceptions.
///
/// Thread: any normal thread; the haptic thread creates no Error. Bound: one message on the heap; success has no
/// message and allocates nothing.
#pragma once

#include <string>
#include <utility>

namespace tactus {

/// Error or success. Converts to true for an error:
///
///     if (const tactus::Error error = session.open("card_house.toml")) return report(error);
///
/// A failed call changes nothing except what its description states. No call of the library throws, except when memory
/// runs out, and none ends the program because of a mistake of its caller or in a file.
class [[nodiscard]] Error {
 public:
  /// Where the cause lies.
  enum class Kind {
    kNone = 0,     ///< success
    kFile = 1,     ///< a file's content: a scene, a device file, a tape; one line for each mistake
    kOption = 2,   ///< an option, or options that do not go together
    kMachine = 3,  ///< the machine or the device lacks something or reports an error
    kUse = 4,      ///< a call that is not allowed now, such as tick() before open()
  };

  /// Success.
  Error() = default;
  /// \param kind where the cause lies
  /// \param message readable text: what failed, what was found, what is accepted or the remedy
  Error(Kind kind, std::string message) : kind_(kind), message_(std::move(message)) {}

  /// True for an error.
  explicit operator bool() const noexcept { return kind_ != Kind::kNone; }
  /// Where the cause lies.
  Kind kind() const noexcept { return kind_; }
  /// Readable message; empty on success.
  const std::string& message() const noexcept { return message_; }

 private:
  Kind kind_{Kind::kNone};
  std::string message_;
};

}  // namespace tactus
