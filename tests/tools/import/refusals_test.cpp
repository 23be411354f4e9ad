// What is refused, all of it in one go with file and line; what --drop does; hostile files end with one line.
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/tools/import/import_bench.h"
#include "tools/import/limited_process.h"

using namespace tactus;
using namespace tactus::test;
using namespace tactus::scene_import;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

namespace {

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == std::string::npos; }

std::string refusal_of(const std::string& name) { return refusal(options_for(kModels / name)); }

}  // namespace

TEST_CASE("everything that a scene cannot have is refused in one go, by its line") {
  TACTUS_NEEDS_COMPILER();
  const std::string lines = refusal_of("refused.xml");
  const std::pair<int, const char*> expected[] = {{3, "plugin"},       {6, "a spring"},
                                                  {6, "has damping"},  {9, "2 joints"},
                                                  {10, "rotor"},       {10, "friction of its own"},
                                                  {15, "limit"},       {16, "a composite"},
                                                  {17, "flexible"},    {18, "distance function"},
                                                  {19, "gravcomp"},    {19, "a fluid"},
                                                  {20, "no shape"},    {22, "a contact of its own"},
                                                  {23, "a tendon"},    {24, "an equality of joints"},
                                                  {25, "an actuator"}, {5, "<exclude>"},
                                                  {15, "contype"}};
  for (const auto& [line, what] : expected) {
    CAPTURE(line, what);
    const std::string head = fmt::format("refused.xml:{}: ", line);
    bool found = false;
    for (std::size_t at = 0; !found && (at = lines.find(head, at)) != std::string::npos; ++at) {
      const std::string text = lines.substr(at, lines.find('\n', at) - at);
      found = text.find(what) != std::string::npos && text.find("; accepted: ") != std::string::npos;
    }
    CHECK(found);
  }
  CHECK_THAT(refusal_of("mimic.urdf"), Contains("mimic.urdf:12: ") && Contains("mimics") && Contains("has damping"));
}

TEST_CASE("masks that keep bodies apart are refused among thousands of shapes of their own masks too") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  const auto model = [&](const char* last) {
    std::string text = "<mujoco><worldbody>";
    for (int i = 0; i < 800; ++i) {
      text += fmt::format("<body pos='{} 0 0'><freejoint/>", i);
      for (const char* masks : {"contype='1'", "contype='3'", "conaffinity='3'", "contype='5'", last})
        text += fmt::format("<geom size='0.1' {}/>", masks);
      text += "</body>";
    }
    return scratch.write("many.xml", text + "</worldbody></mujoco>");
  };
  CHECK_THAT(refusal(options_for(model("contype='8' conaffinity='8'"))),
             Contains("many.xml:1: ") && Contains("and of 999 or more other pairs of bodies"));
  imported(options_for(model("conaffinity='7'")));
}

TEST_CASE("the option --drop leaves kinds out, and the scene's first lines say so") {
  TACTUS_NEEDS_COMPILER();
  auto options = options_for(kModels / "mimic.urdf");
  options.drop = {"mimic", "damping"};
  CHECK_THAT(refusal(options), Contains("friction of its own") && !Contains("mimics"));
  options.drop.push_back("friction-loss");
  const auto made = imported(options);
  CHECK(made.account.dropped.size() == 3);
  CHECK_THAT(made.files.text, StartsWith("# Made by tactus import from mimic.urdf") &&
                                  Contains("# Left out by --drop: mimic, line 12: "));
  CHECK(loaded(made).effect_data.joints.size() == 2);
}

TEST_CASE("the proxy may be one of the model's bodies, or a sphere of a radius") {
  TACTUS_NEEDS_COMPILER();
  auto options = options_for(kModels / "stack.xml");
  options.proxy = "third";
  const auto made = imported(options);
  CHECK(made.account.bodies == 3);
  const auto scene = loaded(made);
  CHECK(scene.bodies[scene.proxy].mass == 1);
  CHECK(scene.bodies[scene.proxy].shape.kind == physics::ShapeKind::kBox);
  options.proxy = "fourth";
  CHECK_THAT(refusal(options), Contains("--proxy fourth") && Contains("first, second, third"));
  options.proxy = "0.02";
  options.proxy_position = Vec3d{0, 0, 1};
  options.device = "desk3d";
  const auto sphere = loaded(imported(options));
  CHECK(sphere.bodies[sphere.proxy].motion.pose.position.z == 1);
  CHECK(sphere.device.profile == "desk3d");
}

