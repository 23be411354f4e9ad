// Whatever comes over its control socket, a controller goes on driving its device: random bytes, bytes that are no
// UTF-8, lines that are too long, connections that say nothing.
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/random.h"

namespace {

// `tactus run --config` as a process of its own, with the simulated device, until it is asked to stop.
class Controller {
 public:
  Controller() {
    folder_ = (std::filesystem::temp_directory_path() / "tactus-bytes-XXXXXX").string();
    REQUIRE(mkdtemp(folder_.data()) != nullptr);
    std::ofstream(folder_ + "/tactus.toml") << "scene = \"" TACTUS_SOURCE_DIR "/sim/scenes/stack20.toml\"\n"
                                            << "[cores]\npriority = 0\n[control]\nsocket = \"" << socket() << "\"\n";
    process_ = fork();
    REQUIRE(process_ >= 0);
    if (process_ == 0) {
      if (std::freopen("/dev/null", "w", stdout) == nullptr) _exit(127);
      if (std::freopen((folder_ + "/log").c_str(), "w", stderr) == nullptr) _exit(127);
      execl(TACTUS_PROGRAM, "tactus", "run", "--config", (folder_ + "/tactus.toml").c_str(), nullptr);
      _exit(127);
    }
    while (exchange("state\n").find("ticks") == std::string::npos && is_running()) usleep(10'000);
  }
  ~Controller() {
    if (is_running()) {
      kill(process_, SIGKILL);
      waitpid(process_, &status_, 0);
    }
    std::filesystem::remove_all(folder_);
  }

  std::string socket() const { return folder_ + "/control"; }
  bool is_running() { return !ended_ && !(ended_ = waitpid(process_, &status_, WNOHANG) == process_); }
  // As a shell gives it: 128 and the signal's number for one that a signal ended.
  int wait_for_status() {
    if (!ended_) ended_ = waitpid(process_, &status_, 0) == process_;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }
  std::string log() const {
    std::ifstream file(folder_ + "/log");
    return {std::istreambuf_iterator<char>(file), {}};
  }

  // Sends the bytes as they are, ends its side, and gives all that comes back.
  std::string exchange(const std::string& bytes) const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, socket().c_str());
    const int connection = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    std::string answer;
    if (connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
      (void)send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      ::shutdown(connection, SHUT_WR);
      std::array<char, 4096> part;
      for (ssize_t got; (got = read(connection, part.data(), part.size())) > 0;)
        answer.append(part.data(), static_cast<std::size_t>(got));
    }
    close(connection);
    return answer;
  }

 private:
  std::string folder_;
  pid_t process_{-1};
  int status_{0};
  bool ended_{false};
};

}  // namespace

TEST_CASE("no bytes on its control socket end a controller, and it goes on ticking") {
  Controller controller;
  INFO(controller.log());
  REQUIRE(controller.is_running());
  const auto state = [&] { return nlohmann::json::parse(controller.exchange("state\n"), nullptr, false); };
  const auto before = state();
  tactus::sim::Random random(20);
  for (int i = 0; i < 300; ++i) {
    std::string bytes(static_cast<std::size_t>(i), '\0');
    for (char& byte : bytes) byte = static_cast<char>(random.next() >> 56);
    if (i % 3 == 0) bytes.insert(0, "\xff\xfe\x80");
    if (i % 2 == 0) bytes += '\n';
    const auto answer = nlohmann::json::parse(controller.exchange(bytes), nullptr, false);
    REQUIRE(answer.is_object());
    CHECK(answer["ok"] == false);
  }
  const auto after = state();
  REQUIRE(after.is_object());
  CHECK(after["ticks"].get<long>() >= before["ticks"].get<long>());
  CHECK(after["fault"] == 0);
  controller.exchange("stop\n");
  CHECK(controller.wait_for_status() == 0);
}
