// Steps whose instructions tools/bench/step_instructions counts: bench_counted_steps SCENE STEPS, on one thread. SCENE:
// a row of `tactus experiment peers`, settled for as long as there. Prints what was solved, one "name value" a line.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tools/experiment/engine.h"
#include "tools/experiment/instructions.h"

namespace tactus::bench {

int run(const char* name, int steps) {
  const auto scene = experiment::make_scene(name, false);
  if (!scene) {
    std::fprintf(stderr, "no such row: %s\n", name);
    return EXIT_FAILURE;
  }
  const auto engine = experiment::make_tactus(*scene, {});
  const auto settle_steps = static_cast<int>(std::lround(scene->settle_s / scene->step_s));
  for (int i = 0; i < settle_steps; ++i) engine->step();
  double points = 0;
  for (int i = 0; i < steps; ++i) {
    experiment::start_counting();
    engine->step();
    experiment::stop_counting();
    points += engine->measure().contacts;
  }
  std::printf("bodies %zu\npoints %.1f\n", scene->cubes.size(), points / steps);
  if (!engine->failure().empty()) {
    std::fprintf(stderr, "%s\n", engine->failure().c_str());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

}  // namespace tactus::bench

int main(int argc, char** argv) {
  const int steps = argc == 3 ? std::atoi(argv[2]) : 0;
  if (steps > 0) return tactus::bench::run(argv[1], steps);
  std::fprintf(stderr, "bench_counted_steps SCENE STEPS\n");
  return EXIT_FAILURE;
}
