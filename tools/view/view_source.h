// What a viewer shows: a running controller (live_source.h), or tapes (tape_source.h).
//
// Thread: one, the server's. Bound: a look takes some ms at most.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/publication/watcher.h"
#include "tools/view/page_messages.h"

namespace tactus::view {

// The result of a page's request, in words.
struct Answer {
  bool ok{false};
  std::string said;
};

class ViewSource {
 public:
  virtual ~ViewSource() = default;

  // Number of worlds that are shown side by side; `view` below is an index.
  virtual std::size_t views() const { return 1; }
  // Whose run it is, as "hand 1 of 2"; empty where there is one hand.
  virtual std::string hand() const { return {}; }
  // The first message of a page (scene_text.h).
  virtual const std::string& scene(std::size_t view) const = 0;

  struct Update {
    std::uint64_t lost{0};  // ticks
    bool fresh{false};      // `frame` is new
    bool restarted{false};  // the ticks go on at another time: those before are no longer valid
  };
  // Reads what is new since the last call: ticks are appended, the frame is replaced. Called about 60 times a second,
  // for every view in turn.
  virtual Update look(std::size_t view, std::vector<publication::TickEntry>& ticks, publication::Frame& frame) = 0;
  virtual bool ended() { return false; }

  // The state of playing as one JSON object; pages get it when it has changed. Empty: none.
  virtual std::string status() { return {}; }
  virtual Answer ask(const PageMessage& message) = 0;
  // Called when a page has joined, before its first tick.
  virtual void joined() {}
  // True if force would reach a person's hand.
  virtual bool real_device() const { return false; }
};

}  // namespace tactus::view
