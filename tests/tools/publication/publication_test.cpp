// A watcher reads what the controller wrote into the shared memory, whole or not at all. Without a watcher nothing is
// written, and a watcher cannot write.
#include "tools/publication/publication.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "rt/base/denormals.h"
#include "sim/loader/scene_load.h"
#include "tests/support/temporary_file.h"
#include "tests/system/session_bench.h"
#include "tools/publication/shared_words.h"
#include "tools/publication/watcher.h"

using namespace tactus;
using namespace tactus::publication;
using Catch::Matchers::Contains;

namespace {

constexpr double kPeriod_s = 1e-3;

std::unique_ptr<Publication> published(const sim::Scene& scene) {
  auto made = Publication::create(scene, kPeriod_s, "{\"scene\": \"text\"}");
  INFO(made.message());
  REQUIRE(made.ok());
  return std::move(made).value();
}

std::unique_ptr<Watcher> watching(const Publication& publication) {
  auto opened = Watcher::open(fcntl(publication.descriptor(), F_DUPFD_CLOEXEC, 0));
  INFO(opened.message());
  REQUIRE(opened.ok());
  return std::move(opened).value();
}

// A session whose records and steps go to a publication, on the virtual clock.
struct Run {
  std::shared_ptr<Publication> publication;
  std::unique_ptr<session::Session> session;
  std::optional<session::VirtualRun> run;

  Run(sim::Scene scene, haptics::CouplingScheme coupling, bool watched) {
    session::RunOptions options = test::virtual_options();
    options.coupling = coupling;
    session = test::make_session(std::move(scene), options);
    publication = published(session->scene);
    if (watched) publication->watchers() = 1;
    session->shown = {publication->tap(), &publication->watchers(), publication};
    REQUIRE(session->record("").ok());
    set_denormals_flush();
    run.emplace(*session);
  }
  // The global world is shown after each tick in which it stepped, as its own thread would.
  void ticks(int count) {
    for (int i = 0; i < count; ++i) {
      run->tick();
      session->drain->drain();
      if (session->global != nullptr) Publication::stepped(publication.get(), *session->global);
    }
  }
};

double distance(const Position& a, const Vec3d& b) { return norm(number_cast<double>(Vec3<float>{a.x, a.y, a.z}) - b); }

}  // namespace

TEST_CASE("a frame has the poses, roles and contacts of the global world") {
  Run run(test::scene_file("card_house.toml"), haptics::CouplingScheme::kSubWorld, true);
  run.ticks(1500);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // until the next frame is due
  Publication::stepped(run.publication.get(), *run.session->global);
  const auto watcher = watching(*run.publication);
  Frame frame;
  REQUIRE(watcher->read_frame(frame));
  const sim::GlobalWorld& world = *run.session->global;
  const auto bodies = world.bodies();
  REQUIRE(frame.positions.size() == bodies.size());
  CHECK(frame.head.time_s == world.time_s());
  CHECK(frame.head.tick == world.statistics().steps);
  CHECK(frame.head.component == world.component().size());
  std::size_t members = 0, proxies = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    CHECK(distance(frame.positions[i], bodies[i].motion.pose.position) < 1e-6);
    const Quatd& q = bodies[i].motion.pose.rotation;
    const Rotation& r = frame.rotations[i];
    // Twice the error of the components: half a unit each.
    CHECK(std::abs(r.w / 32767.0 - q.w) + std::abs(r.x / 32767.0 - q.x) + std::abs(r.y / 32767.0 - q.y) +
              std::abs(r.z / 32767.0 - q.z) <
          4 * 0.51 / 32767);
    members += (frame.roles[i] & kIsMember) != 0 ? 1 : 0;
    if ((frame.roles[i] & kIsProxy) != 0) {
      ++proxies;
      CHECK(bodies[i].id == run.session->scene.proxy);
    }
    CHECK(((frame.roles[i] & kIsMember) != 0) == world.extraction().is_member(static_cast<sim::BodyIndex>(i)));
  }
  CHECK(members == world.extraction().members().size());
  CHECK(proxies == 1);
  CHECK(frame.head.left_out == 0);
}

