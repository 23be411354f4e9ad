#include "tactus/session.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/caught.h"
#include "tools/json_text.h"
#include "tools/library/access.h"
#include "tools/library/session_parts.h"
#include "tools/version/version.h"

namespace tactus {
namespace {

using Kind = Error::Kind;
using library::Access;

static_assert(static_cast<std::uint32_t>(Request::kArm) == loop::kArm &&
              static_cast<std::uint32_t>(Request::kRearm) == loop::kRearm &&
              static_cast<std::uint32_t>(Request::kDisarm) == loop::kDisarm &&
              static_cast<std::uint32_t>(Request::kResetScene) == loop::kReset);
static_assert(static_cast<std::uint32_t>(Verdict::kBad) == static_cast<std::uint32_t>(session::Level::kBad));
static_assert(std::atomic<bool>::is_always_lock_free, "stop() may be called by a signal handler");

Error not_open(const char* call) {
  return {Kind::kUse, fmt::format("Session::{}: the session is not open; accepted: after Session::open", call)};
}

Error in_own_words(const Error& error) { return {error.kind(), library::in_own_words(error.message())}; }

Summary to_public(const session::RunSummary& from) {
  const session::RunVerdict verdict = judge(from);
  Summary to;
  to.verdict = static_cast<Verdict>(verdict.level());
  to.ticks = from.stats.ticks;
  to.contact_ticks = from.stats.contact_ticks;
  to.faults = from.stats.fault_count;
  to.overruns = from.real_time ? from.timing.overruns : 0;
  to.max_force_N = from.stats.force_max_N;
  to.mean_force_N = from.stats.ticks == 0 ? 0.0 : from.stats.force_sum_N / static_cast<double>(from.stats.ticks);
  to.state_hash = from.state_hash;
  to.text = to_text(from);
  auto object = to_json(from);
  object["version"] = version();
  to.json = json_text(object, 2);
  return to;
}

// A scene that is empty has no hands; the session says so when it is built.
unsigned hands_of(const Scene& scene) { return std::max(1u, scene.hands()); }

// The options of one hand: its device, its script of faults.
Result<session::RunOptions> options_of_hand(const Options& options, const std::filesystem::path& scene_file,
                                            unsigned hand, bool own_device) {
  Options own = options;
  if (hand > 0) own.inject = hand <= options.more_injects.size() ? options.more_injects[hand - 1] : "";
  auto read = library::run_options(own);
  if (!read.ok()) return read;
  read.value().scene = scene_file;
  if (!own_device) return read;
  if (options.device != "sim" || !options.device_file.empty())
    return Status::error(fmt::format(
        "--device: '{:.64}' beside a Device of the program's own; accepted: sim, or no Device", options.device));
  read.value().given_device = true;
  read.value().device = session::kGivenDevice;
  if (const Status status = session::check_options(read.value()); !status.ok()) return status;
  return read;
}

}  // namespace

Error Access::open(Session& session, const Scene& scene, const Options& options, std::span<Device* const> devices) {
  static std::atomic<std::uint64_t> openings{0};
  auto parts = std::make_unique<Session::Parts>(hands_of(scene));
  parts->opening = ++openings;
  parts->scene = scene;
  parts->options = options;
  parts->devices.assign(devices.begin(), devices.end());  // copied first: they may belong to the session closed below
  (void)session.close();
  session.parts_.reset();
  for (unsigned hand = 0; hand < parts->each.size(); ++hand) {
    const bool own_device = hand < devices.size() && parts->devices[hand] != nullptr;
    auto read = options_of_hand(parts->options, file(parts->scene), hand, own_device);
    if (!read.ok()) return {Kind::kOption, read.message()};
    parts->run_options.push_back(std::move(read).value());
  }
  Error error;
  if (const Status status = caught([&] { error = parts->build(); }); !status.ok())
    return {Kind::kMachine, "Session::open: " + status.message()};
  if (!error) session.parts_ = std::move(parts);
  return error;
}

session::Session& Access::session(Session& session) { return *session.parts_->sessions.front(); }

session::VirtualRun& Access::virtual_run(Session& session) { return *session.parts_->virtual_run; }

session::RunSummary Access::summary(Session& session) {
  session.parts_->end();
  return session.parts_->summary(0);
}

Session::Session() noexcept = default;
Session::~Session() { (void)close(); }
Session::Session(Session&& other) noexcept = default;
Session& Session::operator=(Session&& other) noexcept {
  if (this == &other) return *this;
  (void)close();
  parts_ = std::move(other.parts_);
  return *this;
}

Error Session::open(const std::filesystem::path& scene_file, const Options& options) {
  (void)close();
  parts_.reset();
  Scene scene;
  if (Error error = scene.load(scene_file)) return error;
  return open(scene, options);
}
Error Session::open(const Scene& scene, const Options& options) {
  return in_own_words(Access::open(*this, scene, options));
}
Error Session::open(const Scene& scene, const Options& options, Device& device) {
  Device* const only = &device;
  return in_own_words(Access::open(*this, scene, options, {&only, 1}));
}
Error Session::open(const Scene& scene, const Options& options, std::span<Device* const> devices) {
  return in_own_words(Access::open(*this, scene, options, devices));
}

bool Session::is_open() const noexcept { return parts_ != nullptr && !parts_->closed; }

Error Session::record(const std::filesystem::path& tape) {
  if (!is_open()) return not_open("record");
  const session::Session& first = *parts_->sessions.front();
  if (first.stats.ticks > 0 || first.drain != nullptr || parts_->ended())
    return {Kind::kUse, "Session::record: too late; accepted: once, before the first tick"};
  if (tape.empty()) return {Kind::kUse, "Session::record: no file is named; accepted: a path"};
  if (const Status status = parts_->hands->record(tape); !status.ok()) {
    for (session::Session* session : parts_->sessions) session->options.record.clear();
    return {Kind::kFile, status.message()};
  }
  return {};
}

Error Session::step(std::uint64_t ticks) {
  if (!is_open()) return not_open("step");
  if (!parts_->virtual_run)
    return {Kind::kUse, "Session::step: this session is in real time; accepted: run(), or Options::real_time = false"};
  if (Error error = parts_->start_devices()) return error;
  parts_->step(ticks);
  return {};
}

Error Session::run(double duration_s, const Monitor& monitor) {
  if (!is_open()) return not_open("run");
  if (parts_->virtual_run)
    return {Kind::kUse,
            "Session::run: this session is in virtual time; accepted: step(), or Options::real_time = true"};
  if (parts_->in_monitor) return {Kind::kUse, "Session::run: a run is under way; accepted: when it is over"};
  if (parts_->ended()) return {Kind::kUse, "Session::run: this session has run; accepted: after reset() or open()"};
  if (!(duration_s == 0 || (duration_s >= 0.01 && duration_s <= 1e6)))
    return {
        Kind::kOption,
        fmt::format("Session::run: {:g} s is out of range; accepted: 0.01 to 1e6 s, or 0: until stopped", duration_s)};
  return parts_->run(duration_s, monitor);
}

Error Session::reset() {
  if (!is_open()) return not_open("reset");
  if (parts_->in_monitor) return {Kind::kUse, "Session::reset: a run is under way; accepted: when it is over"};
  parts_->end();
  Error error;
  if (const Status status = caught([&] { error = parts_->build(); }); !status.ok())
    error = {Kind::kMachine, "Session::reset: " + status.message()};
  if (error) parts_.reset();
  return in_own_words(error);
}

struct SavedState::State {
  std::uint64_t opening{0};  // of the session
  std::shared_ptr<const session::VirtualRun::Saved> run;
  struct Hand {
    std::optional<library::OwnDevice::State> own;
    Tick last;
  };
  std::vector<Hand> hands;
};

Error Session::save(SavedState& saved) const {
  if (!is_open()) return not_open("save");
  if (!parts_->virtual_run) return {Kind::kUse, "Session::save: this session is in real time; accepted: virtual time"};
  auto state = std::make_shared<SavedState::State>();
  state->opening = parts_->opening;
  state->run = parts_->virtual_run->save();
  for (const Parts::Hand& hand : parts_->each) {
    SavedState::State::Hand& kept = state->hands.emplace_back();
    if (hand.own != nullptr) kept.own = hand.own->state();
    kept.last = hand.last;
  }
  saved.state_ = std::move(state);
  return {};
}

Error Session::restore(const SavedState& saved) {
  if (!is_open()) return not_open("restore");
  if (!parts_->virtual_run)
    return {Kind::kUse, "Session::restore: this session is in real time; accepted: virtual time"};
  if (saved.empty() || saved.state_->opening != parts_->opening)
    return {Kind::kUse, "Session::restore: the state is not of this session; accepted: what its save() gave"};
  if (parts_->sessions.front()->drain != nullptr)
    return {Kind::kUse, "Session::restore: a tape is being written, and it has no jumps; accepted: without record()"};
  if (Error error = parts_->start_devices()) return error;
  parts_->virtual_run->restore(*saved.state_->run);
  for (std::size_t i = 0; i < parts_->each.size(); ++i) {
    Parts::Hand& hand = parts_->each[i];
    const SavedState::State::Hand& kept = saved.state_->hands[i];
    if (kept.own) hand.own->set_state(*kept.own);
    hand.last = kept.last;
    hand.history_size = 0;
  }
  parts_->view_is_old = true;
  return {};
}

Error Session::close() {
  if (!is_open() || parts_->in_monitor) return {};
  parts_->end();
  parts_->closed = true;
  for (const Parts::Hand& hand : parts_->each)
    if (const std::string& fault = hand.ended->tape_fault; !fault.empty()) return {Kind::kFile, fault};
  return {};
}

void Session::request(Request request, unsigned hand) noexcept {
  if (hand < hands())
    parts_->each[hand].requests.fetch_or(static_cast<std::uint32_t>(request), std::memory_order_relaxed);
}
void Session::stop() noexcept {
  if (parts_ != nullptr) parts_->stop.store(true, std::memory_order_relaxed);
}

unsigned Session::hands() const noexcept { return parts_ != nullptr ? static_cast<unsigned>(parts_->each.size()) : 0; }

const Tick& Session::last(unsigned hand) const noexcept {
  static const Tick nothing;
  return hand < hands() ? parts_->each[hand].last : nothing;
}
std::span<const Tick> Session::ticks(unsigned hand) const noexcept {
  if (hand >= hands()) return {};
  return {parts_->each[hand].history.data(), parts_->each[hand].history_size};
}
std::uint64_t Session::ticks_done() const noexcept {
  if (parts_ == nullptr) return 0;
  return parts_->in_monitor ? last().number + 1 : parts_->sessions.front()->stats.ticks;
}
double Session::time_s() const noexcept { return static_cast<double>(ticks_done()) * period_s(); }
double Session::period_s() const noexcept {
  return parts_ != nullptr ? parts_->sessions.front()->options.period_s() : 0.0;
}

std::span<const BodyState> Session::bodies() const {
  if (parts_ == nullptr) return {};
  parts_->look();
  return parts_->view.bodies;
}
std::span<const Role> Session::roles(unsigned hand) const {
  if (hand >= hands()) return {};
  parts_->look();
  return parts_->view.hands[hand].roles;
}
std::span<const BodyNumber> Session::members(unsigned hand) const {
  if (hand >= hands()) return {};
  parts_->look();
  return parts_->view.hands[hand].members;
}
std::span<const Contact> Session::contacts(unsigned hand) const {
  if (hand >= hands() || parts_->in_monitor) return {};
  parts_->look();
  return parts_->view.hands[hand].contacts;
}
std::span<const BorderContact> Session::border_contacts(unsigned hand) const {
  if (hand >= hands() || parts_->in_monitor) return {};
  parts_->look();
  return parts_->view.hands[hand].border;
}

std::uint64_t Session::state_hash(unsigned hand) const noexcept {
  return hand >= hands() || parts_->in_monitor ? 0 : parts_->sessions[hand]->loop->state_hash();
}

std::vector<std::string> Session::notes(unsigned hand) const {
  if (hand >= hands()) return {};
  const session::Session& session = *parts_->sessions[hand];
  const std::string lowered = lowered_text(gains_of(session.scene, session.options, session.device->properties()));
  if (lowered.empty()) return {};
  return {fmt::format("{}: {}", lowered, library::in_own_words(lowered_why(session.options, session.ratio)))};
}

Summary Session::summary(unsigned hand) const {
  if (hand >= hands() || parts_->in_monitor) return {};
  return to_public(parts_->summary(hand));
}

const Scene& Session::scene() const noexcept {
  static const Scene nothing;
  return parts_ != nullptr ? parts_->scene : nothing;
}
const Options& Session::options() const noexcept {
  static const Options nothing;
  return parts_ != nullptr ? parts_->options : nothing;
}

}  // namespace tactus
