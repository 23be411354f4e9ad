// The command line: what is wrong is one line on stderr, with the exit status that says what kind of wrong.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/run_command.h"
#include "tests/support/skip.h"

using Catch::Matchers::Contains;

namespace {

struct Output : tactus::test::CommandOutput {
  std::string err;
};

// A file of its own for each process: ctest runs cases side by side.
std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("tactus_cli_" + std::to_string(getpid()) + name)).string();
}

Output run(const std::string& arguments) {
  const std::string error_file = temporary(".err");
  Output output{tactus::test::run_command(std::string(TACTUS_PROGRAM) + " " + arguments + " 2>" + error_file), {}};
  std::ifstream errors(error_file);
  output.err.assign(std::istreambuf_iterator<char>(errors), {});
  std::filesystem::remove(error_file);
  return output;
}

auto lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

const std::string kScenes = TACTUS_SOURCE_DIR "/sim/scenes/";

}  // namespace

TEST_CASE("bad usage is one line on stderr that says what is accepted, and exit 2") {
  const struct {
    const char *arguments, *says;
  } cases[] = {
      {"", "tactus: no command; accepted: "},
      {"scnee", "tactus: scnee: no such command, did you mean scene?; accepted: "},
      {"--jsno", "tactus: --jsno: no such option"},
      {"scene", "tactus scene: no command; accepted: check"},
      {"scene chekc", "tactus scene: chekc: no such command, did you mean check?"},
      {"scene check", "tactus scene check: FILE is required"},
      {"scene check --jsno x.toml", "tactus scene check: --jsno: no such option, did you mean --json?"},
      {"scene check --rate=fast x.toml", "tactus scene check: "},
      {"scene check --rate 1 x.toml", "tactus scene check: "},
      {"scene check a.toml b.toml", "tactus scene check: b.toml: one argument too many"},
      {"hil", "tactus hil: --device is required; accepted: "},
      {"hil --device usbb", "tactus hil: --device: 'usbb' is no device; accepted: "},
      {"hil --device sim --only watchdgo", "tactus hil: --only: 'watchdgo' is no check; accepted: "},
      {"hil --device sim --timing never", "tactus hil: --timing: 'never' is none; accepted: judge, report"},
      {"hil --device usb --virtual-time", "tactus hil: --virtual-time: usb keeps real time; accepted: "},
      {"hil --device sim --force 1000", "tactus hil: --force: 1000 is out of range; accepted: "},
      {"hil --device sim --rate 1", "tactus hil: --rate: 1 is out of range; accepted: "},
      {"device", "tactus device: no command; accepted: ask, new, calibrate"},
      {"device ask", "tactus device ask: --device is required; accepted: "},
      {"timing --load gpu", "tactus timing: --load: 'gpu' is none; accepted: none, cpu, memory, stress-ng"},
      {"timing --duration 1", "tactus timing: --duration: 1 is out of range; accepted: 3 to 1e6 s"},
      {"timing --against rtla", "tactus timing: "},
      {"timing --with-viewer --duration 3", "tactus timing: --duration: 3 s have no window of 1 s with and without"},
      {"timing --with-viewer --against cyclictest", "tactus timing: --with-viewer: its windows are cyclictest's"},
      {"timing --with-viewer --device usb", "tactus timing: --with-viewer: usb misses commands in the pauses"},
      {"timing --with-viewer --certify b.json", "tactus timing: --certify: signs a run without a viewer off"},
      {"export", "tactus export: TAPE is required"},
      {"export /nowhere.tape", "tactus export: no output; accepted: "},
      {"run", "tactus run: SCENE is required; accepted: "},
      {"run --ratio 10.0 x.toml",
       "tactus run: --ratio: '10.0' is none; accepted: a whole number, 0 or more: haptic ticks"},
      {"run --pace 1 " TACTUS_SOURCE_DIR "/sim/scenes/wall.toml", "tactus run: --pace: "},
      {"run --virtual-time --device usb " TACTUS_SOURCE_DIR "/sim/scenes/wall.toml",
       "tactus run: --virtual-time: usb keeps real time; accepted: with --device sim, drives-sim, falcon-sim or "
       "example"},
      {"run --device example --device-file x.toml " TACTUS_SOURCE_DIR "/sim/scenes/wall.toml",
       "tactus run: --device-file: example has properties of its own"},
      {"hil --device falcon-sim --device-file x.toml",
       "tactus hil: --device-file: falcon-sim has properties of its own"},
      {"run --hand pointer --device usb " TACTUS_SOURCE_DIR "/sim/scenes/wall.toml", "tactus run: --hand pointer: "},
      {"run --config /nowhere.toml", "/nowhere.toml: the file: cannot be read; accepted: "},
      {"run --budget /nowhere.json " TACTUS_SOURCE_DIR "/sim/scenes/wall.toml",
       "tactus run: --budget: /nowhere.json: cannot be read; accepted: "},
      {"run --budget / " TACTUS_SOURCE_DIR "/sim/scenes/wall.toml",
       "tactus run: --budget: /: cannot be read; accepted: "},
      {"config", "tactus config: no command; accepted: check"},
      {"config check /nowhere.toml", "/nowhere.toml: the file: cannot be read; accepted: "},
      {"control fly", "tactus control: "},
      {"scene check /nowhere.toml", "tactus: /nowhere.toml: the file: cannot be read; accepted: "},
  };
  for (const auto& c : cases) {
    const Output output = run(c.arguments);
    INFO("tactus " << c.arguments << "\n" << output.err);
    CHECK(output.exit_code == 2);
    CHECK(output.out.empty());
    CHECK(lines(output.err) == 1);
    CHECK_THAT(output.err, Contains(c.says));
    CHECK_THAT(output.err, Contains("accepted: "));
  }
}

