#include "tools/service/control_server.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "rt/loop/haptic_loop.h"
#include "tools/caught.h"
#include "tools/json_text.h"

namespace tactus::service {
namespace {

constexpr int kLookEvery_ms = 100;  // for the end of the run

class File {
 public:
  explicit File(int number) : number_(number) {}
  ~File() {
    if (number_ >= 0) close(number_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  int number() const { return number_; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

bool fill_address(const std::filesystem::path& socket, sockaddr_un& address) {
  address.sun_family = AF_UNIX;
  if (socket.string().size() >= sizeof address.sun_path) return false;
  std::strcpy(address.sun_path, socket.c_str());
  return true;
}

// Up to the end of the line, the other side's end, or the end of the patience with the whole line.
std::string read_line(int connection) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::milliseconds(kPatience_ms);
  const auto left_ms = [&] {
    const auto left = give_up - std::chrono::steady_clock::now();
    return static_cast<int>(std::max<std::int64_t>(0, std::chrono::ceil<std::chrono::milliseconds>(left).count()));
  };
  std::string line;
  char byte = 0;
  pollfd waiting{connection, POLLIN, 0};
  // A signal to this thread is no end of a line.
  while (line.size() < kLongestLine && TEMP_FAILURE_RETRY(poll(&waiting, 1, left_ms())) > 0 &&
         TEMP_FAILURE_RETRY(read(connection, &byte, 1)) == 1) {
    if (byte == '\n') break;
    line += byte;
  }
  return line;
}

std::string good(const std::string& said) { return json_text(nlohmann::json{{"ok", true}, {"said", said}}); }
std::string bad(const std::string& said) { return json_text(nlohmann::json{{"ok", false}, {"said", said}}); }

}  // namespace

Result<std::unique_ptr<ControlServer>> ControlServer::open(const std::filesystem::path& socket,
                                                           std::atomic<std::uint32_t>& requests,
                                                           std::atomic<bool>& stop, Reload reload, bool can_reset) {
  const auto fail = [&](const std::string& what) {
    return Status::error(
        fmt::format("control socket {}: {}; accepted: a path in a folder that this user may write to, "
                    "of up to 107 characters",
                    socket.string(), what));
  };
  sockaddr_un address{};
  if (!fill_address(socket, address)) return fail("the path is too long");
  // What a run before left behind; one that somebody serves is not taken away from them.
  if (ask_control(socket, "state").ok()) return fail("another run serves it");
  if (struct stat status{}; stat(socket.c_str(), &status) == 0 && S_ISSOCK(status.st_mode)) unlink(socket.c_str());
  File listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (listener.number() < 0) return fail(strerrordesc_np(errno));
  const mode_t before = umask(0117);
  const bool bound = bind(listener.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const int error = errno;
  umask(before);
  if (!bound) return fail(strerrordesc_np(error));
  if (listen(listener.number(), 4) != 0) return fail(strerrordesc_np(errno));
  return std::unique_ptr<ControlServer>(
      new ControlServer(listener.release(), socket, requests, stop, std::move(reload), can_reset));
}

ControlServer::ControlServer(int listener, std::filesystem::path socket, std::atomic<std::uint32_t>& requests,
                             std::atomic<bool>& stop, Reload reload, bool can_reset)
    : listener_(listener),
      socket_(std::move(socket)),
      requests_(requests),
      stop_(stop),
      reload_(std::move(reload)),
      can_reset_(can_reset),
      thread_([this] { serve(); }) {}

ControlServer::~ControlServer() {
  closing_.store(true, std::memory_order_relaxed);
  thread_.join();
  close(listener_);
  unlink(socket_.c_str());
}

void ControlServer::tell(std::string state) {
  const std::lock_guard lock(mutex_);
  state_ = std::move(state);
}

std::string ControlServer::answer(const std::string& line) {
  const auto ask = [&](loop::OperatorBit bit, const char* said) {
    requests_.fetch_or(bit, std::memory_order_relaxed);  // nothing is handed over with it
    return good(said);
  };
  if (line == "state") {
    const std::lock_guard lock(mutex_);
    return state_;
  }
  if (line == "arm") return ask(loop::kArm, "armed: force on, with the device where it is");
  if (line == "rearm")
    return ask(loop::kRearm, latched_.load(std::memory_order_relaxed)
                                 ? "re-arm asked for: the fault is taken back if the device is the same; see state"
                                 : "nothing is latched: nothing was done");
  if (line == "disarm") return ask(loop::kDisarm, "disarmed: force off");
  if (line == "reset") {
    if (!can_reset_) return bad("the direct coupling has no global world that could begin anew");
    return ask(loop::kReset, "reset: the scene begins anew; the force fades, and comes back with it");
  }
  if (line == "stop") {
    stop_.store(true, std::memory_order_relaxed);
    return good("stopping");
  }
  if (line == "reload") {
    if (!reload_) return bad("this run has no configuration file");
    std::string said;
    const Status status = reload_(said);
    return status.ok() ? good(said) : bad(status.message());
  }
  const bool long_line = line.size() > kLongestEcho;
  return bad(fmt::format("'{}'{} is no request; accepted: state, arm, rearm, disarm, reset, reload, stop",
                         line.substr(0, kLongestEcho), long_line ? " and more" : ""));
}

void ControlServer::serve_one(int connection) {
  std::string text;
  const Status status = caught([&] { text = answer(read_line(connection)); });
  if (!status.ok()) text = bad(status.message());
  text += '\n';
  (void)send(connection, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);  // an answer fits the socket's buffer
}

void ControlServer::serve() {
  pollfd waiting{listener_, POLLIN, 0};
  while (!closing_.load(std::memory_order_relaxed)) {
    if (poll(&waiting, 1, kLookEvery_ms) <= 0) continue;
    const File connection(accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC));
    if (connection.number() >= 0)
      (void)caught([&] { serve_one(connection.number()); });  // no memory even for an answer: there is none
    else
      (void)poll(nullptr, 0, kLookEvery_ms);  // out of files: the connection stays and would be asked for at once
  }
}

Result<std::string> ask_control(const std::filesystem::path& socket, const std::string& line) {
  const auto fail = [&](const std::string& what) {
    return Status::error(fmt::format("{}: {}; accepted: the socket of a running `tactus run --config` or --control",
                                     socket.string(), what));
  };
  sockaddr_un address{};
  if (!fill_address(socket, address)) return fail("the path is too long");
  const File connection(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (connection.number() < 0) return fail(strerrordesc_np(errno));
  if (connect(connection.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return fail(errno == ENOENT || errno == ECONNREFUSED ? "no run answers there"
                : errno == EACCES                        ? "this user may not ask there; the group tactus may"
                                                         : strerrordesc_np(errno));
  const std::string text = line + "\n";
  if (send(connection.number(), text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size()))
    return fail(strerrordesc_np(errno));
  std::string answer;
  char buffer[1024];
  pollfd waiting{connection.number(), POLLIN, 0};
  while (TEMP_FAILURE_RETRY(poll(&waiting, 1, 3 * kPatience_ms)) > 0) {
    const ssize_t count = TEMP_FAILURE_RETRY(read(connection.number(), buffer, sizeof buffer));
    if (count <= 0) break;
    answer.append(buffer, static_cast<std::size_t>(count));
  }
  if (!answer.ends_with('\n')) return fail("no answer");
  answer.pop_back();
  return answer;
}

}  // namespace tactus::service
