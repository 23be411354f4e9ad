// A tape is shown as it was recorded, whichever way a tick is reached, and what cannot be shown is said.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "rt/base/denormals.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/view/tape_source.h"

using namespace tactus;
using namespace tactus::view;
using Catch::Matchers::Contains;

namespace {

void record_run(const std::string& path, std::uint64_t ticks, session::RunOptions options = test::virtual_options(),
                const std::string& scene = "card_house.toml") {
  options.record = path;
  auto session = test::make_session(test::scene_file(scene), options);
  REQUIRE(session->record(path).ok());
  (void)test::run(*session, ticks);
}

std::unique_ptr<TapeShow> shown(const std::string& path) {
  set_denormals_flush();
  auto show = TapeShow::open(path);
  INFO(show.message());
  REQUIRE(show.ok());
  return std::move(show).value();
}

void wait_until_rebuilt(const TapeShow& show) {
  while (!show.history().done()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

std::string bytes_of(const TapeShow& show) {
  publication::Frame frame;
  show.take_frame(frame);
  std::string bytes;
  const auto add = [&](const auto& list) {
    bytes.append(reinterpret_cast<const char*>(list.data()), list.size() * sizeof list[0]);
  };
  add(frame.positions);
  add(frame.rotations);
  add(frame.roles);
  add(frame.contacts);
  return bytes + std::to_string(frame.head.time_s);
}

// Overwrites some bytes at this share of the file.
void damage(const std::string& path, double share) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(0, std::ios::end);
  file.seekp(static_cast<std::streamoff>(share * static_cast<double>(file.tellg())));
  file << "damaged damaged damaged";
}

PageMessage asking(const std::string& what, double value = 0) { return {.ask = what, .value = value}; }

}  // namespace

TEST_CASE("a tick that is scrubbed to is the tick that playing shows, and its signals are the tape's", "[threads]") {
  const test::TemporaryFile tape;
  record_run(tape.path(), 2600);
  const auto played = shown(tape.path()), scrubbed = shown(tape.path());
  wait_until_rebuilt(*played);
  wait_until_rebuilt(*scrubbed);
  REQUIRE(played->history().note() == "");
  std::map<std::uint64_t, std::string> frames;
  std::vector<publication::TickEntry> ticks, before;
  REQUIRE(played->tick() == 0);
  while (played->step(ticks))
    if (played->tick() % 367 == 0 || played->tick() == 2599) frames[played->tick()] = bytes_of(*played);
  REQUIRE(ticks.size() == 2599);
  for (const std::uint64_t tick : {2599u, 734u, 1835u, 367u, 2202u}) {
    before.clear();
    REQUIRE(scrubbed->seek(tick, before));
    CHECK(scrubbed->tick() == tick);
    CHECK(bytes_of(*scrubbed) == frames[tick]);
    REQUIRE(before.size() == tick + 1);  // all that the plots may show
    CHECK(std::memcmp(&before.back().tick, &ticks[tick - 1].tick, sizeof(loop::TickRecord)) == 0);
  }
}

TEST_CASE("all bodies of a tape are where they were, and have their roles", "[threads]") {
  const test::TemporaryFile tape;
  record_run(tape.path(), 1000);
  const auto show = shown(tape.path());
  wait_until_rebuilt(*show);
  std::vector<publication::TickEntry> ticks;
  REQUIRE(show->seek(999, ticks));
  publication::Frame frame;
  show->take_frame(frame);
  REQUIRE(frame.roles.size() == 27);
  std::size_t members = 0, proxies = 0, unknown = 0;
  for (const std::uint8_t role : frame.roles) {
    members += (role & publication::kIsMember) != 0;
    proxies += (role & publication::kIsProxy) != 0;
    unknown += (role & publication::kIsUnknown) != 0;
  }
  CHECK(members == ticks.back().tick.out.members);
  CHECK(proxies == 1);
  CHECK(unknown == 0);
  const auto& proxy = ticks.back().tick.out.proxy.pose.position;
  CHECK(frame.positions[0].z == static_cast<float>(proxy.z));
}

TEST_CASE("the forces that a tape shows hold the bodies up", "[threads]") {
  const test::TemporaryFile tape;
  session::RunOptions options = test::virtual_options();
  options.coupling = haptics::CouplingScheme::kDirect;
  record_run(tape.path(), 400, options, "card_house.toml");
  const auto show = shown(tape.path());
  std::vector<publication::TickEntry> ticks;
  REQUIRE(show->seek(399, ticks));
  publication::Frame frame;
  show->take_frame(frame);
  double on_ground_N = 0, weight_N = 0;
  for (const auto& body : show->scene().bodies)
    if (body.kind == physics::BodyKind::kDynamic && body.id != show->scene().proxy) weight_N += 9.81 * body.mass;
  for (const auto& contact : frame.contacts) {
    const bool a_fixed = show->scene().bodies[contact.a].kind == physics::BodyKind::kFixed;
    const bool b_fixed = show->scene().bodies[contact.b].kind == physics::BodyKind::kFixed;
    if (b_fixed) on_ground_N -= static_cast<double>(contact.z);
    if (a_fixed) on_ground_N += static_cast<double>(contact.z);
  }
  CHECK(on_ground_N == Approx(weight_N).epsilon(0.1));
  CHECK(show->history().cycles() == 0);
}

TEST_CASE("a damaged tape is shown before and after the damage, and its world up to it", "[threads]") {
  const test::TemporaryFile tape;
  session::RunOptions few = test::virtual_options();
  few.members = 9;
  record_run(tape.path(), 4000, few);
  damage(tape.path(), 0.5);
  const auto show = shown(tape.path());
  wait_until_rebuilt(*show);
  CHECK(show->index().damages == 1);
  CHECK_THAT(show->index().damage, Contains("is damaged"));
  CHECK_THAT(show->history().note(), Contains("records are missing"));
  CHECK(show->history().cycles() > 50);
  std::vector<publication::TickEntry> ticks;
  publication::Frame frame;
  REQUIRE(show->seek(3900, ticks));
  show->take_frame(frame);
  CHECK((frame.roles[0] & publication::kIsMember) != 0);
  CHECK(std::count(frame.roles.begin(), frame.roles.end(), std::uint8_t{publication::kIsUnknown}) > 0);
  REQUIRE(show->seek(500, ticks));
  show->take_frame(frame);
  CHECK(std::count(frame.roles.begin(), frame.roles.end(), std::uint8_t{publication::kIsUnknown}) == 0);
}

TEST_CASE("a tape that is cut off is shown up to there, and what is none is refused as replay refuses it",
          "[threads]") {
  const test::TemporaryFile tape, foreign;
  record_run(tape.path(), 2000);
  std::ifstream whole(tape.path(), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(whole), {}};
  REQUIRE(truncate(tape.path().c_str(), static_cast<off_t>(bytes.size() * 3 / 4)) == 0);
  const auto show = shown(tape.path());
  CHECK_THAT(show->index().damage, Contains("cut off at byte"));
  CHECK(show->index().last_tick > 1000);
  CHECK(show->index().last_tick < 1999);
  std::ofstream(foreign.path()) << "this is no tape";
  const auto refused = TapeSource::open({foreign.path()});
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.message() == session::open_tape(foreign.path()).message());
  CHECK_FALSE(TapeSource::open({"/nowhere.tape"}).ok());
}

