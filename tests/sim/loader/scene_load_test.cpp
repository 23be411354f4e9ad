// What is wrong with a scene is said with its place; what is right is read as written.
#include "sim/loader/scene_load.h"
#include "sim/loader/body_label.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>

using namespace tactus;
using namespace tactus::sim;
using Catch::Matchers::Contains;

namespace {

// Behind the text of a test, so that lines and columns are those of the test's text.
const std::string kProxy = "\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\n";

text::Diagnostics diagnose(const std::string& text) {
  text::Diagnostics diagnostics;
  const auto scene = parse_scene(text, "x.toml", &diagnostics);
  CHECK(scene.ok() == diagnostics.ok());
  return diagnostics;
}

Scene good(const std::string& text) {
  auto scene = parse_scene(text, "dir/x.toml");
  INFO(scene.message());
  REQUIRE(scene.ok());
  return std::move(scene).value();
}

std::string box(const std::string& more) { return "[[body]]\nshape = \"box\"\nsize_m = [1, 1, 1]\n" + more; }

struct Case {
  std::string text;
  unsigned line, column;
  std::string where, what, accepted;
};

}  // namespace

TEST_CASE("every kind of mistake is named with its line, column, key and what is accepted") {
  const std::string hand = "[hand]\nrepeat = false\npath = [\n";
  const Case cases[] = {
      {"title = 3", 1, 9, "title", "3 is not text", "one line of at most 200"},
      {"title = \"a\\nb\"", 1, 9, "title", "line breaks", "one line"},
      {"titel = \"a\"", 1, 1, "titel", "did you mean title?", "title"},
      {"effects = 3", 1, 11, "effects", "not an array", "an array"},
      {"effects = [\"gravty\"]", 1, 12, "effects", "did you mean gravity?", "gravity, friction, gyroscopic, sleeping"},
      {"effects = [3]", 1, 12, "effects", "3 is not an effect", "gravity"},
      {"effects = [\"friction\", \"friction\"]", 1, 24, "effects", "there twice", "once"},
      {"gravity_m_per_s2 = [0, 0, -9.81]", 1, 20, "gravity_m_per_s2", "the effect gravity is not declared",
       "\"gravity\" among the effects"},
      {"effects = [\"gravity\"]\ngravity_m_per_s2 = [0, 0, nan]", 2, 20, "gravity_m_per_s2", "nan in z", "[x, y, z]"},
      {"effects = [\"gravity\"]\ngravity_m_per_s2 = [0, inf, 0]", 2, 20, "gravity_m_per_s2", "inf in y", "<= 1000"},
      {"effects = [\"gravity\"]\ngravity_m_per_s2 = [0, 0]", 2, 20, "gravity_m_per_s2", "an array of 2", "[x, y, z]"},
      {"simulation = 1", 1, 14, "simulation", "1 is not a table", "[simulation]"},
      {"[simulation]\nratio = 10.0", 2, 9, "[simulation] ratio", "10 is written with a decimal point", "such as 10"},
      {box("mass_kg = 1\nrotation_deg = [0, 0, 90]"), 5, 1, "[body.1] rotation_deg",
       "did you mean rotation_vector_rad?", "rotation_vector_rad and "},
      {"[simulation]\nratio = 0", 2, 9, "[simulation] ratio", "0 is not a ratio", "a whole number from 1 to 64"},
      {"[simulation]\nratio = 2.5", 2, 9, "[simulation] ratio", "2.5 is not", "a whole number"},
      {"[simulation]\nratio = \"ten\"", 2, 9, "[simulation] ratio", "\"ten\" is not", "a whole number"},
      {"[simulation]\nmembers = 257", 2, 11, "[simulation] members", "257", "from 1 to 256"},
      {"[simulation]\ncontact_hertz_Hz = 251", 2, 20, "[simulation] contact_hertz_Hz", "too stiff", "at most 250 Hz"},
      {"[simulation]\nglobal_sub_steps_per_tick = 8\nsub_steps = 2\ncontact_hertz_Hz = 501", 4, 20,
       "[simulation] contact_hertz_Hz", "too stiff for 2 haptic and 8 global", "at most 500 Hz"},
      {"[simulation]\nfriction_sweeps = \"evry\"", 2, 19, "[simulation] friction_sweeps", "did you mean every?",
       "auto, relax, every"},
      {"[device]\nprofile = \"desk3\"", 2, 11, "[device] profile", "did you mean desk3d?", "virtuose6d, desk3d"},
      {"[device]\nmotion_scale = 0", 2, 16, "[device] motion_scale", "0 is not a scale", ">= 0.01"},
      {"[coupling]\nstiffness = 3", 2, 1, "[coupling] stiffness", "did you mean stiffness_N_per_m?",
       "damping_Ns_per_m"},
      {"[coupling]\ndamping_Ns_per_m = -1", 2, 20, "[coupling] damping_Ns_per_m", "-1 is not a damping", ">= 0"},
      {"[hand]\nmass_kg = -1", 2, 11, "[hand] mass_kg", "-1 is not a mass", ">= 0"},
      {hand + "{time_s = 1, position_m = [0, 0, 0]}]", 4, 11, "[hand] path.1 time_s", "begins at 1 s", "0"},
      {hand + "{position_m = [0, 0, 0]}]", 4, 1, "[hand] path.1 time_s", "missing", "a number"},
      {hand + "{time_s = 0, position_m = [0, 0, 0]},\n{time_s = 0, position_m = [0, 0, 0]}]", 5, 11,
       "[hand] path.2 time_s", "0 s is not after 0 s", "ascending"},
      {"[hand]\npath = [\n{time_s = 0, position_m = [0, 0, 0]}, {time_s = 1, position_m = [0, 0, 1]}]", 2, 8,
       "[hand] path", "does not end where it begins", "repeat = false"},
      {"[[body]]\nmass_kg = 1", 1, 1, "[body.1] shape", "missing",
       "box, sphere, capsule, cylinder, cone, hull, compound, plane"},
      {"[[body]]\nshape = \"sfere\"\nradius_m = 1\nmass_kg = 1", 2, 9, "[body.1] shape", "did you mean sphere?", "box"},
      {"[[body]]\nshape = \"sphere\"\nmass_kg = 1", 1, 1, "[body.1] radius_m", "missing", "a number"},
      {"[[body]]\nshape = \"capsule\"\nradius_m = 1\nmass_kg = 1", 1, 1, "[body.1] length_m", "missing", "cap"},
      {box("mass_kg = -1"), 4, 11, "[body.1] mass_kg", "-1 is not a mass", "a number >= 1e-06 and <= 1e+06"},
      {box("mass_kg = 0"), 4, 11, "[body.1] mass_kg", "0 is not a mass", ">= 1e-06"},
      {box(""), 1, 1, "[body.1] mass_kg", "missing", "density_kg_per_m3"},
      {box("mass_kg = 1\ndensity_kg_per_m3 = 1"), 5, 21, "[body.1] density_kg_per_m3", "a mass already", "mass_kg or"},
      {"[[body]]\nshape = \"sphere\"\nradius_m = 0.0001\ndensity_kg_per_m3 = 1", 4, 21, "[body.1] density_kg_per_m3",
       "gives a mass of 4.18", ">= 1e-06"},
      {box("fixed = true\nmass_kg = 1"), 5, 11, "[body.1] mass_kg", "a fixed body has none", "no such key"},
      {box("fixed = \"yes\"\nmass_kg = 1"), 4, 9, "[body.1] fixed", "neither true nor false", "true, false"},
      {"[[body]]\nshape = \"plane\"\nfixed = false", 3, 9, "[body.1] fixed", "a plane never moves", "true"},
      {box("mass_kg = 1\nfriction = 0.5"), 5, 12, "[body.1] friction", "the effect friction is not declared",
       "\"friction\" among the effects"},
      {box("mass_kg = 1\nfriction = 11"), 5, 12, "[body.1] friction", "11 is not a coefficient", "<= 10"},
      {box("mass_kg = 1\nposition_m = [0, 0, 1e5]"), 5, 14, "[body.1] position_m", "100000 in z", "<= 10000"},
      {box("mass_kg = 1\nvelocity_m_per_s = [200, 0, 0]"), 5, 20, "[body.1] velocity_m_per_s", "200 in x", "<= 100"},
      {box("mass_kg = 1\nfricton = 0.5"), 5, 1, "[body.1] fricton", "did you mean friction?", "friction and "},
      {box("mass_kg = 1\n") + box("mass_kg = -2"), 8, 11, "[body.2] mass_kg", "-2 is not a mass", ">="},
      {"body = [3]", 1, 9, "[body.1]", "3 is not a table", "a table"},
      {"[[generate]]\ncount = 3", 1, 1, "[generate.1] kind", "missing", "wall, pile, tower, card_house, domino_row"},
      {"[[generate]]\nkind = \"cardhouse\"", 2, 8, "[generate.1] kind", "did you mean card_house?", "wall, pile"},
      {"[[generate]]\nkind = \"pile\"\ncount = 100001", 3, 9, "[generate.1] count", "100001", "from 1 to 100000"},
      {"[[generate]]\nkind = \"pile\"\nseed = -1", 3, 8, "[generate.1] seed", "-1 is not a seed", ">= 0"},
      {"[[generate]]\nkind = \"tower\"\nlayers = 1000\nblocks_per_layer = 100", 2, 8, "[generate.1] kind",
       "makes 100000 bodies", "99999 more: a scene has at most 100000"},
      {"[[generate]]\nkind = \"wall\"\ngap_m = 0.1", 3, 9, "[generate.1] gap_m", "too wide", "a fifth"},
      {"[[generate]]\nkind = \"card_house\"\nangle_rad = 0.5", 3, 13, "[generate.1] angle_rad", "wide",
       "a smaller angle"},
      {"[[generate]]\nkind = \"card_house\"\ngap_m = 0.01", 3, 9, "[generate.1] gap_m", "nothing to rest on",
       "at most"},
      {"[[generate]]\nkind = \"domino_row\"\nspacing_m = 0.001", 3, 13, "[generate.1] spacing_m", "thickness", ">="},
      {"[[generate]]\nkind = \"pile\"\ncubes_m = 1", 3, 1, "[generate.1] cubes_m", "did you mean cube_m?",
       "cube_m and "},
      {"title = ", 1, 9, "title", "has no value", "true or false, text in quotes"},
      {"title = mine # one", 1, 9, "title", "mine is no value", "text in quotes"},
      {box("kinematic = yes"), 4, 13, "kinematic", "yes is no value, did you mean true?", "true, false"},
      {box("kinematic = False"), 4, 13, "kinematic", "False is no value, did you mean false?", "true, false"},
      {box("mass_kg = 1,5"), 4, 12, "mass_kg", "1,5 is no value", "a number such as 0.5"},
      {"title = \"a\"\n# b\n[\n", 3, 1, "the file", "not complete", "TOML"},
      {"title = \"a\"\ntitle = \"b\"", 2, 1, "title", "is set a second time", "once"},
      {"[simulation]\n[simulation]\nratio = 4", 2, 1, "[simulation]", "a second time", "begins with [[simulation]]"},
      {"[body]\nshape = \"box\"", 1, 1, "body", "a table is not an array", "[[body]] for each"},
      {"title = \"a\neffects = []", 1, 11, "the file", "a text without its closing quote", "\"text\""},
      {"effects = [gravity]", 1, 12, "the file", "no value begins like this", "text in quotes"},
  };
  for (const Case& c : cases) {
    const auto found = diagnose(c.text + kProxy);
    INFO(c.text << "\n-> " << found.message());
    REQUIRE(found.mistakes.size() == 1);
    const text::Mistake& m = found.mistakes.front();
    CHECK(m.line == c.line);
    CHECK(m.column == c.column);
    CHECK(m.where == c.where);
    CHECK_THAT(m.what, Contains(c.what));
    CHECK_THAT(m.accepted, Contains(c.accepted));
  }
}