TEST_CASE("of several hands each shows its own members and its own graph") {
  auto scene = sim::load_scene(TACTUS_SOURCE_DIR "/tools/examples/two_hands.toml");
  REQUIRE(scene.ok());
  const session::RunOptions options = test::virtual_options();
  auto hands = session::Hands::create(scene.value(), {options, options}, std::vector<session::Hardware>(2));
  INFO(hands.message());
  REQUIRE(hands.ok());
  REQUIRE(session::run_virtual(hands.value(), 1000).ok());  // both hold the block
  const sim::GlobalWorld& world = hands.value().world();
  for (unsigned hand = 0; hand < 2; ++hand) {
    const auto publication = published(hands.value()[hand].scene);
    publication->watchers() = 1;
    Publication::stepped(publication.get(), world);
    const auto watcher = watching(*publication);
    Frame frame;
    REQUIRE(watcher->read_frame(frame));
    CHECK(frame.head.component == world.component(hand).size());
    CHECK(number_of(world.component(hand).front()) == hand);
    for (std::size_t i = 0; i < frame.roles.size(); ++i) {
      const auto body = static_cast<sim::BodyIndex>(i);
      CHECK(((frame.roles[i] & kIsMember) != 0) == world.extraction(hand).is_member(body));
      CHECK(((frame.roles[i] & kIsProxy) != 0) == (i == hand));
    }
    CHECK_FALSE(frame.contacts.empty());
  }
}

TEST_CASE("contacts carry the weight of what stands") {
  // A hand at rest above a stack: the ground bears all of it.
  Run run(test::scene_text(test::kPressScene), haptics::CouplingScheme::kSubWorld, true);
  run.ticks(1500);  // the hand presses with about 2 N
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  Publication::stepped(run.publication.get(), *run.session->global);
  const auto watcher = watching(*run.publication);
  Frame frame;
  REQUIRE(watcher->read_frame(frame));
  const BodyId ground = 1, block = 2;
  double on_ground_N = 0, on_block_N = 0;
  for (const ContactForce& contact : frame.contacts) {
    if (contact.b == ground) on_ground_N += static_cast<double>(contact.z);
    if (contact.a == 0 && contact.b == block) on_block_N += static_cast<double>(contact.z);
  }
  const double weight_N = 9.81;
  CHECK(on_block_N < -1.0);
  CHECK(on_ground_N == Approx(-weight_N + on_block_N).epsilon(0.05));
}

TEST_CASE("every tick is read as the recorder has it, in order") {
  Run run(test::scene_text(test::kPressScene), haptics::CouplingScheme::kSubWorld, true);
  const auto watcher = watching(*run.publication);
  std::vector<TickEntry> ticks;
  CHECK(watcher->read_ticks(ticks, 1000) == 0);  // begins here
  std::vector<loop::TickOutput> outputs;
  for (int i = 0; i < 400; ++i) {
    run.ticks(1);
    outputs.push_back(run.session->driver->output());
  }
  CHECK(watcher->read_ticks(ticks, 1000) == 0);
  REQUIRE(ticks.size() == 399);  // the last waits for its times
  for (std::size_t i = 0; i < ticks.size(); ++i)
    CHECK(std::memcmp(&ticks[i].tick.out, &outputs[i], sizeof outputs[i]) == 0);
}

TEST_CASE("a watcher that is too slow loses the oldest ticks, and gets their number") {
  const sim::Scene scene = test::scene_text(test::kPressScene);
  const auto publication = published(scene);
  publication->watchers() = 1;
  const auto watcher = watching(*publication);
  std::vector<TickEntry> ticks;
  (void)watcher->read_ticks(ticks, 1);
  const loop::RecordTap tap = publication->tap();
  loop::TickRecord record;
  const std::uint64_t written = kTickEntries + 1000;
  for (std::uint64_t i = 0; i <= written; ++i) {
    record.out.tick = i;
    tap.taken(tap.context, loop::kTickRecord, std::as_bytes(std::span<const loop::TickRecord, 1>(&record, 1)));
  }
  CHECK(watcher->read_ticks(ticks, 2 * kTickEntries) == 1000);
  REQUIRE(ticks.size() == kTickEntries);
  CHECK(ticks.front().tick.out.tick == 1000);
  CHECK(ticks.back().tick.out.tick == written - 1);
}

