// The control socket end to end, the log's lines, and what systemd is told.
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "rt/loop/haptic_loop.h"
#include "tools/service/control_server.h"
#include "tools/service/event_log.h"
#include "tools/service/monitor.h"
#include "tools/service/notify.h"
#include "tools/version/version.h"

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

using namespace tactus;
using namespace tactus::service;

namespace {

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "tactus-control-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};

struct Bench {
  Folder folder;
  std::atomic<std::uint32_t> requests{0};
  std::atomic<bool> stop{false};
  std::filesystem::path socket = folder.path / "control";
  std::unique_ptr<ControlServer> server = open();

  std::unique_ptr<ControlServer> open(const Watchable& watchable = {}) {
    const auto reload = [](std::string& said) {
      said = "nothing changed";
      return Status::good();
    };
    auto opened = ControlServer::open(socket, requests, stop, reload, true, watchable);
    INFO(opened.message());
    REQUIRE(opened.ok());
    return std::move(opened).value();
  }
  nlohmann::json ask(const std::string& line) const {
    const auto answer = ask_control(socket, line);
    INFO(answer.message());
    REQUIRE(answer.ok());
    return nlohmann::json::parse(answer.value());
  }
};

std::string written(const std::function<void(EventLog&)>& events, bool with_level = false) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* file = open_memstream(&text, &size);
  EventLog log(file, with_level, 1.0);
  events(log);
  std::fclose(file);
  std::string lines(text, size);
  std::free(text);
  return lines;
}

// Connections that send the beginning of a request and then nothing.
class SlowClients {
 public:
  SlowClients(const std::filesystem::path& socket, int count) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, socket.c_str());
    for (int i = 0; i < count; ++i) {
      const int connection = ::socket(AF_UNIX, SOCK_STREAM, 0);
      connections_.push_back(connection);
      REQUIRE(connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
      REQUIRE(write(connection, "sta", 3) == 3);
    }
  }
  ~SlowClients() {
    for (const int connection : connections_) close(connection);
  }
  SlowClients(const SlowClients&) = delete;
  SlowClients& operator=(const SlowClients&) = delete;

 private:
  std::vector<int> connections_;
};

}  // namespace

TEST_CASE("clients that send slowly do not delay a disarm, whatever their number", "[threads]") {
  // Served one after the other they would take longer than the time-out of a request.
  for (const int count : {8, 3 * static_cast<int>(kMaxClients)}) {
    Bench bench;
    const SlowClients slow(bench.socket, count);
    CHECK(bench.ask("disarm")["ok"] == true);
    CHECK(bench.requests.load() == loop::kDisarm);
  }
}

TEST_CASE("a socket whose run is busy is not taken away from it, nor one that is another run's by now", "[threads]") {
  Bench bench;
  {
    const SlowClients slow(bench.socket, 8);
    const auto second = ControlServer::open(bench.socket, bench.requests, bench.stop, {});
    REQUIRE_FALSE(second.ok());
    CHECK_THAT(second.message(), Contains("another run serves it"));
  }
  std::filesystem::remove(bench.socket);
  auto other = bench.open();
  bench.server.reset();
  CHECK(bench.ask("state").is_object());  // the other run's socket is still there
  bench.server = std::move(other);
}

TEST_CASE("a run that ends takes no new work, and disarms all the same", "[threads]") {
  Bench bench;
  CHECK(bench.ask("stop")["ok"] == true);
  for (const char* request : {"arm", "rearm", "reset", "reload"}) CHECK(bench.ask(request)["ok"] == false);
  CHECK(bench.requests.load() == 0);
  CHECK(bench.ask("disarm")["ok"] == true);
}

TEST_CASE("requests become operator bits, each once, and stop sets the flag", "[threads]") {
  Bench bench;
  CHECK(bench.ask("arm")["ok"] == true);
  CHECK(bench.requests.exchange(0) == loop::kArm);
  CHECK(bench.ask("disarm")["ok"] == true);
  CHECK(bench.ask("rearm")["ok"] == true);
  CHECK(bench.requests.exchange(0) == (loop::kDisarm | loop::kRearm));
  bench.server->tell_latched(false);
  CHECK(bench.ask("rearm")["said"] == "nothing is latched: nothing was done");
  CHECK(bench.requests.exchange(0) == loop::kRearm);  // one may have latched just now; the loop knows
  CHECK(bench.ask("reset")["ok"] == true);
  CHECK(bench.requests.exchange(0) == loop::kReset);
  CHECK_FALSE(bench.stop.load());
  CHECK(bench.ask("stop")["said"] == "stopping");
  CHECK(bench.stop.load());
}

