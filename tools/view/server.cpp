#include "tools/view/server.h"

#include <utility>  // before asio 1.74: it uses std::exchange without it

#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <algorithm>
#include <deque>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "rt/base/clock.h"
#include "tools/json_text.h"
#include "tools/view/admission.h"
#include "tools/view/page_messages.h"
#include "tools/view/page_stream.h"

namespace tactus::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;
using beast::error_code;

constexpr auto kPollEvery = std::chrono::milliseconds(16);
constexpr int kLastPolls = 30;  // polls after `stop` until pages that have not received the last messages are closed
constexpr auto kPatience = std::chrono::seconds(5);
constexpr std::size_t kMaxConnections = 64;
constexpr std::uint32_t kLongestHeader = 8192;

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

std::string_view type_of(std::string_view path) {
  if (path.ends_with(".html")) return "text/html; charset=utf-8";
  if (path.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (path.ends_with(".css")) return "text/css; charset=utf-8";
  if (path.ends_with(".svg")) return "image/svg+xml";
  return "application/octet-stream";
}

void set_security(Response& response) {
  response.set("Content-Security-Policy", "default-src 'self'; frame-ancestors 'none'");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set(http::field::cache_control, "no-store");
}

Response answer(const Request& request, http::status status, std::string body, std::string_view type) {
  Response response(status, request.version());
  response.set(http::field::content_type, beast::string_view(type.data(), type.size()));
  set_security(response);
  response.keep_alive(false);
  response.content_length(body.size());
  if (request.method() != http::verb::head) response.body() = std::move(body);
  return response;
}

class Server;

// A page that is admitted.
class Page : public std::enable_shared_from_this<Page> {
 public:
  Page(beast::tcp_stream&& connection, Server& server, std::size_t of)
      : view(of), socket_(std::move(connection)), server_(server) {}

  void accept(const Request& request);
  void send_text(std::string text);
  void send_new();
  // The source's status. A page that is behind gets only the newest one, before further frames of the run.
  void send_status(const std::string& status);
  bool told_all() const noexcept { return !busy_ && texts_.empty() && status_ == told_; }
  void close() {
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

  const std::size_t view;
  PageStream stream;

 private:
  void read();
  void took(std::string_view text);
  void write_next();
  void leave();

  websocket::stream<beast::tcp_stream> socket_;
  Server& server_;
  beast::flat_buffer buffer_;
  std::deque<std::string> texts_;
  std::string writing_;
  std::string status_, told_;  // the newest of the source; the one that the page has
  bool busy_{false}, open_{false};
  MessageRate rate_;
};

// A connection before it is a page, or one that fetches a file.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket&& socket, Server& server);
  ~Connection();
  void read();

 private:
  void take();
  void respond(Response response);

  beast::tcp_stream stream_;
  Server& server_;
  beast::flat_buffer buffer_;
  http::request_parser<http::string_body> parser_;
  Response response_;
};

class Server final : public ViewServer {
 public:
  Server(ViewSettings settings, std::unique_ptr<ViewSource> source)
      : settings_(std::move(settings)), source_(std::move(source)), timer_(io_), views_(source_->views()) {}

  Status listen();
  std::string address() const override { return "http://127.0.0.1:" + std::to_string(port_) + "/#" + settings_.token; }
  ViewReport serve(const std::atomic<bool>& stop) override;

  // For connections and pages.
  Response file(const Request& request) const;
  Response refusal(const Request& request, http::status status, const std::string& reason);
  std::optional<Response> refuse_page(const Request& request);
  void admit(beast::tcp_stream&& stream, const Request& request);
  void joined(const std::shared_ptr<Page>& page);
  void left(const std::shared_ptr<Page>& page);
  Answer asked(const Page* page, const PageMessage& message);
  void led(const Page* page, const PageMessage& message);
  void count_refused(const std::string& reason) { ++report_.refused[reason]; }
  const publication::Frame& frame(std::size_t view) const { return views_[view].frame; }
  const std::string& scene(std::size_t view) const { return source_->scene(view); }
  void count_sent(std::size_t bytes) {
    ++report_.frames_sent;
    report_.bytes += bytes;
  }
  std::size_t connections{0};

 private:
  Status listen_on(const tcp::endpoint& endpoint);
  void accept(tcp::acceptor& acceptor);
  void poll(const std::atomic<bool>& stop);
  void look(std::size_t view);
  void end_run();
  std::optional<std::size_t> view_at(const Request& request) const;
  std::size_t pages_of(std::size_t view) const;

  ViewSettings settings_;
  std::unique_ptr<ViewSource> source_;
  asio::io_context io_{1};
  asio::steady_timer timer_;
  int last_polls_{0};  // since it was asked to stop
  std::deque<tcp::acceptor> acceptors_;
  std::uint16_t port_{0};
  std::set<std::shared_ptr<Page>> pages_;
  const Page* leads_{nullptr};  // the page that has the hand
  struct View {
    publication::Frame frame;
    bool has_frame{false};
  };
  std::vector<View> views_;
  std::vector<publication::TickEntry> ticks_;
  ViewReport report_;
};

// --- a page

void Page::accept(const Request& request) {
  beast::get_lowest_layer(socket_).expires_never();
  error_code ignored;
  beast::get_lowest_layer(socket_).socket().set_option(tcp::no_delay(true), ignored);
  socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  socket_.set_option(websocket::stream_base::decorator(
      [](websocket::response_type& response) { response.set(http::field::sec_websocket_protocol, "tactus"); }));
  socket_.read_message_max(kLongestMessage);
  socket_.auto_fragment(false);  // a message is one frame
  socket_.async_accept(request, [self = shared_from_this()](error_code error) {
    if (error) return;
    self->open_ = true;
    self->server_.joined(self);
    self->send_text(self->server_.scene(self->view));
    self->read();
  });
}

void Page::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
    if (error) {
      if (error == websocket::error::message_too_big) self->server_.count_refused("message");
      return self->leave();
    }
    const std::string text = beast::buffers_to_string(self->buffer_.data());
    self->buffer_.consume(self->buffer_.size());
    self->took(text);
    if (self->open_) self->read();
  });
}

