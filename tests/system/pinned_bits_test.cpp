// Committed hashes: each scene that ships with each coupling and each border. A change of the code that means to change
// no result changes no line of pinned_bits.txt; one that does says why in its commit. Each run leaves what it observed
// in tests/pinned_bits of the build folder: cat build/release/tests/pinned_bits/* > tests/system/pinned_bits.txt
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "rt/base/hash.h"
#include "sim/model/choice_names.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

struct Row {
  std::string scene, coupling, border;
  unsigned members{0};  // 0: the scene's own
  std::uint64_t ticks{0};
  std::string hash;  // 16 hexadecimal digits
};

const char* const kHeading =
    "# scene, coupling, border, members (0: the scene's own), ticks, hash: see pinned_bits_test.cpp\n";
const std::string kFile = TACTUS_SOURCE_DIR "/tests/system/pinned_bits.txt";

std::vector<Row> read_rows() {
  std::ifstream file(kFile);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    Row row;
    words >> row.scene >> row.coupling >> row.border >> row.members >> row.ticks >> row.hash;
    INFO(line);
    REQUIRE_FALSE(words.fail());
    rows.push_back(row);
  }
  return rows;
}

// The chain of every tick's status and wrench, and the state of both worlds after the last.
std::string observed(const Row& row) {
  session::RunOptions options = virtual_options();
  options.coupling = sim::parse_coupling_scheme(row.coupling).value();
  options.border = sim::parse_border_mode(row.border).value();
  options.members = row.members;
  auto session = make_session(scene_file(row.scene), options);
  Fnv1a hash;
  run(*session, row.ticks, [&](const loop::TickOutput& out) {
    hash.add(out.status);
    hash.add(out.members);
    hash.add(out.border);
    const auto& wrench = out.command.wrench;
    for (const Vec3d& v : {wrench.force, wrench.torque}) {
      hash.add(v.x);
      hash.add(v.y);
      hash.add(v.z);
    }
    return true;
  });
  hash.add(session->loop->state_hash());
  if (session->global != nullptr) hash.add(session->global->state_hash());
  std::ostringstream text;
  text << std::hex << std::setfill('0') << std::setw(16) << hash.value();
  return text.str();
}

// The row's line without its hash.
std::string line_of(const Row& row) {
  std::ostringstream line;
  line << row.scene << ' ' << row.coupling << ' ' << row.border << ' ' << row.members << ' ' << row.ticks << ' ';
  return line.str();
}

void check_scenes(std::size_t part, std::size_t parts) {
  std::map<std::string, std::vector<Row>> scenes;
  for (const Row& row : read_rows()) scenes[row.scene].push_back(row);
  const auto folder = std::filesystem::path(TACTUS_HASH).parent_path() / "pinned_bits";
  std::filesystem::create_directories(folder);
  std::ofstream seen(folder / std::to_string(part));
  if (part == 0) seen << kHeading;
  std::size_t number = 0;
  for (const auto& [scene, rows] : scenes) {
    const std::size_t first = number++ * parts / scenes.size();
    if (first != part) continue;
    for (const Row& row : rows) {
      const std::string hash = observed(row);
      seen << line_of(row) << hash << '\n';
      INFO(line_of(row) << hash);
      CHECK(hash == row.hash);
    }
  }
}

}  // namespace

TEST_CASE("pinned bits: the first quarter of the scenes", "[pinned][no-asan]") { check_scenes(0, 4); }
TEST_CASE("pinned bits: the second quarter of the scenes", "[pinned][no-asan]") { check_scenes(1, 4); }
TEST_CASE("pinned bits: the third quarter of the scenes", "[pinned][no-asan]") { check_scenes(2, 4); }
TEST_CASE("pinned bits: the last quarter of the scenes", "[pinned][no-asan]") { check_scenes(3, 4); }

// Also in the builds that leave out the others: the second compiler's.
TEST_CASE("pinned bits: a stack with every coupling and border", "[pinned]") {
  unsigned compared = 0;
  for (const Row& row : read_rows()) {
    if (row.scene != "stack20.toml") continue;
    INFO(line_of(row));
    CHECK(observed(row) == row.hash);
    ++compared;
  }
  CHECK(compared >= haptics::kCouplingSchemes.size());
}

TEST_CASE("every scene has a pinned row for every coupling, and for every border where the sub-world has one") {
  const auto rows = read_rows();
  const auto has = [&](const std::string& scene, std::string_view coupling, std::string_view border) {
    return std::any_of(rows.begin(), rows.end(), [&](const Row& r) {
      return r.scene == scene && r.coupling == coupling && (border.empty() || r.border == border);
    });
  };
  for (const auto& entry : std::filesystem::directory_iterator(TACTUS_SOURCE_DIR "/sim/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const std::string scene = entry.path().filename();
    for (const auto coupling : haptics::kCouplingSchemes) {
      INFO(scene << ' ' << sim::name_of(coupling));
      CHECK(has(scene, sim::name_of(coupling), ""));
    }
    for (const auto border : physics::kBorderModes) {
      INFO(scene << ' ' << sim::name_of(border));
      CHECK(has(scene, "sub-world", sim::name_of(border)));
    }
  }
}