TEST_CASE("a message is one line for each mistake, in the order of the file") {
  const auto found = diagnose("[proxy]\nshape = \"sphere\"\nradius_m = 0\nmass_kg = -1\n");
  CHECK(found.message() ==
        "x.toml:3:12: [proxy] radius_m: 0 is not a length; accepted: a number >= 0.0001 and <= 1000\n"
        "x.toml:4:11: [proxy] mass_kg: -1 is not a mass; accepted: a number >= 1e-06 and <= 1e+06");
}

TEST_CASE("mistakes are in the order of the file, whatever order its tables are read in") {
  const auto found =
      diagnose("[hand]\nmass_kg = -1\n[coupling]\ndamping_Ns_per_m = -1\n[simulation]\nratio = 0" + kProxy);
  REQUIRE(found.mistakes.size() == 3);
  CHECK(found.mistakes[0].line == 2);
  CHECK(found.mistakes[1].line == 4);
  CHECK(found.mistakes[2].line == 6);
}

TEST_CASE("a text is as long as its characters, whatever bytes each takes") {
  std::string longest, longer;
  while (diagnose("title = \"" + longest + "x\"" + kProxy).mistakes.empty()) longest += "x";
  REQUIRE(longest.size() > 20);
  std::string umlauts;
  for (std::size_t i = 0; i < longest.size(); ++i) umlauts += "\u00fc";
  REQUIRE(umlauts.size() == 2 * longest.size());
  CHECK(diagnose("title = \"" + umlauts + "\"" + kProxy).mistakes.empty());
  CHECK(diagnose("title = \"" + umlauts + "x\"" + kProxy).mistakes.size() == 1);
}

