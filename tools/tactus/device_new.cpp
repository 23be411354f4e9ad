// tactus device new: a description file from options, or from questions on a terminal.
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>

#include "hal/device_file.h"
#include "hal/drives/bus_load.h"
#include "tools/device/new_description.h"
#include "tools/tactus/device.h"

namespace tactus::tools {
namespace {

using device::NewDescription;
using device::Question;

struct NewCommand {
  NewDescription description;
  std::string out;
  unsigned rate_Hz{1000};
  bool ask{false}, overwrite{false};
  std::vector<CLI::Option*> options;  // one per question
  CLI::Option *kind{nullptr}, *family{nullptr};
};

int refuse(const std::string& text) { return complain("tactus device new: " + text, kExitBadInput); }

// An empty line keeps the value. False: the input has ended.
bool answer(const std::string& question, std::string& value) {
  fmt::print(stderr, "{} [{}]: ", question, value);
  std::string line;
  if (!std::getline(std::cin, line)) return false;
  if (!line.empty()) value = line;
  return true;
}

bool answer(const std::string& question, double& value) {
  for (;;) {
    std::string text = fmt::format("{:g}", value);
    if (!answer(question, text)) return false;
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    if (end != text.c_str() && *end == 0 && std::isfinite(number)) {
      value = number;
      return true;
    }
    fmt::print(stderr, "'{}' is no number\n", text);
  }
}

// What was not given as an option is asked for.
Status ask_for_the_rest(NewCommand& c) {
  NewDescription& d = c.description;
  const Status ended = Status::error("the input ended before the last question");
  if (c.kind->count() == 0 && !answer("kind of arm: point_arm, wristed_arm, stage", d.kind)) return ended;
  if (c.family->count() == 0 &&
      !answer("drives: damiao, cubemars, mini_cheetah, robstride, moteus, odrive, or firmware", d.family))
    return ended;
  if (Status status = device::check_choices(d); !status.ok()) return status;
  device::complete(d);
  const auto all = device::questions();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (c.options[i]->count() > 0 || !all[i].applies(d)) continue;
    const std::string unit = all[i].unit[0] == 0 ? "" : fmt::format(", {}", all[i].unit);
    if (!answer(all[i].text + unit, d.*all[i].value)) return ended;
  }
  return Status::good();
}

int run_new(NewCommand& c) {
  NewDescription& d = c.description;
  if (!c.out.empty() && !c.overwrite && std::filesystem::exists(c.out))
    return refuse(fmt::format("--out: {} is there already; accepted: another name, or --overwrite", c.out));
  if (c.ask || (isatty(STDIN_FILENO) != 0 && c.kind->count() == 0))
    if (const Status status = ask_for_the_rest(c); !status.ok()) return refuse(status.message());
  if (const Status status = device::check_choices(d); !status.ok()) return refuse(status.message());
  device::complete(d);
  const std::string text = device::description_text(d);
  const auto parsed = hal::parse_device_description(text, c.out.empty() ? "the description" : c.out);
  if (!parsed.ok()) return complain_of_each(parsed.message(), kExitBadInput);
  if (!parsed.value().drives.empty())
    if (const Status status =
            hal::check_bus_load(parsed.value().drives, std::chrono::nanoseconds(1'000'000'000 / c.rate_Hz));
        !status.ok())
      return refuse(status.message() + "; --buses can0,can1 spreads the drives over two");
  if (c.out.empty()) {
    fmt::print("{}", text);
    return kExitGood;
  }
  if (const int exit_code = write_file(c.out, text); exit_code != kExitGood) return exit_code;
  for (const std::string& line : device::consequences(parsed.value(), c.rate_Hz)) fmt::print("{}\n", line);
  const char* simulated = parsed.value().drives.empty() ? "sim" : "drives-sim";
  fmt::print("{} is written. See it move: tactus run sim/scenes/card_house.toml --device {} --device-file {} --view\n",
             c.out, simulated, c.out);
  return kExitGood;
}

}  // namespace

void add_device_new_command(CLI::App& device, int& exit_code) {
  auto command = std::make_shared<NewCommand>();
  NewDescription& d = command->description;
  CLI::App* app = device.add_subcommand("new", "A description file of a device, from options or questions.");
  app->footer(
      "On a terminal without --kind, or with --ask, it asks for every figure that no option gives. The description is\n"
      "checked as a run checks it: ranges of the drives, identifiers, load of the buses. What only a measurement "
      "tells\n"
      "is an estimate, and the file says so. Without --out it is printed. Exit status: 0 good; 2 a figure does not go\n"
      "with the others.\n\n"
      "Examples:\n  tactus device new --kind point_arm --family damiao --out my_arm.toml\n"
      "  tactus device new --kind wristed_arm --family moteus --buses can0,can1 --ratio 8 --peak-torque 0.5\n"
      "  tactus device new --ask --out my_arm.toml");
  command->kind = app->add_option("--kind", d.kind, "point_arm, wristed_arm or stage")->capture_default_str();
  command->family = app->add_option("--family", d.family,
                                    "of the drives: damiao, cubemars, mini_cheetah, robstride, moteus, odrive; or\n"
                                    "firmware: a device on tactus' own wire")
                        ->capture_default_str();
  app->add_option("--name", d.name, "for messages")->capture_default_str();
  app->add_option("--buses", d.buses, "CAN interfaces, a comma between two")->capture_default_str();
  app->add_option("--watchdog", d.watchdog_ms, "of the drives [ms], at most 10")->capture_default_str();
  for (const Question& question : device::questions()) {
    const std::string unit = question.unit[0] == 0 ? "" : fmt::format(" [{}]", question.unit);
    CLI::Option* option = app->add_option(question.option, d.*question.value, question.text + unit);
    if (d.*question.value != 0) option->capture_default_str();
    command->options.push_back(option);
  }
  app->add_option("--rate", command->rate_Hz, "of the loop [Hz], for the load of the buses")
      ->check(CLI::Range(100, 10000))
      ->capture_default_str();
  app->add_option("--out", command->out, "write the file here");
  app->add_flag("--ask", command->ask, "ask for what no option gives");
  app->add_flag("--overwrite", command->overwrite, "replace the file");
  app->callback([command, &exit_code] { exit_code = run_new(*command); });
}

}  // namespace tactus::tools
