/// \file
/// How a call of the library says that it did not work: the one way, without exceptions.
///
/// Thread: any normal one; no haptic thread makes an error. Bound: one message on the heap; a good result has none and
/// allocates nothing.
#pragma once

#include <string>
#include <utility>

namespace tactus {

/// What went wrong, or that nothing did. True where something did:
///
///     if (const tactus::Error error = session.open("card_house.toml")) return report(error);
///
/// A call that failed has changed nothing but what its description says. No call of the library throws, but for memory
/// that is not there, and none ends the program for what its caller or a file did wrong.
class [[nodiscard]] Error {
 public:
  /// Who can do something about it.
  enum class Kind {
    kNone = 0,     ///< nothing went wrong
    kFile = 1,     ///< a file's content: a scene, a device file, a tape; one line for each mistake
    kOption = 2,   ///< an option, or options that do not go together
    kMachine = 3,  ///< what the machine or the device lacks or says
    kUse = 4,      ///< a call that makes no sense now, such as tick() before open()
  };

  /// Nothing went wrong.
  Error() = default;
  /// \param kind who can do something about it
  /// \param message for people: what failed, what was found, what is accepted or helps
  Error(Kind kind, std::string message) : kind_(kind), message_(std::move(message)) {}

  /// True: something went wrong.
  explicit operator bool() const noexcept { return kind_ != Kind::kNone; }
  /// Who can do something about it.
  Kind kind() const noexcept { return kind_; }
  /// For people, to be shown as it is; empty where nothing went wrong.
  const std::string& message() const noexcept { return message_; }

 private:
  Kind kind_{Kind::kNone};
  std::string message_;
};

}  // namespace tactus
