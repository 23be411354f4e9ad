// Five seconds of a scene in virtual time: what the hand feels, and how many bodies it can feel.
//   first_touch SCENE
#include <cmath>
#include <cstdio>

#include "tactus/tactus.h"

int main(int count, char** words) {
  tactus::Session session;
  if (const tactus::Error error = session.open(count > 1 ? words[1] : "card_house.toml")) {
    std::fprintf(stderr, "%s\n", error.message().c_str());
    return 1;
  }
  std::printf("%s: %u bodies\n  time s  force N  members  contacts\n", session.scene().title().c_str(),
              session.scene().bodies());
  while (session.time_s() < 5) {
    if (const tactus::Error error = session.step(500)) {
      std::fprintf(stderr, "%s\n", error.message().c_str());
      return 1;
    }
    const tactus::Tick& tick = session.last();
    std::printf("%8.1f %8.3f %8u %9u\n", session.time_s(),
                std::hypot(tick.force_N[0], tick.force_N[1], tick.force_N[2]), tick.members, tick.contacts);
  }
  std::printf("%s", session.summary().text.c_str());
}
