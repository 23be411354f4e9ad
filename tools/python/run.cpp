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
    "3 numbers, the position in m, 7, position and rotation w x y z, or 6, the force in N and the torque in N m of a "
    "hand that pushes, in the world's frame";

HandPush push_of(const double* row) {
  HandPush push;
  std::copy_n(row, 3, push.force_N.begin());
  std::copy_n(row + 3, 3, push.torque_Nm.begin());
  if (!std::all_of(row, row + 6, [](double x) { return std::isfinite(x); }))
    raise(Kind::kOption, fmt::format("hand: a wrench is not finite; accepted: {}", kAcceptedTarget));
  return push;
}

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

bool is_wish(py::ssize_t numbers) { return numbers == 3 || numbers == 6 || numbers == 7; }

HandWish wish_of(const double* row, py::ssize_t numbers) {
  if (numbers == 6) return push_of(row);
  return pose_of(row, numbers);
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

Numbers numbers_of(const py::handle& value) {
  const py::array given = py::array::ensure(value);
  if (given && given.dtype().kind() != 'c') {  // of complex numbers the imaginary part would be lost
    Numbers numbers = Numbers::ensure(given);
    if (numbers) return numbers;
  }
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
  const bool fits = numbers.ndim() == 2 && is_wish(numbers.shape(1));
  if (!fits) {
    std::vector<py::ssize_t> shape(numbers.shape(), numbers.shape() + numbers.ndim());
    raise(Kind::kOption,
          fmt::format("step: targets of shape ({}); accepted: (ticks, 3), (ticks, 7) or (ticks, 6), a row each: {}",
                      fmt::join(shape, ", "), kAcceptedTarget));
  }
  Targets targets;
  targets.rows.reserve(static_cast<std::size_t>(numbers.shape(0)));
  for (py::ssize_t row = 0; row < numbers.shape(0); ++row)
    targets.rows.push_back(wish_of(numbers.data(row, 0), numbers.shape(1)));
  return targets;
}

Run::Call::Call(const Run& run, const char* name) : run_(run) {
  if (run.busy_.exchange(true, std::memory_order_acquire))
    raise(Kind::kUse, fmt::format("Session.{}: another thread, or the hand, calls this session while it steps; "
                                  "accepted: one call at a time",
                                  name));
}

namespace {

constexpr const char* kAcceptedHands =
    "a list with a function, \"targets\" or None for each hand, or None: the scene's own";

bool is_list(const py::handle& value) { return py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value); }

// The Python object that leads each hand.
std::vector<py::object> leaders_of(const py::object& hand, unsigned hands) {
  if (!is_list(hand)) {
    if (hands > 1 && !hand.is_none())
      raise(Kind::kOption,
            fmt::format("Session: hand: {} for {} hands; accepted: {}", shown(hand), hands, kAcceptedHands));
    return std::vector<py::object>(hands, hand);
  }
  const auto given = py::reinterpret_borrow<py::sequence>(hand);
  if (given.size() != hands)
    raise(Kind::kOption,
          fmt::format("Session: hand: {} for {} hands; accepted: {}", given.size(), hands, kAcceptedHands));
  std::vector<py::object> leaders;
  for (const auto& leader : given) leaders.push_back(py::reinterpret_borrow<py::object>(leader));
  return leaders;
}

const std::string& inject_of(const Options& options, unsigned hand) {
  static const std::string none;
  if (hand == 0) return options.inject;
  return hand <= options.more_injects.size() ? options.more_injects[hand - 1] : none;
}

}  // namespace

Run::Run(const Scene& scene, const py::object& hand, const Options& options) : hands_(std::max(1u, scene.hands())) {
  if (!(options.rate_Hz > 0)) raise_if(session_.open(scene, options));  // the library's error names the accepted range
  const auto leaders = leaders_of(hand, static_cast<unsigned>(hands_.size()));
  std::vector<Device*> devices;
  for (unsigned i = 0; i < leaders.size(); ++i) {
    if (!leaders[i].is_none()) lead(i, leaders[i], library::Access::scene(scene), options);
    devices.push_back(hands_[i].device.get());
  }
  raise_if(session_.open(scene, options, devices));
}

