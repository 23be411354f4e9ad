// Recorded motions: every mistake in a file with its line, the path and its velocities, what a tape needs, what the
// device can follow.
#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "sim/loader/motion_file.h"
#include "sim/loader/scene_load.h"
#include "sim/loader/scene_report.h"

using namespace tactus;
using namespace tactus::sim;
using Catch::Matchers::Contains;

namespace {

const std::string kHeader =
    "time_s,position_x_m,position_y_m,position_z_m,rotation_w,rotation_x,rotation_y,rotation_z\n";
const std::string kProxy = "\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\n";

std::string only_mistake(const std::string& text) {
  const MotionFile motion = parse_motion(text, "m.csv");
  REQUIRE(motion.mistakes.size() == 1);
  return motion.mistakes.front();
}

// A circle of 2 cm about the origin at half a turn a second, once round, turning about z with it.
std::string circle(unsigned rows) {
  std::string text = kHeader;
  for (unsigned i = 0; i < rows; ++i) {
    const double t = 2.0 * i / (rows - 1), angle = i + 1 == rows ? 0 : M_PI * t;
    text += fmt::format("{},{},{},0,{},0,0,{}\n", 5 + t, 0.02 * (std::cos(angle) - 1), 0.02 * std::sin(angle),
                        std::cos(0.5 * angle), std::sin(0.5 * angle));
  }
  return text;
}

struct Folder {
  Folder() : path(std::filesystem::temp_directory_path() / fmt::format("tactus_motion_{}", ::getpid())) {
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
  Scene load(const std::string& hand, text::Diagnostics* diagnostics = nullptr) const {
    write("x.toml", "[hand]\n" + hand + kProxy);
    auto scene = load_scene(path / "x.toml", diagnostics);
    INFO(scene.message());
    REQUIRE(scene.ok());
    return std::move(scene).value();
  }
  std::string wrong(const std::string& hand) const {
    write("x.toml", "[hand]\n" + hand + kProxy);
    const auto scene = load_scene(path / "x.toml");
    REQUIRE_FALSE(scene.ok());
    return scene.message();
  }
  std::filesystem::path path;
};

}  // namespace

TEST_CASE("a recorded motion is read row by row, its times from 0, with or without rotations") {
  const MotionFile motion =
      parse_motion("\xef\xbb\xbf" + kHeader + "7,1,2,3,1,0,0,0\r\n 7.5 , 1,2,4,0.8,0.6,0,0\n\n", "m.csv");
  REQUIRE(motion.mistakes.empty());
  REQUIRE(motion.rows.size() == 2);
  CHECK(motion.rows[0] == MotionRow{0, 1, 2, 3, 1, 0, 0, 0});
  CHECK(motion.rows[1] == MotionRow{0.5, 1, 2, 4, 0.8, 0.6, 0, 0});
  const MotionFile places = parse_motion("time_s,position_x_m,position_y_m,position_z_m\n0,1,2,3\n1,2,3,4\n", "m.csv");
  REQUIRE(places.mistakes.empty());
  CHECK(places.rows[1] == MotionRow{1, 2, 3, 4, 1, 0, 0, 0});
}

TEST_CASE("every mistake in a recorded motion has its line, what is wrong and what is accepted") {
  CHECK_THAT(only_mistake(""), Contains("m.csv:1: column 1 is nothing, not time_s; accepted: time_s,position_x_m"));
  CHECK_THAT(only_mistake("time_s,position_x_mm,position_y_m,position_z_m\n"),
             Contains("m.csv:1: column 2 is \"position_x_mm\", not position_x_m"));
  CHECK_THAT(only_mistake("time_s,position_x_m,position_y_m\n"), Contains("m.csv:1: 3 columns; accepted: "));
  CHECK_THAT(only_mistake("time_s;position_x_m\n0;1\n"), Contains("m.csv:1: column 1 is \"time_s;position_x_m\""));
  CHECK_THAT(only_mistake("0,1,2,3\n1,1,2,3\n"), Contains("m.csv:1: column 1 is \"0\", not time_s"));
  CHECK_THAT(only_mistake(kHeader), Contains("m.csv:1: 0 rows make no motion; accepted: two or more"));
  CHECK_THAT(only_mistake(kHeader + "0,0,0,0,1,0,0,0\n"), Contains("m.csv:2: 1 rows make no motion"));
  const std::string first = kHeader + "0,0,0,0,1,0,0,0\n", last = "9,0,0,0,1,0,0,0\n";
  CHECK_THAT(only_mistake(first + "1,0,0,0,1,0,0\n" + last), Contains("m.csv:3: 7 columns; accepted: 8"));
  CHECK_THAT(only_mistake(first + "\n" + last), Contains("m.csv:3: 0 columns; accepted: 8"));
  CHECK_THAT(only_mistake(first + "1,nan,0,0,1,0,0,0\n" + last),
             Contains("m.csv:3: \"nan\" in position_x_m is not a finite number; accepted: numbers such as 0.25"));
  CHECK_THAT(only_mistake(first + "1,,0,0,1,0,0,0\n" + last), Contains("m.csv:3: nothing in position_x_m"));
  CHECK_THAT(only_mistake(first + "0,0,0,0,1,0,0,0\n" + last),
             Contains("m.csv:3: time 0 s is not after 0 s, the one before; accepted: ascending times"));
  CHECK_THAT(only_mistake(first + "-1,0,0,0,1,0,0,0\n" + last), Contains("m.csv:3: time -1 s is not after 0 s"));
  CHECK_THAT(only_mistake(first + "1,0,0,0,1,1,0,0\n" + last),
             Contains("m.csv:3: the rotation is a quaternion of length 1.41421; accepted: length 1, w first"));
  CHECK_THAT(only_mistake(first + "1,0,0,0,0,0,1,0\n"),
             Contains("m.csv:3: turns by 3.14 rad") && Contains("at most 1.5 rad"));
  CHECK_THAT(only_mistake(first + "1,2e4,0,0,1,0,0,0\n" + last), Contains("m.csv:3: position_x_m is 20000"));
  CHECK_THAT(only_mistake(first + "4000,0,0,0,1,0,0,0\n"),
             Contains("m.csv:3: is 4000 s after the first; accepted: at most 3600 s"));
  CHECK(parse_motion(first + "1,x,0,0,1,0,0,0\n2,y,0,0,1,0,0,0\n" + last, "m.csv").mistakes.size() == 2);
  std::string many = "time_s,position_x_m,position_y_m,position_z_m\n";
  for (std::size_t i = 0; i <= kMaxMotionRows; ++i) many += fmt::format("{},0,0,0\n", 0.001 * static_cast<double>(i));
  CHECK_THAT(only_mistake(many), Contains("m.csv:20002: is a row too many; accepted: at most 20000 rows"));
}

TEST_CASE("a hand that is recorded has the file's path, its velocities by its neighbours, and rests at its ends") {
  const Folder folder;
  folder.write("circle.csv", circle(201));
  const Scene scene = folder.load("file = \"circle.csv\"\n");
  const HandScript& hand = scene.hand;
  CHECK(hand.motion == haptics::HandMotion::kCubic);
  CHECK_FALSE(hand.repeat);
  REQUIRE(hand.path.size() == 201);
  CHECK(hand.path[0].time_s == 0);
  CHECK(hand.path[0].velocity_m_per_s == Vec3d{});
  CHECK(hand.path[200].velocity_m_per_s == Vec3d{});
  for (std::size_t i = 1; i < 200; ++i) {
    const double angle = M_PI * hand.path[i].time_s;
    // A difference over 20 ms of a circle is short by (pi x 10 ms)^2 / 6 of it.
    CHECK(norm(hand.path[i].velocity_m_per_s - 0.02 * M_PI * Vec3d{-std::sin(angle), std::cos(angle), 0}) < 1.1e-5);
    CHECK(norm(hand.path[i].angular_velocity_rad_per_s - Vec3d{0, 0, M_PI}) < 1e-9);
  }
  const Scene again = folder.load("file = \"circle.csv\"\nrepeat = true\n");
  CHECK(norm(again.hand.path[0].velocity_m_per_s - 0.02 * M_PI * Vec3d{0, 1, 0}) < 1.1e-5);
  CHECK(again.hand.path[0].velocity_m_per_s == again.hand.path[200].velocity_m_per_s);
  CHECK(folder.load("file = \"circle.csv\"\ninterpolation = \"linear\"\n").hand.motion == haptics::HandMotion::kLinear);
}

TEST_CASE("where a pause meets a quick move, a recorded hand does not swing out") {
  const Folder folder;
  folder.write(
      "m.csv",
      "time_s,position_x_m,position_y_m,position_z_m\n0,0,0,0\n1,0,0,0\n1.01,0.01,0,0\n1.11,0.02,0,0\n2,1,0,0\n");
  const auto path = folder.load("file = \"m.csv\"\n").hand.path;
  CHECK(path[1].velocity_m_per_s == Vec3d{});  // before it there is a pause
  // The parabola has (0.1 x 1 + 0.01 x 0.1) / 0.11 m/s there; the slower leg has 0.1.
  CHECK(norm(path[2].velocity_m_per_s - Vec3d{0.3, 0, 0}) < 1e-12);
}

TEST_CASE("the source of a scene with a recorded motion needs no file any more") {
  const Folder folder;
  folder.write("circle.csv", circle(50));
  const Scene scene = folder.load("file = \"circle.csv\"\n");
  std::filesystem::remove(folder.path / "circle.csv");
  const auto again = parse_scene(scene.source, "y");
  INFO(again.message());
  REQUIRE(again.ok());
  CHECK(again.value().source == scene.source);
  REQUIRE(again.value().hand.path.size() == scene.hand.path.size());
  for (std::size_t i = 0; i < scene.hand.path.size(); ++i) {
    const ScriptWaypoint &a = scene.hand.path[i], &b = again.value().hand.path[i];
    CHECK(a.time_s == b.time_s);
    CHECK(a.position_m == b.position_m);
    CHECK(a.rotation_vector_rad == b.rotation_vector_rad);
    CHECK(a.velocity_m_per_s == b.velocity_m_per_s);
    CHECK(a.angular_velocity_rad_per_s == b.angular_velocity_rad_per_s);
  }
}

TEST_CASE("mistakes about a recorded motion name the scene's line and the file's") {
  const Folder folder;
  folder.write("bad.csv", kHeader + "0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n1,0,0,0,2,0,0,0\n");
  const std::string two = folder.wrong("file = \"bad.csv\"\n");
  CHECK_THAT(two, Contains("x.toml:2:8: [hand] file: ") && Contains("bad.csv:3: time 0 s is not after 0 s"));
  CHECK_THAT(two, Contains("bad.csv:4: the rotation is a quaternion of length 2"));
  CHECK_THAT(folder.wrong("file = \"none.csv\"\n"),
             Contains("none.csv: there is no such file; accepted: a path from the scene"));
  CHECK_THAT(folder.wrong("file = \"\"\n"), Contains("is no name of a file"));
  folder.write("good.csv", circle(21));
  CHECK_THAT(folder.wrong("file = \"good.csv\"\npath = []\n"),
             Contains("path: there is a file already; accepted: path or file"));
  CHECK_THAT(folder.wrong("file = \"good.csv\"\ninterpolation = \"spline\"\n"), Contains("cubic, linear"));
  CHECK_THAT(folder.wrong("file = \"good.csv\"\n#" + std::string(kMaxSceneBytes - 300, ' ') + "\n"),
             Contains("bytes with what its files hold; accepted: at most 4194304 bytes: fewer rows"));
  CHECK_THAT(folder.wrong("interpolation = \"cubic\"\n"), Contains("interpolation: there is no file"));
  CHECK_THAT(folder.wrong("fiel = \"m.csv\"\n"), Contains("did you mean file?") && Contains(" file, mass_kg, "));
  folder.write("away.csv", "time_s,position_x_m,position_y_m,position_z_m\n0,0,0,0\n1,0.1,0,0\n");
  CHECK_THAT(folder.wrong("file = \"away.csv\"\nrepeat = true\n"),
             Contains("[hand] file: repeats, and does not end where it begins"));
  CHECK_THAT(parse_scene("[hand]\nfile = \"away.csv\"\n" + kProxy, "x.toml").message(),
             Contains("only a scene that is a file itself may name one"));
  CHECK_THAT(
      parse_scene("[hand]\nfile = \"m\"\n" + kProxy + "[[motion_file]]\nname = \"m\"\nrows = [0, 0]\n", "x").message(),
      Contains("[motion_file.1] rows: 2 numbers make no motion"));
}

TEST_CASE("a motion that is too fast for the device, or beyond its reach, is a problem with the row's line") {
  const Folder folder;
  haptics::DeviceProperties device;
  device.max_speed_m_per_s = 1;
  device.max_angular_speed_rad_per_s = 10;
  device.workspace_radius_m = 0.3;
  const auto problem = [&](const std::string& rows, const std::string& hand = "") {
    folder.write("m.csv", kHeader + rows);
    const auto report = report_on(folder.load("file = \"m.csv\"\n" + hand), device, 1e-3);
    REQUIRE(report.problems.size() == 1);
    return report.problems.front();
  };
  const std::string first = "0,0,0,0,1,0,0,0\n1,0.01,0,0,1,0,0,0\n";
  CHECK_THAT(problem(first + "1.05,0.11,0,0,1,0,0,0\n2,0.11,0,0,1,0,0,0\n", "interpolation = \"linear\"\n"),
             Contains("[hand] file m.csv:4: asks for 2 m/s; accepted: at most 1 m/s, what the device can do"));
  CHECK_THAT(problem(first + "1.05,0.01,0,0,0.8,0.6,0,0\n2,0.01,0,0,0.8,0.6,0,0\n", "interpolation = \"linear\"\n"),
             Contains("[hand] file m.csv:4: asks for 25.7 rad/s; accepted: at most 10 rad/s"));
  CHECK_THAT(problem(first + "3,0.5,0,0,1,0,0,0\n4,0.2,0,0,1,0,0,0\n"),
             Contains("[hand] file m.csv:4: leaves the device's workspace: 0.5 m from its middle"));
  // 0.9 m/s in the mean between two pauses, where it rests: a cubic has 1.5 times that in the middle.
  CHECK_THAT(problem("0,0,0,0,1,0,0,0\n0.1,0,0,0,1,0,0,0\n0.2,0.09,0,0,1,0,0,0\n0.3,0.09,0,0,1,0,0,0\n"),
             Contains("m.csv:4: asks for 1.35 m/s"));
  const auto report = report_on(folder.load("file = \"m.csv\"\n"), device, 1e-3);
  CHECK_THAT(to_text(report), Contains("m.csv, 4 rows, cubic in between"));
}
