// The simulated device at 1 kHz, in real time: a thread of the library's runs the loop, this one shows what came of it
// ten times a second, and takes a fault back when its cause is gone. Ctrl-C ends it.
//   real_time SCENE [SECONDS]
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tactus/tactus.h"

namespace {

tactus::Session g_session;

double newtons(const tactus::Tick& tick) { return std::hypot(tick.force_N[0], tick.force_N[1], tick.force_N[2]); }

}  // namespace

int main(int count, char** words) {
  if (count < 2) {
    std::fprintf(stderr, "usage: real_time SCENE [SECONDS]\n");
    return 2;
  }
  tactus::Options options;
  options.real_time = true;
  options.inject = "lost@1000+20";  // after a second the device is silent for 20 ticks: a fault
  if (const tactus::Error error = g_session.open(words[1], options)) {
    std::fprintf(stderr, "real_time: %s\n", error.message().c_str());
    return 1;
  }
  std::signal(SIGINT, [](int) { g_session.stop(); });

  tactus::FaultCode fault = tactus::FaultCode::kNone;
  double fault_s = 0, shown_s = 0, most_N = 0;
  const auto monitor = [&](const tactus::Progress& progress) {
    for (const tactus::Tick& tick : progress.ticks) {
      most_N = std::max(most_N, newtons(tick));
      if (tick.fault == fault) continue;
      fault = tick.fault;
      fault_s = tick.time_s;
      std::printf("tick %llu: %s\n", static_cast<unsigned long long>(tick.number),
                  std::string(tactus::describe(fault)).c_str());
    }
    const tactus::Tick& now = g_session.last();
    if (fault != tactus::FaultCode::kNone && now.time_s > fault_s + 0.3) g_session.request(tactus::Request::kRearm);
    if (now.time_s < shown_s + 0.1) return true;
    shown_s = now.time_s;
    const tactus::BodyState& proxy = g_session.bodies()[g_session.scene().proxy()];
    std::printf("%6.1f s  %5.2f N, at most %5.2f N  proxy at %6.1f mm  members %3u  late ticks %llu\n", now.time_s,
                newtons(now), most_N, 1e3 * proxy.position_m[2], now.members,
                static_cast<unsigned long long>(progress.overruns));
    most_N = 0;
    return true;  // false ends the run
  };
  if (const tactus::Error error = g_session.run(count > 2 ? std::atof(words[2]) : 5, monitor)) {
    std::fprintf(stderr, "real_time: %s\n", error.message().c_str());
    return 1;
  }
  std::printf("%s", g_session.summary().text.c_str());
  return fault == tactus::FaultCode::kNone ? 0 : 1;
}
