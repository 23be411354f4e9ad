#include "tools/service/control_server.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "rt/loop/haptic_loop.h"
#include "tools/caught.h"
#include "tools/json_text.h"

namespace tactus::service {
namespace {

constexpr int kLookEvery_ms = 100;                      // interval of checking for the end of the run
constexpr std::chrono::milliseconds kHandSilence{200};  // after it another one may take the hand
constexpr double kFarthestWish_m = 10, kFarthestTurn_rad = 100;

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

struct Connections {
  std::vector<Client> clients;  // the oldest first
  std::vector<File> watchers;
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

// True: the other side has closed the connection. What came is discarded.
bool has_left(int connection) {
  char bytes[4096];
  const ssize_t count = TEMP_FAILURE_RETRY(recv(connection, bytes, sizeof bytes, MSG_DONTWAIT));
  return count == 0 || (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK);
}

union DescriptorMessage {  // aligned for its header
  cmsghdr header;
  char bytes[CMSG_SPACE(sizeof(int))];
};

// Sends the text, with the descriptor unless it is -1. Does not wait: the text fits in the socket's buffer.
bool send_with_descriptor(int connection, std::string text, int descriptor) {
  iovec part{text.data(), text.size()};
  DescriptorMessage control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = &control;
    message.msg_controllen = sizeof control;
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &descriptor, sizeof descriptor);
  }
  return TEMP_FAILURE_RETRY(sendmsg(connection, &message, MSG_NOSIGNAL | MSG_DONTWAIT)) ==
         static_cast<ssize_t>(text.size());
}

// Returns the descriptor that came with the text, or -1.
int receive_with_descriptor(int connection, std::string& text) {
  char bytes[1024];
  iovec part{bytes, sizeof bytes};
  DescriptorMessage control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = &control;
  message.msg_controllen = sizeof control;
  const ssize_t count = TEMP_FAILURE_RETRY(recvmsg(connection, &message, MSG_CMSG_CLOEXEC));
  text.assign(bytes, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  const cmsghdr* const header = CMSG_FIRSTHDR(&message);
  int descriptor = -1;
  if (count > 0 && header != nullptr && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_RIGHTS &&
      header->cmsg_len == CMSG_LEN(sizeof(int)))
    std::memcpy(&descriptor, CMSG_DATA(header), sizeof descriptor);
  return descriptor;
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
                                                           std::atomic<bool>& stop, Reload reload, bool can_reset,
                                                           const Watchable& watchable) {
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
      new ControlServer({listener.release(), socket}, requests, stop, std::move(reload), can_reset, watchable));
}

ControlServer::ControlServer(Listener listener, std::atomic<std::uint32_t>& requests, std::atomic<bool>& stop,
                             Reload reload, bool can_reset, const Watchable& watchable)
    : listener_(listener.descriptor),
      socket_(std::move(listener.socket)),
      requests_(requests),
      stop_(stop),
      reload_(std::move(reload)),
      can_reset_(can_reset),
      watchable_(watchable),
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
  const std::string word = line.substr(0, line.find(' '));
  const std::string rest = line.size() > word.size() ? line.substr(word.size() + 1) : std::string();
  for (const char* one : {"play", "pause", "tick", "cycle", "pace"})
    if (word == one) return answer_pacing(word, rest);
  if (word == "hand") return answer_hand(rest);
  const bool long_line = line.size() > kLongestEcho;
  return bad(
      fmt::format("'{}'{} is no request; accepted: state, arm, rearm, disarm, reset, reload, stop, watch, play, "
                  "pause, tick, cycle, pace X, hand ID take",
                  line.substr(0, kLongestEcho), long_line ? " and more" : ""));
}

std::string ControlServer::answer_pacing(const std::string& word, const std::string& rest) {
  if (watchable_.pacing == nullptr)
    return bad("real time cannot be paused, stepped or slowed down; accepted: a run with --virtual-time");
  Pacing& pacing = *watchable_.pacing;
  if (word == "pace") {
    double pace = -1;
    const auto read = std::from_chars(rest.data(), rest.data() + rest.size(), pace);
    if (read.ec != std::errc() || read.ptr != rest.data() + rest.size() ||
        !(pace == 0 || (pace >= kMinPace && pace <= kMaxPace)))
      return bad(
          fmt::format("pace: accepted: {:g} to {:g} times real time, or 0 for as fast as it goes", kMinPace, kMaxPace));
    pacing.pace.store(pace, std::memory_order_relaxed);
    return good(pace == 0 ? "as fast as it goes" : fmt::format("{:g} times real time", pace));
  }
  pacing.playing.store(word == "play", std::memory_order_relaxed);
  if (word == "tick") pacing.ticks.fetch_add(1, std::memory_order_relaxed);
  if (word == "cycle") pacing.cycles.fetch_add(1, std::memory_order_relaxed);
  return good(word == "play" ? "playing" : "paused");
}