void Page::took(std::string_view text) {
  if (!rate_.admits(MonotonicClock::now_ns())) {
    server_.count_refused("rate");
    return leave();
  }
  const auto message = parse_message(text);
  if (!message.ok()) {
    server_.count_refused("message");
    return send_text(json_text(nlohmann::json{{"kind", "refused"}, {"said", message.message()}}));
  }
  if (message.value().hand) return server_.led(this, message.value());
  if (message.value().ask.empty()) {
    stream.acknowledge(message.value().acknowledged);
    return send_new();
  }
  const Answer answer = server_.asked(this, message.value());
  status_.clear();  // sends the status again, even if it did not change
  told_.clear();
  send_text(json_text(
      nlohmann::json{{"kind", "answer"}, {"ask", message.value().ask}, {"ok", answer.ok}, {"said", answer.said}}));
}

void Page::send_text(std::string text) {
  texts_.push_back(std::move(text));
  write_next();
}

void Page::send_new() { write_next(); }

void Page::send_status(const std::string& status) {
  if (status.empty()) return;
  status_ = status;
  write_next();
}

// Sends texts first, then the source's status, then the newest frame of the run if the page can take one.
void Page::write_next() {
  if (busy_ || !open_) return;
  bool text = true;
  if (!texts_.empty()) {
    writing_ = std::move(texts_.front());
    texts_.pop_front();
  } else if (status_ != told_) {
    writing_ = told_ = status_;
  } else if (!stream.ready()) {
    return;
  } else {
    text = false;
    writing_ = stream.take(server_.frame(view), MonotonicClock::now_ns());
    server_.count_sent(writing_.size());
  }
  busy_ = true;
  socket_.binary(!text);
  socket_.async_write(asio::buffer(writing_), [self = shared_from_this()](error_code error, std::size_t) {
    self->busy_ = false;
    if (error) return self->leave();
    self->write_next();
  });
}