TEST_CASE("state returns the run's last report, reload its answer", "[threads]") {
  Bench bench;
  bench.server->tell(R"({"ok":true,"ticks":42})");
  CHECK(bench.ask("state")["ticks"] == 42);
  CHECK(bench.ask("reload")["said"] == "nothing changed");
}

TEST_CASE("real time is not paused, stepped or slowed down, and virtual time is", "[threads]") {
  Bench bench;
  for (const char* line : {"play", "pause", "tick", "cycle", "pace 0.1"}) {
    const auto refused = bench.ask(line);
    CHECK(refused["ok"] == false);
    CHECK_THAT(refused["said"].get<std::string>(),
               StartsWith("real time cannot be paused") && Contains("; accepted: "));
  }
  Pacing pacing;
  bench.server.reset();
  bench.server = bench.open({.pacing = &pacing});
  CHECK(bench.ask("pause")["ok"] == true);
  CHECK_FALSE(pacing.playing.load());
  CHECK(bench.ask("tick")["ok"] == true);
  CHECK(bench.ask("cycle")["ok"] == true);
  CHECK(pacing.ticks.load() == 1);
  CHECK(pacing.cycles.load() == 1);
  CHECK(bench.ask("pace 0.01")["ok"] == true);
  CHECK(pacing.pace.load() == 0.01);
  CHECK(bench.ask("pace 0")["ok"] == true);
  for (const char* line : {"pace", "pace x", "pace 0.001", "pace 101", "pace nan", "pace -1", "pace 1 2"})
    CHECK(bench.ask(line)["ok"] == false);
  CHECK(pacing.pace.load() == 0);
  CHECK(bench.ask("play")["ok"] == true);
  CHECK(pacing.playing.load());
}

TEST_CASE("one client at a time leads the simulated hand, and none a real device's", "[threads]") {
  Bench bench;
  CHECK(bench.ask("hand 1 take")["ok"] == false);
  session::HandInput hand;
  bench.server.reset();
  bench.server = bench.open({.hand = &hand});
  CHECK(bench.ask("hand 1 0 0 0 0 0 0")["ok"] == false);  // not taken
  CHECK(bench.ask("hand 1 take")["ok"] == true);
  CHECK(bench.ask("hand 1 0.1 0 -0.2 0 0 0.5")["ok"] == true);
  const auto second = bench.ask("hand 2 take");
  CHECK(second["ok"] == false);
  CHECK(second["said"] == "another page has the hand");
  for (const char* line : {"hand", "hand 1", "hand 0 take", "hand 1 1 2 3", "hand 1 nan 0 0 0 0 0",
                           "hand 1 11 0 0 0 0 0", "hand 1 x 0 0 0 0 0", "hand 1 1e999 0 0 0 0 0"})
    CHECK(bench.ask(line)["ok"] == false);
  CHECK(bench.ask("hand 1 rest")["ok"] == true);
  CHECK(bench.ask("hand 2 take")["ok"] == true);
}

TEST_CASE("what is no request is refused, also where it is long or nothing", "[threads]") {
  Bench bench;
  for (const std::string& line : {std::string("fly"), std::string(), std::string(10 * kLongestLine, 'x')}) {
    const auto answer = ask_control(bench.socket, line);
    INFO(answer.message());
    REQUIRE(answer.ok());
    CHECK(nlohmann::json::parse(answer.value())["ok"] == false);
  }
  CHECK(bench.ask("arm")["ok"] == true);  // and it goes on
  CHECK(bench.requests.load() == loop::kArm);
}

TEST_CASE("an answer is JSON whatever was asked, and repeats at most 64 bytes of it", "[threads]") {
  Bench bench;
  const std::string long_line = std::string(kLongestEcho, 'x') + "yy";
  for (const std::string& line : {std::string("\xff\xfe\x80"), std::string("\xc3"), std::string(3, '\0'), long_line}) {
    const auto answer = nlohmann::json::parse(bench.server->answer(line), nullptr, /*allow_exceptions=*/false);
    REQUIRE(answer.is_object());
    CHECK(answer["ok"] == false);
    CHECK_THAT(answer["said"].get<std::string>(), Contains("is no request") && !Contains("xy"));
  }
}