TEST_CASE("with the direct coupling the members' poses come every sixteenth tick, and are on no tape") {
  Run run(test::scene_text(test::kPressScene), haptics::CouplingScheme::kDirect, true);
  run.ticks(33);
  CHECK(run.publication->frames() == 3);  // before ticks 0, 16 and 32
  const auto watcher = watching(*run.publication);
  const auto bodies = run.session->loop->sub_world().world().bodies();
  std::vector<Vec3d> at;
  for (const physics::Body& body : bodies) at.push_back(body.motion.pose.position);
  run.ticks(15);
  at.clear();
  for (const physics::Body& body : run.session->loop->sub_world().world().bodies())
    at.push_back(body.motion.pose.position);
  run.ticks(1);
  Frame frame;
  REQUIRE(watcher->read_frame(frame));
  CHECK(frame.head.tick == 48);
  REQUIRE(frame.positions.size() == at.size());
  for (std::size_t i = 0; i < at.size(); ++i) CHECK(distance(frame.positions[i], at[i]) < 1e-6);
  const test::TemporaryFile dump;
  REQUIRE(run.session->drain->dump(dump.path(), "{}").ok());
  auto tape = loop::TapeReader::open(dump.path());
  REQUIRE(tape.ok());
  loop::TapeRecord record;
  std::size_t ticks = 0;
  while (tape.value()->next(record) == loop::TapeRead::kRecord) {
    CHECK(record.kind != loop::kBodiesRecord);
    ticks += record.kind == loop::kTickRecord ? 1 : 0;
  }
  CHECK(ticks == 49);
}

TEST_CASE("without a watcher nothing is written, and a watcher changes no bit of the run") {
  const auto coupling = GENERATE(haptics::CouplingScheme::kSubWorld, haptics::CouplingScheme::kDirect);
  Run alone(test::scene_file("card_house.toml"), coupling, false);
  alone.ticks(1200);
  CHECK(alone.publication->frames() == 0);
  CHECK(alone.publication->ticks() == 0);
  Run watched(test::scene_file("card_house.toml"), coupling, true);
  watched.ticks(1200);
  CHECK(watched.publication->frames() > 0);
  CHECK(watched.publication->ticks() > 1000);
  CHECK(watched.session->loop->state_hash() == alone.session->loop->state_hash());
  const std::uint64_t frames = watched.publication->frames();
  watched.publication->watchers() = 0;
  watched.ticks(200);
  CHECK(watched.publication->frames() == frames);
}

TEST_CASE("a watcher cannot write, shrink or map the memory for writing") {
  const sim::Scene scene = test::scene_text(test::kPressScene);
  const auto publication = published(scene);
  const int descriptor = publication->descriptor();
  CHECK(write(descriptor, "x", 1) == -1);
  CHECK(ftruncate(descriptor, 0) == -1);
  CHECK(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0) == MAP_FAILED);
  // Nor after opening it again for writing.
  const int again = open(("/proc/self/fd/" + std::to_string(descriptor)).c_str(), O_RDWR | O_CLOEXEC);
  if (again >= 0) {
    CHECK(write(again, "x", 1) == -1);
    CHECK(ftruncate(again, 0) == -1);
    CHECK(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, again, 0) == MAP_FAILED);
    close(again);
  }
}

TEST_CASE("what is no such memory, or another layout's, is refused in one line") {
  const auto memory = [](const Header& header, bool sealed) {
    const int descriptor = memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    REQUIRE(descriptor >= 0);
    REQUIRE(ftruncate(descriptor, 1 << 20) == 0);
    REQUIRE(pwrite(descriptor, &header, sizeof header, 0) == sizeof header);
    if (sealed) REQUIRE(fcntl(descriptor, F_ADD_SEALS, F_SEAL_SHRINK) == 0);
    return descriptor;
  };
  const auto refusal = [&](const Header& header, bool sealed = true) {
    const auto opened = Watcher::open(memory(header, sealed));
    REQUIRE_FALSE(opened.ok());
    return opened.message();
  };
  Header header;
  header.tape_version = loop::kTapeVersion;
  CHECK_THAT(refusal(header, false), Contains("it is not sealed; accepted: "));
  CHECK_THAT(refusal(header), Contains("its header is damaged"));
  header.version = 99;
  CHECK_THAT(refusal(header), Contains("layout 99."));
  header.magic[0] = 'X';
  CHECK_THAT(refusal(header), Contains("it does not begin as one"));
}

TEST_CASE("whatever a header's numbers are, nothing outside of the memory is read") {
  const sim::Scene scene = test::scene_text(test::kPressScene);
  const auto publication = published(scene);
  const auto watcher = watching(*publication);
  Header good;
  REQUIRE(pread(publication->descriptor(), &good, sizeof good, 0) == sizeof good);
  const std::uint64_t odd[]{0, 1, 7, 1u << 20, (1u << 20) + 8, 1ull << 31, 1ull << 62, ~0ull, ~0ull - 7};
  std::size_t accepted = 0;
  for (std::size_t at = 16; at < offsetof(Header, frames); at += 8)
    for (const std::uint64_t number : odd) {
      Header header = good;
      std::memcpy(reinterpret_cast<std::byte*>(&header) + at, &number, sizeof number);
      const int descriptor = memfd_create("test", MFD_CLOEXEC | MFD_ALLOW_SEALING);
      REQUIRE(ftruncate(descriptor, static_cast<off_t>(good.bytes)) == 0);
      header.frames = header.ticks = 5;
      REQUIRE(pwrite(descriptor, &header, sizeof header, 0) == sizeof header);
      REQUIRE(fcntl(descriptor, F_ADD_SEALS, F_SEAL_SHRINK) == 0);
      const auto opened = Watcher::open(descriptor);
      if (!opened.ok()) continue;
      ++accepted;
      Frame frame;
      std::vector<TickEntry> ticks;
      (void)opened.value()->read_frame(frame);
      (void)opened.value()->read_ticks(ticks, 100);
    }
  CHECK(accepted > 0);  // such as another period
}

