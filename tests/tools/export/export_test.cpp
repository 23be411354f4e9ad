// Exports read back: the doubles of the tape, bit by bit; the bodies of the run.
#include "tools/export/export.h"

#include <bit>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "rt/base/denormals.h"
#include "rt/loop/timed_tick.h"
#include "sim/loader/scene_load.h"
#include "sim/model/given_pose.h"
#include "tests/system/session_bench.h"
#include "tools/export/columns.h"
#include "tools/export/sink.h"
#include "tools/session/replay.h"
#include "tools/session/tape_player.h"

using namespace tactus;
using namespace tactus::exporting;
using Catch::Matchers::Contains;

namespace {

// A folder of its own, gone at the end of the test.
class Folder {
 public:
  Folder() {
    std::string path = (std::filesystem::temp_directory_path() / "tactus-export-XXXXXX").string();
    REQUIRE(mkdtemp(path.data()) != nullptr);
    path_ = path;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::size_t files() const {
    std::size_t n = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_)) ++n;
    return n;
  }

 private:
  std::filesystem::path path_;
};

using SeesTick = std::function<void(const session::Session&, const loop::TickOutput&)>;

void record(const std::string& tape, std::uint64_t ticks, const SeesTick& see = {}) {
  session::RunOptions options = test::virtual_options();
  options.record = tape;
  auto session = test::make_session(test::scene_text(test::kPressScene), options);
  REQUIRE(session->record(tape).ok());
  const auto observer = [&](const loop::TickOutput& out) {
    if (see) see(*session, out);
    return true;
  };
  auto summary = test::run(*session, ticks, observer);
  session->close_tape(summary);
}

ExportReport exported(const ExportOptions& options) {
  bool machine = false;
  const auto result = export_tape(options, {}, machine);
  INFO(result.message());
  REQUIRE(result.ok());
  return result.value();
}

std::string refused(const ExportOptions& options, bool by_machine = false) {
  bool machine = false;
  const auto result = export_tape(options, {}, machine);
  REQUIRE_FALSE(result.ok());
  CHECK(machine == by_machine);
  CHECK(result.message().find('\n') == std::string::npos);
  return result.message();
}

std::vector<loop::TickRecord> ticks_of(const std::string& path) {
  auto tape = session::open_tape(path);
  REQUIRE(tape.ok());
  std::vector<loop::TickRecord> ticks;
  const auto take = [&](const loop::TapeRecord& record) {
    if (record.kind == loop::kTickRecord) ticks.push_back(session::tick_of(record).value());
    return Status::good();
  };
  REQUIRE(session::walk(tape.value(), {.record = take, .damage = {}, .progress = {}}).ok());
  return ticks;
}

using Table = std::vector<std::vector<std::string>>;  // the first row has the names

Table read_csv(const std::string& path) {
  std::ifstream file(path);
  Table table;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells;
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    table.push_back(cells);
  }
  return table;
}

}  // namespace

TEST_CASE("every number of a CSV reads as the tape's, bit by bit") {
  const Folder folder;
  record(folder / "a.tape", 900);
  ExportOptions options;
  options.tape = folder / "a.tape";
  options.csv = folder / "a.csv";
  const ExportReport report = exported(options);
  CHECK(report.good());
  CHECK(report.rows == 900);
  CHECK(report.bytes == std::filesystem::file_size(options.csv));
  const auto ticks = ticks_of(options.tape);
  const Table table = read_csv(options.csv);
  REQUIRE(table.size() == ticks.size() + 1);
  REQUIRE(table[0].size() == all_columns().size());
  std::size_t different = 0;
  for (std::size_t row = 0; row < ticks.size(); ++row)
    for (std::size_t i = 0; i < all_columns().size(); ++i) {
      const Column& column = all_columns()[i];
      const Value value = value_of(column, {ticks[row], {}}, 1e-3);
      const std::string& cell = table[row + 1].at(i);
      const bool same = column.is_real()
                            ? std::bit_cast<std::uint64_t>(std::stod(cell)) == std::bit_cast<std::uint64_t>(value.real)
                            : std::stoull(cell) == value.count;
      different += same ? 0 : 1;
    }
  CHECK(different == 0);
  // The run pressed: there is something to read.
  CHECK(ticks.back().out.command.wrench.force.z > 0.5);
}

