// The threads of a viewer: a fault's tape is opened and served by one of its own while the run's page asks for its
// address, and what opens no tape says why.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/view/fault_viewer.h"

using namespace tactus;
using namespace tactus::view;
using Catch::Matchers::Contains;

namespace {

void record_run(const std::string& path, std::uint64_t ticks) {
  session::RunOptions options = test::virtual_options();
  options.record = path;
  auto session = test::make_session(test::scene_file("card_house.toml"), options);
  REQUIRE(session->record(path).ok());
  (void)test::run(*session, ticks);
}

std::string address_of(const FaultViewer& viewer) {
  while (viewer.address().empty() && viewer.error().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return viewer.address();
}

std::string fetch(const std::string& address, const std::string& path) {
  const std::string port = address.substr(17, address.find('/', 17) - 17);  // after "http://127.0.0.1:"
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port)));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int connection = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  REQUIRE(connect(connection, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
  const std::string request = "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + port + "\r\n\r\n";
  REQUIRE(send(connection, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size()));
  std::string answer;
  char part[4096];
  for (ssize_t got; (got = read(connection, part, sizeof part)) > 0;)
    answer.append(part, static_cast<std::size_t>(got));
  close(connection);
  return answer;
}

}  // namespace

TEST_CASE("a fault's tape is served at an address of its own, the next fault's in its place", "[threads]") {
  const test::TemporaryFile first, second;
  record_run(first.path(), 300);
  record_run(second.path(), 300);
  FaultViewer viewer(std::map<std::string, std::string>{{"/index.html", "the page"}});
  CHECK(viewer.address().empty());
  viewer.open(first.path());
  const std::string address = address_of(viewer);
  REQUIRE_THAT(address, Catch::Matchers::StartsWith("http://127.0.0.1:"));
  CHECK_THAT(fetch(address, "/"), Contains("200 OK") && Contains("the page"));
  CHECK_THAT(fetch(address, "/other"), Contains("404"));
  viewer.open(second.path());
  const std::string next = address_of(viewer);
  REQUIRE_FALSE(next.empty());
  CHECK(next.substr(next.find('#')) != address.substr(address.find('#')));  // the token
  CHECK_THAT(fetch(next, "/"), Contains("200 OK"));
  viewer.open("/nowhere.tape");
  CHECK(address_of(viewer).empty());
  CHECK_THAT(viewer.error(), Contains("/nowhere.tape"));
  for (int i = 0; i < 20; ++i) viewer.open(i % 2 == 0 ? first.path() : "/nowhere.tape");  // the last one counts
  viewer.open(second.path());
  CHECK_THAT(fetch(address_of(viewer), "/"), Contains("200 OK"));
  CHECK(viewer.error().empty());
}