void Page::leave() {
  if (!open_) return;
  open_ = false;
  close();
  server_.left(shared_from_this());
}

// --- a connection

Connection::Connection(tcp::socket&& socket, Server& server) : stream_(std::move(socket)), server_(server) {
  ++server_.connections;
  parser_.header_limit(kLongestHeader);
  parser_.body_limit(0);
}
Connection::~Connection() { --server_.connections; }

void Connection::read() {
  stream_.expires_after(kPatience);
  http::async_read(stream_, buffer_, parser_, [self = shared_from_this()](error_code error, std::size_t) {
    if (!error) self->take();
  });
}

void Connection::take() {
  const Request request = parser_.release();
  const bool wants_socket = websocket::is_upgrade(request);
  if (!is_this_machine(view_of(request[http::field::host])))
    return respond(server_.refusal(request, http::status::misdirected_request, "host"));
  if (!wants_socket) return respond(server_.file(request));
  if (auto refused = server_.refuse_page(request)) return respond(std::move(*refused));
  server_.admit(std::move(stream_), request);
}

void Connection::respond(Response response) {
  response_ = std::move(response);
  http::async_write(stream_, response_, [self = shared_from_this()](error_code, std::size_t) {
    error_code ignored;
    self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
  });
}

// --- the server

Status Server::listen() {
  const Status four = listen_on({asio::ip::address_v4::loopback(), settings_.port});
  if (!four.ok()) return four;
  port_ = acceptors_.front().local_endpoint().port();
  (void)listen_on({asio::ip::address_v6::loopback(), port_});  // where the machine has IPv6
  return Status::good();
}

Status Server::listen_on(const tcp::endpoint& endpoint) {
  error_code error;
  tcp::acceptor acceptor(io_);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    return Status::error("port " + std::to_string(endpoint.port()) + ": " + error.message() +
                         "; accepted: --port with a free one, or 0 for any");
  acceptors_.push_back(std::move(acceptor));
  return Status::good();
}

void Server::accept(tcp::acceptor& acceptor) {
  acceptor.async_accept([this, &acceptor](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error && connections < kMaxConnections) std::make_shared<Connection>(std::move(socket), *this)->read();
    accept(acceptor);
  });
}

ViewReport Server::serve(const std::atomic<bool>& stop) {
  for (tcp::acceptor& acceptor : acceptors_) accept(acceptor);
  poll(stop);
  io_.run();
  pages_.clear();
  return report_;
}

void Server::poll(const std::atomic<bool>& stop) {
  const bool stopping = stop.load(std::memory_order_relaxed);
  if (stopping && last_polls_ > 0) {
    const bool told = std::ranges::all_of(pages_, [](const auto& page) { return page->told_all(); });
    if (told || last_polls_ >= kLastPolls) return io_.stop();
  }
  if (stopping) ++last_polls_;  // at least one poll, so that pages learn that the run is over
  if (!report_.run_ended && source_->ended()) end_run();
  if (report_.run_ended && pages_.empty()) return io_.stop();
  for (std::size_t view = 0; view < views_.size() && !stopping; ++view) look(view);
  const std::string status = pages_.empty() ? std::string() : source_->status();
  const auto pages = pages_;
  for (const auto& page : pages) page->send_status(status);
  timer_.expires_after(kPollEvery);
  timer_.async_wait([this, &stop](error_code error) {
    if (!error) poll(stop);
  });
}

void Server::look(std::size_t view) {
  ticks_.clear();
  const ViewSource::Update update = source_->look(view, ticks_, views_[view].frame);
  views_[view].has_frame = views_[view].has_frame || update.fresh;
  const auto pages = pages_;  // a page that fails leaves the set
  for (const auto& page : pages) {
    if (page->view != view) continue;
    const std::uint32_t before = page->stream.dropped();
    if (update.restarted) page->stream.restart();
    page->stream.offer_ticks(ticks_, update.lost);
    if (update.fresh) page->stream.offer_frame();
    report_.frames_dropped += page->stream.dropped() - before;
    page->send_new();
  }
}