TEST_CASE("from and to choose by the end of the tick, and signals choose the columns") {
  const Folder folder;
  record(folder / "a.tape", 300);
  ExportOptions options;
  options.tape = folder / "a.tape";
  options.csv = folder / "a.csv";
  options.from_s = 0.1;
  options.to_s = 0.15;
  options.signals = {"members"};
  const ExportReport report = exported(options);
  CHECK(report.rows == 50);
  CHECK(report.columns == 3);
  const Table table = read_csv(options.csv);
  CHECK(table[0] == std::vector<std::string>{"tick", "time_s", "members"});
  CHECK(table[1][0] == "99");  // ends at 0.1 s
  CHECK(table.back()[0] == "148");
}

TEST_CASE("the bodies of an export are those of the run, frame by frame") {
  const Folder folder;
  std::map<std::string, std::vector<double>> run;  // by "tick,body": pose
  record(folder / "a.tape", 800, [&](const session::Session& session, const loop::TickOutput& out) {
    for (const physics::Body& body : session.loop->sub_world().world().bodies()) {
      const Vec3d& p = body.motion.pose.position;
      const Quatd& q = body.motion.pose.rotation;
      run[std::to_string(out.tick) + "," + std::to_string(body.id)] = {p.x, p.y, p.z, q.w, q.x, q.y, q.z};
    }
  });
  ExportOptions options;
  options.tape = folder / "a.tape";
  options.csv = folder / "a.csv";
  options.world_Hz = 50;
  const ExportReport report = exported(options);
  CHECK(report.good());
  CHECK(report.frames == 40);
  const Table table = read_csv(folder / "a.bodies.csv");
  REQUIRE(table.size() == report.bodies + 1);
  CHECK(report.bodies >= 40);
  std::size_t different = 0;
  for (std::size_t row = 1; row < table.size(); ++row) {
    const auto& cells = table[row];
    const auto& pose = run.at(cells[0] + "," + cells[2]);
    CHECK(std::stoull(cells[0]) % 20 == 0);
    CHECK(cells[3] == (cells[2] == "0" ? "proxy" : "member"));
    for (std::size_t i = 0; i < pose.size(); ++i) different += std::stod(cells[4 + i]) == pose[i] ? 0 : 1;
  }
  CHECK(different == 0);
}

TEST_CASE(
    "poses of bodies are those of the frame that the scene places, where principal axes are turned and off-centre") {
  const std::string text =
      "effects = []\n[proxy]\nshape = \"compound\"\nmass_kg = 0.2\nposition_m = [0.1, 0.2, 0.3]\n"
      "rotation_vector_rad = [0, 0, 1.5707963267948966]\n"
      "[[proxy.parts]]\nshape = \"box\"\nsize_m = [0.1, 0.01, 0.01]\nposition_m = [0.05, 0, 0]\n"
      "[[proxy.parts]]\nshape = \"box\"\nsize_m = [0.01, 0.06, 0.01]\nposition_m = [0.1, 0.03, 0.02]\n";
  auto parsed = sim::parse_scene(text, "x.toml");
  INFO(parsed.message());
  REQUIRE(parsed.ok());
  const sim::Scene& scene = parsed.value();
  const Posed& own = scene.bodies[0].motion.pose;
  const Posed placed{{0.1, 0.2, 0.3}, normalized(Quatd{1, 0, 0, 1})};
  REQUIRE(norm(own.position - placed.position) > 0.01);
  const Vec3d x{1, 0, 0}, y{0, 1, 0};
  REQUIRE(norm(rotate(own.rotation, x) - rotate(placed.rotation, x)) > 0.1);
  const auto check_same = [&](const Posed& a, const Posed& b) {
    CHECK(norm(a.position - b.position) < 1e-12);
    CHECK(norm(rotate(a.rotation, x) - rotate(b.rotation, x)) < 1e-12);
    CHECK(norm(rotate(a.rotation, y) - rotate(b.rotation, y)) < 1e-12);
  };
  check_same(sim::given_pose(scene, 0, own), placed);
  // Moved as a whole, the frame moves along.
  const Posed move{{0.3, -0.1, 0.2}, normalized(Quatd{1, 0.2, -0.3, 0.4})};
  check_same(sim::given_pose(scene, 0, move * own), move * placed);
}