TEST_CASE("a core that this machine lacks is one line and exit 3, in each command that pins a thread") {
  const std::string scene = kScenes + "press.toml";
  for (const auto& [command, name] : std::vector<std::pair<std::string, std::string>>{
           {"timing --cpu 1023 --duration 3", "timing"},
           {"run " + scene + " --duration 1 --cpu 1023", "run"},
           {"run " + scene + " --duration 1 --world-threads 1 --world-cpu 1023", "run"},
           {"hil --device sim --cpu 1023", "hil"},
           {"experiment stability-map --cpu 1023 --quick", "experiment stability-map"}}) {
    CAPTURE(command);
    const Output output = run(command);
    CHECK(output.exit_code == 3);
    CHECK(output.out.empty());
    CHECK(lines(output.err) == 1);
    CHECK_THAT(output.err, Contains("tactus " + name + ": --") &&
                               Contains("cpu: this program cannot stay on core 1023; accepted: "));
  }
}

TEST_CASE("with --json bad usage and input are one object with the error, and the same line and status as without") {
  for (const std::string arguments :
       {"run", "run /nowhere.toml", "run --config /nowhere.toml", "run --accuracy best /nowhere.toml",
        "replay /nowhere.tape", "export /nowhere.tape --csv /nowhere.csv", "control state --socket /nowhere",
        "control fly", "tune /nowhere.toml", "timing --duration 1", "timing --scene /nowhere.toml --duration 3",
        "hil --device usbb", "doctor --device x", "scene check /nowhere.toml", "scene chekc",
        "experiment capacity --ratio x"}) {
    const Output plain = run(arguments), output = run(arguments + " --json");
    INFO("tactus " << arguments << " --json\n" << output.err << output.out);
    CHECK(plain.exit_code >= 2);
    CHECK(plain.out.empty());
    CHECK(output.exit_code == plain.exit_code);
    CHECK(output.err == plain.err);
    const auto object = nlohmann::json::parse(output.out, nullptr, false);
    REQUIRE(object.is_object());
    const std::string error = object.value("error", "");
    CHECK_FALSE(error.empty());
    CHECK_THAT(output.err, Contains(error.substr(0, error.find('\n'))));
    CHECK(object.contains("version"));
  }
}

TEST_CASE("a bad scene is a line for each mistake, with file, line and column, and exit 2") {
  const std::string file = temporary(".toml");
  std::ofstream(file) << "titel = 1\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = -1\n";
  const Output output = run("scene check " + file);
  CHECK(output.exit_code == 2);
  CHECK(lines(output.err) == 2);
  CHECK_THAT(output.err, Contains(file + ":1:1: titel: not a key, did you mean title?; accepted: "));
  CHECK_THAT(output.err, Contains(file + ":5:11: [proxy] mass_kg: -1 is not a mass; accepted: "));
  const Output json = run("scene check --json " + file);
  CHECK(json.exit_code == 2);
  CHECK_THAT(json.out, Contains("\"accepted\": false"));
  CHECK_THAT(json.out, Contains("\"line\": 5"));
  std::filesystem::remove(file);
}

