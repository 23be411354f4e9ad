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
#include "hal/drives/drive_check.h"
#include "tools/device/new_description.h"
#include "tools/tactus/device.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

using device::NewDescription;
using device::Question;

struct NewCommand {
  NewDescription description;
  std::string out;
  bool ask{false}, overwrite{false};
  std::vector<CLI::Option*> options;  // one per question
  CLI::Option *kind{nullptr}, *family{nullptr}, *buses{nullptr};
};

// Mistakes of the description's text begin with its line; the others with the command.
Status mistake(const std::string& text) { return Status::error("tactus device new: " + text); }

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

// Reports an invalid choice and asks again.
bool answer(const NewDescription& d, const std::string& question, std::string& value,
            Status (*check)(const NewDescription&)) {
  for (const std::string offered = value;; value = offered) {
    if (!answer(question, value)) return false;
    const Status status = check(d);
    if (status.ok()) return true;
    fmt::print(stderr, "{}\n", status.message());
  }
}

// Asks for what the options did not give. False: the input has ended.
bool ask_for_the_rest(NewCommand& c) {
  NewDescription& d = c.description;
  if (c.kind->count() == 0 && !answer(d, "kind of arm: point_arm, wristed_arm, stage", d.kind, device::check_kind))
    return false;
  if (c.family->count() == 0 &&
      !answer(d, "drives: damiao, cubemars, mini_cheetah, robstride, moteus, odrive, or firmware", d.family,
              device::check_family))
    return false;
  if (!device::check_choices(d).ok()) return true;  // of what options gave: they are not asked for
  device::complete(d);
  if (c.buses->count() == 0 && device::has_drives(d) &&
      !answer(d, "CAN interfaces, a comma between two", d.buses, device::check_buses))
    return false;
  const auto all = device::questions();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (c.options[i]->count() > 0 || !all[i].applies(d)) continue;
    const std::string unit = all[i].unit[0] == 0 ? "" : fmt::format(", {}", all[i].unit);
    if (!answer(all[i].text + unit, d.*all[i].value)) return false;
  }
  return true;
}

// The description, checked as a run checks it.
struct Described {
  std::string text;
  hal::DeviceProfile profile;
};

Result<Described> describe(NewCommand& c) {
  NewDescription& d = c.description;
  if (const Status status = device::check_choices(d); !status.ok()) return mistake(status.message());
  device::complete(d);
  Described made{.text = device::description_text(d), .profile = {}};
  const auto parsed = hal::parse_device_description(made.text, c.out.empty() ? "the description" : c.out);
  if (!parsed.ok()) return parsed.status();
  const hal::DriveDescription& drives = parsed.value().drives;
  const std::chrono::nanoseconds period(1'000'000'000 / d.rate_Hz);
  if (!drives.empty())
    for (const Status& status : {hal::check_bus_load(drives, period), hal::check_watchdog(drives, period)})
      if (!status.ok()) return mistake(status.message());
  made.profile = hal::make_profile(parsed.value());
  return made;
}

// When asking interactively, reports a mistake and asks again with the previous answers as defaults.
Result<Described> ask_and_describe(NewCommand& c) {
  const bool asking = c.ask || (isatty(STDIN_FILENO) != 0 && c.kind->count() == 0);
  if (asking && !ask_for_the_rest(c)) return mistake("the input ended before the last question");
  for (;;) {
    auto made = describe(c);
    if (made.ok() || !asking) return made;
    fmt::print(stderr, "{}\nOnce more; Enter keeps what is shown.\n", made.message());
    if (!ask_for_the_rest(c)) return made;
  }
}

// The scene beside a description: my_arm.toml has my_arm_scene.toml.
std::string scene_beside(const std::string& out) {
  const std::filesystem::path path(out);
  return (path.parent_path() / (path.stem().string() + "_scene.toml")).string();
}

int write_both(const NewCommand& c, const Described& made) {
  const unsigned rate_Hz = c.description.rate_Hz;
  const std::string scene = scene_beside(c.out);
  if (const int exit_code = write_file(c.out, made.text); exit_code != kExitGood) return exit_code;
  if (const int exit_code = write_file(scene, device::scene_text(made.profile, rate_Hz)); exit_code != kExitGood)
    return exit_code;
  for (const std::string& line : device::consequences(made.profile.description, rate_Hz)) fmt::print("{}\n", line);
  fmt::print("{} and {} are written. See it move: tactus run {} --device {} --device-file {}{} --view\n", c.out, scene,
             scene, made.profile.description.drives.empty() ? "sim" : "drives-sim", c.out,
             rate_Hz == 1000 ? "" : fmt::format(" --rate {}", rate_Hz));
  return kExitGood;
}

int run_new(NewCommand& c) {
  if (!c.out.empty() && !c.overwrite)
    for (const std::string& file : {c.out, scene_beside(c.out)})
      if (std::filesystem::exists(file))
        return complain(fmt::format("tactus device new: --out: {} is there already; accepted: another name, or "
                                    "--overwrite",
                                    file),
                        kExitBadInput);
  auto made = ask_and_describe(c);
  if (!made.ok()) return complain_of_each(made.message(), kExitBadInput);
  if (!c.out.empty()) return write_both(c, made.value());
  fmt::print("{}", made.value().text);
  return kExitGood;
}

}  // namespace

