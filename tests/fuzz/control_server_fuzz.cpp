// Arbitrary bytes on a running controller's control socket: the server survives, answers with one JSON object, repeats
// at most kLongestEcho of the bytes, and serves the next client; the pace stays within its bounds. The bytes after the
// first line are the configuration that "reload" reads.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/service/configuration.h"
#include "tools/service/control_server.h"

using namespace tactus;

namespace {

// JSON escapes one byte as at most six characters (a zero byte as \u0000); the rest of the answer has at most 256.
constexpr std::size_t kLongestAnswer = 6 * service::kLongestEcho + 256;

void require(bool holds) {
  if (!holds) std::abort();
}

struct Controller {
  Controller() {
    require(mkdtemp(folder) != nullptr);
    socket = std::string(folder) + "/control";
    auto opened = service::ControlServer::open(socket, requests, stop,
                                               [this](std::string& said) {
                                                 const auto read = service::parse_configuration(configuration, "fuzz");
                                                 said = "read";
                                                 return read.status();
                                               },
                                               true, {.pacing = &pacing, .hand = &hand});
    require(opened.ok());
    server = std::move(opened).value();
    server->tell(R"({"ok":true})");
  }
  ~Controller() {
    server.reset();
    rmdir(folder);
  }

  char folder[32]{"/tmp/tactus-fuzz-XXXXXX"};
  std::string socket, configuration;
  std::atomic<std::uint32_t> requests{0};
  std::atomic<bool> stop{false};
  service::Pacing pacing;
  session::HandInput hand;
  std::unique_ptr<service::ControlServer> server;
};

// Sends the bytes as they are, ends its side, and reads all that comes.
std::string answer_to(const std::string& socket, std::string_view bytes) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, socket.c_str());
  const int connection = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  // libFuzzer's alarm interrupts calls.
  require(TEMP_FAILURE_RETRY(connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address)) == 0);
  (void)TEMP_FAILURE_RETRY(send(connection, bytes.data(), bytes.size(), MSG_NOSIGNAL));
  shutdown(connection, SHUT_WR);
  std::string answer;
  char part[4096];
  for (ssize_t got; (got = TEMP_FAILURE_RETRY(read(connection, part, sizeof part))) > 0;)
    answer.append(part, static_cast<std::size_t>(got));
  close(connection);
  return answer;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Controller controller;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::size_t line = bytes.find('\n');
  controller.configuration = line == std::string_view::npos ? "" : std::string(bytes.substr(line + 1));
  const std::string_view sent = bytes.substr(0, line == std::string_view::npos ? size : line + 1);
  const std::string answer = answer_to(controller.socket, sent);
  require(answer.ends_with('\n') && answer.find('\n') == answer.size() - 1);
  const auto parsed = nlohmann::json::parse(answer, nullptr, /*allow_exceptions=*/false);
  require(parsed.is_object() && parsed.contains("ok") && parsed["ok"].is_boolean());
  require(sent.starts_with("reload") || answer.size() <= kLongestAnswer);
  const double pace = controller.pacing.pace.load();
  require(pace == 0 || (pace >= service::kMinPace && pace <= service::kMaxPace));
  require(answer_to(controller.socket, "state\n") == "{\"ok\":true}\n");
  return 0;
}
