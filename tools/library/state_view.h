// The arrays behind Session's views: filled from both worlds when somebody looks, never moved while a session is open.
//
// Thread: the session's owner; take() the global world's. Frame: world. Bound: bind() allocates for the scene; nothing
// else does. What a world has more of than the arrays were made for does not happen: they have the worlds' capacities.
#pragma once

#include <atomic>
#include <vector>

#include "tactus/state.h"
#include "tools/session/session.h"

namespace tactus::library {

struct StateView {
  std::vector<BodyState> bodies;  // by number
  std::vector<Role> roles;        // by number
  std::vector<BodyNumber> members;
  std::vector<Contact> contacts;
  std::vector<BorderContact> border;

  // [setup] As the scene begins. With a scene of the same size the arrays stay where they are.
  void bind(const session::Session& session);
  // From both worlds, which nobody steps meanwhile.
  void look(const session::Session& session);
  // Bodies, roles and members as the global world has them.
  void look(const sim::GlobalWorld& world);

 private:
  void place_members(const session::Session& session);
  void list_contacts(const session::Session& session);
  void list_border(const session::Session& session);
};

// Hands the global world's state over to a thread that looks now and then: none waits for the other. Bound: the copy is
// made only where a look was taken since the last one.
class StateHandOver {
 public:
  void bind(const session::Session& session) { view_.bind(session); }
  // [global world's thread] After a step.
  void take(const sim::GlobalWorld& world) noexcept;
  // [the looking thread] True: `view` has a newer state.
  bool look(StateView& view);

 private:
  StateView view_;
  std::atomic<bool> filled_{false};  // true: the looker's to read; false: the world's to fill
};

}  // namespace tactus::library