std::string ControlServer::answer_hand(const std::string& rest) {
  if (watchable_.hand == nullptr) return bad("a real device's hand is a person's; accepted: the simulated device");
  std::istringstream words(rest);
  std::uint64_t id = 0;
  std::string word;
  if (!(words >> id >> word) || id == 0)
    return bad("hand: accepted: hand ID take, hand ID rest, hand ID X Y Z RX RY RZ");
  const auto now = Clock::now();
  if (hand_holder_ != id && now < hand_until_) return bad("another page has the hand");
  if (word == "take" || word == "rest") {
    hand_holder_ = word == "take" ? id : 0;
    hand_until_ = word == "take" ? now + kHandSilence : now;
    word == "take" ? watchable_.hand->take() : watchable_.hand->rest();
    return good(word == "take" ? "the hand is yours" : "the hand rests");
  }
  if (hand_holder_ != id) return bad("hand: it is to be taken first");
  std::istringstream numbers(rest);
  double wish[6]{};
  numbers >> id;
  for (double& number : wish) numbers >> number;
  if (numbers.fail()) return bad("hand: accepted: six numbers");
  for (int i = 0; i < 6; ++i)
    if (!(std::abs(wish[i]) <= (i < 3 ? kFarthestWish_m : kFarthestTurn_rad)))
      return bad(fmt::format("hand: accepted: up to {:g} m and {:g} rad", kFarthestWish_m, kFarthestTurn_rad));
  hand_until_ = now + kHandSilence;
  watchable_.hand->lead({wish[0], wish[1], wish[2]}, {wish[3], wish[4], wish[5]});
  return good("");
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

bool ControlServer::begins_watching(int connection, std::size_t watching) {
  std::string refusal;
  if (watchable_.descriptor < 0) refusal = bad("this run shows nothing");
  if (watching >= kMaxWatchers) refusal = bad(fmt::format("{} watch already; accepted: one fewer", watching));
  const std::string text = (refusal.empty() ? good("watching") : refusal) + "\n";
  const int descriptor = refusal.empty() ? watchable_.descriptor : -1;
  return send_with_descriptor(connection, text, descriptor) && descriptor >= 0;
}

void ControlServer::serve() {
  Connections connections;
  while (!closing_.load(std::memory_order_relaxed)) {
    // Not enough memory for an answer: none is sent.
    (void)caught([&] { serve_round(connections); });
    if (watchable_.watchers != nullptr)
      watchable_.watchers->store(static_cast<std::uint32_t>(connections.watchers.size()), std::memory_order_relaxed);
  }
  if (watchable_.watchers != nullptr) watchable_.watchers->store(0, std::memory_order_relaxed);
}

template <class Connections>
void ControlServer::serve_round(Connections& connections) {
  std::vector<Client>& clients = connections.clients;
  std::vector<File>& watchers = connections.watchers;
  std::vector<pollfd> waiting{{listener_, POLLIN, 0}};
  for (const Client& client : clients) waiting.push_back({client.connection.number(), POLLIN, 0});
  for (const File& watcher : watchers) waiting.push_back({watcher.number(), POLLIN, 0});
  (void)poll(waiting.data(), waiting.size(), kLookEvery_ms);
  const pollfd* const of_watchers = waiting.data() + 1 + clients.size();
  for (std::size_t i = watchers.size(); i-- > 0;)
    if (of_watchers[i].revents != 0 && has_left(watchers[i].number()))
      watchers.erase(watchers.begin() + static_cast<std::ptrdiff_t>(i));
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
  const auto is_over = [&](Client& client) {
    const bool crowded_out = clients.size() > kMaxClients && &client == &clients.front();
    if (!client.complete && now < client.give_up && !crowded_out) return false;
    if (client.line != "watch")
      serve_one(client.connection.number(), client.line);
    else if (begins_watching(client.connection.number(), watchers.size()))
      watchers.push_back(std::move(client.connection));
    return true;
  };
  for (auto client = clients.begin(); client != clients.end();)
    client = is_over(*client) ? clients.erase(client) : std::next(client);
}

namespace {

std::string not_served(const std::filesystem::path& socket, const std::string& what) {
  return fmt::format("{}: {}; accepted: the socket of a running `tactus run --config` or --control", socket.string(),
                     what);
}

// Connects and sends the line.
Result<File> ask(const std::filesystem::path& socket, const std::string& line) {
  const auto fail = [&](const std::string& what) { return Status::error(not_served(socket, what)); };
  sockaddr_un address{};
  if (!fill_address(socket, address)) return fail("the path is too long");
  File connection(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (connection.number() < 0) return fail(strerrordesc_np(errno));
  if (connect(connection.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return fail(errno == ENOENT || errno == ECONNREFUSED ? "no run answers there"
                : errno == EACCES                        ? "this user may not ask there; the group tactus may"
                                                         : strerrordesc_np(errno));
  const std::string text = line + "\n";
  if (send(connection.number(), text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size()))
    return fail(strerrordesc_np(errno));
  return connection;
}

}  // namespace

Result<std::string> ask_control(const std::filesystem::path& socket, const std::string& line) {
  const auto connection = ask(socket, line);
  if (!connection.ok()) return connection.status();
  std::string answer;
  char buffer[1024];
  pollfd waiting{connection.value().number(), POLLIN, 0};
  while (TEMP_FAILURE_RETRY(poll(&waiting, 1, 3 * kPatience_ms)) > 0) {
    const ssize_t count = TEMP_FAILURE_RETRY(read(waiting.fd, buffer, sizeof buffer));
    if (count <= 0) break;
    answer.append(buffer, static_cast<std::size_t>(count));
  }
  if (!answer.ends_with('\n')) return Status::error(not_served(socket, "no answer"));
  answer.pop_back();
  return answer;
}

Result<WatchedRun> watch_control(const std::filesystem::path& socket) {
  auto connection = ask(socket, "watch");
  if (!connection.ok()) return connection.status();
  pollfd waiting{connection.value().number(), POLLIN, 0};
  std::string answer;
  int memory = -1;
  if (TEMP_FAILURE_RETRY(poll(&waiting, 1, 3 * kPatience_ms)) > 0) memory = receive_with_descriptor(waiting.fd, answer);
  if (memory >= 0) return WatchedRun{memory, connection.value().release()};
  const auto said = nlohmann::json::parse(answer, nullptr, /*allow_exceptions=*/false);
  const bool refused = said.is_object() && said.contains("said") && said["said"].is_string();
  return Status::error(refused ? socket.string() + ": " + said["said"].template get<std::string>()
                               : not_served(socket, "no answer"));
}

}  // namespace tactus::service