TEST_CASE("beside the key that was meant a long list of keys is a number, a short one is there") {
  const std::string far = diagnose(box("mass_kg = 1\nzzzz = 1") + kProxy).message();
  CHECK_THAT(far, Contains("zzzz: not a key; accepted: ") && Contains("mass_kg") && Contains("size_m"));
  const std::string near = diagnose(box("mass_kg = 1\nfricton = 1") + kProxy).message();
  CHECK(near.size() < 110);
  CHECK_THAT(diagnose("[coupling]\nstiffness = 1" + kProxy).message(),
             Contains("did you mean stiffness_N_per_m?; accepted: damping_Nms_per_rad, damping_Ns_per_m, "));
}

TEST_CASE("a line stays a line whatever a key holds") {
  const auto found = diagnose("\"a\\nb\\u001b[31m\" = 1" + kProxy);
  REQUIRE(found.mistakes.size() == 1);
  CHECK(found.message().find('\n') == std::string::npos);
  CHECK(found.message().find('\x1b') == std::string::npos);
}

TEST_CASE("a scene needs a proxy that can move") {
  CHECK_THAT(diagnose("").message(), Contains("proxy: missing"));
  CHECK_THAT(diagnose("[proxy]\nshape = \"plane\"").message(), Contains("[proxy] shape"));
  CHECK_THAT(diagnose("[proxy]\nshape = \"sphere\"\nradius_m = 1\nmass_kg = 1\nfixed = true").message(),
             Contains("[proxy] fixed: not a key"));
}

