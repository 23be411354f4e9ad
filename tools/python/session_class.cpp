// tactus.Session's own part: calls, state and views of a Run.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include "tools/python/classes.h"
#include "tools/python/errors.h"
#include "tools/python/layouts.h"
#include "tools/python/options.h"
#include "tools/python/run.h"

namespace py = pybind11;

namespace tactus::python {
namespace {

// replace() exchanges the Run; a view keeps the Run from which it was made.
class SessionObject : public ZeroedByPython {
 public:
  SessionObject(const Scene& scene, const py::object& hand, const py::dict& options)
      : run_(std::make_shared<Run>(scene, hand, options_of(options))) {}

  void replace(const Scene& scene, const py::object& hand, const py::dict& options) {
    made("Session");
    auto next = std::make_shared<Run>(scene, hand, options_of(options));
    {
      const Run::Call call(run(), "replace");
      run().leave_views();
    }
    run_ = std::move(next);
  }

  void step(const py::object& ticks) {
    const Run::Call call(run(), "step");
    if (py::isinstance<py::array>(ticks) || PyIndex_Check(ticks.ptr()) == 0) return run().step(ticks);
    const py::int_ number = py::reinterpret_steal<py::int_>(PyNumber_Index(ticks.ptr()));
    const long long count = PyLong_AsLongLong(number.ptr());
    if (count < 0 || PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      raise(Error::Kind::kOption,
            fmt::format("Session.step: {} ticks; accepted: 0 or more, or an array of targets", shown(ticks)));
    }
    run().step(static_cast<std::uint64_t>(count));
  }

  void record(const py::object& tape) {
    const Run::Call call(run(), "record");
    raise_if(run().session().record(path_of(tape, "Session.record")));
  }
  void reset() {
    const Run::Call call(run(), "reset");
    run().reset();
  }
  void close() {
    const Run::Call call(run(), "close");
    raise_if(run().session().close());
  }
  Saved save() const {
    const Run::Call call(run(), "save");
    return run().save();
  }
  void restore(const py::object& saved) {
    const Run::Call call(run(), "restore");
    if (!py::isinstance<Saved>(saved))
      raise(Error::Kind::kOption,
            fmt::format("Session.restore: {} is no saved state; accepted: what save() returned", shown(saved)));
    const auto& state = saved.cast<const Saved&>();
    state.made("SavedState");
    run().restore(state);
  }

  unsigned hands() const { return run().session().hands(); }

  // Each of these applies to one hand. Precondition: the hand exists.
  void request(const py::object& asked, unsigned hand) {
    static const std::pair<std::string_view, Request> kRequests[] = {{"arm", Request::kArm},
                                                                     {"rearm", Request::kRearm},
                                                                     {"disarm", Request::kDisarm},
                                                                     {"reset_scene", Request::kResetScene}};
    const std::string word = shown(asked);
    for (const auto& [name, request] : kRequests)
      if (word == fmt::format("'{}'", name)) return run().session().request(request, hand);
    raise(Error::Kind::kOption,
          fmt::format("Session.request: {} is no request; accepted: arm, rearm, disarm, reset_scene", word));
  }
  py::array look(unsigned hand) {
    const Run::Call call(run(), "look");
    auto ticks = std::make_unique<std::vector<Tick>>(run().look(hand));
    const std::span<const Tick> span = *ticks;
    const py::capsule owner(ticks.release(), [](void* kept) { delete static_cast<std::vector<Tick>*>(kept); });
    return items_of(tick_type(), span, owner);
  }
  std::uint64_t ticks_lost(unsigned hand) const { return run().ticks_lost(hand); }
  py::object last(unsigned hand) const {
    const Run::Call call(run(), "last");
    const Tick& tick = run().session().last(hand);
    return py::array(tick_type(), 1, &tick)[py::int_(0)];
  }
  py::array roles(unsigned hand) {
    const Run::Call call(run(), "roles");
    run().show_bodies();
    const auto roles = run().session().roles(hand);
    return view_of(py::dtype::of<std::uint8_t>(), {static_cast<py::ssize_t>(roles.size())}, {1}, roles.data(), owner());
  }
  py::array members(unsigned hand) {
    const Run::Call call(run(), "members");
    run().show_bodies();
    return items_of(py::dtype::of<std::uint32_t>(), run().session().members(hand), owner());
  }
  py::array contacts(unsigned hand) {
    const Run::Call call(run(), "contacts");
    run().show_bodies();
    return items_of(contact_type(), run().session().contacts(hand), owner());
  }
  py::array border(unsigned hand) {
    const Run::Call call(run(), "border");
    run().show_bodies();
    return items_of(border_contact_type(), run().session().border_contacts(hand), owner());
  }
  std::string state_hash(unsigned hand) const {
    const Run::Call call(run(), "state_hash");
    return fmt::format("{:016x}", run().session().state_hash(hand));
  }
  std::vector<std::string> notes(unsigned hand) const {
    const Run::Call call(run(), "notes");
    return run().session().notes(hand);
  }
  Summary summary(unsigned hand) const {
    const Run::Call call(run(), "summary");
    return run().session().summary(hand);
  }