TEST_CASE("a tape of real time has each tick's times, and replays all the same") {
  const Folder folder;
  const std::string tape = folder / "a.tape";
  session::RunOptions options = test::virtual_options();
  options.coupling = haptics::CouplingScheme::kDirect;
  options.record = tape;
  auto session = test::make_session(test::scene_text(test::kPressScene), options);
  REQUIRE(session->record(tape).ok());
  set_denormals_flush();
  loop::TimedTick<hal::AnyDevice> tick(*session->driver, 1'000'000);
  const std::int64_t before_ns = MonotonicClock::now_ns();
  for (int i = 0; i < 50; ++i) {
    loop::TickTiming timing;
    timing.woke_ns = MonotonicClock::now_ns();
    timing.scheduled_ns = timing.woke_ns - 1'234;
    tick(timing, [&]() noexcept { return session->operator_bits(); });
    session->count_tick();
  }
  const std::int64_t after_ns = MonotonicClock::now_ns();
  session::RunSummary summary = session->summary();
  session->close_tape(summary);
  const auto replayed = session::replay(tape);
  REQUIRE(replayed.ok());
  CHECK(replayed.value().good());
  CHECK(replayed.value().compared == 50);
  ExportOptions to_csv;
  to_csv.tape = tape;
  to_csv.csv = folder / "a.csv";
  to_csv.signals = {"times"};
  (void)exported(to_csv);
  const Table table = read_csv(to_csv.csv);
  REQUIRE(table.size() == 51);
  CHECK(table[0] ==
        std::vector<std::string>{"tick", "time_s", "woke_ns", "wake_ns", "read_ns", "compute_ns", "write_ns"});
  std::int64_t last_ns = before_ns;
  for (std::size_t row = 1; row < table.size(); ++row) {
    const std::int64_t woke_ns = std::stoll(table[row][2]);
    CHECK(woke_ns >= last_ns);
    CHECK(table[row][3] == "1234");
    last_ns = woke_ns + std::stoll(table[row][4]) + std::stoll(table[row][5]) + std::stoll(table[row][6]);
    CHECK(std::stoll(table[row][5]) > 0);
  }
  CHECK(last_ns <= after_ns);
}

TEST_CASE("a damaged tape is exported around the damage, and the export says what is lost") {
  const Folder folder;
  record(folder / "a.tape", 500);
  {
    std::fstream file(folder / "a.tape", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(folder / "a.tape") / 2));
    file.write("damage", 6);
  }
  ExportOptions options;
  options.tape = folder / "a.tape";
  options.csv = folder / "a.csv";
  const ExportReport report = exported(options);
  CHECK_FALSE(report.good());
  CHECK(report.lost_ticks >= 1);
  CHECK(report.rows + report.lost_ticks == 500);
  CHECK(read_csv(options.csv).size() == report.rows + 1);
  CHECK_THAT(report.warning, Contains("its checksum does not match") && Contains("not on the tape"));
}

TEST_CASE("what an export refuses is one line that says what is accepted, and no file is left") {
  const Folder folder;
  record(folder / "a.tape", 50);
  ExportOptions options;
  options.tape = folder / "a.tape";
  CHECK_THAT(refused(options), Contains("no output; accepted: one or more of --csv"));
  options.csv = options.tape;
  options.overwrite = true;
  CHECK_THAT(refused(options), Contains("is the tape; accepted: another file"));
  options.csv = folder / "a.csv";
  options.mcap = folder / "." + std::string("/a.csv");
  CHECK_THAT(refused(options), Contains("is written by --csv; accepted: another file"));
  options.mcap = folder / "none" + std::string("/a.mcap");
  CHECK_THAT(refused(options), Contains("cannot be written: No such file or directory; accepted: "));
  CHECK(folder.files() == 1);  // the tape: the CSV that was begun is gone
  options.mcap.clear();
  options.to_s = 0;
  CHECK_THAT(refused(options), Contains("--to: 0 is not after --from 0; accepted: "));
  options.to_s = 1;
  options.world_Hz = -1;
  CHECK_THAT(refused(options), Contains("--world: -1 is no rate; accepted: "));
  options.world_Hz = 0;
  options.signals = {"smell"};
  CHECK_THAT(refused(options), Contains("--signals: 'smell' is no signal; accepted: "));
  options.signals.clear();
  options.overwrite = false;
  (void)exported(options);
  CHECK_THAT(refused(options), Contains("a.csv: exists; accepted: another name, or --overwrite"));
  options.tape = folder / "none.tape";
  options.overwrite = true;
  CHECK_THAT(refused(options), Contains("none.tape"));
}

TEST_CASE("a full disk is the machine's fault, and one line") {
  const Folder folder;
  record(folder / "a.tape", 50);
  ExportOptions options;
  options.tape = folder / "a.tape";
  options.csv = "/dev/full";
  CHECK_THAT(refused(options, true), Contains("/dev/full: cannot be written: No space left on device"));
}
