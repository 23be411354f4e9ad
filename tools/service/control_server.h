// The control socket of a running tactus: one line in, one line of JSON out, over a Unix stream socket.
//
//   state     what the loop does now        arm       force on, with the device where it is
//   rearm     take a latched fault back     disarm    force off
//   reload    read the configuration again  reset     the scene back to its start, the force off meanwhile
//   stop      end the run
// Who may write to the socket may do all of it: its mode is 0660, its folder the service's. Thread: construction and
// destruction [setup]; it serves on a thread of its own, of normal priority; tell() by one normal thread.
// Bound: kMostClients connections at once, of more the oldest is answered and closed; kLongestLine bytes in within
// kPatience_ms, or what came until then is answered. Who is slow to ask keeps nobody waiting. Any bytes may come: an
// answer repeats at most kLongestEcho of them, and what its making throws is the answer.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "rt/base/result.h"

namespace tactus::service {

inline constexpr std::size_t kLongestLine = 256;
inline constexpr std::size_t kLongestEcho = 64;  // of what was sent, in an answer
inline constexpr int kPatience_ms = 1000;
inline constexpr std::size_t kMostClients = 16;

class ControlServer {
 public:
  using Reload = std::function<Status(std::string& said)>;

  // `requests`: OperatorBit (rt/loop/haptic_loop.h) is set there, and taken by whoever gives it to the loop; `stop` is
  // set by "stop"; `reload` gives a line, what was changed, or an error; `can_reset`: there is a global world.
  static Result<std::unique_ptr<ControlServer>> open(const std::filesystem::path& socket,
                                                     std::atomic<std::uint32_t>& requests, std::atomic<bool>& stop,
                                                     Reload reload, bool can_reset = true);
  ~ControlServer();

  // The answer to "state": one JSON object.
  void tell(std::string state);
  // Whether a re-arm has something to take back, for its answer; true until it is told.
  void tell_latched(bool latched) noexcept { latched_.store(latched, std::memory_order_relaxed); }

  // One line's answer. Public for tests.
  std::string answer(const std::string& line);

 private:
  ControlServer(int listener, std::filesystem::path socket, std::atomic<std::uint32_t>& requests,
                std::atomic<bool>& stop, Reload reload, bool can_reset);
  void serve();
  template <class Clients>
  void serve_round(Clients& clients);
  void serve_one(int connection, const std::string& line);

  int listener_;
  std::filesystem::path socket_;
  std::atomic<std::uint32_t>& requests_;
  std::atomic<bool>& stop_;
  Reload reload_;
  bool can_reset_;
  std::uint64_t inode_;  // of the socket that was bound
  std::atomic<bool> closing_{false}, latched_{true};
  std::mutex mutex_;
  std::string state_{"{}"};
  std::thread thread_;  // last: it uses the others
};

// The other end: sends the line, gives the answer. One line on an error.
Result<std::string> ask_control(const std::filesystem::path& socket, const std::string& line);

}  // namespace tactus::service