TEST_CASE("ids follow the file: the proxy, the bodies, what is generated") {
  const auto scene = good(
      "effects = [\"friction\"]\n"
      "[[generate]]\nkind = \"tower\"\nlayers = 2\nblocks_per_layer = 3\nposition_m = [0, 0, 5]\n"
      "[[generate]]\nkind = \"domino_row\"\ncount = 4\n"
      "[[body]]\nshape = \"plane\"\nfriction = 0.5\n"
      "[[body]]\nshape = \"sphere\"\nradius_m = 0.1\nmass_kg = 3\n" +
      kProxy);
  REQUIRE(scene.bodies.size() == 1 + 2 + 6 + 4);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) CHECK(scene.bodies[i].id == i);
  CHECK(scene.proxy == 0);
  CHECK(scene.bodies[0].gravity_scale == 0);
  CHECK(scene.bodies[1].shape.kind == physics::ShapeKind::kPlane);
  CHECK(scene.bodies[1].kind == physics::BodyKind::kFixed);
  CHECK(scene.bodies[2].mass == 3);
  CHECK(scene.bodies[2].gravity_scale == 1);
  REQUIRE(scene.generated.size() == 2);
  CHECK(scene.generated[0].first == 3);
  CHECK(scene.generated[0].count == 6);
  CHECK(scene.generated[1].first == 9);
  CHECK(scene.generated[1].count == 4);
  CHECK(scene.bodies[3].motion.pose.position.z == Approx(5 + 0.5 * 0.015));
  CHECK(scene.name == "x");
}

TEST_CASE("sizes are full edge lengths, a density times the volume is the mass, and the source is kept") {
  const std::string text =
      "[[body]]\nshape = \"box\"\nsize_m = [0.2, 0.4, 0.6]\ndensity_kg_per_m3 = 1000\n"
      "rotation_vector_rad = [0, 0, 1.5707963267948966]\nvelocity_m_per_s = [1, 2, 3]\n"
      "[[body]]\nshape = \"capsule\"\nradius_m = 0.1\nlength_m = 0.5\nmass_kg = 1\n" +
      kProxy;
  const auto scene = good(text);
  const auto& b = scene.bodies[1];
  CHECK(b.shape.half_extents == Vec3d{0.1, 0.2, 0.3});
  CHECK(b.mass == Approx(48));
  CHECK(b.inertia.x == Approx(48.0 / 12 * (0.4 * 0.4 + 0.6 * 0.6)));
  CHECK(rotate(b.motion.pose.rotation, Vec3d{1, 0, 0}).y == Approx(1));
  CHECK(b.motion.velocity.linear == Vec3d{1, 2, 3});
  CHECK(scene.bodies[2].shape.half_length == Approx(0.25));
  CHECK(scene.source == text);
}

