// state_hash SCENE TICKS: runs the scene in virtual time and prints the hash of its final state. A program of its own,
// so that a second build of the same sources (Debug) can be asked without the whole program and its tools.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>

#include "sim/loader/scene_load.h"
#include "tools/session/virtual_run.h"

int main(int count, char** words) {
  using namespace tactus;
  const auto fail = [](const std::string& why) {
    std::fprintf(stderr, "state_hash: %s\n", why.c_str());
    return 2;
  };
  if (count != 3) return fail("usage: state_hash SCENE TICKS");
  auto scene = sim::load_scene(words[1]);
  if (!scene.ok()) return fail(scene.message());
  session::RunOptions options;
  options.virtual_time = true;
  auto session = session::Session::create(std::move(scene).value(), options);
  if (!session.ok()) return fail(session.message());
  const auto summary = session::run_virtual(*session.value(), std::strtoull(words[2], nullptr, 10), {});
  if (!summary.ok()) return fail(summary.message());
  std::printf("%016" PRIx64 "\n", summary.value().state_hash);
  return 0;
}
