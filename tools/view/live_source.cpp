#include "tools/view/live_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/random.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "tools/json_text.h"
#include "tools/service/control_server.h"
#include "tools/view/page_stream.h"
#include "tools/view/scene_text.h"

namespace tactus::view {
namespace {

// Two viewers may have the same process number, in two containers.
std::uint64_t random_id() {
  std::uint64_t id = 0;
  if (getrandom(&id, sizeof id, 0) != static_cast<ssize_t>(sizeof id)) id = static_cast<std::uint64_t>(getpid());
  return id | 1u;
}

}  // namespace

Result<std::unique_ptr<LiveSource>> LiveSource::open(const std::filesystem::path& socket) {
  auto controller = publication::WatchedController::open(socket);
  if (!controller.ok()) return controller.status();
  return std::unique_ptr<LiveSource>(new LiveSource(socket, std::move(controller).value()));
}

LiveSource::LiveSource(std::filesystem::path socket, std::unique_ptr<publication::WatchedController> controller)
    : socket_(std::move(socket)),
      controller_(std::move(controller)),
      scene_(scene_text(controller_->scene(), controller_->settings())),
      real_device_(controller_->settings().options.device != "sim"),
      hand_id_(random_id()) {}

std::string LiveSource::hand() const {
  const session::RunOptions& options = controller_->settings().options;
  return options.hands > 1 ? fmt::format("hand {} of {}", options.hand + 1, options.hands) : std::string();
}

ViewSource::Update LiveSource::look(std::size_t, std::vector<publication::TickEntry>& ticks,
                                    publication::Frame& frame) {
  Update update;
  update.lost = controller_->watcher().read_ticks(ticks, kMaxTicks);
  update.fresh = controller_->watcher().read_frame(frame);
  return update;
}

// The state that the run publishes, and the address of the page of its fault.
std::string LiveSource::status() {
  std::string text;
  if (controller_->watcher().read_state(text)) state_ = text;
  if (state_.empty()) return {};
  auto state = nlohmann::ordered_json::parse(state_, nullptr, /*allow_exceptions=*/false);
  if (!state.is_object()) return {};
  const auto& tape_name = state["fault_tape"];
  const auto& fault_count = state["faults"];
  const std::string tape = tape_name.is_string() ? tape_name.get<std::string>() : "";
  const std::uint64_t faults = fault_count.is_number_unsigned() ? fault_count.get<std::uint64_t>() : 0;
  if (fault_viewer_ && !tape.empty() && faults != faults_) {
    faults_ = faults;
    fault_viewer_->open(tape);
  }
  if (fault_viewer_) {
    state["fault_page"] = fault_viewer_->address();
    if (const std::string error = fault_viewer_->error(); !error.empty()) state["fault_tape_error"] = error;
  }
  return json_text(state);
}

Answer LiveSource::ask(const PageMessage& message) {
  if (message.ask == "seek" || message.ask == "back")
    return {false, "a run cannot go back: record it, and view the tape"};
  if (message.hand || message.ask == "take" || message.ask == "rest") return lead(message);
  const std::string line = message.ask == "pace" ? fmt::format("pace {:g}", message.value) : message.ask;
  return request(line);
}

Answer LiveSource::lead(const PageMessage& message) const {
  const std::string what =
      message.hand ? fmt::format("{:.6f}", fmt::join(*message.hand, " ")) : std::string(message.ask);
  return request(fmt::format("hand {} {}", hand_id_, what));
}

Answer LiveSource::request(const std::string& line) const {
  const auto reply = service::ask_control(socket_, line);
  if (!reply.ok()) return {false, reply.message()};
  const auto object = nlohmann::json::parse(reply.value(), nullptr, /*allow_exceptions=*/false);
  if (!object.is_object()) return {false, "the run's answer is no JSON"};
  return {object.value("ok", false), object.value("said", "")};
}

}  // namespace tactus::view