TEST_CASE("a scene that will not run well is exit 1, with the reason") {
  const std::string file = temporary(".toml");
  std::ofstream(file) << "[coupling]\nstiffness_N_per_m = 90000\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\n"
                         "mass_kg = 0.1\n[[body]]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 1\n"
                         "position_m = [0.015, 0, 0]\n";
  const Output output = run("scene check " + file);
  CHECK(output.exit_code == 1);
  CHECK_THAT(output.out, Contains("problem: [coupling] translation: 90000 N/m"));
  CHECK_THAT(output.out, Contains("problem: the proxy (line 3) and body 1 (line 7) overlap by 0.005 m"));
  CHECK_THAT(output.out, Contains("verdict: bad"));
  std::filesystem::remove(file);
}

TEST_CASE("a good scene is exit 0, as text and as one JSON object") {
  const Output text = run("scene check " + kScenes + "card_house.toml");
  INFO(text.err);
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Contains("verdict: good"));
  CHECK(text.err.empty());
  const Output json = run("scene check --json " + kScenes + "card_house.toml");
  CHECK(json.exit_code == 0);
  CHECK(json.out.front() == '{');
  CHECK_THAT(json.out, Contains("\"stiffness_allowed_N_per_m\"") && Contains("\"good\": true"));
}

TEST_CASE("hil on the simulated device without a clock is exit 0, as a table, as JSON and as JUnit XML") {
  const std::string junit = temporary(".xml");
  const Output text = run("hil --device sim --virtual-time --only losses,watchdog,e-stop --junit " + junit);
  INFO(text.err);
  CHECK(text.exit_code == 0);
  CHECK(text.err.empty());
  CHECK_THAT(text.out, Contains("watchdog") && Contains("fades at 3, brakes at 10") && Contains("3 good, 0 bad"));
  std::ifstream file(junit);
  const std::string xml{std::istreambuf_iterator<char>(file), {}};
  CHECK_THAT(xml, Contains("tests=\"3\" failures=\"0\" skipped=\"0\""));
  std::filesystem::remove(junit);
  const Output json = run("hil --device sim --virtual-time --only clock --json");
  CHECK(json.exit_code == 0);
  CHECK(json.out.front() == '{');
  CHECK_THAT(json.out, Contains("\"drift_ppm\": 0.0") && Contains("\"verdict\": \"good\""));
  const Output list = run("hil --list");
  CHECK(list.exit_code == 0);
  CHECK_THAT(list.out, Contains("watchdog") && Contains("soak"));
}

TEST_CASE("an output that cannot be written, or that is the scene itself, is refused before the work begins") {
  const std::string mine = temporary(".toml");
  std::filesystem::copy_file(kScenes + "press.toml", mine);
  const auto size = std::filesystem::file_size(mine);
  for (const std::string& command :
       {"run " + mine + " --virtual-time --duration 0.1 --record " + mine, "experiment capacity --quick --csv " + mine,
        "experiment energy-loss --quick --page " + mine, "timing --duration 1 --svg " + mine,
        "timing --duration 1 --certify " + mine, "timing --duration 1 --trace " + mine,
        "hil --device sim --virtual-time --only clock --junit " + mine,
        std::string("experiment capacity --quick --csv /nonexistent/x.csv")}) {
    const Output output = run(command);
    INFO(command << "\n" << output.err);
    CHECK(output.exit_code == 2);
    CHECK(lines(output.err) == 1);
    CHECK(output.out.empty());
    CHECK_THAT(output.err, Contains("; accepted: "));
    CHECK(std::filesystem::file_size(mine) == size);
  }
  std::filesystem::remove(mine);
}

TEST_CASE("a result that standard output does not take is no success") {
  TACTUS_NEEDS(access("/dev/full", W_OK) == 0, "there is no /dev/full");
  const std::string scene = kScenes + "press.toml";
  for (const std::string& command : {"scene check " + scene, "scene check --json " + scene, std::string("scene keys"),
                                     "run " + scene + " --virtual-time --duration 0.1 --json"}) {
    const Output output = run(command + " >/dev/full");
    INFO(command << "\n" << output.err);
    CHECK(output.exit_code == 3);
    CHECK(lines(output.err) == 1);
  }
}

