// bench_view_server SCENE: serves the page of tactus view with all moving bodies of the scene in motion, 60 times a
// second and 17 ticks a frame, without simulating anything; what a page takes of it is measured by
// tools/bench/view_in_browser. Prints the address, and at its end (SIGTERM) what it sent.
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <csignal>

#include "rt/base/clock.h"
#include "sim/loader/scene_load.h"
#include "tools/experiment/shared_files.h"
#include "tools/publication/packed.h"
#include "tools/view/admission.h"
#include "tools/view/scene_text.h"
#include "tools/view/server.h"

namespace tactus::bench {
namespace {

std::atomic<bool> g_stop{false};
void ask_to_stop(int) { g_stop.store(true); }

class MovingSource final : public view::ViewSource {
 public:
  explicit MovingSource(const sim::Scene& scene) : scene_(view::scene_text(scene, {})) {
    for (const physics::Body& body : scene.bodies)
      if (body.kind == physics::BodyKind::kDynamic) at_.push_back(publication::position_of(body.motion.pose.position));
  }

  const std::string& scene(std::size_t) const override { return scene_; }

  Update look(std::size_t, std::vector<publication::TickEntry>& ticks, publication::Frame& frame) override {
    constexpr double kPeriod_s = 1.0 / 60;
    const double now_s = 1e-9 * static_cast<double>(MonotonicClock::now_ns());
    if (now_s < next_s_) return {};
    next_s_ = std::max(now_s, next_s_ + kPeriod_s);
    frame.head = {.time_s = 1e-3 * static_cast<double>(tick_), .bodies = static_cast<std::uint32_t>(at_.size())};
    frame.positions = at_;
    frame.rotations.assign(at_.size(), {});
    frame.roles.assign(at_.size(), std::uint8_t{0});
    frame.roles[0] = publication::kIsProxy | publication::kIsMember;
    const auto swing = static_cast<float>(0.01 * std::sin(5 * now_s));
    for (publication::Position& position : frame.positions) position.z += swing;
    for (int i = 0; i < 17; ++i) {
      ticks.emplace_back();
      ticks.back().tick.out.tick = tick_++;
    }
    return {.lost = 0, .fresh = true, .restarted = false};
  }

  view::Answer ask(const view::PageMessage&) override { return {}; }

 private:
  std::string scene_;
  std::vector<publication::Position> at_;
  double next_s_{0};
  std::uint64_t tick_{0};
};

int serve(const char* name) {
  const auto scene = sim::load_scene(name);
  auto files = view::load_files(experiment::shared_file("view"));
  if (!scene.ok() || !files.ok()) {
    fmt::print(stderr, "{}\n", scene.ok() ? files.message() : scene.message());
    return 2;
  }
  auto server = view::ViewServer::open({.files = std::move(files).value(), .token = view::make_token()},
                                       std::make_unique<MovingSource>(scene.value()));
  if (!server.ok()) return 3;
  std::signal(SIGTERM, ask_to_stop);
  fmt::print("{}\n", server.value()->address());
  std::fflush(stdout);
  const view::ViewReport report = server.value()->serve(g_stop);
  fmt::print("{{\"frames_sent\": {}, \"frames_dropped\": {}, \"bytes\": {}}}\n", report.frames_sent,
             report.frames_dropped, report.bytes);
  return 0;
}

}  // namespace
}  // namespace tactus::bench

int main(int argc, char** argv) { return argc == 2 ? tactus::bench::serve(argv[1]) : 2; }