TEST_CASE("the proxy may be a compound, and joints hold it") {
  TACTUS_NEEDS_COMPILER();
  auto options = options_for(kModels / "cabinet.urdf");
  options.proxy = "door";
  const auto scene = loaded(imported(options));
  const auto& door = scene.bodies[scene.proxy];
  CHECK(door.shape.kind == physics::ShapeKind::kCompound);
  CHECK(door.mass == Approx(1.55).epsilon(1e-12));  // with the knob
  CHECK(norm(scene.device.world_from_device.position - door.motion.pose.position) < 1e-12);
  CHECK(std::ranges::count_if(scene.effect_data.joints, [&](const physics::Joint& joint) {
          return joint.a == scene.proxy || joint.b == scene.proxy;
        }) == 1);
}

TEST_CASE("a body of more shapes than a compound has parts is refused") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  const auto model = [&](int count) {
    return options_for(scratch.write(
        "many.xml", fmt::format("<mujoco><worldbody>\n<body name='chain'><freejoint/><replicate count='{}' "
                                "offset='.1 0 0'><geom size='.06'/></replicate></body></worldbody></mujoco>",
                                count)));
  };
  CHECK_THAT(refusal(model(129)), Equals("many.xml:2: body \"chain\" has 129 shapes; accepted: at most 128 in one "
                                         "body: fewer shapes, or fewer --pieces"));
  CHECK(loaded(imported(model(128))).compounds.at(0).parts.size() == 128);
}

TEST_CASE(
    "what the loader does not accept is refused by the model's line and element, beside all else, and no scene made") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  const std::string text =
      "<mujoco><worldbody>\n<body name='dust'><freejoint/><geom size='.05' mass='1e-9'/></body>\n"
      "<body name='rock' pos='1 0 0'><freejoint/>\n<geom name='big' type='box' size='1 1 1' mass='1e9'/></body>\n"
      "</worldbody>{}</mujoco>";
  const std::string lines = refusal(options_for(scratch.write("light.xml", fmt::format(fmt::runtime(text), ""))));
  CHECK_THAT(lines, StartsWith("light.xml:2: ") &&
                        Contains("body \"dust\": mass_kg: 1e-09 is not a mass; accepted: ") &&
                        Contains("\nlight.xml:4: geom \"big\": mass_kg: 1000000000 is not a mass"));
  const std::string both = refusal(options_for(scratch.write(
      "light.xml", fmt::format(fmt::runtime(text), "\n<actuator><motor joint='none' gear='1'/></actuator>"))));
  CHECK_THAT(both, Contains("is an actuator"));
  auto options = options_for(kModels / "stack.xml");
  options.proxy_position = Vec3d{std::nan(""), 2, 3};
  CHECK_THAT(refusal(options), Equals("--proxy-position: not finite; accepted: three finite numbers [m]"));
  options.proxy_position = Vec3d{1e12, 2, 3};
  CHECK_THAT(refusal(options), Contains("position_m: ") && Contains("; accepted: "));
}

TEST_CASE("what the loader does not accept is said beside what a scene cannot have") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  const auto file =
      scratch.write("both.xml",
                    "<mujoco><worldbody>\n<body name='dust'><freejoint/><geom size='.05' mass='1e-9'/></body>\n"
                    "<body pos='1 0 0'><joint name='j' damping='1'/><geom size='.05'/></body></worldbody></mujoco>");
  CHECK_THAT(refusal(options_for(file)), Contains("both.xml:3: ") && Contains("has damping") &&
                                             Contains("both.xml:2: ") && Contains("mass_kg: 1e-09 is not a mass"));
}

TEST_CASE("numbers that are not finite are reported with their element") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  const auto file = scratch.write("nan.xml",
                                  "<mujoco><worldbody>\n<body name='n' pos='nan 0 0'><freejoint/><geom size='.1'/>"
                                  "</body></worldbody></mujoco>");
  CHECK_THAT(refusal(options_for(file)),
             StartsWith("nan.xml:2: body \"n\": its ") && Contains("is not finite; accepted: finite numbers"));
}

TEST_CASE("an element of more than a million characters is XML") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  std::string vertices;
  for (int i = 0; i < 130'000; ++i) vertices += fmt::format("0.{} 0 0 ", i % 10);
  REQUIRE(vertices.size() > 1'000'000);
  const auto file = scratch.write(
      "long.xml", fmt::format("<mujoco><asset><mesh name='m' vertex=\"{} 0 0 0 .1 0 0 0 .1 0 0 0 .1\"/></asset>"
                              "<worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>",
                              vertices));
  CHECK(imported(options_for(file)).account.bodies == 1);
}

TEST_CASE("more bodies than the compiler has memory for are refused with their number") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  std::string text = "<mujoco><worldbody>";
  for (int i = 0; i < 6000; ++i) text += fmt::format("<body pos='{} 0 0'><freejoint/><geom size='.1'/></body>", i);
  CHECK_THAT(refusal(options_for(scratch.write("wide.xml", text + "</worldbody></mujoco>"))),
             StartsWith("wide.xml: 6000 bodies; accepted: at most 3000"));
}

