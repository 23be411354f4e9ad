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
#include <string_view>
#include <utility>
#include <vector>

#include "rt/loop/haptic_loop.h"
#include "tools/caught.h"
#include "tools/json_text.h"

namespace tactus::service {
namespace {

constexpr int kLookEvery_ms = 100;  // interval of checking for the end of the run

class File {
 public:
  explicit File(int number) : number_(number) {}
  File(File&& other) noexcept : number_(other.release()) {}
  File& operator=(File&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~File() {
    if (number_ >= 0) close(number_);
  }
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

using Clock = std::chrono::steady_clock;

// A client connection, before or after its request.
struct Client {
  File connection;
  Clock::time_point give_up;
  std::string line{};
  bool complete{false};  // end of line, connection closed by the client, or line too long
};

// Reads the available bytes without waiting.
void receive(Client& client) {
  char bytes[kLongestLine];
  const ssize_t count =
      TEMP_FAILURE_RETRY(recv(client.connection.number(), bytes, kLongestLine - client.line.size(), MSG_DONTWAIT));
  if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
  const std::string_view came(bytes, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  const std::size_t end = came.find('\n');
  client.line += came.substr(0, end);
  client.complete = came.empty() || end != std::string_view::npos || client.line.size() >= kLongestLine;
}

// Reads the remaining input, because closing with unread input would discard the answer.
void drain(int connection) {
  char bytes[4096];
  for (int i = 0; i < 64 && TEMP_FAILURE_RETRY(recv(connection, bytes, sizeof bytes, MSG_DONTWAIT)) > 0; ++i) {}
}

bool is_served(const sockaddr_un& address) {
  const File connection(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (connect(connection.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return true;
  return errno != ECONNREFUSED && errno != ENOENT;  // in use, or owned by another process: must not be removed
}

std::uint64_t inode_of(const std::filesystem::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_ino : 0;
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
  // Removes a socket left by an earlier run, but not one that is still served.
  if (is_served(address)) return fail("another run serves it");
  if (struct stat status{}; stat(socket.c_str(), &status) == 0 && S_ISSOCK(status.st_mode)) unlink(socket.c_str());
  File listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (listener.number() < 0) return fail(strerrordesc_np(errno));
  const mode_t before = umask(0117);
  const bool bound = bind(listener.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const int error = errno;
  umask(before);
  if (!bound) return fail(strerrordesc_np(error));
  if (listen(listener.number(), static_cast<int>(kMaxClients)) != 0) return fail(strerrordesc_np(errno));
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
      inode_(inode_of(socket_)),
      thread_([this] { serve(); }) {}

ControlServer::~ControlServer() {
  closing_.store(true, std::memory_order_relaxed);
  thread_.join();
  close(listener_);
  if (inode_of(socket_) == inode_) unlink(socket_.c_str());  // only if it is still this socket
}

void ControlServer::tell(std::string state) {
  const std::lock_guard lock(mutex_);
  state_ = std::move(state);
}

std::string ControlServer::answer(const std::string& line) {
  const auto ask = [&](loop::OperatorBit bit, const char* said) {
    requests_.fetch_or(bit, std::memory_order_relaxed);  // relaxed: no other data is passed with it
    return good(said);
  };
  if (line == "state") {
    const std::lock_guard lock(mutex_);
    return state_;
  }
  const bool ending = stop_.load(std::memory_order_relaxed);
  if (ending && (line == "arm" || line == "rearm" || line == "reset" || line == "reload"))
    return bad("the run is ending: nothing was done");
  if (line == "arm") return ask(loop::kArm, "armed: force on, with the device where it is");
  if (line == "rearm")
    return ask(loop::kRearm, latched_.load(std::memory_order_relaxed)
                                 ? "re-arm asked for: the fault is taken back if the device is the same; see state"
                                 : "nothing is latched: nothing was done");
  if (line == "disarm") return ask(loop::kDisarm, "disarmed: force off");
  if (line == "reset") {
    if (!can_reset_) return bad("the direct coupling has no global world to reset");
    return ask(loop::kReset, "reset: the scene is reset; the force fades, and comes back by the ramp");
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

void ControlServer::serve_one(int connection, const std::string& line) {
  std::string text;
  const Status status = caught([&] { text = answer(line); });
  if (!status.ok()) text = bad(status.message());
  text += '\n';
  (void)send(connection, text.data(), text.size(),
             MSG_NOSIGNAL | MSG_DONTWAIT);  // does not block: an answer fits in the socket's buffer
  drain(connection);
}

void ControlServer::serve() {
  std::vector<Client> clients;  // the oldest first
  while (!closing_.load(std::memory_order_relaxed)) {
    // Not enough memory for an answer: none is sent.
    (void)caught([&] { serve_round(clients); });
  }
}

template <class Clients>
void ControlServer::serve_round(Clients& clients) {
  std::vector<pollfd> waiting{{listener_, POLLIN, 0}};
  for (const Client& client : clients) waiting.push_back({client.connection.number(), POLLIN, 0});
  (void)poll(waiting.data(), waiting.size(), kLookEvery_ms);
  for (std::size_t i = 0; i < clients.size(); ++i)
    if (waiting[i + 1].revents != 0) receive(clients[i]);
  if (waiting[0].revents != 0) {
    File connection(accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC));
    if (connection.number() >= 0)
      clients.push_back({std::move(connection), Clock::now() + std::chrono::milliseconds(kPatience_ms)});
    else
      (void)poll(nullptr, 0, kLookEvery_ms);  // out of file descriptors: wait, because the pending connection would
                                              // wake poll again at once
  }
  const auto now = Clock::now();
  const auto is_over = [&](const Client& client) {
    const bool crowded_out = clients.size() > kMaxClients && &client == &clients.front();
    if (!client.complete && now < client.give_up && !crowded_out) return false;
    serve_one(client.connection.number(), client.line);
    return true;
  };
  for (auto client = clients.begin(); client != clients.end();)
    client = is_over(*client) ? clients.erase(client) : std::next(client);
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
