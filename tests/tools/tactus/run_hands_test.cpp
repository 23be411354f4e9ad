// tactus run of a scene with several hands, from the command line.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/support/run_command.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

namespace {

const std::string kScene = TACTUS_SOURCE_DIR "/tools/examples/two_hands.toml";

CommandOutput tactus_run(const std::string& options, const std::string& scene = kScene) {
  return run_command(std::string(TACTUS_PROGRAM) + " run " + scene + " " + options + " 2>&1");
}

}  // namespace

TEST_CASE("several hands: a summary each, and the worst of them is the program's") {
  const auto json = run_command(std::string(TACTUS_PROGRAM) + " run " + kScene +
                                " --virtual-time --duration 0.9 --device sim --device sim --inject '' "
                                "--inject estop@500 --json 2>/dev/null");
  CHECK(json.exit_code == 1);
  const auto object = nlohmann::json::parse(json.out);
  REQUIRE(object["hands"].size() == 2);
  CHECK(object["level"] == "bad");
  CHECK(object["exit_code"] == 1);
  CHECK(object["real_time"] == false);
  CHECK(object["hands"][0]["number"] == 1);
  CHECK(object["hands"][0]["level"] == "good");
  CHECK(object["hands"][0]["faults"].empty());
  CHECK(object["hands"][1]["number"] == 2);
  CHECK(object["hands"][1]["faults"].size() == 1);
  for (const auto& hand : object["hands"]) CHECK(hand["run"]["ticks"] == 900);
  CHECK(object["hands"][0]["state_hash"] != object["hands"][1]["state_hash"]);

  const auto text = tactus_run("--virtual-time --duration 0.3");
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Contains("hand 1 of 2: Two hands push a block to and fro (good)"));
  CHECK_THAT(text.out, Contains("hand 2 of 2: Two hands push a block to and fro (good)"));
}

TEST_CASE("several hands: what is of one hand alone is refused in one line") {
  const auto refused = [](const std::string& options, const std::string& scene = kScene) {
    const auto output = tactus_run(options, scene);
    INFO(output.out);
    CHECK(output.exit_code == 2);
    CHECK(std::count(output.out.begin(), output.out.end(), '\n') == 1);
    CHECK_THAT(output.out, Contains("accepted: "));
    return output.out;
  };
  CHECK_THAT(refused("--virtual-time --figures force_z_N:what"), Contains("--figures: "));
  CHECK_THAT(refused("--virtual-time --figures force_z_N:rms --control x.sock"),
             Contains("--figures: is of a run that"));
  CHECK_THAT(refused("--budget x.json"), Contains("--budget: certifies one haptic thread"));
  CHECK_THAT(refused("--virtual-time --device sim --device sim --device sim"), Contains("--device: 3 for 2 hands"));
  CHECK_THAT(refused("--virtual-time --device sim --device sim", TACTUS_SOURCE_DIR "/sim/scenes/wall.toml"),
             Contains("--device: 2 for 1 hands"));
  CHECK_THAT(refused("--device can:can0"), Contains("serves one hand"));
  CHECK_THAT(refused("--device dhd:/a --device dhd:/b"), Contains("serves one hand") && Contains("dhd:FOLDER,1234"));
  CHECK_THAT(refused("--virtual-time --inject lost@5 --inject stall@100+20"),
             Contains("hand 2: --inject: stall@100+20") && Contains("in the first --inject"));
  CHECK_THAT(refused("--virtual-time --device sim --device can:can0"), Contains("hand 2: --virtual-time"));
  CHECK_THAT(refused("--virtual-time --coupling static"), Contains("accepted: sub-world"));
  CHECK_THAT(refused("--virtual-time --keep-gains --ratio 40"), Contains("40 to 80 ms late"));
}

TEST_CASE("several hands: figures of each are those of its tape") {
  const TemporaryFile first;
  const std::string second = first.path() + ".2";  // the file has no extension
  const std::string options = "--virtual-time --duration 1.4 --figures force_x_N:min --figures force_x_N:max --json ";
  const auto figures_of = [&](const std::string& more) {
    const auto output =
        run_command(std::string(TACTUS_PROGRAM) + " run " + kScene + " " + options + more + " 2>/dev/null");
    const auto object = nlohmann::json::parse(output.out);
    REQUIRE(object["hands"].size() == 2);
    return std::make_pair(object["hands"][0]["figures"], object["hands"][1]["figures"]);
  };
  const auto figures = figures_of("");
  CHECK(figures == figures_of("--record " + first.path()));
  CHECK(figures.first != figures.second);
  const std::pair<std::string, nlohmann::json> tapes[] = {{first.path(), figures.first}, {second, figures.second}};
  for (const auto& [tape, of_hand] : tapes) {
    const TemporaryFile table;
    const auto exported = run_command(std::string(TACTUS_PROGRAM) + " export " + tape + " --overwrite --csv " +
                                      table.path() + " --signals force_x_N 2>&1");
    INFO(exported.out);
    REQUIRE(exported.exit_code == 0);
    std::ifstream file(table.path());
    double least_N = 0, most_N = 0;
    std::size_t ticks = 0;
    for (std::string line; std::getline(file, line);) {
      const std::size_t comma = line.rfind(',');
      char* end = nullptr;
      const char* const begin = line.c_str() + (comma == std::string::npos ? 0 : comma + 1);
      const double force_N = std::strtod(begin, &end);
      if (end == begin) continue;  // a header
      ++ticks;
      least_N = std::min(least_N, force_N);
      most_N = std::max(most_N, force_N);
    }
    CHECK(ticks == 1400);
    CHECK(of_hand["force_x_N:min"].get<double>() == least_N);
    CHECK(of_hand["force_x_N:max"].get<double>() == most_N);
  }
  (void)std::remove(second.c_str());
}

