// tactus._core.Live: a running controller's publication, copied look by look, and requests to its control socket.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <memory>

#include "sim/model/given_pose.h"
#include "tools/publication/packed.h"
#include "tools/publication/watched_controller.h"
#include "tools/python/classes.h"
#include "tools/python/columns.h"
#include "tools/python/errors.h"
#include "tools/service/control_server.h"

namespace py = pybind11;

namespace tactus::python {
namespace {

using publication::ContactForce;
using publication::Frame;
using publication::TickEntry;
using Rows = std::vector<exporting::Row>;

template <class Call>
auto without_gil(Call&& call) {
  py::gil_scoped_release others;
  return call();
}

// Owns the value that a view refers to.
template <class T>
py::capsule keeper_of(std::unique_ptr<T> value) {
  return py::capsule(value.release(), [](void* kept) { delete static_cast<T*>(kept); });
}

// Poses of the frames that the scene places.
void add_poses(const sim::Scene& scene, std::span<const BodyId> moving, const Frame& frame, py::dict& to) {
  const auto count = static_cast<py::ssize_t>(moving.size());
  py::array_t<double> positions({count, py::ssize_t{3}}), rotations({count, py::ssize_t{4}});
  double *position = positions.mutable_data(), *rotation = rotations.mutable_data();
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const Posed own = publication::pose_of(frame.positions[i], frame.rotations[i]);
    const auto [p, q] = sim::given_pose(scene, moving[i], own);
    for (const double value : {p.x, p.y, p.z}) *position++ = value;
    for (const double value : {q.w, q.x, q.y, q.z}) *rotation++ = value;
  }
  to["position"] = positions;
  to["rotation"] = rotations;
}

py::array contacts_of(const Frame& frame) {
  py::dict layout;
  layout["names"] = py::make_tuple("position_m", "force_N", "a", "b");
  layout["formats"] = py::make_tuple("(3,)<f4", "(3,)<f4", "<u4", "<u4");
  layout["offsets"] = py::make_tuple(offsetof(ContactForce, point), offsetof(ContactForce, x),
                                     offsetof(ContactForce, a), offsetof(ContactForce, b));
  layout["itemsize"] = sizeof(ContactForce);
  return py::array(py::dtype::from_args(layout), {static_cast<py::ssize_t>(frame.contacts.size())},
                   {static_cast<py::ssize_t>(sizeof(ContactForce))}, frame.contacts.data());  // a copy: it has no owner
}

class LiveObject : public ZeroedByPython {
 public:
  explicit LiveObject(std::filesystem::path socket) : socket_(std::move(socket)) {
    auto opened = without_gil([&] { return publication::WatchedController::open(socket_); });
    if (!opened.ok()) raise(Error::Kind::kMachine, opened.message());
    controller_ = std::move(opened).value();
    period_s_ = controller_->watcher().period_s();
    settings_ = controller_->settings();
    for (const physics::Body& body : controller_->scene().bodies)
      if (body.kind == physics::BodyKind::kDynamic) moving_.push_back(body.id);
  }

  void close() { controller_.reset(); }

  py::dict look() {
    entries_.clear();
    lost_ = watcher().read_ticks(entries_, publication::kTickEntries);
    auto rows = std::make_unique<Rows>();
    rows->reserve(entries_.size());
    for (const TickEntry& entry : entries_) rows->push_back({entry.tick, entry.times});
    const std::span<const exporting::Row> seen = *rows;
    const py::capsule keeper = keeper_of(std::move(rows));
    py::dict columns;
    for (const exporting::Column& column : exporting::all_columns())
      columns[py::str(column.name)] = column_of(seen, column, period_s_, keeper);
    return columns;
  }

  py::object frame() {
    if (!watcher().read_frame(frame_) || frame_.head.bodies != moving_.size()) return py::none();
    py::dict frame;
    frame["tick"] = frame_.head.tick;
    frame["time_s"] = frame_.head.time_s;
    frame["resets"] = frame_.head.resets;
    frame["component"] = frame_.head.component;
    add_poses(controller_->scene(), moving_, frame_, frame);
    frame["roles"] = py::array_t<std::uint8_t>(static_cast<py::ssize_t>(frame_.roles.size()), frame_.roles.data());
    frame["contacts"] = contacts_of(frame_);
    frame["contacts_left_out"] = frame_.head.left_out;
    return frame;
  }