TEST_CASE("a file that is missing is one refusal") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  const auto file = scratch.write("m.xml",
                                  "<mujoco><asset><mesh name='a' file='none.stl'/></asset><worldbody><body>"
                                  "<freejoint/><geom type='mesh' mesh='a'/></body></worldbody></mujoco>");
  const std::string lines = refusal(options_for(file));
  CHECK_THAT(lines, StartsWith("m.xml:1: <mesh> names \"none.stl\", which cannot be read"));
  CHECK(is_one_line(lines));
}

TEST_CASE("an open mesh is refused where mass comes from its volume") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  const std::string text =
      "<mujoco><asset><mesh name=\"m\" inertia=\"shell\" vertex=\"0 0 0 .1 0 0 0 .1 0 0 0 .1\" "
      "face=\"0 2 1 0 1 3 0 3 2\"/></asset>\n<worldbody><body><freejoint/>{}\n<geom name=\"g\" type=\"mesh\" "
      "mesh=\"m\"/></body></worldbody></mujoco>";
  CHECK_THAT(refusal(options_for(scratch.write("open.xml", fmt::format(fmt::runtime(text), "")))),
             StartsWith("open.xml:3: geom \"g\": its mesh is open at 3 edges"));
  const auto file = scratch.write(
      "inertial.xml",
      fmt::format(fmt::runtime(text), "<inertial pos='.02 .02 .02' mass='1' diaginertia='.001 .001 .001'/>"));
  CHECK(imported(options_for(file)).account.bodies == 1);
}

TEST_CASE("SDF and USD are named, and other kinds too") {
  CHECK_THAT(refusal_of("robot.sdf"), StartsWith("robot.sdf: SDF is not read"));
  CHECK_THAT(refusal_of("stage.usda"), StartsWith("stage.usda: USD is not read"));
  CHECK_THAT(refusal_of("README.md"), Contains("no kind that is known"));
  CHECK_THAT(refusal_of("nothing.xml"), Contains("no such file"));
}

TEST_CASE("hostile XML ends with one line") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  CHECK_THAT(refusal_of("laughs.xml"), Equals("laughs.xml:2: a document type declaration; accepted: XML without one"));
  std::string deep = "<mujoco><worldbody>";
  for (int i = 0; i < 100'000; ++i) deep += "<body>";
  const std::string nested = refusal(options_for(scratch.write("deep.xml", deep)));
  CHECK_THAT(nested, Contains("nested deeper than 200"));
  CHECK(is_one_line(nested));
  for (const char* text :
       {"", "<", "<mujoco", "<mujoco>", "</mujoco>", "<mujoco a='>", "<!--", "\xff\xfe", "<mujoco><worldbody/><a"})
    CHECK(is_one_line(refusal(options_for(scratch.write("broken.xml", text)))));
  const std::string includes =
      refusal(options_for(scratch.write("self.xml", "<mujoco><include file='self.xml'/></mujoco>")));
  CHECK(is_one_line(includes));
}

TEST_CASE("no file outside of the model's folder is read") {
  TACTUS_NEEDS_COMPILER();
  const std::string lines = refusal_of("outside.xml");
  CHECK_THAT(lines, Contains("outside.xml:2: <include> names \"../../../../etc/hosts\", which is outside"));
  CHECK_THAT(lines, Contains("outside.xml:4: <mesh> names \"../secret.stl\", which is outside"));
  CHECK_THAT(lines, Contains("outside.xml:5: <mesh> names \"/etc/passwd\", which is outside"));
  CHECK_THAT(lines, Contains("outside.xml:6: <hfield> names \"missing.png\", which cannot be read"));
  const Scratch scratch;
  std::filesystem::create_directories(scratch.path / "model");
  scratch.write("secret.stl", "solid");
  std::filesystem::create_symlink(scratch.path / "secret.stl", scratch.path / "model/link.stl");
  const auto file = scratch.write("model/m.xml", "<mujoco><asset><mesh name='a' file='link.stl'/></asset></mujoco>");
  CHECK_THAT(refusal(options_for(file)), Contains("a link that leads outside"));
}