TEST_CASE("an effect that is not declared is off, and one that nothing uses is a warning") {
  const auto plain = good(kProxy);
  CHECK_FALSE((plain.effects.gravity || plain.effects.friction || plain.effects.gyroscopic));
  CHECK(plain.gravity_m_per_s2 == Vec3d{});
  const auto found = diagnose("effects = [\"gravity\", \"friction\", \"gyroscopic\"]" + kProxy);
  REQUIRE(found.warnings.size() == 3);
  CHECK_THAT(found.warning_message(), Contains("\"gravity\" is declared and not used: no body falls"));
  CHECK_THAT(found.warning_message(), Contains("\"friction\" is declared and not used"));
  CHECK_THAT(found.warning_message(), Contains("\"gyroscopic\" is declared and not used"));
  CHECK(diagnose("effects = [\"gravity\", \"friction\", \"gyroscopic\"]\n[[body]]\nshape = \"box\"\n"
                 "size_m = [1, 2, 3]\nmass_kg = 1\nfriction = 0.1" +
                 kProxy)
            .warnings.empty());
}

TEST_CASE("when bodies sleep is read, with the effect sleeping only") {
  const auto scene =
      good("effects = [\"sleeping\"]\n[sleeping]\nmax_speed_m_per_s = 0.02\nafter_s = 1.5\nfrom_start = true" + kProxy);
  CHECK(scene.effects.sleeping);
  CHECK(scene.sleeping.max_speed_m_per_s == 0.02);
  CHECK(scene.sleeping.after_s == 1.5);
  CHECK(scene.sleeping.from_start);
  CHECK_FALSE(good(kProxy).effects.sleeping);
  CHECK_THAT(diagnose("[sleeping]\nafter_s = 1" + kProxy).message(),
             Contains("sleeping: set, but the effect sleeping is not declared"));
  CHECK_THAT(diagnose("effects = [\"sleeping\"]\n[sleeping]\nmax_speed_m_per_s = 0" + kProxy).message(),
             Contains("0 is not a speed"));
}

TEST_CASE("the far region has as many sub-steps as the near one, or fewer, but enough for the contact frequency") {
  const std::string near = "[simulation]\nsub_steps = 8\nglobal_sub_steps_per_tick = 4\n";
  CHECK(good(near + kProxy).solver.far_sub_steps_per_tick == 4);
  CHECK(good(near + "far_sub_steps_per_tick = 1" + kProxy).solver.far_sub_steps_per_tick == 1);
  CHECK_THAT(diagnose(near + "far_sub_steps_per_tick = 5" + kProxy).message(), Contains("<= 4"));
  const auto few = good("[simulation]\nglobal_sub_steps_per_tick = 0.4\ncontact_hertz_Hz = 100" + kProxy).solver;
  CHECK(few.global_sub_steps(10) == 4);
  CHECK(few.global_sub_steps(1) == 1);
  CHECK(few.far_sub_steps(8) == 4);
  CHECK_THAT(diagnose("[simulation]\nglobal_sub_steps_per_tick = 0" + kProxy).message(), Contains(">= 0.1"));
  CHECK_THAT(diagnose(near + "far_sub_steps_per_tick = 1\ncontact_hertz_Hz = 500" + kProxy).message(),
             Contains("at most 250 Hz"));
}

TEST_CASE("a scene says in which sweeps friction is solved") {
  CHECK(good(kProxy).solver.friction_sweeps == physics::FrictionSweeps::kAuto);
  CHECK(good("[simulation]\nfriction_sweeps = \"every\"" + kProxy).solver.friction_sweeps ==
        physics::FrictionSweeps::kEvery);
}