TEST_CASE("a file's name does not command the terminal") {
  for (const char* command : {"run", "config check", "sweep", "replay", "run --config",
                              "run sim/scenes/press.toml --device-file", "scene check"}) {
    const Output output = run(command + std::string(" '\x1b[31mred.toml'"));
    INFO(command << "\n" << output.err);
    CHECK(output.exit_code != 0);
    CHECK(output.err.find('\x1b') == std::string::npos);
  }
}

TEST_CASE("a device that is not there is one line and exit 3, for run and for hil") {
  for (const std::string& command : {std::string("hil --device "), "run " + kScenes + "stack20.toml --device "}) {
    for (const char* device : {"usb:NO-SUCH-SERIAL", "can:nosuchcan0"}) {
      const Output output = run(command + device);
      INFO(command << device << "\n" << output.err);
      CHECK(output.exit_code == 3);
      CHECK(lines(output.err) == 1);
      CHECK(output.out.empty());
    }
  }
}

TEST_CASE("config check lists every mistake: of the file, of the scene, device and budget that it names") {
  const std::string file = temporary(".toml");
  std::ofstream(file) << "scene = \"/nowhere.toml\"\n[device]\nname = \"can:can0\"\nfile = \"/nodevice.toml\"\n"
                         "[cores]\nhaptic = 1000\n[limits]\nbudget = \"/nobudget.json\"\n[control]\n"
                         "socket = \"control\"\nre_arm = true\n";
  const Output output = run("config check " + file);
  INFO(output.err);
  CHECK(output.exit_code == 2);
  CHECK(lines(output.err) == 6);
  for (const char* says : {"/nowhere.toml", "/nodevice.toml", "has no core 1000", "/nobudget.json", "no place for a",
                           "re_arm: not a key, did you mean rearm?"})
    CHECK_THAT(output.err, Contains(says));
  const auto json = nlohmann::json::parse(run("config check --json " + file).out);
  CHECK(json["good"] == false);
  CHECK(json["problems"].size() == 6);
  std::filesystem::remove(file);
}

TEST_CASE("the name of a file that is no UTF-8 does no harm to --json") {
  const std::string scene = temporary("\xff\xfe.toml"), tape = temporary("\xff.tape");
  std::filesystem::copy_file(kScenes + "stack20.toml", scene);
  for (const std::string& command :
       {"run --virtual-time --duration 0.1 --json " + scene + " --record " + tape, "replay --json " + tape,
        "scene check --json " + scene, "config check --json " + scene}) {
    const Output output = run(command);
    INFO(command << "\n" << output.err);
    CHECK(output.exit_code == (command.starts_with("config") ? 2 : 0));
    CHECK(nlohmann::json::parse(output.out, nullptr, /*allow_exceptions=*/false).is_object());
  }
  std::filesystem::remove(scene);
  std::filesystem::remove(tape);
}

TEST_CASE("a service that is told to stop ends well, where a run with a latched fault does not") {
  const std::string config = temporary(".toml");
  std::ofstream(config) << "scene = \"" << kScenes << "stack20.toml\"\n[control]\nsocket = \"" << temporary(".sock")
                        << "\"\n";
  const std::string faulting = std::string(TACTUS_PROGRAM) + " run --inject unplugged@200 ";
  const auto service = tactus::test::run_until({"fault code="}, faulting + "--config " + config + " 2>&1");
  INFO(service.out);
  CHECK(service.exit_code == 0);
  CHECK_THAT(service.out, Contains("device unplugged"));
  const auto by_hand = tactus::test::run_until({"FAULT at "}, faulting + kScenes + "stack20.toml 2>&1");
  INFO(by_hand.out);
  CHECK(by_hand.exit_code == 1);
  std::filesystem::remove(config);
}

TEST_CASE("the program prints its version, commit, target and kernel") {
  const Output output = run("--version");
  CHECK(output.exit_code == 0);
  CHECK_THAT(output.out, Catch::StartsWith("tactus 0.") && Contains("(commit ") && Contains("x86-64") &&
                             Contains("kernel ") && Contains("PREEMPT_RT"));
}

TEST_CASE("help teaches with an example") {
  for (const char* command : {"", "scene ", "scene check "}) {
    const Output output = run(std::string(command) + "--help");
    CHECK(output.exit_code == 0);
    CHECK(output.err.empty());
    CHECK_THAT(output.out, Contains("Example") && Contains("  tactus scene check sim/scenes/card_house.toml"));
  }
}
