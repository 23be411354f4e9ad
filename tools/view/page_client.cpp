#include "tools/view/page_client.h"

#include <utility>  // before asio 1.74: it uses std::exchange without it

#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <sys/socket.h>

#include <charconv>
#include <cstring>
#include <thread>

#include "tools/caught.h"
#include "tools/view/wire.h"

namespace tactus::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;

struct Address {
  std::string host, token;  // 127.0.0.1:PORT
  std::uint16_t port{0};
};

// Of http://127.0.0.1:PORT/#TOKEN; port 0: it is none.
Address parse(const std::string& text) {
  constexpr std::string_view kScheme = "http://";
  Address address;
  const std::size_t slash = text.find('/', kScheme.size()), token = text.find('#');
  if (!text.starts_with(kScheme) || slash == std::string::npos || token == std::string::npos) return address;
  address.host = text.substr(kScheme.size(), slash - kScheme.size());
  address.token = text.substr(token + 1, text.find('&', token) - token - 1);
  const std::size_t colon = address.host.find(':');
  if (colon != std::string::npos)
    std::from_chars(address.host.data() + colon + 1, address.host.data() + address.host.size(), address.port);
  return address;
}

class Client final : public PageClient {
 public:
  ~Client() override {
    // Ends the read that the thread waits in; the thread alone uses the stream.
    shutdown(socket_.next_layer().native_handle(), SHUT_RDWR);
    if (thread_.joinable()) thread_.join();
  }

  Status connect(const Address& address) {
    error_code error;
    socket_.next_layer().connect({asio::ip::address_v4::loopback(), address.port}, error);
    if (error) return Status::error("nobody listens at " + address.host);
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(beast::http::field::origin, "http://" + address.host);
      request.set(beast::http::field::sec_websocket_protocol, "tactus, " + address.token);
    }));
    socket_.read_message_max(0);  // any length: a full frame has megabytes
    socket_.handshake(address.host, "/run", error);
    if (!error) socket_.read(buffer_, error);  // the scene
    if (error) return Status::error("the viewer at " + address.host + " admits no page: " + error.message());
    buffer_.clear();
    thread_ = std::thread([this] { (void)caught([this] { take_all(); }); });
    return Status::good();
  }

 private:
  void take_all() {
    error_code error;
    while (!error) {
      socket_.read(buffer_, error);
      WireHeader header;
      if (!error && socket_.got_binary() && buffer_.size() >= sizeof header) {
        std::memcpy(&header, buffer_.data().data(), sizeof header);
        bytes_.fetch_add(buffer_.size(), std::memory_order_relaxed);
        if ((header.flags & kHasFrame) != 0) frames_.fetch_add(1, std::memory_order_relaxed);
        const std::string taken = "{\"ack\": " + std::to_string(header.number) + "}";
        socket_.text(true);
        socket_.write(asio::buffer(taken), error);
      }
      buffer_.clear();
    }
  }

  asio::io_context io_{1};
  websocket::stream<tcp::socket> socket_{io_};
  beast::flat_buffer buffer_;
  std::thread thread_;
};

}  // namespace

Result<std::unique_ptr<PageClient>> PageClient::open(const std::string& text) {
  const Address address = parse(text);
  if (address.port == 0)
    return Status::error("'" + text + "' is no page's address; accepted: as tactus view prints it");
  auto client = std::make_unique<Client>();
  Status connected = Status::good();
  if (const Status thrown = caught([&] { connected = client->connect(address); }); !thrown.ok()) return thrown;
  if (!connected.ok()) return connected;
  return std::unique_ptr<PageClient>(std::move(client));
}

}  // namespace tactus::view