TEST_CASE("a generated part is copied in a grid about its place") {
  const std::string wall =
      "[[generate]]\nkind = \"wall\"\ncolumns = 2\nrows = 1\nmass_kg = 1\nposition_m = [1, 0, 0]\n";
  const auto one = good(wall + kProxy), six = good(wall + "copies_x = 3\ncopies_y = 2\ncopy_pitch_m = 2" + kProxy);
  REQUIRE(one.bodies.size() == 3);
  REQUIRE(six.bodies.size() == 1 + 6 * 2);
  CHECK(six.generated[0].count == 12);
  for (unsigned copy = 0; copy < 6; ++copy)
    for (unsigned k = 0; k < 2; ++k) {
      const Vec3d moved = six.bodies[1 + 2 * copy + k].motion.pose.position - one.bodies[1 + k].motion.pose.position;
      CHECK(norm(moved - Vec3d{2.0 * (copy % 3) - 2, 2.0 * (copy / 3) - 1, 0}) < 1e-12);
    }
  CHECK_THAT(diagnose(wall + "copies_x = 1000\ncopies_y = 1000" + kProxy).message(),
             Contains("1000000 copies make 2000000 bodies"));
}

TEST_CASE("a card house on too smooth a ground, or of too smooth cards, is a warning") {
  const auto warn = [](double ground, double cards) {
    return diagnose(fmt::format("effects = [\"friction\"]\n[[body]]\nshape = \"plane\"\nfriction = {}\n[[generate]]\n"
                                "kind = \"card_house\"\nangle_rad = 0.25\nlevels = 2\nfriction = {}{}",
                                ground, cards, kProxy))
        .warning_message();
  };
  // Cards of 88.9 x 2 mm: mu > 0.8 (tan - 2 / 88.9) = 0.186 under the feet, 0.2315 between the tops and the flat card.
  CHECK(warn(0.3, 0.24).empty());
  CHECK_THAT(warn(0.3, 0.23), Contains("between cards"));
  CHECK_THAT(warn(0.13, 0.26), Contains("with the ground"));  // sqrt(0.13 x 0.26) = 0.184
  CHECK(warn(0.14, 0.26).empty());                            // sqrt(0.14 x 0.26) = 0.191
}

TEST_CASE("a scene with several proxies has as many hands, each with its own tables or the one for all") {
  const std::string ball = "shape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\n";
  const std::string proxies = "[[proxy]]\n" + ball + "[[proxy]]\n" + ball + "position_m = [1, 0, 0]\n";
  const std::string body = "[[body]]\nname = \"a\"\n" + ball + "position_m = [2, 0, 0]\n";
  const auto scene =
      good(proxies + body + "[[device]]\n[[device]]\nposition_m = [1, 0, 0]\n[coupling]\nstiffness_N_per_m = 700\n");
  REQUIRE(scene.hands() == 2);
  const auto second = scene_of_hand(scene, 1);
  CHECK(scene.proxy == 0);
  CHECK(second.proxy == 1);
  CHECK(scene.bodies[2].motion.pose.position.x == 2);
  CHECK(scene.device.world_from_device.position.x == 0);
  CHECK(second.device.world_from_device.position.x == 1);
  CHECK(scene.coupling.stiffness_N_per_m == 700);
  CHECK(second.coupling.stiffness_N_per_m == 700);
  CHECK(second.hand.path.at(0).position_m.x == 1);  // it rests at its proxy
  CHECK(scene_of_hand(second, 1).proxy == 0);       // the others are still there
  CHECK(body_label(scene, 1).starts_with("the proxy of hand 2 (line "));
  CHECK(body_label(scene, 2).starts_with("'a' (line "));
  const auto joints = [&](const char* name) {
    return "effects = [\"joints\"]\n" + proxies + body + "[[joint]]\nkind = \"ball\"\na = \"a\"\nb = \"" + name +
           "\"\n";
  };
  CHECK(good(joints("proxy2")).effect_data.joints.size() == 1);
  CHECK_THAT(diagnose(joints("proxy3")).message(), Contains("no body is called \"proxy3\""));
  // What does not go together, a line each.
  CHECK_THAT(diagnose(proxies + "[hand]\n").message(), Contains("1 for 2 hands") && Contains("[[hand]] 2 times"));
  CHECK_THAT(diagnose(proxies + "[[device]]\n[[device]]\n[[device]]\n").message(),
             Contains("3 for 2 hands") && Contains("[[device]] once or 2 times"));
  CHECK_THAT(diagnose("[[device]]\n[[device]]\n" + kProxy).message(), Contains("2 for 1 hands"));
  std::string five;
  for (int i = 0; i < 5; ++i) five += "[[proxy]]\n" + ball;
  CHECK_THAT(diagnose(five).message(), Contains("proxy: 5 entries") && Contains("[[proxy]]"));
  CHECK_THAT(diagnose("proxy = 1\n").message(), Contains("proxy: 1 is not a table"));
}

