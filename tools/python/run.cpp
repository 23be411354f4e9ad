#include "tools/python/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/library/access.h"
#include "tools/python/errors.h"
#include "tools/session/find_description.h"

namespace py = pybind11;

namespace tactus::python {
namespace {

using Kind = Error::Kind;

constexpr std::uint64_t kTicksBetweenSignals = 1000;  // Ctrl-C is seen after at most so many ticks
constexpr const char* kAcceptedTarget =
    "3 numbers, the position in m, or 7, position and rotation w x y z, in the world's frame";

HandPose pose_of(const double* row, py::ssize_t columns) {
  HandPose pose;
  std::copy_n(row, 3, pose.position_m.begin());
  if (columns == 7) std::copy_n(row + 3, 4, pose.rotation.begin());
  double square = 0;
  for (const double part : pose.rotation) square += part * part;
  const bool finite = std::ranges::all_of(pose.position_m, [](double x) { return std::isfinite(x); });
  if (!finite || !std::isfinite(square) || square < 1e-12)
    raise(Kind::kOption,
          fmt::format("hand: a target is not finite, or its rotation is 0; accepted: {}", kAcceptedTarget));
  for (double& part : pose.rotation) part /= std::sqrt(square);
  return pose;
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

Numbers numbers_of(const py::handle& value) {
  Numbers numbers = Numbers::ensure(value);
  if (numbers) return numbers;
  PyErr_Clear();
  raise(Kind::kOption, fmt::format("hand: {} is no target; accepted: {}", shown(value), kAcceptedTarget));
}

py::array array_of(const HandPose& pose) {
  py::array_t<double> array(7);
  std::copy_n(pose.position_m.data(), 3, array.mutable_data());
  std::copy_n(pose.rotation.data(), 4, array.mutable_data() + 3);
  return array;
}

py::array array_of(const Vector3& force, const Vector3& torque) {
  py::array_t<double> array(6);
  std::copy_n(force.data(), 3, array.mutable_data());
  std::copy_n(torque.data(), 3, array.mutable_data() + 3);
  return array;
}

}  // namespace

Targets Targets::from(const py::handle& value) {
  const Numbers numbers = numbers_of(value);
  const bool fits = numbers.ndim() == 2 && (numbers.shape(1) == 3 || numbers.shape(1) == 7);
  if (!fits) {
    std::vector<py::ssize_t> shape(numbers.shape(), numbers.shape() + numbers.ndim());
    raise(Kind::kOption, fmt::format("step: targets of shape ({}); accepted: (ticks, 3) or (ticks, 7), a row each: {}",
                                     fmt::join(shape, ", "), kAcceptedTarget));
  }
  Targets targets;
  targets.rows.reserve(static_cast<std::size_t>(numbers.shape(0)));
  for (py::ssize_t row = 0; row < numbers.shape(0); ++row)
    targets.rows.push_back(pose_of(numbers.data(row, 0), numbers.shape(1)));
  return targets;
}

Run::Call::Call(const Run& run, const char* name) : run_(run) {
  if (run.busy_.exchange(true, std::memory_order_acquire))
    raise(Kind::kUse, fmt::format("Session.{}: another thread, or the hand, calls this session while it steps; "
                                  "accepted: one call at a time",
                                  name));
}

Run::Run(const Scene& scene, const py::object& hand, const Options& options) {
  if (hand.is_none()) {
    raise_if(session_.open(scene, options));
    return;
  }
  const bool targets = py::isinstance<py::str>(hand) && py::cast<std::string>(hand) == "targets";
  if (!targets && PyCallable_Check(hand.ptr()) == 0)
    raise(Kind::kOption, fmt::format("Session: hand: {} is no hand; accepted: a function hand(tick, tool_pose, force), "
                                     "\"targets\", or None: the scene's own",
                                     shown(hand)));
  if (!options.inject.empty())
    raise(Kind::kOption, "Session: inject: the hand is Python's, on an arm without a link; accepted: the scene's own");
  if (!targets) function_ = hand;
  const sim::Scene& inner = library::Access::scene(scene);
  const auto profile = session::find_description(inner.device.profile, {});
  if (!profile.ok()) raise(Kind::kFile, profile.message());
  const auto ask = [this](const HandAsked& asked, HandPose& target) { return this->ask(asked, target); };
  if (!(options.rate_Hz > 0)) raise_if(session_.open(scene, options));  // the library says what is accepted
  hand_ = std::make_unique<HandDevice>(inner, profile.value(), 1.0 / options.rate_Hz, ask);
  raise_if(session_.open(scene, options, *hand_));
}

void Run::step(std::uint64_t ticks) {
  const std::uint64_t most = std::min<std::uint64_t>(kTicksBetweenSignals, session_.options().history_ticks);
  while (ticks > 0) {
    const std::uint64_t count = std::min(ticks, most);
    Error error;
    {
      py::gil_scoped_release others;
      error = session_.step(count);
      keep_ticks();
      if (shown_) (void)session_.bodies();
    }
    if (error_of_hand_) end_with_error_of_hand();
    raise_if(error);
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    ticks -= count;
  }
}

void Run::step(const Targets& targets) {
  if (hand_ == nullptr)
    raise(Kind::kUse,
          "Session.step: the hand is the scene's own; accepted: a number of ticks, or a session with "
          "hand=\"targets\"");
  block_ = &targets;
  next_row_ = 0;
  struct Leave {
    const Targets*& block;
    ~Leave() { block = nullptr; }
  } leave{block_};
  // The arm moves between two ticks, so the very first tick has no target: its row is left out.
  if (session_.ticks_done() == 0) next_row_ = 1;
  step(targets.rows.size());
}

bool Run::ask(const HandAsked& asked, HandPose& target) noexcept {
  if (block_ != nullptr) {
    if (next_row_ >= block_->rows.size()) return false;
    target = block_->rows[next_row_++];
    return true;
  }
  if (!function_ || error_of_hand_) return false;
  try {
    py::gil_scoped_acquire gil;
    return ask_function(asked, target);
  } catch (...) {
    error_of_hand_ = std::current_exception();
    session_.stop();
    return false;
  }
}

bool Run::ask_function(const HandAsked& asked, HandPose& target) {
  const py::object wanted = function_(asked.tick, array_of(asked.tool), array_of(asked.force_N, asked.torque_Nm));
  if (wanted.is_none()) return false;
  const Numbers numbers = numbers_of(wanted);
  if (numbers.ndim() != 1 || (numbers.size() != 3 && numbers.size() != 7))
    raise(Kind::kOption, fmt::format("hand: a target of {} numbers in {} dimensions; accepted: {}", numbers.size(),
                                     numbers.ndim(), kAcceptedTarget));
  target = pose_of(numbers.data(), numbers.size());
  return true;
}

// In Python it comes out as it went in.
void Run::end_with_error_of_hand() {
  const std::exception_ptr error = std::exchange(error_of_hand_, nullptr);
  std::rethrow_exception(error);
}

void Run::keep_ticks() {
  const auto ticks = session_.ticks();
  const std::size_t room = session_.options().history_ticks;
  unseen_.insert(unseen_.end(), ticks.begin(), ticks.end());
  if (unseen_.size() <= room) return;
  const std::size_t over = unseen_.size() - room;
  lost_ += over;
  unseen_.erase(unseen_.begin(), unseen_.begin() + static_cast<std::ptrdiff_t>(over));
}

std::vector<Tick> Run::look() {
  lost_of_look_ = std::exchange(lost_, 0);
  return std::exchange(unseen_, {});
}

void Run::reset() {
  raise_if(session_.reset());
  unseen_.clear();
  lost_ = 0;
  if (shown_) (void)session_.bodies();
}

Saved Run::save() const {
  Saved saved;
  raise_if(session_.save(saved.session));
  if (hand_ != nullptr) saved.hand = hand_->state();
  return saved;
}

void Run::restore(const Saved& saved) {
  raise_if(session_.restore(saved.session));
  if (saved.hand) hand_->set_state(*saved.hand);
  unseen_.clear();
  lost_ = 0;
  if (shown_) (void)session_.bodies();
}

void Run::leave_views() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  // The memory is the session's own and not const; only its views are.
  for (const BodyState& body : session_.bodies()) {
    auto& old = const_cast<BodyState&>(body);
    old.position_m.fill(kNan);
    old.rotation.fill(kNan);
    old.velocity_m_per_s.fill(kNan);
    old.angular_velocity_rad_per_s.fill(kNan);
  }
  for (const Role& role : session_.roles()) const_cast<Role&>(role) = static_cast<Role>(255);
  for (const BodyNumber& member : session_.members()) const_cast<BodyNumber&>(member) = 0xffffffffu;
  for (const Contact& contact : session_.contacts()) {
    auto& old = const_cast<Contact&>(contact);
    old = {0xffffffffu, 0xffffffffu, {kNan, kNan, kNan}, {kNan, kNan, kNan}, kNan, {kNan, kNan, kNan}, kNan};
  }
  for (const BorderContact& contact : session_.border_contacts()) {
    auto& old = const_cast<BorderContact&>(contact);
    old = {0xffffffffu, 0xffffffffu, {kNan, kNan, kNan}, {kNan, kNan, kNan}, kNan, {kNan, kNan, kNan}};
  }
}

}  // namespace tactus::python
