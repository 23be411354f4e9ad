// tactus device ask: reads and writes the registers of a device on tactus' wire, shows its fault log, and the registers
// that a description needs.
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "hal/device_class.h"
#include "tools/device/ask.h"
#include "tools/hil/simulated_bench.h"
#include "tools/json_report.h"
#include "tools/session/find_description.h"
#include "tools/tactus/device.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

using device::RegisterValue;

struct AskCommand {
  std::string device, profile{"virtuose6d"}, device_file;
  std::vector<std::string> words;
  unsigned rate_Hz{1000};
  bool write{false}, json{false};
};

int refuse_request(const std::string& text, int exit_code = kExitBadInput) {
  return complain("tactus device ask: " + text, exit_code);
}

int refuse_device(const std::string& text) { return refuse_request(text, kExitMachineCannot); }

constexpr const char* kForms = "read [REGISTER]..., write REGISTER VALUE, execute REGISTER [VALUE], faults, needs";

// The registers as JSON: objects with name, value as text, unit.
nlohmann::ordered_json json_of(const RegisterValue& one) {
  return {{"register", device::name_of(*one.row, one.index)},
          {"number", one.row->number + one.index},
          {"value", device::value_text(*one.row, one.bits)},
          {"unit", one.row->unit}};
}

int show(const AskCommand& c, const std::vector<RegisterValue>& values) {
  auto list = nlohmann::ordered_json::array();
  for (const RegisterValue& one : values) {
    if (!c.json)
      fmt::print("{:#06x} {:<24} {:>14} {}\n", one.row->number + one.index, device::name_of(*one.row, one.index),
                 device::value_text(*one.row, one.bits), one.row->unit);
    list.push_back(json_of(one));
  }
  if (c.json) fmt::print("{}\n", report_text(nlohmann::ordered_json{{"registers", list}}, 2));
  return kExitGood;
}

int read_and_show(const AskCommand& c, hal::AnyLink& link) {
  std::vector<RegisterValue> all;
  for (std::size_t i = 1; i < c.words.size(); ++i) {
    const auto name = device::find_by_name(c.words[i]);
    if (!name.ok()) return refuse_request(name.message());
    const auto values = device::read_registers(link, name.value());
    if (!values.ok()) return refuse_device(values.message());
    all.insert(all.end(), values.value().begin(), values.value().end());
  }
  if (c.words.size() > 1) return show(c, all);
  const auto values = device::read_all(link);
  return values.ok() ? show(c, values.value()) : refuse_device(values.message());
}

int write_and_show(const AskCommand& c, hal::AnyLink& link) {
  const bool executes = c.words[0] == "execute";
  if (c.words.size() != 3 && !(executes && c.words.size() == 2))
    return refuse_request(fmt::format("accepted: {}", kForms));
  const auto name = device::find_by_name(c.words[1]);
  if (!name.ok()) return refuse_request(name.message());
  const firmware::Register& row = *name.value().row;
  if ((row.access == firmware::Access::kCommand) != executes)
    return refuse_request(fmt::format("{} is {}; accepted: {}", row.name, executes ? "no command" : "a command",
                                      executes ? "write" : "execute"));
  if (row.access == firmware::Access::kRead)
    return refuse_request(
        fmt::format("{} is told by the device and cannot be written; accepted: read {}", row.name, row.name));
  if (name.value().count != 1)
    return refuse_request(
        fmt::format("{} are {} registers; accepted: one of them, such as {}[0]", row.name, row.count, row.name));
  const auto bits = device::parse_value(row, c.words.size() == 3 ? c.words[2] : "0");
  if (!bits.ok()) return refuse_request(bits.message());
  const auto is_now = device::write_register(link, name.value(), bits.value());
  if (!is_now.ok()) return refuse_device(is_now.message());
  return show(c, {{&row, name.value().first, is_now.value()}});
}

int show_faults(const AskCommand& c, hal::AnyLink& link) {
  const auto entries = device::read_fault_log(link);
  if (!entries.ok()) return refuse_device(entries.message());
  if (c.json) {
    fmt::print("{}\n", report_text(nlohmann::ordered_json{{"faults", entries.value()}}, 2));
    return kExitGood;
  }
  for (const std::string& entry : entries.value()) fmt::print("{}\n", entry);
  if (entries.value().empty()) fmt::print("no faults since the device was switched on\n");
  return kExitGood;
}