TEST_CASE("a huge mesh and a flood of bodies end with one line") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  scratch.write("huge.stl", "");
  std::filesystem::resize_file(scratch.path / "huge.stl", 100u << 20);  // sparse
  const auto mesh =
      scratch.write("m.xml",
                    "<mujoco><asset><mesh name='a' file='huge.stl'/></asset>"
                    "<worldbody><body><freejoint/><geom type='mesh' mesh='a'/></body></worldbody></mujoco>");
  CHECK_THAT(refusal(options_for(mesh)), Contains("of 104857600 bytes; accepted: files of at most 64 MB"));
  const auto flood = scratch.write(
      "flood.xml",
      "<mujoco><worldbody><replicate count='100000'><replicate count='100000'><body><geom size='1'/></body>"
      "</replicate></replicate></worldbody></mujoco>");
  auto options = options_for(flood);
  options.compiler_limits.cpu_s = 3;  // of 60: it takes all that it gets
  CHECK(is_one_line(refusal(options)));
}

TEST_CASE("work beyond its limits is ended, and one that crashes too") {
  const Limits limits{.wall_s = 60, .cpu_s = 60, .memory_bytes = 1u << 30, .answer_bytes = 1000};
  Limits impatient = limits;
  impatient.wall_s = 1;
  CHECK(run_apart([] { return std::string("an answer"); }, limits).value() == "an answer");
  CHECK_THAT(run_program({"sleep", "60"}, impatient).message(), Contains("longer than 1 s"));
  CHECK_THAT(run_program({"yes"}, limits).message(), Contains("becomes more than"));
  CHECK_THAT(run_program({"tactus-no-such-program"}, limits).message(), Contains("not there"));
  CHECK_FALSE(run_apart(
                  []() -> std::string {
                    ::raise(SIGSEGV);
                    return "";
                  },
                  limits)
                  .ok());
  const auto thrown = run_apart([]() -> std::string { throw std::runtime_error("no"); }, limits);
  CHECK_THAT(thrown.status().message(), Contains("status 1"));
}

TEST_CASE("broken files of shapes end with one line") {
  const Scratch scratch;
  for (const char* name : {"a.gltf", "a.glb", "a.obj", "a.stl"})
    for (const char* text :
         {"", "{", "glTF\x02", "solid\nfacet", "v 1 2\nf 1 2 3",
          "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"children\":[0]}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}",
          "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"../../etc/passwd\"}]}"}) {
      CAPTURE(name, text);
      CHECK(is_one_line(refusal(options_for(scratch.write(name, text)))));
    }
}

TEST_CASE("a compiler whose answer names what is not there gives no model") {
  TACTUS_NEEDS_COMPILER();
  const Scratch scratch;
  // Repeats an answer, so that one can be changed on its way. It stands beside a wasm, as the compiler does.
  scratch.write("mujoco.wasm", "");
  const auto repeats = scratch.write("repeat.mjs",
                                     "import {readFileSync} from 'node:fs';"
                                     "process.stdout.write(readFileSync(new URL('answer.json', import.meta.url)));");
  const auto answer_of = [](const char* name) {
    return nlohmann::json::parse(run_program({"node", compiler().string(), (kModels / name).string()}, {}).value());
  };
  auto options = options_for(kModels / "four_bar.xml");
  options.compiler = repeats;
  const auto refusal_with = [&](const nlohmann::json& answer) {
    scratch.write("answer.json", answer.dump());
    return refusal(options);
  };
  const auto linkage = answer_of("four_bar.xml"), fixed = answer_of("fixed.xml");
  for (const auto& answer : {linkage, fixed}) {
    scratch.write("answer.json", answer.dump());
    CHECK_FALSE(imported(options).files.text.empty());
  }
  for (const char* place : {"/bodies/1/parent", "/bodies/1/weld", "/geoms/0/body", "/joints/0/body", "/joints/0/parent",
                            "/equalities/0/body_a", "/equalities/0/body_b"})
    for (const int index : {-1, 4, 1'000'000}) {
      CAPTURE(place, index);
      auto answer = linkage;
      answer["model"].at(nlohmann::json::json_pointer(place)) = index;
      CHECK_THAT(refusal_with(answer), StartsWith("four_bar.xml: the compiler gives no model; "));
    }
  for (std::size_t i = 0; i < fixed.at("model").at("geoms").size(); ++i) {
    auto answer = fixed;
    auto& geom = answer["model"]["geoms"][i];
    if (geom.at("type") == "mesh") geom["mesh"] = 99;
    if (geom.at("type") == "hfield") geom["field"] = 99;
    if (answer != fixed) CHECK_FALSE(refusal_with(answer).empty());
  }
  auto answer = fixed;
  REQUIRE_FALSE(answer["model"]["meshes"].empty());
  answer["model"]["meshes"][0]["triangles"][0] = 1'000'000;
  CHECK_FALSE(refusal_with(answer).empty());
  REQUIRE_FALSE(fixed.at("model").at("fields").empty());
  answer = fixed;
  answer["model"]["fields"][0]["rows"] = 100'000;
  CHECK_FALSE(refusal_with(answer).empty());
}