  template <class Field>
  py::array bodies(Field BodyState::*field, const char* name) {
    const Run::Call call(run(), name);
    run().show_bodies();
    return field_of(run().session().bodies(), field, owner());
  }
  std::uint64_t ticks() const { return run().session().ticks_done(); }
  double time_s() const { return run().session().time_s(); }
  double period_s() const { return run().session().period_s(); }
  const Scene& scene() const { return run().session().scene(); }

 private:
  py::capsule owner() const {
    return py::capsule(new std::shared_ptr<Run>(run_),
                       [](void* kept) { delete static_cast<std::shared_ptr<Run>*>(kept); });
  }

  Run& run() const {
    made("Session");
    return *run_;
  }

  std::shared_ptr<Run> run_;
};

// One hand of a session: its number, and the session's Python object, which it keeps alive. After a replace() it is of
// the new scene.
class HandObject : public ZeroedByPython {
 public:
  HandObject(py::object session, unsigned number) : session_(std::move(session)), number_(number) {}

  SessionObject& session() const {
    made("SessionHand");
    auto& session = session_.cast<SessionObject&>();
    if (number_ >= session.hands())
      raise(Error::Kind::kUse, fmt::format("Session.hands[{}]: the scene was replaced, and this one has {} hands; "
                                           "accepted: a hand of Session.hands",
                                           number_, session.hands()));
    return session;
  }
  unsigned number() const noexcept { return number_; }