// Without a device: what it needs. With one: also what it has, and whether a run would accept that.
int show_needs(const AskCommand& c, const hal::DeviceProfile& profile, hal::AnyLink* link) {
  const auto needed = device::needed_registers(profile, 1'000'000 / c.rate_Hz);
  if (c.write && link != nullptr) {
    const auto written = device::write_needed(*link, needed);
    if (!written.ok()) return refuse_device(written.message());
    if (!c.json)
      fmt::print("{} registers written; `execute save` keeps them when the device is switched off\n", written.value());
  }
  auto list = nlohmann::ordered_json::array();
  bool all_good = true;
  for (const device::NeededRegister& one : needed) {
    const firmware::Register& row = *one.value.row;
    const std::string name = device::name_of(row, one.value.index), value = device::value_text(row, one.value.bits);
    auto object = json_of(one.value);
    std::string told_text;
    bool good = true;
    if (link != nullptr) {
      const auto told = device::read_registers(*link, {&row, one.value.index, 1});
      if (!told.ok()) return refuse_device(told.message());
      good = device::satisfies(one, told.value()[0].bits);
      told_text = device::value_text(row, told.value()[0].bits);
      object["device"] = told_text;
      object["good"] = good;
    }
    all_good = all_good && good;
    list.push_back(object);
    if (!c.json)
      fmt::print("{:#06x} {:<16} {:>14} {:<18} {:>14} {}\n", row.number + one.value.index, name, value, row.unit,
                 told_text,
                 link == nullptr ? ""
                 : good          ? "good"
                                 : "write it");
  }
  if (c.json) fmt::print("{}\n", report_text(nlohmann::ordered_json{{"needs", list}, {"good", all_good}}, 2));
  return all_good ? kExitGood : kExitVerdictBad;
}

Result<std::unique_ptr<hal::AnyLink>> open_link(const AskCommand& c, const hal::DeviceProfile& profile) {
  const auto choice = hal::choose_device(c.device);
  if (!choice.ok()) return choice.status();
  const hal::DeviceClass& device_class = *choice.value().device_class;
  const std::int64_t period_ns = 1'000'000'000 / c.rate_Hz;
  if (device_class.name == "sim")
    return std::make_unique<hal::AnyLink>(std::make_unique<hil::SimulatedBench>(profile, period_ns));
  if (device_class.open_link == nullptr)
    return Status::error(fmt::format("{} has no registers of tactus' wire; accepted: usb, can, sim", c.device));
  auto opened = device_class.open_link(
      {.address = choice.value().address, .profile = profile, .period_ns = period_ns, .hand = {}, .faults = {}});
  if (!opened.ok()) return opened.status();
  return std::move(opened.value().link);
}

int run_ask(const AskCommand& c) {
  const std::string what = c.words.empty() ? "read" : c.words[0];
  if (what != "read" && what != "write" && what != "execute" && what != "faults" && what != "needs")
    return refuse_request(fmt::format("'{}' is none; accepted: {}", what, kForms));
  if (c.write && what != "needs") return refuse_request("--write goes with needs; accepted: write REGISTER VALUE");
  if (c.device.empty() && (what != "needs" || c.write))
    return refuse_request("--device is required; accepted: usb, usb:SERIAL, can:IFACE, can:IFACE:NODE, sim");
  const auto profile = session::find_description(c.profile, c.device_file);
  if (!profile.ok()) return complain_of_each(profile.message(), kExitBadInput);
  if (c.device.empty()) return show_needs(c, profile.value(), nullptr);
  const auto link = open_link(c, profile.value());
  if (!link.ok()) return refuse_device(link.message());
  if (what == "needs") return show_needs(c, profile.value(), link.value().get());
  if (what == "faults") return show_faults(c, *link.value());
  if (what == "read") return read_and_show(c, *link.value());
  return write_and_show(c, *link.value());
}

}  // namespace

void add_device_ask_command(CLI::App& device, int& exit_code) {
  auto command = std::make_shared<AskCommand>();
  CLI::App* app = device.add_subcommand(
      "ask", "Read and write registers of a device with tactus' wire protocol; compare them with a description.");
  app->footer(
      "WHAT: read (all), read REGISTER..., write REGISTER VALUE, execute REGISTER [VALUE], faults (the fault log),\n"
      "or needs: the register values that the description requires, compared with the device's as a run does;\n"
      "without --device they are only printed. A register has its name in firmware/PROTOCOL.md, an element of an\n"
      "array as in max_effort[2], or its number. Do not use this while a run drives the device. No request moves a\n"
      "motor.\n"
      "Exit status: 0 good; 1 needs: the device differs; 2 bad usage; 3 no such device, or it refuses the request.\n\n"
      "Examples:\n"
      "  tactus device ask --device usb\n"
      "  tactus device ask --device can:can0 read quantum serial\n"
      "  tactus device ask --device usb write max_effort[2] 3.5\n"
      "  tactus device ask --device usb --device-file my_arm.toml needs --write\n"
      "  tactus device ask --device usb execute save");
  app->add_option("WHAT", command->words, "request, see below; default: read");
  app->add_option("--device", command->device, "device: usb, usb:SERIAL, can:IFACE, can:IFACE:NODE, or sim");
  app->add_option("--device-file", command->device_file, std::string(help::kDeviceFile) + "; default: --profile");
  app->add_option("--profile", command->profile, help::kProfile)->capture_default_str();
  app->add_option("--rate", command->rate_Hz, help::kRate)
      ->check(in_range(session::kRates_Hz, "Hz"))
      ->capture_default_str();
  app->add_flag("--write", command->write,
                "with needs: write the registers whose values differ from the description's");
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, &exit_code] { exit_code = run_ask(*command); });
}

}  // namespace tactus::tools
