// What a watcher costs: packing a frame beside a step of the global world, copying it, and a page's messages with their
// bytes. A frame is packed at most 60 times a second, so its time is waited for between two turns. Without arguments it
// also says which program prints which row of the table in tools/view/README.md.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <thread>

#include "rt/base/denormals.h"
#include "sim/loader/scene_load.h"
#include "tools/experiment/shared_files.h"
#include "tools/publication/publication.h"
#include "tools/publication/watcher.h"
#include "tools/session/virtual_run.h"
#include "tools/view/page_stream.h"

namespace tactus::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

double thread_time_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// The heap of 5,000 bodies after 0.3 s of virtual time, all awake, and its publication.
struct Heap5000 {
  std::unique_ptr<session::Session> session;
  std::unique_ptr<publication::Publication> publication;

  Heap5000() {
    set_denormals_flush();
    session::RunOptions options;
    options.virtual_time = true;
    options.duration_s = 1;
    auto scene = sim::load_scene(experiment::shared_file("scenes") / "pile5000.toml");
    TACTUS_CHECK(scene.ok(), 0, 0);
    session = std::move(session::Session::create(std::move(scene).value(), options)).value();
    session::VirtualRun run(*session);
    for (int i = 0; i < 300; ++i) run.tick();
    publication = std::move(publication::Publication::create(session->scene, 1e-3, "{}")).value();
    publication->watchers() = 1;
  }
  static Heap5000& get() {
    static Heap5000 heap;
    return heap;
  }
};

void global_step_of_5000(benchmark::State& state) {
  Heap5000& heap = Heap5000::get();
  for (auto _ : state) heap.session->global->advance();
}

void packing_5000(benchmark::State& state) {
  Heap5000& heap = Heap5000::get();
  for (auto _ : state) {
    std::this_thread::sleep_for(std::chrono::milliseconds(17));
    const auto from = Clock::now();
    publication::Publication::stepped(heap.publication.get(), *heap.session->global);
    state.SetIterationTime(Seconds(Clock::now() - from).count());
  }
}

// A step and what is packed after it, at most 60 times a second, as the global thread does while watched. The ratio is
// of the same steps, with and without what follows them, in processor time: other programs do not count.
void global_step_watched(benchmark::State& state) {
  Heap5000& heap = Heap5000::get();
  double step_s = 0, packing_s = 0;
  for (auto _ : state) {
    const double from_s = thread_time_s();
    heap.session->global->advance();
    const double stepped_s = thread_time_s();
    publication::Publication::stepped(heap.publication.get(), *heap.session->global);
    packing_s += thread_time_s() - stepped_s;
    step_s += stepped_s - from_s;
  }
  state.counters["watched_over_not"] = (step_s + packing_s) / step_s;
}

publication::Frame frame_of(std::size_t bodies) {
  publication::Frame frame;
  frame.head.bodies = static_cast<std::uint32_t>(bodies);
  frame.positions.resize(bodies);
  frame.rotations.resize(bodies);
  frame.roles.resize(bodies);
  return frame;
}

// `bodies`, of which `moving` move in each message; without ticks and contacts.
void message_to_a_page(benchmark::State& state) {
  publication::Frame frame = frame_of(static_cast<std::size_t>(state.range(0)));
  const auto moving = static_cast<std::size_t>(state.range(1));
  view::PageStream stream;
  std::size_t bytes = 0;
  const auto send = [&] {
    stream.offer_frame();
    const std::string message = stream.take(frame, 0);
    view::WireHeader header;
    std::memcpy(&header, message.data(), sizeof header);
    stream.acknowledge(header.number);
    bytes = message.size();
  };
  send();
  for (auto _ : state) {
    for (std::size_t i = 0; i < moving; ++i) frame.positions[i].x += 1e-3f;
    send();
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}

void nobody_watches(benchmark::State& state) {
  Heap5000& heap = Heap5000::get();
  heap.publication->watchers() = 0;
  for (auto _ : state) publication::Publication::stepped(heap.publication.get(), *heap.session->global);
  heap.publication->watchers() = 1;
}

BENCHMARK(global_step_of_5000)->Unit(benchmark::kMillisecond);
BENCHMARK(packing_5000)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(100);
BENCHMARK(global_step_watched)->Unit(benchmark::kMillisecond);
BENCHMARK(nobody_watches);
BENCHMARK(message_to_a_page)
    ->Args({5000, 5000})
    ->Args({50400, 300})
    ->Args({50400, 50400})
    ->Unit(benchmark::kMicrosecond);

struct Row {
  const char *figure, *bound, *printed_by;
};
constexpr Row kRows[] = {
    {"instructions of a tick, watched or not", "equal to 0.1 %", "view_instructions"},
    {"instructions of the record of a tick's times", "300 a tick", "view_instructions"},
    {"wake-up and own part of a tick, watched or not", "p50 1.02, p99 1.1 times", "tactus timing --with-viewer"},
    {"global step of 5,000 bodies while watched", "1.03 times", "global_step_watched, here"},
    {"global step after the last watcher left", "1.00 +- 0.01 times", "nobody_watches, here: what it adds"},
    {"controller's memory", "32 MB more", "view_costs"},
    {"bytes a frame: 5,000 bodies, all moving", "100 kB", "message_to_a_page/5000/5000, here"},
    {"bytes a frame: 50,400 bodies, 300 moving", "10 kB", "message_to_a_page/50400/300, here"},
    {"frames that a page takes", "5,000: 55/s, 7 MB/s; 50,400: 20/s", "view_in_browser BUILD --frames"},
    {"draw calls", "60 in any scene", "view_in_browser BUILD --draw-calls"},
    {"pointer to tick, to page", "p95 25 ms, 100 ms later", "view_in_browser BUILD --pointer"},
    {"first picture after tactus view", "2 s at 5,000 bodies", "view_in_browser BUILD --first-picture"},
    {"export", "CSV 20 times, HDF5 and MCAP 50 times real time", "view_costs"},
};

void print_rows() {
  std::printf("\n%-48s %-48s %s\n", "figure", "bound", "printed by (programs of tools/bench)");
  for (const Row& row : kRows) std::printf("%-48s %-48s %s\n", row.figure, row.bound, row.printed_by);
}

}  // namespace
}  // namespace tactus::bench

int main(int argc, char** argv) {
  const bool everything = argc == 1;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  if (everything) tactus::bench::print_rows();
  return 0;
}