 private:
  py::object session_;
  unsigned number_;
};

// The session and the hand of an object. The session itself stands for its first hand.
SessionObject& session_of(SessionObject& session) { return session; }
SessionObject& session_of(const HandObject& hand) { return hand.session(); }
unsigned hand_of(const SessionObject&) { return 0; }
unsigned hand_of(const HandObject& hand) { return hand.number(); }

// Adds the members that concern one hand to a class whose objects have a hand.
template <class Object>
void add_of_hand(py::class_<Object>& object) {
  const auto of = [](auto method) {
    return [method](Object& self) { return (session_of(self).*method)(hand_of(self)); };
  };
  object
      .def_property_readonly(
          "roles", of(&SessionObject::roles),
          "(bodies,) uint8: who simulates each body; 0 fixed, 1 asleep, 2 global, 3 outside, 4 "
          "member, 5 border. A member of another hand's sub-world is global or outside here. A view, "
          "as Session.position.")
      .def_property_readonly("members", of(&SessionObject::members),
                             "(members,) uint32: numbers of the sub-world's bodies, ascending, as of now.")
      .def_property_readonly("contacts", of(&SessionObject::contacts),
                             "(contacts,) structured: a, b, position_m, normal (from a to b), force_N, friction_N (on "
                             "b), separation_m; world, mean of the last tick. As of now.")
      .def_property_readonly("border", of(&SessionObject::border),
                             "(contacts,) structured: member, outside, position_m, normal (to the member), force_N, "
                             "friction_N (on the member); world, mean of the last tick. As of now.")
      .def_property_readonly("last", of(&SessionObject::last),
                             "The last tick, with the fields of look(); 0 before the first.")
      .def_property_readonly("ticks_lost", of(&SessionObject::ticks_lost),
                             "Ticks that the last look() missed, because more than history_ticks had passed.")
      .def_property_readonly("state_hash", of(&SessionObject::state_hash),
                             "16 hexadecimal digits: the hash of the sub-world's state, as `tactus run --json` has it.")
      .def_property_readonly("notes", of(&SessionObject::notes), "What was changed of the options, a line each.")
      .def_property_readonly(
          "summary_text", [](Object& self) { return session_of(self).summary(hand_of(self)).text; },
          "Statistics and verdict, as `tactus run` prints them.")
      .def(
          "summary",
          [](Object& self) {
            return py::module_::import("json").attr("loads")(session_of(self).summary(hand_of(self)).json);
          },
          "Statistics and verdict so far: a dict, the object of `tactus run --json`; of several hands, the one in its "
          "`hands`.")
      .def("look", of(&SessionObject::look),
           "The ticks since the last look, oldest first, at most history_ticks: (ticks,) structured, with force_N and "
           "torque_Nm (on the hand, device frame), proxy_position_m (world), device_energy_J, damped_energy_J, "
           "border_work_J, border_tank_J, fault, conditions, members, contacts and more.")
      .def(
          "request", [](Object& self, const py::object& word) { session_of(self).request(word, hand_of(self)); },
          py::arg("word"), "For the next tick: arm, rearm, disarm or reset_scene; the last is of all hands.");
}

void add_bodies(py::class_<SessionObject>& session) {
  const auto bodies = [](auto field, const char* name) {
    return [field, name](SessionObject& self) { return self.bodies(field, name); };
  };
  session
      .def_property_readonly("position", bodies(&BodyState::position_m, "position"),
                             "(bodies, 3) float64, m, world: the origins of the frames that the scene places, as its "
                             "position_m; members of "
                             "any hand as of the last tick, the others as of the last global step. A view: read-only, "
                             "not a copy, it follows "
                             "the run.")
      .def_property_readonly("rotation", bodies(&BodyState::rotation, "rotation"),
                             "(bodies, 4) float64: w, x, y, z, world from body. A view, as position.")
      .def_property_readonly("velocity", bodies(&BodyState::velocity_m_per_s, "velocity"),
                             "(bodies, 3) float64, m/s, world: of the centres of mass. A view, as position.")
      .def_property_readonly("angular_velocity", bodies(&BodyState::angular_velocity_rad_per_s, "angular_velocity"),
                             "(bodies, 3) float64, rad/s, about the world's axes. A view, as position.");
}

void add_calls(py::class_<SessionObject>& session) {
  session
      .def("step", &SessionObject::step, py::arg("ticks"),
           "Computes so many ticks, without the GIL; or, with an array of targets for the hand, (ticks, 3) or (ticks, "
           "7) float64, position in m and rotation w x y z, or of wrenches, (ticks, 6), N and N m, world, one tick for "
           "each row. With several hands: a list "
           "with such an array for each, of as many rows, or None: that hand is led as without targets.")
      .def(
          "record", &SessionObject::record, py::arg("tape"),
          "Writes a tape of all ticks that follow, until close() or reset(). Before the first tick. With several hands "
          "one of each: my.tape of the first, my.2.tape of the second.")
      .def("reset", &SessionObject::reset,
           "Restarts the run: the same scene, options and hands, so the same bits. Views stay.")
      .def("close", &SessionObject::close, "Ends the session and its tape; what it shows keeps its last values.")
      .def("save", &SessionObject::save, "The state of the run, for restore().")
      .def("restore", &SessionObject::restore, py::arg("saved"),
           "Continues from a state that this session saved: the ticks that follow have the same bits as then.")
      .def("_replace", &SessionObject::replace);
}

void add_figures(py::class_<SessionObject>& session) {
  session
      .def_property_readonly(
          "hands",
          [](const py::object& self) {
            const unsigned count = self.cast<const SessionObject&>().hands();
            py::tuple hands(count);
            for (unsigned hand = 0; hand < count; ++hand) hands[hand] = HandObject(self, hand);
            return hands;
          },
          "A SessionHand for each [[proxy]] of the scene, in the order of the file. What is of one hand alone, such as "
          "members and look(), is the first one's on the session itself.")
      .def_property_readonly("ticks", &SessionObject::ticks, "Ticks since the start or the last reset.")
      .def_property_readonly("time_s", &SessionObject::time_s, "Simulated time, s.")
      .def_property_readonly("period_s", &SessionObject::period_s, "Of a tick, s.")
      .def_property_readonly("_scene", &SessionObject::scene);
}

}  // namespace

void add_session(py::module_& module) {
  py::class_<Saved>(module, "SavedState", "State of a session, from Session.save.");
  py::class_<HandObject> hand(module, "SessionHand",
                              "One hand of a session, from Session.hands. It keeps the session alive.");
  hand.def_property_readonly("number", &HandObject::number, "Of this hand, from 0.");
  add_of_hand(hand);
  py::class_<SessionObject> session(module, "Session");
  session.def(py::init<const Scene&, const py::object&, const py::dict&>());
  add_calls(session);
  add_bodies(session);
  add_of_hand(session);
  add_figures(session);
}

}  // namespace tactus::python