TEST_CASE("a frame that is read while it is written is whole, or is not read", "[threads]") {
  const sim::Scene scene = test::scene_file("pile250.toml");
  const auto publication = published(scene);
  publication->watchers() = 1;
  std::atomic<bool> seen_enough{false};
  const std::size_t bodies = watching(*publication)->bodies();
  std::thread writer([&] {
    const loop::RecordTap tap = publication->tap();
    std::vector<std::byte> bytes(sizeof(loop::BodiesRecord) + bodies * sizeof(loop::BodyPose));
    for (std::uint32_t number = 1; !seen_enough.load(); ++number) {
      const loop::BodiesRecord head{number, static_cast<std::uint32_t>(bodies), number};
      std::memcpy(bytes.data(), &head, sizeof head);
      std::size_t i = 0;
      for (const physics::Body& body : scene.bodies) {
        if (body.kind != physics::BodyKind::kDynamic) continue;
        const auto value = static_cast<float>(number);
        const loop::BodyPose pose{body.id, {value, value, value}, {static_cast<std::int16_t>(number), 0, 0, 0}};
        std::memcpy(bytes.data() + sizeof head + i++ * sizeof pose, &pose, sizeof pose);
      }
      tap.taken(tap.context, loop::kBodiesRecord, bytes);
    }
  });
  const auto watcher = watching(*publication);
  std::size_t frames = 0, torn = 0;
  std::uint64_t last = 0;
  Frame frame;
  while (frames < 2'000) {
    if (!watcher->read_frame(frame)) continue;
    ++frames;
    if (frame.number < last || frame.head.resets != frame.head.tick) ++torn;
    last = frame.number;
    for (std::size_t k = 0; k < frame.positions.size(); ++k)
      if (frame.positions[k].x != static_cast<float>(frame.head.tick) || frame.positions[k].z != frame.positions[k].x ||
          frame.rotations[k].w != static_cast<std::int16_t>(frame.head.tick))
        ++torn;
  }
  seen_enough = true;
  writer.join();
  CHECK(torn == 0);
}

TEST_CASE("the run's state text is read once and complete, and a text that is too long leaves the one before it") {
  const auto publication = published(test::scene_file("stack20.toml"));
  const auto watcher = watching(*publication);
  std::string state = "none";
  CHECK_FALSE(watcher->read_state(state));
  for (const std::string& text : {std::string("{}"), std::string(8176, 'x'), std::string("short")}) {
    publication->say(text);
    REQUIRE(watcher->read_state(state));
    CHECK(state == text);
    CHECK_FALSE(watcher->read_state(state));
  }
  publication->say(std::string(8177, 'y'));
  CHECK_FALSE(watcher->read_state(state));
  CHECK(state == "short");
}

TEST_CASE("the run's state text, read while it is written, is complete or is not read", "[threads]") {
  const auto publication = published(test::scene_file("stack20.toml"));
  const auto watcher = watching(*publication);
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (int i = 0; i < 20'000; ++i)
      publication->say(std::string(static_cast<std::size_t>(1 + i % 97), static_cast<char>('a' + i % 26)));
    done = true;
  });
  std::string state;
  int read = 0;
  while (!done || read == 0) {
    if (!watcher->read_state(state)) continue;
    ++read;
    REQUIRE(!state.empty());
    CHECK(state.find_first_not_of(state.front()) == std::string::npos);
  }
  writer.join();
  CHECK(read > 0);
}

TEST_CASE("the end of the run is seen") {
  const sim::Scene scene = test::scene_text(test::kPressScene);
  auto publication = published(scene);
  const auto watcher = watching(*publication);
  CHECK(watcher->text() == "{\"scene\": \"text\"}");
  CHECK(watcher->period_s() == kPeriod_s);
  CHECK_FALSE(watcher->ended());
  publication.reset();
  CHECK(watcher->ended());
}
