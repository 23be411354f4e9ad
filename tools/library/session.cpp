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
  const session::Verdict verdict = judge(from);
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

}  // namespace

Error Access::open(Session& session, const Scene& scene, const Options& options, Device* device) {
  static std::atomic<std::uint64_t> openings{0};
  auto parts = std::make_unique<Session::Parts>();
  parts->opening = ++openings;
  auto read = library::run_options(options);
  parts->scene = scene;
  parts->options = options;
  parts->device = device;  // copied first: they may belong to the session closed below
  (void)session.close();
  session.parts_.reset();
  if (!read.ok()) return {Kind::kOption, read.message()};
  parts->run_options = std::move(read).value();
  parts->run_options.scene = file(parts->scene);
  if (device != nullptr) {
    if (parts->options.device != "sim" || !parts->options.device_file.empty())
      return {Kind::kOption,
              fmt::format("--device: '{:.64}' beside a Device of the program's own; accepted: sim, or no Device",
                          parts->options.device)};
    parts->run_options.given_device = true;
    parts->run_options.device = session::kGivenDevice;
    if (const Status status = session::check_options(parts->run_options); !status.ok())
      return {Kind::kOption, status.message()};
  }
  Error error;
  if (const Status status = caught([&] { error = parts->build(); }); !status.ok())
    return {Kind::kMachine, "Session::open: " + status.message()};
  if (!error) session.parts_ = std::move(parts);
  return error;
}

session::Session& Access::session(Session& session) { return *session.parts_->session; }

session::VirtualRun& Access::virtual_run(Session& session) { return *session.parts_->virtual_run; }

session::RunSummary Access::summary(Session& session) {
  session.parts_->end();
  return session.parts_->summary();
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
  return in_own_words(Access::open(*this, scene, options, &device));
}

bool Session::is_open() const noexcept { return parts_ != nullptr && !parts_->closed; }

Error Session::record(const std::filesystem::path& tape) {
  if (!is_open()) return not_open("record");
  session::Session& session = *parts_->session;
  if (session.stats.ticks > 0 || session.drain != nullptr || parts_->ended)
    return {Kind::kUse, "Session::record: too late; accepted: once, before the first tick"};
  if (tape.empty()) return {Kind::kUse, "Session::record: no file is named; accepted: a path"};
  session.options.record = tape;
  if (const Status status = session.record(tape.string()); !status.ok()) {
    session.options.record.clear();
    return {Kind::kFile, status.message()};
  }
  return {};
}

Error Session::step(std::uint64_t ticks) {
  if (!is_open()) return not_open("step");
  if (!parts_->virtual_run)
    return {Kind::kUse, "Session::step: this session is in real time; accepted: run(), or Options::real_time = false"};
  if (Error error = parts_->start_device()) return error;
  parts_->step(ticks);
  return {};
}

Error Session::run(double duration_s, const Monitor& monitor) {
  if (!is_open()) return not_open("run");
  if (parts_->virtual_run)
    return {Kind::kUse,
            "Session::run: this session is in virtual time; accepted: step(), or Options::real_time = true"};
  if (parts_->in_monitor) return {Kind::kUse, "Session::run: a run is under way; accepted: when it is over"};
  if (parts_->ended) return {Kind::kUse, "Session::run: this session has run; accepted: after reset() or open()"};
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
  std::optional<library::OwnDevice::State> own;
  Tick last;
};

Error Session::save(SavedState& saved) const {
  if (!is_open()) return not_open("save");
  if (!parts_->virtual_run) return {Kind::kUse, "Session::save: this session is in real time; accepted: virtual time"};
  auto state = std::make_shared<SavedState::State>();
  state->opening = parts_->opening;
  state->run = parts_->virtual_run->save();
  if (parts_->own != nullptr) state->own = parts_->own->state();
  state->last = parts_->last;
  saved.state_ = std::move(state);
  return {};
}

Error Session::restore(const SavedState& saved) {
  if (!is_open()) return not_open("restore");
  if (!parts_->virtual_run)
    return {Kind::kUse, "Session::restore: this session is in real time; accepted: virtual time"};
  if (saved.empty() || saved.state_->opening != parts_->opening)
    return {Kind::kUse, "Session::restore: the state is not of this session; accepted: what its save() gave"};
  if (parts_->session->drain != nullptr)
    return {Kind::kUse, "Session::restore: a tape is being written, and it has no jumps; accepted: without record()"};
  if (Error error = parts_->start_device()) return error;
  parts_->virtual_run->restore(*saved.state_->run);
  if (saved.state_->own) parts_->own->set_state(*saved.state_->own);
  parts_->last = saved.state_->last;
  parts_->history_size = 0;
  parts_->view_is_old = true;
  return {};
}

Error Session::close() {
  if (!is_open() || parts_->in_monitor) return {};
  parts_->end();
  parts_->closed = true;
  const std::string& fault = parts_->ended->tape_fault;
  return fault.empty() ? Error() : Error(Kind::kFile, fault);
}

void Session::request(Request request) noexcept {
  if (parts_ != nullptr) parts_->requests.fetch_or(static_cast<std::uint32_t>(request), std::memory_order_relaxed);
}
void Session::stop() noexcept {
  if (parts_ != nullptr) parts_->stop.store(true, std::memory_order_relaxed);
}

const Tick& Session::last() const noexcept {
  static const Tick nothing;
  return parts_ != nullptr ? parts_->last : nothing;
}
std::span<const Tick> Session::ticks() const noexcept {
  if (parts_ == nullptr) return {};
  return {parts_->history.data(), parts_->history_size};
}
std::uint64_t Session::ticks_done() const noexcept {
  if (parts_ == nullptr) return 0;
  return parts_->in_monitor ? parts_->last.number + 1 : parts_->session->stats.ticks;
}
double Session::time_s() const noexcept { return static_cast<double>(ticks_done()) * period_s(); }
double Session::period_s() const noexcept { return parts_ != nullptr ? parts_->session->options.period_s() : 0.0; }

std::span<const BodyState> Session::bodies() const {
  if (parts_ == nullptr) return {};
  parts_->look();
  return parts_->view.bodies;
}
std::span<const Role> Session::roles() const {
  if (parts_ == nullptr) return {};
  parts_->look();
  return parts_->view.roles;
}
std::span<const BodyNumber> Session::members() const {
  if (parts_ == nullptr) return {};
  parts_->look();
  return parts_->view.members;
}
std::span<const Contact> Session::contacts() const {
  if (parts_ == nullptr || parts_->in_monitor) return {};
  parts_->look();
  return parts_->view.contacts;
}
std::span<const BorderContact> Session::border_contacts() const {
  if (parts_ == nullptr || parts_->in_monitor) return {};
  parts_->look();
  return parts_->view.border;
}

std::uint64_t Session::state_hash() const noexcept {
  return parts_ == nullptr || parts_->in_monitor ? 0 : parts_->session->loop->state_hash();
}

std::vector<std::string> Session::notes() const {
  if (parts_ == nullptr) return {};
  const session::Session& session = *parts_->session;
  const std::string lowered = lowered_text(gains_of(session.scene, session.options, session.device->properties()));
  if (lowered.empty()) return {};
  return {
      fmt::format("{}: the most that coupling {} bears at ratio {}", lowered, parts_->options.coupling, session.ratio)};
}

Summary Session::summary() const {
  if (parts_ == nullptr || parts_->in_monitor) return {};
  return to_public(parts_->summary());
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