void Server::end_run() {
  report_.run_ended = true;
  for (const auto& page : pages_) page->send_text(R"({"kind":"ended"})");
}

Response Server::file(const Request& request) const {
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return answer(request, http::status::method_not_allowed, "GET and HEAD alone\n", "text/plain");
  std::string path(view_of(request.target()));
  path = path.substr(0, path.find('?'));
  if (path == "/") path = "/index.html";
  const auto at = settings_.files.find(path);
  if (at == settings_.files.end()) return answer(request, http::status::not_found, "no such file\n", "text/plain");
  return answer(request, http::status::ok, at->second, type_of(path));
}

Response Server::refusal(const Request& request, http::status status, const std::string& reason) {
  count_refused(reason);
  return answer(request, status, "refused: " + reason + "\n", "text/plain");
}

std::optional<Response> Server::refuse_page(const Request& request) {
  const Refusal refused = refuse(view_of(request[http::field::host]), view_of(request[http::field::origin]),
                                 view_of(request[http::field::sec_websocket_protocol]), settings_.token);
  if (refused != Refusal::kNone) return refusal(request, http::status::forbidden, std::string(name_of(refused)));
  const std::optional<std::size_t> view = view_at(request);
  if (!view) return refusal(request, http::status::not_found, "path");
  if (pages_of(*view) >= kMaxPages) return refusal(request, http::status::service_unavailable, "pages");
  return std::nullopt;
}

std::optional<std::size_t> Server::view_at(const Request& request) const {
  if (request.target() == "/run") return 0;
  if (request.target() == "/beside" && views_.size() > 1) return 1;
  return std::nullopt;
}

std::size_t Server::pages_of(std::size_t view) const {
  return static_cast<std::size_t>(
      std::count_if(pages_.begin(), pages_.end(), [&](const auto& page) { return page->view == view; }));
}

void Server::admit(beast::tcp_stream&& stream, const Request& request) {
  std::make_shared<Page>(std::move(stream), *this, view_at(request).value_or(0))->accept(request);
}

void Server::joined(const std::shared_ptr<Page>& page) {
  pages_.insert(page);
  report_.clients_most = std::max(report_.clients_most, pages_of(0));
  if (views_[page->view].has_frame) page->stream.offer_frame();
  source_->joined();
}

void Server::left(const std::shared_ptr<Page>& page) {
  pages_.erase(page);
  if (leads_ == page.get()) (void)asked(leads_, {.ask = "rest"});
}

Answer Server::asked(const Page* page, const PageMessage& message) {
  if (source_->real_device() && gives_force(message.ask) && !settings_.allow_force) {
    count_refused("force");
    return {false, "force on a real device is not given from a page; accepted: tactus view --allow-force"};
  }
  const bool of_hand = message.ask == "take" || message.ask == "rest";
  if (of_hand && leads_ != nullptr && leads_ != page) {
    count_refused("hand");
    return {false, "another page has the hand"};
  }
  const Answer answer = source_->ask(message);
  if (of_hand && !answer.ok) count_refused("hand");
  if (of_hand && answer.ok) leads_ = message.ask == "take" ? page : nullptr;
  return answer;
}

// Sends no answer, since up to 125 come a second; a refusal is counted.
void Server::led(const Page* page, const PageMessage& message) {
  if (leads_ != page || !source_->ask(message).ok) count_refused("hand");
}

}  // namespace

Result<std::map<std::string, std::string>> load_files(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, error)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    files["/" + entry.path().lexically_relative(folder).generic_string()] = bytes.str();
  }
  if (!files.contains("/index.html"))
    return Status::error(folder.string() +
                         ": no page there: this build had no node or no npm (Debian: nodejs, npm); accepted: build "
                         "again with both");
  return files;
}

Result<std::unique_ptr<ViewServer>> ViewServer::open(ViewSettings settings, std::unique_ptr<ViewSource> source) {
  auto server = std::make_unique<Server>(std::move(settings), std::move(source));
  if (const Status status = server->listen(); !status.ok()) return status;
  return std::unique_ptr<ViewServer>(std::move(server));
}

}  // namespace tactus::view