void Run::lead(unsigned hand, const py::handle& leader, const sim::Scene& scene, const Options& options) {
  const std::string where = hands_.size() == 1 ? "Session: hand" : fmt::format("Session: hand[{}]", hand);
  const bool targets = py::isinstance<py::str>(leader) && py::cast<std::string>(leader) == "targets";
  if (!targets && PyCallable_Check(leader.ptr()) == 0)
    raise(Kind::kOption, fmt::format("{}: {} is no hand; accepted: a function hand(tick, tool_pose, force), "
                                     "\"targets\", or None: the scene's own",
                                     where, shown(leader)));
  if (!inject_of(options, hand).empty())
    raise(Kind::kOption,
          fmt::format("{}: is Python's, on an arm without a link, beside inject; accepted: the scene's own", where));
  Hand& led = hands_[hand];
  if (!targets) led.function = py::reinterpret_borrow<py::object>(leader);
  const sim::Scene of_hand = sim::scene_of_hand(scene, hand);
  const auto profile = session::find_description(of_hand.device.profile, {});
  if (!profile.ok()) raise(Kind::kFile, profile.message());
  const auto ask = [this, &led](const HandAsked& asked, HandWish& wish) { return this->ask(led, asked, wish); };
  led.device = std::make_unique<HandDevice>(of_hand, profile.value(), 1.0 / options.rate_Hz, ask);
}

void Run::step(std::uint64_t ticks) {
  const std::uint64_t most = std::min<std::uint64_t>(kTicksBetweenSignals, session_.options().history_ticks);
  while (ticks > 0) {
    const std::uint64_t count = std::min(ticks, most);
    Error error;
    {
      py::gil_scoped_release others;
      error = session_.step(count);
      for (unsigned hand = 0; hand < hands_.size(); ++hand) keep_ticks(hand);
      if (shown_) (void)session_.bodies();
    }
    if (error_of_hand_) end_with_error_of_hand();
    raise_if(error);
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    ticks -= count;
  }
}

void Run::step(const py::handle& targets) {
  struct Leave {
    std::vector<Hand>& hands;
    ~Leave() {
      for (Hand& hand : hands) hand.block.reset();
    }
  } leave{hands_};
  step(take_targets(targets));
}

// Returns the number of rows.
std::uint64_t Run::take_targets(const py::handle& targets) {
  std::vector<py::object> of_hands{py::reinterpret_borrow<py::object>(targets)};
  if (hands_.size() > 1) {
    if (PySequence_Check(targets.ptr()) == 0 || py::isinstance<py::str>(targets) || py::len(targets) != hands_.size())
      raise(Kind::kOption,
            fmt::format("Session.step: targets for {} hands; accepted: a list with an array (ticks, 3) or "
                        "(ticks, 7), or (ticks, 6), or None, for each",
                        hands_.size()));
    of_hands.clear();
    for (const auto& one : py::reinterpret_borrow<py::sequence>(targets))
      of_hands.push_back(py::reinterpret_borrow<py::object>(one));
  }
  std::optional<std::size_t> rows;
  for (std::size_t i = 0; i < hands_.size(); ++i) {
    if (hands_.size() > 1 && of_hands[i].is_none()) continue;
    if (hands_[i].device == nullptr)
      raise(Kind::kUse,
            "Session.step: the hand is the scene's own; accepted: a number of ticks, or a session with "
            "hand=\"targets\"");
    Targets own = Targets::from(of_hands[i]);
    if (rows && *rows != own.rows.size())
      raise(Kind::kOption,
            fmt::format("Session.step: {} targets for one hand and {} for another; accepted: as many for "
                        "each",
                        *rows, own.rows.size()));
    rows = own.rows.size();
    hands_[i].block = std::move(own);
    // The arm moves between two ticks, so the very first tick has no target: its row is left out.
    hands_[i].next_row = session_.ticks_done() == 0 ? 1 : 0;
  }
  if (!rows) raise(Kind::kOption, "Session.step: targets of no hand; accepted: an array for one hand at least");
  return *rows;
}

