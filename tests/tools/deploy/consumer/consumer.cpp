// What a user of the library gets wrong: each is an error of one line that says what is accepted, and the program goes
// on. Prints the lines; exit status 1 where one is missing or says nothing.
#include <cmath>
#include <cstdio>
#include <string>

#include <tactus/tactus.h>

namespace {

int g_missing = 0;

void expect(const tactus::Error& error, tactus::Error::Kind kind, const std::string& part) {
  const bool good = error.kind() == kind && error.message().find(part) != std::string::npos &&
                    error.message().find('\n') == std::string::npos;
  std::printf("%s %s\n", good ? "  " : "NO", error.message().c_str());
  g_missing += good ? 0 : 1;
}

struct BadDevice final : tactus::Device {
  tactus::DeviceProperties properties() const override {
    tactus::DeviceProperties p;
    p.max_force_N = -1;
    return p;
  }
  tactus::Reading read(tactus::DeviceSample&) noexcept override { return tactus::Reading::kMissing; }
  void write(const tactus::DeviceCommand&) noexcept override {}
};

}  // namespace

int main(int count, char** words) {
  if (count != 2) return 2;
  using Kind = tactus::Error::Kind;
  tactus::Session session;
  expect(session.tick(), Kind::kUse, "after Session::open");
  expect(session.open("no_scene.toml"), Kind::kFile, "no_scene.toml");
  tactus::Scene scene;
  expect(session.open(scene), Kind::kUse, "after Scene::load");
  expect(scene.load(words[1]), Kind::kNone, "");
  tactus::Options options;
  options.coupling = "glue";
  expect(session.open(scene, options), Kind::kOption, "coupling: 'glue' is none; accepted: sub-world");
  options.coupling = "sub-world";
  options.rate_Hz = 10;
  expect(session.open(scene, options), Kind::kOption, "rate_Hz: 10 is out of range; accepted: 100 to 10000 Hz");
  options.rate_Hz = 1000;
  options.device = "usb";
  expect(session.open(scene, options), Kind::kOption, "usb keeps real time");
  options.device = "can:none0";
  options.real_time = true;
  expect(session.open(scene, options), Kind::kMachine, "none0");
  BadDevice device;
  expect(session.open(scene, {}, device), Kind::kOption, "max_force_N is -1; accepted: a number > 0");
  expect(session.open(scene), Kind::kNone, "");
  expect(session.run(1), Kind::kUse, "Options::real_time = true");
  expect(session.record("/no/folder/x.tape"), Kind::kFile, "cannot be written");
  expect(session.step(20), Kind::kNone, "");
  expect(session.record("x.tape"), Kind::kUse, "before the first tick");
  tactus::Replay replay;
  expect(tactus::replay_tape(words[1], replay), Kind::kFile, "tape");
  if (session.bodies().size() != scene.bodies() || session.ticks().size() != 20) ++g_missing;
  return g_missing == 0 ? 0 : 1;
}