TEST_CASE("the hand's path begins at the proxy, or there is a warning, without a path the hand rests there") {
  const std::string proxy = "\n[proxy]\nshape = \"sphere\"\nradius_m = 0.01\nmass_kg = 0.1\nposition_m = [1, 2, 3]\n";
  const auto rests = good(proxy);
  REQUIRE(rests.hand.path.size() == 1);
  CHECK(rests.hand.path[0].position_m == Vec3d{1, 2, 3});
  CHECK_THAT(diagnose("[hand]\npath = [{time_s = 0, position_m = [1, 2, 3.5]}]" + proxy).warning_message(),
             Contains("begins 0.5 m from the proxy") && Contains("the proxy's centre of mass, [1, 2, 3]"));
  CHECK(diagnose("[hand]\npath = [{time_s = 0, position_m = [1, 2, 3]}]" + proxy).warnings.empty());
}

TEST_CASE("a letter with an accent beside a number is a mistake, and nothing worse") {
  for (const char* letter : {"\u00e9", "\u017f", "\u0416", "\ufd00", "\ufefe", "\uffff"}) {
    const auto found = diagnose("[simulation]\nratio = 10" + std::string(letter) + "\n" + kProxy);
    INFO(letter);
    REQUIRE(found.mistakes.size() == 1);
    CHECK(found.mistakes[0].line == 2);
  }
}

TEST_CASE("no text exhausts the stack or the memory") {
  const auto repeated = [](const std::string& s, std::size_t n) {
    std::string text;
    for (std::size_t i = 0; i < n; ++i) text += s;
    return text;
  };
  CHECK_THAT(diagnose("a = " + repeated("[", 100'000)).message(), Contains("the file"));
  CHECK_THAT(diagnose("a = " + repeated("{a=", 100'000)).message(), Contains("the file"));
  CHECK_THAT(diagnose(repeated("a.", 100'000) + "a = 1").message(), Contains("dots"));
  CHECK_THAT(diagnose("[" + repeated("a.", 100'000) + "a]").message(), Contains("dots"));
  CHECK_THAT(diagnose("[" + repeated("a.", 400) + "a]").message(), Contains("deep"));
  CHECK_THAT(diagnose(repeated(" ", kMaxSceneBytes + 1)).message(),
             Contains("4194305 bytes; accepted: at most 4194304"));
  CHECK_THAT(diagnose("a = [" + repeated("1,", 1'100'000) + "]").message(), Contains("more than 1000000 values"));
  CHECK_THAT(diagnose(repeated("[[body]]\n", 100'001) + kProxy).message(),
             Contains("100001 entries; accepted: an array of at most 99999"));
  std::string keys;
  for (int i = 0; i < 1000; ++i) keys += fmt::format("key{} = 1\n", i);
  const auto found = diagnose(keys + kProxy);
  CHECK(found.mistakes.size() == text::kMaxReportedMistakes);
  CHECK(found.left_out == 1000 - text::kMaxReportedMistakes);
  CHECK_THAT(found.message(), Contains("and 900 more"));
}

TEST_CASE("the contact frequency's limit is a quarter of the rate of the longer sub-steps") {
  SolverChoice solver;
  solver.sub_steps = 4;
  solver.global_sub_steps_per_tick = 1;
  CHECK(max_contact_hertz(solver, 1e-3) == Approx(250));
  solver.global_sub_steps_per_tick = 8;
  CHECK(max_contact_hertz(solver, 1e-3) == Approx(1000));
  CHECK(max_contact_hertz(solver, 0.25e-3) == Approx(4000));
}

TEST_CASE("what cannot be read is a mistake without a line") {
  const auto missing = load_scene("/nowhere/x.toml");
  CHECK_FALSE(missing.ok());
  CHECK_THAT(missing.message(), Catch::StartsWith("/nowhere/x.toml: the file: cannot be read; accepted: "));
  CHECK_FALSE(load_scene("/").ok());
}
