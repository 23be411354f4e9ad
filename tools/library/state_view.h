// The arrays of Session's views: filled from all worlds on request, and never moved while a session is open.
//
// Thread: the session's owner; take(): the global world's. Frame: world. Bound: only bind() allocates. The arrays have
// the worlds' capacities and cannot overflow.
#pragma once

#include <atomic>
#include <vector>

#include "tactus/state.h"
#include "tools/session/session.h"

namespace tactus::library {

struct StateView {
  std::vector<BodyState> bodies;  // by number
  struct Hand {
    std::vector<Role> roles;  // by number
    std::vector<BodyNumber> members;
    std::vector<Contact> contacts;
    std::vector<BorderContact> border;
  };
  std::vector<Hand> hands;

  // One session for each hand, in their order.
  using Sessions = std::span<session::Session* const>;

  // [setup] Fills the arrays with the initial state. For a scene of the same size the arrays keep their addresses.
  void bind(Sessions sessions);
  // Reads all worlds; no thread may step them meanwhile.
  void look(Sessions sessions);
  // Reads bodies, roles and members from the global world.
  void look(const sim::GlobalWorld& world);

 private:
  void place_members(const session::Session& session, Hand& hand);
  void list_contacts(const session::Session& session, Hand& hand);
  void list_border(const session::Session& session, Hand& hand);

  const sim::Scene* scene_{nullptr};  // of the sessions that it is bound to
};

// Passes the global world's state to a thread that reads it at a low rate; neither waits for the other. Bound: a copy
// is made only after the previous one has been read.
class StateHandOver {
 public:
  void bind(StateView::Sessions sessions) { view_.bind(sessions); }
  // [global world's thread] Called after a step.
  void take(const sim::GlobalWorld& world) noexcept;
  // [reading thread] True: `view` was updated to a newer state.
  bool look(StateView& view);

 private:
  StateView view_;
  std::atomic<bool> filled_{false};  // true: owned by the reading thread; false: owned by the global world's thread
};

}  // namespace tactus::library
