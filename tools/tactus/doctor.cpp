// tactus doctor: checks whether this PC is fit for the rate: green, amber or red findings, each with its remedy.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "hal/device_class.h"
#include "tools/doctor/examine.h"
#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

using doctor::MachineFinding;
using doctor::MachineVerdict;
using doctor::Report;

struct DoctorOptions {
  doctor::Request request;
  std::string device{"sim"}, root{"/"};
  bool json{false}, fix{false};
};

std::string coloured(MachineVerdict verdict, bool colour) {
  const std::string name = fmt::format("{:<5}", doctor::name_of(verdict));
  if (!colour) return name;
  constexpr const char* kColours[]{"32", "33", "31"};
  return fmt::format("\033[{}m{}\033[0m", kColours[static_cast<std::size_t>(verdict)], name);
}

void print_text(const Report& report) {
  const bool colour = isatty(STDOUT_FILENO) != 0;
  int counts[3]{};
  for (const MachineFinding& f : report.findings) {
    ++counts[static_cast<std::size_t>(f.verdict)];
    fmt::print("{}  {:<20} {}\n", coloured(f.verdict, colour), f.check, f.found);
    if (!f.remedy.empty()) fmt::print("       {:<20} remedy: {}\n", "", f.remedy);
  }
  fmt::print("\ncpu {} for the haptic thread: {} green, {} amber, {} red\n", report.cpu, counts[0], counts[1],
             counts[2]);
  if (!report.representative())
    fmt::print("timing figures taken here are NOT representative of a dedicated real-time PC:\n");
  for (const MachineFinding& f : report.findings)
    if (f.distorts) fmt::print("  {}: {}\n", f.check, f.found);
}

void print_fixes(const Report& report) {
  fmt::print("# What would remove the findings on this machine; read it, then run what you choose, as root.\n");
  for (const MachineFinding& f : report.findings)
    if (!f.commands.empty()) fmt::print("\n# {}: {}\n{}\n", f.check, f.found, f.commands);
}

void print_json(const Report& report) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const MachineFinding& f : report.findings)
    rows.push_back(
        {{"check", f.check}, {"verdict", doctor::name_of(f.verdict)}, {"found", f.found}, {"cure", f.remedy}});
  const nlohmann::ordered_json object{{"rows", rows}, {"cpu", report.cpu}, {"representative", report.representative()}};
  fmt::print("{}\n", report_text(object, 2));
}

MachineFinding library_finding(const Result<std::string>& look) {
  if (look.ok())
    return {.check = "library", .verdict = MachineVerdict::kGreen, .found = look.value(), .remedy = {}, .commands = {}};
  return {.check = "library",
          .verdict = MachineVerdict::kRed,
          .found = look.message(),
          .remedy = "install the maker's software, or say where it is",
          .commands = {}};
}

int examine(DoctorOptions options) {
  const auto choice = hal::choose_device(options.device);
  if (!choice.ok()) return complain("tactus doctor: " + choice.message(), kExitBadInput);
  const hal::DeviceClass& device_class = *choice.value().device_class;
  options.request.usb = device_class.usb;
  if (device_class.can_interfaces != nullptr)
    options.request.can_interfaces = device_class.can_interfaces(choice.value().address);
  const auto system = doctor::SystemView::open(options.root);
  if (!system.ok()) return complain("tactus doctor: --tree: " + system.message(), kExitBadInput);
  Report report = doctor::examine(system.value(), options.request);
  // The library is that of this machine, so another one's tree says nothing about it.
  if (device_class.look != nullptr && options.root == "/")
    report.findings.push_back(library_finding(device_class.look(choice.value().address)));
  if (options.json)
    print_json(report);
  else if (options.fix)
    print_fixes(report);
  else
    print_text(report);
  return report.worst() == MachineVerdict::kRed ? kExitVerdictBad : kExitGood;
}

}  // namespace

CLI::App* add_doctor_command(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* doctor = program.add_subcommand(
      "doctor", "Check whether this PC can keep the haptic rate; print what to do about each finding.");
  doctor->footer(
      "green: no action needed; amber: occasional late wake-ups; red: deadlines will be missed, or tactus will not\n"
      "run. The program changes nothing. Exit status: 0 no finding is red; 1 a finding is red; 2 bad usage.\n\n"
      "Examples:\n"
      "  tactus doctor --cpu 3\n"
      "  tactus doctor --device can:can0\n"
      "  tactus doctor --fix > remedy.sh");
  doctor->add_option("--cpu", options->request.cpu, help::kCpu)->check(in_range(session::kCores));
  doctor->add_option("--rate", options->request.rate_Hz, help::kRate)
      ->check(in_range(session::kRates_Hz, "Hz"))
      ->capture_default_str();
  doctor->add_option("--device", options->device, help::devices("device whose bus is checked too"))
      ->capture_default_str();
  doctor->add_flag("--gpio", options->request.gpio, "check the GPIO lines too");
  doctor->add_option(
      "--tree", options->root,
      "folder with the recorded /proc, /sys and process data of another machine, to check instead of this one");
  doctor->add_flag("--fix", options->fix, "print the commands that would correct the findings; none of them is run");
  doctor->add_flag("--json", options->json, help::kJson);
  doctor->callback([options, &exit_code] { exit_code = examine(*options); });
  return doctor;
}

}  // namespace tactus::tools
