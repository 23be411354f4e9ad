#include "tools/python/layouts.h"

#include <cstddef>

namespace py = pybind11;

namespace tactus::python {
namespace {

class Layout {
 public:
  explicit Layout(std::size_t size) : size_(size) {}

  Layout& real(const char* name, std::size_t offset) { return add(name, "<f8", offset); }
  Layout& vector(const char* name, std::size_t offset) { return add(name, "(3,)<f8", offset); }
  Layout& rotation(const char* name, std::size_t offset) { return add(name, "(4,)<f8", offset); }
  Layout& number(const char* name, std::size_t offset) { return add(name, "<u4", offset); }
  Layout& count(const char* name, std::size_t offset) { return add(name, "<u8", offset); }

  py::dtype type() const {
    py::dict fields;
    fields["names"] = names_;
    fields["formats"] = formats_;
    fields["offsets"] = offsets_;
    fields["itemsize"] = size_;
    return py::dtype::from_args(fields);
  }

 private:
  Layout& add(const char* name, const char* format, std::size_t offset) {
    names_.append(name);
    formats_.append(format);
    offsets_.append(offset);
    return *this;
  }

  std::size_t size_;
  py::list names_, formats_, offsets_;
};

// What a contact and a border contact both have.
template <class T>
Layout& add_touch(Layout& layout) {
  return layout.vector("position_m", offsetof(T, position_m))
      .vector("normal", offsetof(T, normal))
      .real("force_N", offsetof(T, force_N))
      .vector("friction_N", offsetof(T, friction_N));
}

}  // namespace

py::dtype tick_type() {
  return Layout(sizeof(Tick))
      .count("number", offsetof(Tick, number))
      .real("time_s", offsetof(Tick, time_s))
      .vector("force_N", offsetof(Tick, force_N))
      .vector("torque_Nm", offsetof(Tick, torque_Nm))
      .vector("proxy_position_m", offsetof(Tick, proxy_position_m))
      .rotation("proxy_rotation", offsetof(Tick, proxy_rotation))
      .vector("proxy_velocity_m_per_s", offsetof(Tick, proxy_velocity_m_per_s))
      .vector("proxy_angular_velocity_rad_per_s", offsetof(Tick, proxy_angular_velocity_rad_per_s))
      .vector("target_position_m", offsetof(Tick, target_position_m))
      .rotation("target_rotation", offsetof(Tick, target_rotation))
      .vector("tool_position_m", offsetof(Tick, tool_position_m))
      .rotation("tool_rotation", offsetof(Tick, tool_rotation))
      .real("device_energy_J", offsetof(Tick, device_energy_J))
      .real("damped_energy_J", offsetof(Tick, damped_energy_J))
      .real("border_work_J", offsetof(Tick, border_work_J))
      .real("border_tank_J", offsetof(Tick, border_tank_J))
      .real("deepest_overlap_m", offsetof(Tick, deepest_overlap_m))
      .number("fault", offsetof(Tick, fault))
      .number("conditions", offsetof(Tick, conditions))
      .number("device_fault", offsetof(Tick, device_fault))
      .number("buttons", offsetof(Tick, buttons))
      .number("members", offsetof(Tick, members))
      .number("border", offsetof(Tick, border))
      .number("contacts", offsetof(Tick, contacts))
      .number("sub_steps", offsetof(Tick, sub_steps))
      .number("synchronised", offsetof(Tick, synchronised))
      .type();
}

py::dtype contact_type() {
  Layout layout(sizeof(Contact));
  layout.number("a", offsetof(Contact, a)).number("b", offsetof(Contact, b));
  return add_touch<Contact>(layout).real("separation_m", offsetof(Contact, separation_m)).type();
}

py::dtype border_contact_type() {
  Layout layout(sizeof(BorderContact));
  layout.number("member", offsetof(BorderContact, member)).number("outside", offsetof(BorderContact, outside));
  return add_touch<BorderContact>(layout).type();
}

py::array view_of(const py::dtype& type, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
                  const void* data, const py::handle& owner) {
  py::array view(type, std::move(shape), std::move(strides), data, owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

}  // namespace tactus::python
