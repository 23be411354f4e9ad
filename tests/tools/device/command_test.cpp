// `tactus device` as a user has it: the device in this process, descriptions and a simulated arm.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/device_file.h"
#include "rt/text/read_file.h"
#include "tests/support/run_command.h"
#include "tests/support/temporary_file.h"
#include "tools/device/calibration.h"
#include "tools/private_folder.h"

using namespace tactus;
using Catch::Matchers::Contains;
using test::CommandOutput;

namespace {

// `out`: of stdout and stderr.
CommandOutput run(const std::string& arguments, const std::string& input = "") {
  const test::TemporaryFile answers;
  std::ofstream(answers.path()) << input;
  return test::run_command(TACTUS_PROGRAM " device " + arguments + " 2>&1 <" + answers.path());
}

const std::string kPointArm = TACTUS_SOURCE_DIR "/hal/devices/point_arm_drives.toml";
const std::string kWristedArm = TACTUS_SOURCE_DIR "/hal/devices/wristed_arm_moteus.toml";

}  // namespace

TEST_CASE("device ask: registers of a device, by name, as text and as JSON") {
  const CommandOutput one = run("ask --device sim read period max_effort[2]");
  CHECK(one.exit_code == 0);
  CHECK_THAT(one.out, Contains("0x0132 period") && Contains("1000 us") && Contains("0x0112 max_effort[2]"));
  const CommandOutput all = run("ask --device sim --json");
  REQUIRE(all.exit_code == 0);
  CHECK(nlohmann::json::parse(all.out)["registers"].size() > 100);
  const CommandOutput wrote = run("ask --device sim write max_effort[2] 3.5");
  CHECK(wrote.exit_code == 0);
  CHECK_THAT(wrote.out, Contains("3.5"));
  CHECK_THAT(run("ask --device sim faults").out, Contains("no faults since the device was switched on"));
}

TEST_CASE("device ask needs: what a description needs, and whether a device has it") {
  const CommandOutput alone = run("ask needs --profile desk3d");
  CHECK(alone.exit_code == 0);
  CHECK_THAT(alone.out, Contains("quantum[0]") && Contains("0.000125664") && Contains("brake_frames"));
  const CommandOutput with = run("ask --device sim needs --json");
  REQUIRE(with.exit_code == 0);
  CHECK(nlohmann::json::parse(with.out)["good"] == true);
}

TEST_CASE("device ask: mistakes are one line and status 2, refusals of the device status 3") {
  for (const char* wrong :
       {"ask", "ask --device sim raed", "ask --device sim read max_efort", "ask --device sim write max_effort 1",
        "ask --device sim write max_effort[0] -1", "ask --device sim write save 0", "ask --device sim execute period",
        "ask --device sim --write", "new --kind arm", "new --family vesc",
        "new --kind wristed_arm --family damiao --position-range 3", "calibrate", "new --buses ,",
        "new --buses can0,can0", "new --buses can0,can1,can2", "new --kind wristed_arm --buses can0"}) {
    const CommandOutput output = run(wrong);
    INFO(wrong << "\n" << output.out);
    CHECK(output.exit_code == 2);
    CHECK_THAT(output.out, Contains("accepted: ") || Contains("required") || Contains("fits"));
  }
  const CommandOutput refused = run("ask --device sim write period -5");
  CHECK(refused.exit_code == 2);
  CHECK_THAT(refused.out, Contains("period is told by the device and cannot be written; accepted: read period"));
  CHECK(run("ask --device drives read").exit_code == 3);
}

TEST_CASE("device new: options make a description that is checked, and no file is overwritten unasked") {
  const auto folder = PrivateFolder::make();
  const std::string file = (folder.value()->path() / "my_arm.toml").string(), out = " --out " + file;
  std::ofstream(folder.value()->path() / "my_arm_scene.toml") << "mine";
  CHECK(run("new --kind point_arm --family damiao" + out).exit_code == 2);  // the scene is there
  const CommandOutput made = run("new --kind point_arm --family damiao --radius 0.12 --overwrite" + out);
  CHECK(made.exit_code == 0);
  CHECK_THAT(made.out, Contains("bus can0: 81 % loaded at 1000 Hz") && Contains("my_arm_scene.toml are written"));
  const auto description = hal::load_device_file(file);
  REQUIRE(description.ok());
  CHECK(description.value().description.workspace_radius_m == 0.12);
}

TEST_CASE("device new --ask: an answer counts, an empty line keeps what is offered") {
  const auto folder = PrivateFolder::make();
  const std::string file = (folder.value()->path() / "my_arm.toml").string();
  // kind, family, buses, upper arm, forearm, radius, a word that is no number, then the radius again; the rest is kept
  const CommandOutput made =
      run("new --ask --out " + file, "point_arm\nmoteus\n\n0.25\n\nwide\n0.11\n\n\n\n\n8\n\n\n\n\n\n");
  INFO(made.out);
  REQUIRE(made.exit_code == 0);
  CHECK_THAT(made.out, Contains("'wide' is no number"));
  const auto description = hal::load_device_file(file);
  REQUIRE(description.ok());
  CHECK(description.value().description.links.upper_m == 0.25);
  CHECK(description.value().description.workspace_radius_m == 0.11);
  CHECK(description.value().description.drives.axes[0].ratio == 8);
}

