// Pairs of overlapping boxes: the grid of the global world, its cache, and brute force, on the boxes of a settled heap.
#include <benchmark/benchmark.h>

#include "tools/bench/heap.h"

namespace tactus::bench {
namespace {

template <class Find>
void find_pairs(benchmark::State& state, Find&& find) {
  const auto cubes = static_cast<std::uint32_t>(state.range(0));
  Heap heap(cubes);
  heap.world.begin_step(heap.settings);
  BoundedVector<physics::SlotPair> pairs(16 * cubes);
  for (auto _ : state) {
    pairs.clear();
    benchmark::DoNotOptimize(find(heap.world.bounds(), pairs));
  }
  state.counters["pairs"] = pairs.size();
  state.SetItemsProcessed(state.iterations() * cubes);
}

void grid_finds_pairs(benchmark::State& state) {
  sim::PairGrid grid(static_cast<std::uint32_t>(state.range(0)));
  find_pairs(state, [&](auto bounds, auto& pairs) { return grid.find(bounds, pairs); });
}

// Of a heap at rest: what is left when nothing moves.
void cache_finds_pairs(benchmark::State& state) {
  const auto cubes = static_cast<std::uint32_t>(state.range(0));
  sim::PairCache cache(cubes, 16 * cubes);
  find_pairs(state, [&](auto bounds, auto& pairs) { return cache.find(bounds, pairs); });
}

void brute_force_finds_pairs(benchmark::State& state) {
  find_pairs(state, [](auto bounds, auto& pairs) { return physics::find_pairs_brute_force(bounds, pairs); });
}

BENCHMARK(grid_finds_pairs)->Arg(64)->Arg(1000)->Arg(10000);
BENCHMARK(cache_finds_pairs)->Arg(64)->Arg(1000)->Arg(10000);
BENCHMARK(brute_force_finds_pairs)->Arg(64)->Arg(1000);

}  // namespace
}  // namespace tactus::bench