void add_device_new_command(CLI::App& device, int& exit_code) {
  auto command = std::make_shared<NewCommand>();
  NewDescription& d = command->description;
  CLI::App* app = device.add_subcommand(
      "new", "Write the description file of a device, from options or from answers to questions.");
  app->footer(
      "On a terminal without --kind, or with --ask, the program asks for every value that no option gives. The\n"
      "description is checked as a run checks it: ranges of the drives, identifiers, load of the buses. A value\n"
      "that only a measurement can give is an estimate, and the file marks it so. Values that are not given are\n"
      "chosen to suit the others, for an arm of this size. Without --out the description is printed; with it a\n"
      "scene is written as well, whose gains are stable on the arm. Exit status: 0 good; 2 a value does not suit\n"
      "the others.\n\n"
      "Examples:\n"
      "  tactus device new --kind point_arm --family damiao --out my_arm.toml\n"
      "  tactus device new --kind wristed_arm --family moteus --buses can0,can1 --ratio 8 --peak-torque 0.5\n"
      "  tactus device new --ask --out my_arm.toml");
  command->kind = app->add_option("--kind", d.kind, "kinematics of the device: point_arm, wristed_arm or stage")
                      ->capture_default_str();
  command->family = app->add_option("--family", d.family,
                                    "family of the drives: damiao, cubemars, mini_cheetah, robstride, moteus, odrive;\n"
                                    "or firmware: a device with tactus' wire protocol")
                        ->capture_default_str();
  app->add_option("--name", d.name, "name of the device in messages")->capture_default_str();
  command->buses = app->add_option(
      "--buses", d.buses, "CAN interfaces, separated by commas; default: can0, or can0,can1 if one bus is not enough");
  app->add_option("--watchdog", d.watchdog_ms, "watchdog time of the drives [ms]; at most 10")->capture_default_str();
  for (const Question& question : device::questions()) {
    const std::string unit = question.unit[0] == 0 ? "" : fmt::format(" [{}]", question.unit);
    CLI::Option* option = app->add_option(question.option, d.*question.value, question.text + unit);
    if (d.*question.value > 0) option->capture_default_str();
    command->options.push_back(option);
  }
  app->add_option("--rate", d.rate_Hz,
                  std::string(help::kRate) + ", for the load of the buses; default: 1000; with six RobStrides 900")
      ->check(in_range(session::kRates_Hz, "Hz"));
  app->add_option("--out", command->out,
                  "write the description to this file, and beside it a scene to try it in, such as my_arm_scene.toml");
  app->add_flag("--ask", command->ask, "ask for every value that no option gives");
  app->add_flag("--overwrite", command->overwrite, help::kOverwrite);
  app->callback([command, &exit_code] { exit_code = run_new(*command); });
}

}  // namespace tactus::tools