TEST_CASE("device new: what it writes for each kind on each family runs by the command that it prints", "[slow]") {
  for (const std::string kind : {"point_arm", "wristed_arm", "stage"})
    for (const std::string family :
         {"damiao", "cubemars", "mini_cheetah", "robstride", "moteus", "odrive", "firmware"}) {
      CAPTURE(kind, family);
      const auto folder = PrivateFolder::make();
      const std::string out = (folder.value()->path() / "my_arm.toml").string();
      const CommandOutput made = run("new --kind " + kind + " --family " + family + " --out " + out);
      INFO(made.out);
      REQUIRE(made.exit_code == 0);
      const std::string see = "See it move: tactus run ", view = " --view";
      const std::size_t from = made.out.find(see), to = made.out.find(view);
      REQUIRE((from != std::string::npos && to != std::string::npos));
      const std::string printed = made.out.substr(from + see.size(), to - from - see.size());
      const CommandOutput ran =
          test::run_command(TACTUS_PROGRAM " run " + printed + " --virtual-time --duration 12 --json 2>&1");
      INFO(ran.out);
      REQUIRE(ran.exit_code == 0);
      const auto summary = nlohmann::json::parse(ran.out.substr(ran.out.find('{')));
      CHECK(summary["verdict"] != "bad");
      CHECK(summary["hand"]["force_max_N"] > 0.05);  // the floor is felt
    }
}

TEST_CASE("device new --ask: Enter throughout makes a file, and a mistake is asked for once more") {
  const auto folder = PrivateFolder::make();
  const std::string out = " --out " + (folder.value()->path() / "my_arm.toml").string();
  for (const std::string family : {"", "odrive", "robstride"}) {
    const CommandOutput made = run("new --ask --overwrite" + out, "wristed_arm\n" + family + std::string(30, '\n'));
    INFO(made.out);
    CHECK(made.exit_code == 0);
    CHECK_THAT(made.out, Contains("CAN interfaces, a comma between two [can0,can1]"));
  }
  // a family that is none, one bus twice, then a torque beyond the drives: said, and the rest is kept
  const CommandOutput mended = run("new --ask --overwrite --peak-torque 0.5" + out,
                                   "wristed_arm\nvesc\nodrive\ncan3,can3\ncan3,can4\n0.4\n\n\n900" +
                                       std::string(9, '\n') + std::string(6, '\n') + "5" + std::string(30, '\n'));
  INFO(mended.out);
  CHECK(mended.exit_code == 0);
  CHECK_THAT(mended.out, Contains("'vesc' is none") && Contains("names can3 twice") && Contains("Once more") &&
                             Contains("from axis to axis, m [0.4]"));
}

TEST_CASE("device calibrate: a simulated hand finds the signs and offsets of an arm that is mounted otherwise") {
  for (const std::string& file : {kPointArm, kWristedArm}) {
    CAPTURE(file);
    const std::string text = text::read_file(file, hal::kMaxDeviceFileBytes).value();
    const auto described = hal::parse_device_description(text, file);
    REQUIRE(described.ok());
    std::vector<device::AxisCalibration> mounted;
    for (unsigned i = 0; i < described.value().drives.axes.size(); ++i)
      mounted.push_back({.sign = i % 2 == 0 ? -1.0 : 1.0, .offset_rad = 0.3 - 0.2 * i, .ratio_seen = 1, .doubt = {}});
    const test::TemporaryFile real, out;
    std::ofstream(real.path()) << device::with_calibration(text, mounted);
    const CommandOutput found = run("calibrate --device drives-sim --device-file " + file + " --simulated " +
                                    real.path() + " --out " + out.path());
    INFO(found.out);
    REQUIRE(found.exit_code == 0);
    const auto calibrated = hal::load_device_file(out.path());
    REQUIRE(calibrated.ok());
    const auto& axes = calibrated.value().description.drives.axes;
    for (unsigned i = 0; i < axes.size(); ++i) {
      CHECK(axes[i].sign == mounted[i].sign);
      // The simulated tool begins at its centre: what is left is the quantum of the drive's angle.
      CHECK(axes[i].offset_rad == Approx(mounted[i].offset_rad).margin(2e-3));
    }
  }
}

TEST_CASE("device calibrate: a ratio that is wrong by two is a doubt, and nothing is written") {
  const test::TemporaryFile real, out;
  std::string text = text::read_file(kPointArm, hal::kMaxDeviceFileBytes).value();
  const std::string axis = "[[drives.axis]]";
  text.insert(text.find(axis) + axis.size(), "\nratio = 2");
  std::ofstream(real.path()) << text;
  const CommandOutput found = run("calibrate --device drives-sim --device-file " + kPointArm + " --simulated " +
                                  real.path() + " --out " + out.path());
  CHECK(found.exit_code == 1);
  CHECK_THAT(found.out, Contains("the description's ratio is 1") && Contains("nothing is written"));
  CHECK(out.read().empty());
}