  std::string state() {
    made("Live");
    std::string text;
    if (watcher().read_state(text)) state_ = text;
    return state_;
  }

  bool ended() const { return controller_ == nullptr || controller_->ended(); }

  // The answer, a line of JSON.
  std::string ask(const std::string& line) const {
    made("Live");
    const auto reply = without_gil([&] { return service::ask_control(socket_, line); });
    if (!reply.ok()) raise(Error::Kind::kMachine, reply.message());
    return reply.value();
  }

  py::array_t<std::uint32_t> moving() const {
    return py::array_t<std::uint32_t>(static_cast<py::ssize_t>(moving_.size()), moving_.data());
  }
  std::uint64_t ticks_lost() const noexcept { return lost_; }
  std::uint64_t frames_missed() { return watcher().frames_missed(); }
  double period_s() const noexcept { return period_s_; }
  const std::string& scene_name() const noexcept { return settings_.scene_name; }
  const std::string& scene_text() const noexcept { return settings_.scene_source; }
  const std::string& made_by() const noexcept { return settings_.made_by; }

 private:
  publication::Watcher& watcher() {
    made("Live");
    if (controller_ == nullptr) raise(Error::Kind::kUse, "Live: it is closed");
    return controller_->watcher();
  }

  std::filesystem::path socket_;
  std::unique_ptr<publication::WatchedController> controller_;  // none: closed
  session::TapeSettings settings_;
  std::vector<std::uint32_t> moving_;
  std::vector<TickEntry> entries_;
  Frame frame_;
  std::string state_;
  double period_s_{0};
  std::uint64_t lost_{0};
};

}  // namespace

void add_live(py::module_& module) {
  py::class_<LiveObject>(module, "Live", "A running controller, watched read-only.")
      .def(py::init([](const py::object& socket) { return std::make_unique<LiveObject>(path_of(socket, "Live")); }),
           py::arg("socket"))
      .def(
          "look", &LiveObject::look,
          "The ticks since the last look, oldest first: a dict with an array (ticks,) for each column of Tape.columns, "
          "read-only. The first look begins at the newest tick.")
      .def_property_readonly("ticks_lost", &LiveObject::ticks_lost,
                             "Ticks that the last look() missed, because 16,384 had passed.")
      .def(
          "frame", &LiveObject::frame,
          "The newest state of the bodies, or None if there is none since the last call: a dict with tick (steps of "
          "the "
          "global world), time_s, position (n, 3) [m, world] and rotation (n, 4) [w x y z, world from body, to 0.06 "
          "mrad] of the "
          "frames that the scene places, "
          "and roles (n,) of the bodies in `moving`, contacts of the proxy's component (position_m, force_N on body b, "
          "a, b), contacts_left_out, component, resets. At most 60 a second.")
      .def_property_readonly("frames_missed", &LiveObject::frames_missed, "Frames that were written and not read.")
      .def_property_readonly("moving", &LiveObject::moving,
                             "(n,) uint32: the numbers of the scene's bodies in a frame.")
      .def_property_readonly("ended", &LiveObject::ended, "The run is over, or its process is gone.")
      .def_property_readonly("period_s", &LiveObject::period_s, "Of a tick, s.")
      .def_property_readonly("scene_name", &LiveObject::scene_name, "Of the scene that is run.")
      .def_property_readonly("scene_text", &LiveObject::scene_text, "The scene that is run, with its files' data.")
      .def_property_readonly("made_by", &LiveObject::made_by, "The version of the controller.")
      .def("close", &LiveObject::close, "Watches no more; the run goes on.")
      .def("_state", &LiveObject::state)
      .def("_ask", &LiveObject::ask, py::arg("line"));
}

}  // namespace tactus::python