TEST_CASE("the tape of a fault begins in the middle: members are shown, and the reason", "[threads]") {
  const test::TemporaryFile tape, dumped;
  session::RunOptions options = test::virtual_options();
  auto session = test::make_session(test::scene_file("card_house.toml"), options);
  REQUIRE(session->record("").ok());
  session->drain = std::make_unique<loop::TapeDrain>(
      session->recorder->ring(),
      loop::DrainSettings{.history_bytes = 2u << 20, .keyframe_kind = loop::kKeyframeRecord});
  session::VirtualRun run(*session);
  set_denormals_flush();
  for (int tick = 0; tick < 6000; ++tick) {
    (void)run.tick();
    session->drain->drain();
  }
  const std::string text = session::to_tape_text(session->options, session->device->properties(), session->scene.name,
                                                 session->scene.source);
  REQUIRE(session->drain->dump(dumped.path(), text).ok());
  const auto show = shown(dumped.path());
  wait_until_rebuilt(*show);
  CHECK(show->index().first_tick > 1000);
  CHECK(show->history().note() == "the tape begins in the middle of the run");
  publication::Frame frame;
  show->take_frame(frame);
  CHECK((frame.roles[0] & publication::kIsProxy) != 0);
}

TEST_CASE("two tapes keep step: the clock plays, stops, steps, goes back and slows down", "[threads]") {
  const test::TemporaryFile a, b;
  record_run(a.path(), 1500);
  session::RunOptions direct = test::virtual_options();
  direct.coupling = haptics::CouplingScheme::kDirect;
  record_run(b.path(), 1200, direct);
  auto opened = TapeSource::open({a.path(), b.path()});
  REQUIRE(opened.ok());
  TapeSource& source = *opened.value();
  REQUIRE(source.views() == 2);
  std::vector<publication::TickEntry> ticks;
  publication::Frame frame;
  const auto newest = [&](std::size_t view) {
    ticks.clear();
    (void)source.look(view, ticks, frame);
    return ticks.empty() ? ~std::uint64_t{0} : ticks.back().tick.out.tick;
  };
  CHECK(newest(0) == 0);
  CHECK(newest(1) == 0);
  CHECK(source.ask(asking("tick")).ok);
  CHECK(newest(0) == 1);
  CHECK(newest(1) == 1);
  CHECK(source.ask(asking("cycle")).ok);
  const std::uint64_t cycle = newest(0);
  CHECK(cycle > 2);
  CHECK(newest(1) == cycle);
  CHECK(source.ask(asking("seek", 0.75)).ok);
  CHECK(newest(0) == 749);
  CHECK(newest(1) == 749);
  CHECK(source.ask(asking("seek", 0.9)).ok);
  source.joined();  // the second page of a link does not lose the first one's moment
  CHECK(newest(0) == 899);
  CHECK(source.ask(asking("seek", 0.75)).ok);
  CHECK(newest(0) == 749);
  CHECK(source.ask(asking("back")).ok);
  CHECK(newest(0) == 748);
  CHECK(source.ask(asking("pace", 0.1)).ok);
  CHECK(source.ask(asking("play")).ok);
  source.advance(0.5, 60'000'000'000);  // half a second at a tenth: 50 ticks
  CHECK(source.clock_s() == Approx(0.749 + 0.05));
  CHECK(source.ask(asking("pause")).ok);
  CHECK_FALSE(source.playing());
  CHECK(source.ask(asking("pace", 0)).ok);
  CHECK(source.ask(asking("play")).ok);
  source.advance(0.001, 60'000'000'000);  // as fast as it goes: to the end, where it stops
  CHECK(source.clock_s() == Approx(1.5));
  CHECK_FALSE(source.playing());
  const Answer refused = source.ask(asking("stop"));
  CHECK_FALSE(refused.ok);
  CHECK_THAT(refused.said, Contains("; accepted: play"));
  const auto status = nlohmann::json::parse(source.status());
  CHECK(status["kind"] == "tape");
  CHECK(status["end_s"] == Approx(1.5));
  CHECK_THAT(status["tapes"][1]["note"].get<std::string>(), Contains("the direct coupling has no world outside"));
}