TEST_CASE("several hands: a stiffness that is too much for two on one body is lowered, and said") {
  const auto output = tactus_run("--virtual-time --duration 0.1 --ratio 20");
  CHECK(output.exit_code == 0);
  CHECK_THAT(output.out, Contains("tactus run: hand 1: stiffness 900 -> ") &&
                             Contains("the most that 2 hands on one light body bear at ratio 20"));
}

TEST_CASE("several hands: a tape each, that tactus replay takes") {
  const TemporaryFile first;
  const std::string second = first.path() + ".2";  // the file has no extension
  const auto output = tactus_run("--virtual-time --duration 0.5 --record " + first.path());
  CHECK(output.exit_code == 0);
  for (const std::string& tape : {first.path(), second}) {
    const auto replayed = run_command(std::string(TACTUS_PROGRAM) + " replay " + tape + " 2>&1");
    INFO(replayed.out);
    CHECK(replayed.exit_code == 0);
  }
  (void)std::remove(second.c_str());
}

TEST_CASE("several hands: scene check looks at each, and shows the stiffness that the run has") {
  const auto output = run_command(std::string(TACTUS_PROGRAM) + " scene check " + kScene + " 2>&1");
  INFO(output.out);
  CHECK(output.exit_code == 0);
  CHECK_THAT(output.out,
             Contains("hands, as tactus run has them\n") && Contains("N/m and 2 N m/rad at ratio 5, as in"));

  const TemporaryFile slow;
  std::ifstream file(kScene);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  text.replace(text.find("ratio = 5 "), 10, "ratio = 20");
  std::ofstream(slow.path()) << text;
  const auto checked = run_command(std::string(TACTUS_PROGRAM) + " scene check " + slow.path() + " 2>&1");
  const auto json = run_command(std::string(TACTUS_PROGRAM) + " scene check --json " + slow.path() + " 2>/dev/null");
  const auto run = tactus_run("--virtual-time --duration 0.01", slow.path());
  const std::string lowered = run.out.substr(run.out.find("hand 1: ") + 8);
  CHECK_THAT(checked.out, Contains(lowered.substr(0, lowered.find('\n'))));
  const auto hands = nlohmann::json::parse(json.out)["report"]["hands"];
  REQUIRE(hands.size() == 2);
  CHECK(hands[1]["number"] == 2);
  CHECK(hands[1]["lowered"] == true);
  CHECK(hands[1]["asked_stiffness_N_per_m"] == 900);
  CHECK(hands[1]["stiffness_N_per_m"] < 900);
}

TEST_CASE("several hands: a configuration names their devices, and the run is logged by hand") {
  const TemporaryFile config;
  std::ofstream(config.path()) << "scene = \"" << kScene
                               << "\"\n[[device]]\nname = \"sim\"\n[[device]]\nname = \"sim\"\n"
                                  "[cores]\npriority = 0\n[control]\narm_at_start = true\n";
  const auto checked = run_command(std::string(TACTUS_PROGRAM) + " config check " + config.path() + " 2>&1");
  CHECK(checked.exit_code == 0);
  CHECK_THAT(checked.out, Contains("good; Two hands push a block to and fro on sim, sim at 1000 Hz"));
  // Told to stop it has done its work, whatever its hands came to.
  const auto output = run_until(
      {"running hand=1 ", "running hand=2 ", "fault hand=2 "},
      std::string(TACTUS_PROGRAM) + " run --config " + config.path() + " --inject '' --inject estop@200 2>&1");
  INFO(output.out);
  CHECK(output.exit_code == 0);
  CHECK_THAT(output.out, Contains("running hand=1 ") && Contains("running hand=2 "));
  CHECK_THAT(output.out, Contains("hand 2 of 2") && Contains("fault hand=2 ") && !Contains("fault hand=1 "));
  CHECK_THAT(output.out, !Contains("FAULT at"));  // the log has it, and no status line

  const std::string arm = "file = \"" TACTUS_SOURCE_DIR "/hal/devices/point_arm_drives.toml\"\n";
  std::ofstream(config.path()) << "scene = \"" << kScene << "\"\n[[device]]\nname = \"drives\"\n"
                               << arm << "[[device]]\nname = \"drives:can0\"\n"
                               << arm;
  const auto one_bus = run_command(std::string(TACTUS_PROGRAM) + " config check " + config.path() + " 2>&1");
  CHECK(one_bus.exit_code == 2);
  CHECK_THAT(one_bus.out, Contains("drives of hand 1 takes can0, too"));

  std::ofstream(config.path()) << "scene = \"" << TACTUS_SOURCE_DIR
                               << "/sim/scenes/wall.toml\"\n[[device]]\n[[device]]\n";
  const auto wrong = run_command(std::string(TACTUS_PROGRAM) + " config check " + config.path() + " 2>&1");
  CHECK(wrong.exit_code == 2);
  CHECK_THAT(wrong.out, Contains("[[device]]: 2 for 1 hands of the scene"));
}

TEST_CASE("several hands: watched virtual time has the bits of unwatched") {
  const TemporaryFile socket;
  const auto hashes = [](const std::string& options) {
    const auto output = run_command(std::string(TACTUS_PROGRAM) + " run " + kScene +
                                    " --virtual-time --duration 0.7 --json " + options + " 2>/dev/null");
    const auto object = nlohmann::json::parse(output.out);
    return std::make_pair(object["hands"][0]["state_hash"].get<std::string>(),
                          object["hands"][1]["state_hash"].get<std::string>());
  };
  CHECK(hashes("") == hashes("--control " + socket.path() + ".sock"));
}