TEST_CASE("what a reload throws is its answer, and the server goes on", "[threads]") {
  const Folder folder;
  std::atomic<std::uint32_t> requests{0};
  std::atomic<bool> stop{false};
  const auto server = ControlServer::open(folder.path / "control", requests, stop,
                                          [](std::string&) -> Status { throw std::runtime_error("no disk"); });
  REQUIRE(server.ok());
  const auto answer = ask_control(folder.path / "control", "reload");
  REQUIRE(answer.ok());
  CHECK(nlohmann::json::parse(answer.value())["said"] == "no disk");
  CHECK(ask_control(folder.path / "control", "arm").ok());
}

TEST_CASE("the socket is the group's, is taken over from a dead run and never from a living one", "[threads]") {
  Bench bench;
  struct stat status {};
  REQUIRE(stat(bench.socket.c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0660);
  const auto second = ControlServer::open(bench.socket, bench.requests, bench.stop, {});
  REQUIRE_FALSE(second.ok());
  CHECK_THAT(second.message(), Contains("another run serves it"));
  bench.server.reset();
  CHECK_FALSE(std::filesystem::exists(bench.socket));
  CHECK_FALSE(ask_control(bench.socket, "state").ok());

  const int left = ::socket(AF_UNIX, SOCK_STREAM, 0);  // as a killed run leaves it
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, bench.socket.c_str());
  REQUIRE(bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  close(left);
  bench.server = bench.open();
  CHECK(bench.ask("disarm")["ok"] == true);
}

TEST_CASE("an event comes once in its interval, with how often it was held back, and the level that journald takes") {
  const std::string lines = written([](EventLog& log) {
    log.event(LogLevel::kWarning, "overruns", {{"count", "1"}}, 0.0);
    log.event(LogLevel::kWarning, "overruns", {{"count", "2"}}, 0.4);
    log.event(LogLevel::kError, "fault", {{"text", "no \"link\" now"}}, 0.5);
    log.event(LogLevel::kWarning, "overruns", {{"count", "3"}}, 0.9);
    log.event(LogLevel::kWarning, "overruns", {{"count", "4"}}, 1.0);
    log.event(LogLevel::kWarning, "overruns", {{"count", "5"}}, 2.5);
  });
  CHECK(lines ==
        "overruns count=1\nfault text=\"no \\\"link\\\" now\"\noverruns count=4 suppressed=2\noverruns count=5\n");
  CHECK(written([](EventLog& log) { log.event(LogLevel::kNotice, "x", {}, 0); }, true) == "<5>x\n");
  CHECK(written([](EventLog& log) {
          log.set_hand(2);
          log.event(LogLevel::kNotice, "x", {{"a", "1"}}, 0);
        }) == "x hand=2 a=1\n");
}

TEST_CASE("the monitor reports changes, and that the loop is alive") {
  session::LiveStatus live;
  const std::string lines = written([&](EventLog& log) {
    Monitor monitor(log, {"a.toml", "0123456789abcdef"});
    monitor.look(live, 0.2);
    CHECK_FALSE(monitor.alive());
    live.ticks = 200;
    monitor.look(live, 0.4);
    CHECK(monitor.alive());
    CHECK(monitor.rate_Hz() == Approx(1000));
    live.ticks = 400;
    live.overruns = 3;
    monitor.look(live, 0.6);
    live.ticks = 600;
    live.fault = static_cast<std::uint32_t>(Fault::kEmergencyStop);
    monitor.look(live, 0.8);
    monitor.look(live, 1.0);
    CHECK_FALSE(monitor.alive());
  });
  CHECK_THAT(lines,
             Contains("running rate_Hz=1000 version=\"" + version() +
                      "\" scene=a.toml scene_hash=0123456789abcdef\narmed\noverruns count=3 total=3\nfault code=") &&
                 Contains("standstill"));
  const auto state = nlohmann::json::parse(state_json(live, 1.0, 1000, {"a.toml", "0123456789abcdef"}));
  CHECK(state["version"] == version());
  CHECK(state["scene_file"] == "a.toml");
  CHECK(state["scene_hash"] == "0123456789abcdef");
  CHECK(state["ticks"] == 600);
  CHECK(state["overruns"] == 3);
  CHECK(state["fault"] == static_cast<std::uint32_t>(Fault::kEmergencyStop));
  CHECK_FALSE(state["fault_text"].get<std::string>().empty());
}

TEST_CASE("the log says when force comes and goes, and not twice where a fault takes it") {
  session::LiveStatus live;
  const std::string lines = written([&](EventLog& log) {
    Monitor monitor(log);
    monitor.look(live, 0.2);
    live.ticks = 200;
    live.status = kNotArmed;
    monitor.look(live, 0.4);
    live.ticks = 400;
    live.status = 0;
    monitor.look(live, 0.6);
    live.ticks = 600;
    live.status = kNotArmed;
    monitor.look(live, 0.8);
    live.ticks = 800;
    live.status = 0;
    monitor.look(live, 2.0);
    live.ticks = 1000;
    live.status = kNotArmed;
    live.fault = static_cast<std::uint32_t>(Fault::kEmergencyStop);
    monitor.look(live, 4.0);
  });
  CHECK_THAT(lines, StartsWith("running rate_Hz=1000 ") && Contains("\narmed\ndisarmed\narmed\nfault code="));
  CHECK(std::count(lines.begin(), lines.end(), '\n') == 5);
}

TEST_CASE("systemd is notified over its socket, and without one nothing is sent") {
  const Folder folder;
  unsetenv("NOTIFY_SOCKET");
  CHECK_FALSE(notify("READY=1"));
  const std::string path = (folder.path / "notify").string();
  const int listener = ::socket(AF_UNIX, SOCK_DGRAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  REQUIRE(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  CHECK(notify("READY=1"));
  char text[32]{};
  CHECK(recv(listener, text, sizeof text - 1, MSG_DONTWAIT) == 7);
  CHECK(std::string(text) == "READY=1");
  close(listener);
  unsetenv("NOTIFY_SOCKET");

  setenv("WATCHDOG_USEC", "5000000", 1);
  CHECK(watchdog_period_s() == Approx(5));
  setenv("WATCHDOG_PID", "1", 1);
  CHECK(watchdog_period_s() == 0);
  unsetenv("WATCHDOG_USEC");
  unsetenv("WATCHDOG_PID");
}

TEST_CASE("watch passes the descriptor on and counts the open connections, and other requests are served",
          "[threads]") {
  const Folder folder;
  std::atomic<std::uint32_t> requests{0}, watchers{0};
  std::atomic<bool> stop{false};
  const int memory = memfd_create("test", MFD_CLOEXEC);
  REQUIRE(write(memory, "shown", 5) == 5);
  const auto socket = folder.path / "control";
  auto opened = ControlServer::open(socket, requests, stop, {}, true, {memory, &watchers});
  REQUIRE(opened.ok());
  const auto becomes = [&](std::uint32_t count) {
    for (int i = 0; i < 300 && watchers.load() != count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return watchers.load() == count;
  };
  std::vector<WatchedRun> runs;
  for (std::size_t i = 0; i < kMaxWatchers; ++i) {
    const auto run = watch_control(socket);
    INFO(run.message());
    REQUIRE(run.ok());
    runs.push_back(run.value());
    char text[6]{};
    CHECK(pread(run.value().memory, text, 5, 0) == 5);
    CHECK(std::string(text) == "shown");
  }
  CHECK(becomes(kMaxWatchers));
  const auto refused = watch_control(socket);
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(refused.message(), Contains("8 watch already; accepted: one fewer"));
  CHECK_THAT(ask_control(socket, "state").value(), Contains("{"));
  CHECK(write(runs[0].connection, "noise", 5) == 5);  // is ignored
  close(runs[1].connection);
  CHECK(becomes(kMaxWatchers - 1));
  opened.value().reset();  // the run ends before its watchers
  CHECK(watchers.load() == 0);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    close(runs[i].memory);
    if (i != 1) close(runs[i].connection);
  }
  close(memory);
}

TEST_CASE("a run without publication reports so to a watcher, and a missing run gives one line", "[threads]") {
  Bench bench;
  const auto nothing = watch_control(bench.socket);
  REQUIRE_FALSE(nothing.ok());
  CHECK_THAT(nothing.message(), Contains("this run shows nothing"));
  const auto nobody = watch_control(bench.folder.path / "none");
  REQUIRE_FALSE(nobody.ok());
  CHECK_THAT(nobody.message(), Contains("no run answers there; accepted: "));
}
