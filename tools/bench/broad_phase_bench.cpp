// Pairs of overlapping boxes: the grid of the global world against brute force, on the boxes of a settled heap.
#include <benchmark/benchmark.h>

#include "tools/bench/heap.h"

namespace tactus::bench {
namespace {

template <class T>
void grid_finds_pairs(benchmark::State& state) {
  const auto cubes = static_cast<std::uint32_t>(state.range(0));
  Heap<T> heap(cubes);
  heap.world.begin_step(heap.settings);
  BoundedVector<physics::SlotPair> pairs(16 * cubes);
  for (auto _ : state) {
    pairs.clear();
    benchmark::DoNotOptimize(heap.grid.find(heap.world.bounds(), pairs));
  }
  state.counters["pairs"] = pairs.size();
  state.SetItemsProcessed(state.iterations() * cubes);
}

void brute_force_finds_pairs(benchmark::State& state) {
  const auto cubes = static_cast<std::uint32_t>(state.range(0));
  Heap<double> heap(cubes);
  heap.world.begin_step(heap.settings);
  BoundedVector<physics::SlotPair> pairs(16 * cubes);
  for (auto _ : state) {
    pairs.clear();
    benchmark::DoNotOptimize(physics::find_pairs_brute_force<double>(heap.world.bounds(), pairs));
  }
  state.counters["pairs"] = pairs.size();
  state.SetItemsProcessed(state.iterations() * cubes);
}

BENCHMARK_TEMPLATE(grid_finds_pairs, double)->Arg(64)->Arg(1000)->Arg(10000);
BENCHMARK_TEMPLATE(grid_finds_pairs, float)->Arg(1000);
BENCHMARK(brute_force_finds_pairs)->Arg(64)->Arg(1000);

}  // namespace
}  // namespace tactus::bench