bool Run::ask(Hand& hand, const HandAsked& asked, HandWish& wish) noexcept {
  if (hand.block) {
    if (hand.next_row >= hand.block->rows.size()) return false;
    wish = hand.block->rows[hand.next_row++];
    return true;
  }
  if (!hand.function || error_of_hand_) return false;
  try {
    py::gil_scoped_acquire gil;
    return ask_function(hand, asked, wish);
  } catch (...) {
    error_of_hand_ = std::current_exception();
    session_.stop();
    return false;
  }
}

bool Run::ask_function(const Hand& hand, const HandAsked& asked, HandWish& wish) {
  const py::object wanted = hand.function(asked.tick, array_of(asked.tool), array_of(asked.force_N, asked.torque_Nm));
  if (wanted.is_none()) return false;
  const Numbers numbers = numbers_of(wanted);
  if (numbers.ndim() != 1 || !is_wish(numbers.size()))
    raise(Kind::kOption, fmt::format("hand: a target of {} numbers in {} dimensions; accepted: {}", numbers.size(),
                                     numbers.ndim(), kAcceptedTarget));
  wish = wish_of(numbers.data(), numbers.size());
  return true;
}

// Rethrows the exception of a hand's function: Python gets the same exception object.
void Run::end_with_error_of_hand() {
  const std::exception_ptr error = std::exchange(error_of_hand_, nullptr);
  std::rethrow_exception(error);
}

void Run::keep_ticks(unsigned hand) {
  const auto ticks = session_.ticks(hand);
  const std::size_t capacity = session_.options().history_ticks;
  std::vector<Tick>& unseen = hands_[hand].unseen;
  unseen.insert(unseen.end(), ticks.begin(), ticks.end());
  if (unseen.size() <= capacity) return;
  const std::size_t over = unseen.size() - capacity;
  hands_[hand].lost += over;
  unseen.erase(unseen.begin(), unseen.begin() + static_cast<std::ptrdiff_t>(over));
}

std::vector<Tick> Run::look(unsigned hand) {
  hands_[hand].lost_of_look = std::exchange(hands_[hand].lost, 0);
  return std::exchange(hands_[hand].unseen, {});
}

void Run::forget_ticks() {
  for (Hand& hand : hands_) {
    hand.unseen.clear();
    hand.lost = 0;
  }
}

void Run::reset() {
  raise_if(session_.reset());
  forget_ticks();
  if (shown_) (void)session_.bodies();
}

Saved Run::save() const {
  Saved saved;
  raise_if(session_.save(saved.session));
  for (const Hand& hand : hands_) {
    auto& kept = saved.hands.emplace_back();
    if (hand.device != nullptr) kept = hand.device->state();
  }
  return saved;
}

void Run::restore(const Saved& saved) {
  raise_if(session_.restore(saved.session));
  for (std::size_t i = 0; i < hands_.size(); ++i)
    if (saved.hands[i]) hands_[i].device->set_state(*saved.hands[i]);
  forget_ticks();
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
  for (unsigned hand = 0; hand < hands_.size(); ++hand) {
    for (const Role& role : session_.roles(hand)) const_cast<Role&>(role) = static_cast<Role>(255);
    for (const BodyNumber& member : session_.members(hand)) const_cast<BodyNumber&>(member) = 0xffffffffu;
    for (const Contact& contact : session_.contacts(hand)) {
      auto& old = const_cast<Contact&>(contact);
      old = {.a = 0xffffffffu,
             .b = 0xffffffffu,
             .position_m = {kNan, kNan, kNan},
             .normal = {kNan, kNan, kNan},
             .force_N = kNan,
             .friction_N = {kNan, kNan, kNan},
             .separation_m = kNan};
    }
    for (const BorderContact& contact : session_.border_contacts(hand)) {
      auto& old = const_cast<BorderContact&>(contact);
      old = {.member = 0xffffffffu,
             .outside = 0xffffffffu,
             .position_m = {kNan, kNan, kNan},
             .normal = {kNan, kNan, kNan},
             .force_N = kNan,
             .friction_N = {kNan, kNan, kNan}};
    }
  }
}

}  // namespace tactus::python
