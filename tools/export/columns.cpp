#include "tools/export/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "rt/text/nearest_word.h"

namespace tactus::exporting {
namespace {

constexpr std::string_view kDeviceFrame = "device";
constexpr std::string_view kWorld = "world";

struct Table {
  std::vector<Column> columns;
  std::string group;

  void count(const char* name, std::size_t offset, std::string meaning) {
    columns.push_back({.name = name,
                       .group = group,
                       .unit = "",
                       .frame = "",
                       .meaning = std::move(meaning),
                       .type = ColumnType::kCount,
                       .offset = offset});
  }
  void number(const char* name, std::size_t offset, std::string meaning) {
    columns.push_back({.name = name,
                       .group = group,
                       .unit = "",
                       .frame = "",
                       .meaning = std::move(meaning),
                       .type = ColumnType::kNumber,
                       .offset = offset});
  }
  void real(const char* name, std::size_t offset, const char* unit, const char* meaning) {
    columns.push_back({.name = name,
                       .group = group,
                       .unit = unit,
                       .frame = "",
                       .meaning = meaning,
                       .type = ColumnType::kReal,
                       .offset = offset});
  }
  // Three columns: name_x_unit, name_y_unit, name_z_unit. `suffix`: the unit as names have it.
  void vector(const char* name, std::size_t offset, const char* unit, const char* suffix, std::string_view frame,
              const char* meaning) {
    for (std::size_t i = 0; i < 3; ++i)
      columns.push_back({.name = fmt::format("{}_{}_{}", name, "xyz"[i], suffix),
                         .group = group,
                         .unit = unit,
                         .frame = std::string(frame),
                         .meaning = meaning,
                         .type = ColumnType::kReal,
                         .offset = offset + i * sizeof(double)});
  }
  void rotation(const char* name, std::size_t offset, std::string_view frame, const char* meaning) {
    for (std::size_t i = 0; i < 4; ++i)
      columns.push_back({.name = fmt::format("{}_{}", name, "wxyz"[i]),
                         .group = group,
                         .unit = "1",
                         .frame = std::string(frame),
                         .meaning = meaning,
                         .type = ColumnType::kReal,
                         .offset = offset + i * sizeof(double)});
  }
};

std::string status_meaning() {
  std::string text = "conditions of the tick, a sum of:";
  for (std::uint32_t bit = 1; bit != 0; bit <<= 1)
    if (const auto name = name_of(static_cast<StatusBit>(bit)); !name.empty())
      text += fmt::format(" {} {},", bit, name);
  text.pop_back();
  return text;
}

void add_device(Table& t) {
  t.group = "device";
  t.number("read_status", offsetof(Row, tick.device.status),
           "sample of the device: 0 fresh, 1 missing, 2 corrupt, 3 disconnected");
  t.count("sample_sequence", offsetof(Row, tick.device.sample.sequence),
          "number of the sample's frame, counted by the device");
  t.count("device_time_ns", offsetof(Row, tick.device.sample.device_time_ns),
          "the device's clock at the sample, in nanoseconds");
  t.columns.back().unit = "ns";
  t.number("device_state", offsetof(Row, tick.device.sample.state),
           "the device's state: 0 reset, 1 idle, 2 force, 3 brake");
  t.number("device_fault", offsetof(Row, tick.device.sample.device_fault), "the device's own fault number; 0 none");
  t.number("device_limits", offsetof(Row, tick.device.sample.limits), "the device's limit-active bits");
  t.number("buttons", offsetof(Row, tick.device.sample.buttons), "buttons of the device, bit 0 first; 1 pressed");
  t.count("echoed_sequence", offsetof(Row, tick.device.sample.echoed_sequence),
          "number of the newest command that the device had before the sample");
  t.number("missed_commands", offsetof(Row, tick.device.sample.missed_commands),
           "periods in a row without a command, counted by the device");
  t.group = "tool";
  t.vector("tool_position", offsetof(Row, tick.device.sample.device_from_tool.position), "m", "m", kDeviceFrame,
           "measured position of the tool");
  t.rotation("tool_rotation", offsetof(Row, tick.device.sample.device_from_tool.rotation), kDeviceFrame,
             "measured rotation of the tool, unit quaternion");
}

void add_plan(Table& t) {
  t.group = "plan";
  t.number("operator_bits", offsetof(Row, tick.operator_bits),
           "operator's requests, a sum of: 1 arm, 2 re-arm, 4 disarm, 8 stop line, 16 reset, 32 hold reset, 64 end");
  t.number("sub_steps", offsetof(Row, tick.sub_steps), "sub-steps of the tick, chosen by the governor");
  t.number("adopts", offsetof(Row, tick.adopts), "1: a snapshot of the global world was adopted, a cycle begins");
  t.number("member_budget", offsetof(Row, tick.member_budget),
           "where a cycle begins: members that the governor allows in the next one");
}

void add_command(Table& t) {
  t.group = "command";
  t.count("command_sequence", offsetof(Row, tick.out.command.sequence), "number of the command");
  t.number("wanted_state", offsetof(Row, tick.out.command.wanted),
           "state commanded to the device: 1 idle, 2 force, 3 brake");
  t.number("command_rearm", offsetof(Row, tick.out.command.rearm),
           "1: the device is commanded to leave a latched brake");
  t.group = "force";
  t.vector("force", offsetof(Row, tick.out.command.wrench.force), "N", "N", kDeviceFrame,
           "force commanded, on the hand");
  t.group = "torque";
  t.vector("torque", offsetof(Row, tick.out.command.wrench.torque), "N m", "Nm", kDeviceFrame,
           "torque commanded, on the hand, about the tool's origin");
}

void add_state(Table& t) {
  t.group = "state";
  t.number("fault", offsetof(Row, tick.out.fault), "latched fault; 0 none");
  t.number("status_bits", offsetof(Row, tick.out.status), status_meaning());
  t.number("capacity_bits", offsetof(Row, tick.out.capacity_bits), "capacities that were exceeded; 0 none");
  t.number("dropped", offsetof(Row, tick.out.dropped), "entries that did not fit");
  t.number("cut_sweep", offsetof(Row, tick.out.cut_sweep),
           "sweep at which the solver was cut for lack of time; 4294967295 never");
  t.group = "counts";
  t.number("members", offsetof(Row, tick.out.members), "bodies in the sub-world, the proxy included");
  t.number("border", offsetof(Row, tick.out.border), "contact points between members and outside bodies");
  t.number("pairs", offsetof(Row, tick.out.pairs), "pairs of bodies that were tested for contact");
  t.number("contacts", offsetof(Row, tick.out.contacts), "pairs of bodies in contact");
  t.number("points", offsetof(Row, tick.out.points), "contact points");
  t.group = "overlap";
  t.real("deepest_m", offsetof(Row, tick.out.deepest_m), "m", "deepest overlap of two bodies");
  t.real("deepest_share", offsetof(Row, tick.out.deepest_share), "1",
         "deepest overlap as a share of the thinner body's thickness; 0 where it is small");
}

void add_motion(Table& t) {
  t.group = "target";
  t.vector("target_position", offsetof(Row, tick.out.target.position), "m", "m", kWorld,
           "position that the device asks of the proxy");
  t.rotation("target_rotation", offsetof(Row, tick.out.target.rotation), kWorld,
             "rotation that the device asks of the proxy, unit quaternion");
  t.group = "proxy";
  t.vector("proxy_position", offsetof(Row, tick.out.proxy.pose.position), "m", "m", kWorld,
           "position of the proxy's centre of mass");
  t.rotation("proxy_rotation", offsetof(Row, tick.out.proxy.pose.rotation), kWorld,
             "rotation of the proxy, unit quaternion");
  t.vector("proxy_velocity", offsetof(Row, tick.out.proxy.velocity.linear), "m/s", "m_per_s", kWorld,
           "velocity of the proxy's centre of mass");
  t.vector("proxy_angular_velocity", offsetof(Row, tick.out.proxy.velocity.angular), "rad/s", "rad_per_s", kWorld,
           "angular velocity of the proxy");
  t.group = "wanted";
  t.vector("wanted_force", offsetof(Row, tick.out.wanted.force), "N", "N", kDeviceFrame,
           "force before passivity and limits");
  t.vector("wanted_torque", offsetof(Row, tick.out.wanted.torque), "N m", "Nm", kDeviceFrame,
           "torque before passivity and limits");
}

void add_energy(Table& t) {
  t.group = "energy";
  t.real("device_energy_J", offsetof(Row, tick.out.device_energy_J), "J",
         "from the hand into the virtual side at the device port, since the start");
  t.real("damped_energy_J", offsetof(Row, tick.out.damped_energy_J), "J",
         "taken out by the passivity controller, since the start");
  t.real("border_work_J", offsetof(Row, tick.out.border_work_J), "J",
         "by the border on members, since the start, with sign");
  t.real("corrected_J", offsetof(Row, tick.out.corrected_J), "J",
         "given to members and the device's spring by corrections, since the start, with sign");
  t.real("border_tank_J", offsetof(Row, tick.out.border_tank_J), "J", "energy stored for the border");
}

// The record repeats the tick's number, which is no column of its own.
void add_times(Table& t) {
  t.group = "times";
  t.count("woke_ns", offsetof(Row, times.woke_ns),
          "the tick's beginning on the machine's monotonic clock; 0 not measured");
  t.columns.back().unit = "ns";
  t.number("wake_ns", offsetof(Row, times.wake_ns), "how late the thread woke");
  t.columns.back().unit = "ns";
  t.number("read_ns", offsetof(Row, times.read_ns), "time to read the device");
  t.columns.back().unit = "ns";
  t.number("compute_ns", offsetof(Row, times.compute_ns), "time of the loop's own work");
  t.columns.back().unit = "ns";
  t.number("write_ns", offsetof(Row, times.write_ns), "time to write the command and the records");
  t.columns.back().unit = "ns";
}

std::vector<Column> make_columns() {
  Table table;
  table.group = "time";
  table.count("tick", offsetof(Row, tick.out.tick), "number of the tick, from 0");
  table.columns.push_back({.name = "time_s",
                           .group = "time",
                           .unit = "s",
                           .frame = "",
                           .meaning = "simulated time at the end of the tick",
                           .type = ColumnType::kTime,
                           .offset = 0});
  add_device(table);
  add_plan(table);
  add_command(table);
  add_state(table);
  add_motion(table);
  add_energy(table);
  add_times(table);
  return table.columns;
}

}  // namespace

double time_of(std::uint64_t tick, double period_s) noexcept { return static_cast<double>(tick + 1) * period_s; }

Value value_of(const Column& column, const Row& row, double period_s) noexcept {
  const auto* from = reinterpret_cast<const std::byte*>(&row) + column.offset;
  Value value;
  switch (column.type) {
    case ColumnType::kReal:
      std::memcpy(&value.real, from, sizeof value.real);
      break;
    case ColumnType::kCount:
      std::memcpy(&value.count, from, sizeof value.count);
      break;
    case ColumnType::kNumber: {
      std::uint32_t number = 0;
      std::memcpy(&number, from, sizeof number);
      value.count = number;
      break;
    }
    case ColumnType::kTime:
      value.real = time_of(row.tick.out.tick, period_s);
      break;
  }
  return value;
}

const std::vector<Column>& all_columns() {
  static const std::vector<Column> columns = make_columns();
  return columns;
}

std::vector<std::string> group_names() {
  std::vector<std::string> names;
  for (const Column& column : all_columns())
    if (names.empty() || names.back() != column.group) names.push_back(column.group);
  return names;
}

Result<std::vector<Column>> select_columns(std::span<const std::string> words) {
  const auto& all = all_columns();
  if (words.empty()) return all;
  std::vector<bool> wanted(all.size(), false);
  for (std::size_t i = 0; i < all.size(); ++i) wanted[i] = all[i].group == "time";
  for (const std::string& word : words) {
    bool found = false;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].name == word || all[i].group == word) wanted[i] = found = true;
    if (found) continue;
    std::vector<std::string> known = group_names();
    for (const Column& column : all) known.push_back(column.name);
    const std::vector<std::string_view> views(known.begin(), known.end());
    const auto nearest = text::nearest_word(word, views);
    return Status::error(fmt::format("'{}' is no signal{}; accepted: {}, or a column's name", word,
                                     nearest.empty() ? "" : fmt::format(", did you mean {}?", nearest),
                                     fmt::join(group_names(), ", ")));
  }
  std::vector<Column> chosen;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (wanted[i]) chosen.push_back(all[i]);
  return chosen;
}

}  // namespace tactus::exporting
