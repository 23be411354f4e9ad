// tactus hil --calibrate: a scale's readings, the line through them, the configuration that gets the gain, and the
// command as a user has it, on a simulated Falcon whose readings come from a script.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "hal/device_class.h"
#include "hal/falcon/simulated_falcon.h"
#include "hal/profiles.h"
#include "tests/support/run_command.h"
#include "tests/support/temporary_file.h"
#include "tools/hil/device_line.h"
#include "tools/hil/held_force.h"
#include "tools/hil/scale_calibration.h"

using namespace tactus;
using namespace tactus::hil;
using Catch::Matchers::Contains;
using test::CommandOutput;

namespace {

double newtons(double grams) { return grams * ScaleCalibration::kWeight_N_per_g; }

// A device of `true_gain`, its friction, and a scale that shows whole grams.
GainResult weigh(ScaleCalibration& pushes, double used, double true_gain, double offset_N = 0, double drift_N = 0) {
  while (!pushes.done()) {
    const double shown_g = std::round((pushes.next_command_N() * used / true_gain + offset_N) / newtons(1));
    const std::string doubt = pushes.take(newtons(shown_g));
    INFO(doubt);
    REQUIRE(doubt.empty());
  }
  return pushes.result(drift_N);
}

CommandOutput calibrate(const std::string& options, const std::string& input) {
  const test::TemporaryFile answers;
  std::ofstream(answers.path()) << input;
  return test::run_command(TACTUS_PROGRAM " hil --calibrate " + options + " 2>&1 <" + answers.path());
}

std::string text_of(const test::TemporaryFile& file) {
  const test::Bytes bytes = file.read();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Readings of a Falcon with a gain of 10000 while 5000 is assumed: it makes half of the commanded force, so that the
// program commands twice as much from the second push on. An empty line, Enter, precedes each push.
const std::string kReadings = "12\n\n38\n\n112\n\n165\n\n216\n12\n";

}  // namespace

TEST_CASE("gain: a reading is a number of grams, with a comma or a unit, and nothing else") {
  CHECK(parse_grams("51") == 51);
  CHECK(parse_grams(" 51,5 g\r") == 51.5);
  CHECK(parse_grams("-2") == -2);
  for (const char* wrong : {"", "g", "fifty", "51 kg", "51 52", "1e9", "nan", "inf", "-500", "5001"}) {
    INFO(wrong);
    CHECK_FALSE(parse_grams(wrong).has_value());
  }
}

TEST_CASE(
    "gain: the line through the readings is the gain, whatever it was taken for, and friction does not enter it") {
  for (const double used : {2300.0, 5000.0, 10000.0})
    for (const double true_gain : {2300.0, 4000.0, 10000.0})
      for (const double offset_N : {0.0, -0.1}) {
        CAPTURE(used, true_gain, offset_N);
        ScaleCalibration pushes(used, 8);
        CHECK(pushes.next_command_N() == 0.5);
        if (0.5 * used / true_gain + offset_N < 0.11) continue;  // refused: the first push is too small to be read
        const GainResult result = weigh(pushes, used, true_gain, offset_N);
        CHECK(result.doubt.empty());
        CHECK(result.gain_per_Nm == Approx(true_gain).epsilon(0.02));
        CHECK(result.offset_N == Approx(offset_N).margin(0.02));
      }
}

TEST_CASE("gain: implausible readings are rejected with the reason") {
  ScaleCalibration nothing(10000, 8);
  CHECK_THAT(nothing.take(newtons(2)), Contains("does not rest"));
  ScaleCalibration far_off(10000, 8);
  CHECK_THAT(far_off.take(newtons(900)), Contains("would be 567, and others have 2300 to 10000"));
  ScaleCalibration falling(10000, 8);
  CHECK(falling.take(0.5).empty());
  CHECK_THAT(falling.take(0.4), Contains("after 51 g"));
  ScaleCalibration beyond(10000, 8);
  CHECK_THAT(weigh(beyond, 10000, 1300).doubt, Contains("would be 130"));
  ScaleCalibration bent(10000, 8);
  for (const double shown_N : {0.5, 1.0, 1.5, 3.0}) CHECK(bent.take(shown_N).empty());
  CHECK_THAT(bent.result(0).doubt, Contains("off a line"));
  ScaleCalibration good(10000, 8);
  CHECK_THAT(weigh(good, 10000, 10000, 0.4).doubt, Contains("misses zero"));
  ScaleCalibration moved(10000, 8);
  CHECK_THAT(weigh(moved, 10000, 10000, 0, 0.2).doubt, Contains("20 g more than before"));
}

TEST_CASE("gain: no push is beyond the device's largest force") {
  ScaleCalibration weak(10000, 1.2);
  CHECK(weak.take(0.4).empty());
  CHECK(weak.next_command_N() == 1.2);  // 1.25 N would give what is wanted
}

TEST_CASE("gain: a configuration gets the device's name, and keeps all else") {
  const std::string note = std::string(kMeasuredNote) + " on 2026-01-01";
  CHECK(with_device_name("", "falcon:,4000", note).value() == "[device]\n" + note + "\nname = \"falcon:,4000\"\n");
  const std::string text =
      "scene = \"a.toml\"  # name = no\n\n[device] # mine\n  name = \"falcon\"\ngpio = \"x\"\n[log]\n";
  const std::string once = with_device_name(text, "falcon:,4000", note).value();
  CHECK(once == "scene = \"a.toml\"  # name = no\n\n[device] # mine\n" + note +
                    "\nname = \"falcon:,4000\"\ngpio = \"x\"\n[log]\n");
  const std::string twice = with_device_name(once, "falcon:C:\\n \"v\",4100", note + ": new").value();
  CHECK(twice.find(": new") != std::string::npos);
  CHECK(twice.find("4000") == std::string::npos);
  CHECK_FALSE(with_device_name("[device\n", "falcon", note).ok());
  CHECK_THAT(with_device_name("device = {name = \"falcon\"}\n", "falcon:,4000", note).message(),
             Contains("put name = \"falcon:,4000\" there yourself"));
}

TEST_CASE("gain: the force is held in FORCE, and ends in IDLE, by a fault, and where nothing stands against it") {
  hal::AnyDevice device(std::make_unique<hal::SimulatedFalcon>(hal::HandModel(), 1'000'000));
  auto& falcon = *device.as<hal::SimulatedFalcon>();
  HilOptions options;
  options.stepped = true;
  DeviceUnderTest under_test{device, {}, options};
  {
    HeldForce force(under_test, {0, 0, -1});
    REQUIRE(force.push(2).ok());
    CHECK(falcon.force().z == Approx(-2).epsilon(0.02));
    REQUIRE(force.push(0).ok());
    CHECK_FALSE(falcon.port().green());
    REQUIRE(force.push(1).ok());
    falcon.port().faults.homed = 3;
    CHECK_THAT(force.push(1.5).message(), Contains("does not know the place of an axis"));
    CHECK(norm(falcon.force()) == 0);
    falcon.port().faults.homed = 7;
  }
  hal::AnyDevice loose(
      std::make_unique<hal::SimulatedFalcon>(hal::HandModel({.stiffness_N_per_m = 20}, {}), 1'000'000));
  DeviceUnderTest held_by_little{loose, {}, options};
  {
    HeldForce force(held_by_little, {0, 0, -1});
    CHECK_THAT(force.push(2).message(), Contains("grip moved by 20 mm"));
    CHECK(norm(loose.as<hal::SimulatedFalcon>()->force()) == 0);
  }
}

TEST_CASE("gain: in real time a thread holds the force, and leaves the device in IDLE", "[threads]") {
  hal::AnyDevice device(std::make_unique<hal::SimulatedFalcon>(hal::HandModel(), 1'000'000));
  DeviceUnderTest under_test{device, {}, {}};
  {
    HeldForce force(under_test, {0, 0, -1});
    CHECK(force.push(0.2).ok());
    CHECK(force.trouble().ok());
  }
  CHECK_FALSE(device.as<hal::SimulatedFalcon>()->port().green());
  CHECK(norm(device.as<hal::SimulatedFalcon>()->force()) == 0);
}

TEST_CASE(
    "hil --calibrate: readings become a gain in the configuration, with the date, and wrong lines are asked again") {
  const test::TemporaryFile out;
  std::ofstream(out.path()) << "scene = \"a.toml\"\n[device]\nname = \"falcon-sim:5000\"\n";
  const CommandOutput good = calibrate("--device falcon-sim:5000 --out " + out.path(),
                                       "twelve\n12 kg\n12\n\n\n38\n\n112\n\n165 g\n\n216,0\n12\n");
  INFO(good.out);
  REQUIRE(good.exit_code == 0);
  CHECK_THAT(good.out, Contains("'twelve' is no reading") && Contains("'12 kg' is no reading") &&
                           Contains("'' is no reading") && Contains("Push 4 of 4"));
  const std::string text = text_of(out);
  CHECK_THAT(text, Contains("scene = \"a.toml\"") && Contains("# force gain measured with a kitchen scale on 20") &&
                       Contains("name = \"falcon-sim:10020\"") && !Contains("5000"));
}

TEST_CASE("hil --calibrate: a doubt, an end of the input and a device without a gain write nothing") {
  const test::TemporaryFile out;
  const std::string to = " --out " + out.path();
  const CommandOutput doubt = calibrate("--device falcon-sim" + to, "0\n\n3\n");
  CHECK(doubt.exit_code == 1);
  CHECK_THAT(doubt.out, Contains("does not rest") && Contains("nothing is written"));
  const CommandOutput drift =
      calibrate("--device falcon-sim:5000 --json" + to, kReadings.substr(0, kReadings.size() - 3) + "40\n");
  CHECK(drift.exit_code == 1);
  CHECK_THAT(drift.out,
             Contains("28 g more than before") && Contains("nothing is written") && Contains("\"good\": false"));
  const CommandOutput ended = calibrate("--device falcon-sim" + to, "0\n\n51\n");
  CHECK(ended.exit_code == 2);
  CHECK_THAT(ended.out, Contains("the input ended"));
  CHECK(calibrate("--device falcon-sim" + to, "a\nb\nc\nd\ne\n0\n").exit_code == 2);
  const CommandOutput none = calibrate("--device sim" + to, "");
  CHECK(none.exit_code == 2);
  CHECK_THAT(none.out, Contains("no gain to measure; accepted: falcon, ") && Contains("tactus device calibrate"));
  const CommandOutput script = calibrate("--device falcon" + to, "");
  CHECK(script.exit_code == 3);
  CHECK_THAT(script.out, Contains("asks a person"));
  CHECK(text_of(out).empty());
}
