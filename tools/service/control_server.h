// The control socket of a running tactus: one line in, one line of JSON out, over a Unix stream socket.
//
//   state     the state of the loop         arm       force on, with the device where it is
//   rearm     clear a latched fault         disarm    force off
//   reload    read the configuration again  reset     the scene back to its start, the force off meanwhile
//   stop      end the run                  watch     pass on the memory that shows the run (tools/publication)
//   play, pause, tick, cycle, pace X       of a run in virtual time (pacing.h)
//   hand ID take | rest | X Y Z RX RY RZ   lead the simulated hand: so far from where it was taken [m; rotation vector,
//                                          rad]. ID: a number of the one who leads; others wait for 0.2 s of silence
// After "watch" the connection stays open: the run is watched until it closes, and what comes on it is ignored. Anyone
// who may write to the socket may use all commands: its mode is 0660, in the service's folder. Thread: construction and
// destruction [setup]; it serves on its own thread of normal priority; tell() from one normal thread. Bound:
// kMaxClients connections at once; beyond that the oldest is answered and closed. A request is kLongestLine bytes
// within kPatience_ms; after that, what has arrived is answered. A slow client does not delay others. Any bytes are
// accepted: an answer repeats at most kLongestEcho of them, and an exception while making it becomes the answer.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "rt/base/result.h"
#include "tools/service/pacing.h"
#include "tools/session/hand_input.h"

namespace tactus::service {

inline constexpr std::size_t kLongestLine = 256;
inline constexpr std::size_t kLongestEcho = 64;  // bytes of the request repeated in an answer
inline constexpr int kPatience_ms = 1000;
inline constexpr std::size_t kMaxClients = 16;
inline constexpr std::size_t kMaxWatchers = 8;

// The parts of a run that watchers see and its operator moves; null: this run lacks it.
struct Watchable {
  int descriptor{-1};                             // that "watch" passes on; -1: nothing
  std::atomic<std::uint32_t>* watchers{nullptr};  // counted by the server
  Pacing* pacing{nullptr};                        // of virtual time
  session::HandInput* hand{nullptr};              // of the simulated device
};

class ControlServer {
 public:
  using Reload = std::function<Status(std::string& said)>;

  // `requests`: OperatorBit (rt/loop/haptic_loop.h) is set there and cleared by the thread that passes it to the loop;
  // `stop` is set by "stop"; `reload` returns a line that lists the changes, or an error; `can_reset`: there is a
  // global world; `watchable` must outlive the server.
  static Result<std::unique_ptr<ControlServer>> open(const std::filesystem::path& socket,
                                                     std::atomic<std::uint32_t>& requests, std::atomic<bool>& stop,
                                                     Reload reload, bool can_reset = true,
                                                     const Watchable& watchable = {});
  ~ControlServer();

  // Sets the answer to "state": one JSON object.
  void tell(std::string state);
  // Sets whether a fault is latched, for the answer to "rearm"; true until the first call.
  void tell_latched(bool latched) noexcept { latched_.store(latched, std::memory_order_relaxed); }

  // Answers one line. Public for tests.
  std::string answer(const std::string& line);

 private:
  struct Listener {
    int descriptor;
    std::filesystem::path socket;
  };
  ControlServer(Listener listener, std::atomic<std::uint32_t>& requests, std::atomic<bool>& stop, Reload reload,
                bool can_reset, const Watchable& watchable);
  std::string answer_pacing(const std::string& word, const std::string& rest);
  std::string answer_hand(const std::string& rest);
  void serve();
  template <class Connections>
  void serve_round(Connections& connections);
  void serve_one(int connection, const std::string& line);
  // True: the connection watches from now on.
  bool begins_watching(int connection, std::size_t watching);

  int listener_;
  std::filesystem::path socket_;
  std::atomic<std::uint32_t>& requests_;
  std::atomic<bool>& stop_;
  Reload reload_;
  bool can_reset_;
  Watchable watchable_;
  std::uint64_t inode_;  // of the socket that was bound
  std::atomic<bool> closing_{false}, latched_{true};
  std::uint64_t hand_holder_{0};  // 0: nobody
  std::chrono::steady_clock::time_point hand_until_{};
  std::mutex mutex_;
  std::string state_{"{}"};
  std::thread thread_;  // last: it uses the others
};

// Client: sends the line and returns the answer. Error: one line.
Result<std::string> ask_control(const std::filesystem::path& socket, const std::string& line);

// Client: sends "watch". Both descriptors are the caller's; the run is watched until `connection` is closed. Error: one
// line, also the run's refusal.
struct WatchedRun {
  int memory{-1}, connection{-1};
};
Result<WatchedRun> watch_control(const std::filesystem::path& socket);

}  // namespace tactus::service
