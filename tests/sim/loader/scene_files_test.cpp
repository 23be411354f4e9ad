// The scenes that come with the program: each loads without a word, and each will run well.
#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"

using namespace tactus;
using namespace tactus::sim;

namespace {

std::set<std::filesystem::path> scene_files() {
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(TACTUS_SOURCE_DIR "/sim/scenes"))
    if (entry.path().extension() == ".toml") files.insert(entry.path());
  return files;
}

Scene load(const std::string& name) {
  auto scene = load_scene(std::filesystem::path(TACTUS_SOURCE_DIR "/sim/scenes") / (name + ".toml"));
  INFO(scene.message());
  REQUIRE(scene.ok());
  return std::move(scene).value();
}

// The class of device that all of them name; the figures that their workspaces and gains were chosen for.
haptics::DeviceProperties device() { return {}; }

}  // namespace

TEST_CASE("every scene of the program loads without a mistake or a warning") {
  const auto files = scene_files();
  REQUIRE(files.size() >= 8);
  for (const auto& file : files) {
    text::Diagnostics diagnostics;
    const auto scene = load_scene(file, &diagnostics);
    INFO(diagnostics.message() << diagnostics.warning_message());
    REQUIRE(scene.ok());
    CHECK(diagnostics.warnings.empty());
    CHECK_FALSE(scene.value().title.empty());
    CHECK(scene.value().name == file.stem().string());
  }
}

TEST_CASE("every scene of the program has a stable coupling, a path within reach and no overlap at the start") {
  for (const auto& file : scene_files()) {
    const auto scene = load_scene(file);
    REQUIRE(scene.ok());
    const auto report = report_on(scene.value(), device(), 1e-3);
    INFO(to_text(report));
    CHECK(report.good());
    CHECK(report.start.deepest_m < 1e-6);
  }
}

TEST_CASE("the heap hangs together: its contacts link more than twice as many bodies as may be members") {
  const auto scene = load("pile700");
  const auto report = report_on(scene, device(), 1e-3);
  CHECK(report.bodies.dynamic == 701);
  CHECK(scene.members * 2 < 700);
  // A connected graph of 700 cubes and the ground has at least as many edges as cubes.
  CHECK(report.start.contacts >= 700);
}
