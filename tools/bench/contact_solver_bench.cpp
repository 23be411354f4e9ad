// Steps of a settled heap with different numbers of sub-steps: the difference is the cost of the solver's sweeps.
#include <benchmark/benchmark.h>

#include "tools/bench/heap.h"

namespace tactus::bench {
namespace {

void heap_steps(benchmark::State& state, physics::SweepPrecision precision) {
  const auto cubes = static_cast<std::uint32_t>(state.range(0));
  Heap heap(cubes, precision);
  heap.settings.sub_steps = static_cast<std::uint32_t>(state.range(1));
  for (auto _ : state) heap.step();
  state.counters["points"] = heap.report.points;
  state.counters["per_point"] = benchmark::Counter(
      heap.report.points, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"cubes", "sub_steps"})->Unit(benchmark::kMicrosecond);
  for (const int cubes : {64, 1000})
    for (const int sub_steps : {4, 8}) b->Args({cubes, sub_steps});
}
BENCHMARK_CAPTURE(heap_steps, double, physics::SweepPrecision::kFull)->Apply(sizes);
BENCHMARK_CAPTURE(heap_steps, mixed, physics::SweepPrecision::kSingle)->Apply(sizes);

}  // namespace
}  // namespace tactus::bench
