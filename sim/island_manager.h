// Who of the global world's bodies is awake, and what sleeps beside it.
//
// An island is what hangs together by joints and by overlapping bounds: all that touches, and what is so near that it
// would wake its neighbour in the next step. Static geometry links nobody. When every body of an island has been slow
// for long enough, the whole island leaves the world: its bodies stop, their contacts' impulses are kept, and from then
// on it costs nothing but a look where something awake comes near. It comes back as one: with the bodies where they
// were, and the impulses as warm starts, so that a heap carries its own weight from the first sub-step on. A body's
// place is its rank by id among all that move; its slot, its rank among those that are awake, as in the world. Thread:
// construction [setup]; the rest: the global world's owner, allocates nothing. Frame: world. Units: SI. Bound: as many
// bodies as given; impulses of contacts that do not fit are left out (a colder start).
#pragma once

#include "rt/physics/islands.h"
#include "rt/physics/world.h"
#include "sim/broad_phase/box_grid.h"

namespace tactus::sim {

// When a body counts as slow. Not enabled: nobody ever sleeps.
struct SleepRule {
  bool enabled{false};
  double max_speed_m_per_s{0};  // of its surface
  std::uint32_t steps{0};       // that it must have been slow for
};

class IslandManager {
 public:
  using World = physics::World;
  using Settings = physics::StepSettings;

  // All bodies of the world, all awake.
  IslandManager(const SleepRule& rule, const World& world, std::uint32_t max_contacts);

  // By place; those awake as they were at the last follow().
  std::span<const physics::Body> bodies() const noexcept { return bodies_; }
  // By slot: its place. Ascending.
  std::span<const std::uint32_t> awake() const noexcept { return awake_; }
  std::uint32_t asleep() const noexcept { return grid_.size(); }
  bool is_asleep(std::uint32_t place) const noexcept { return island_of_[place] != kAwake; }
  // Its place; -1 where no moving body has that id.
  std::int32_t place_of(BodyId id) const noexcept;

  // --- before a step: put islands back into the world. True: some came, and slots have moved.
  bool wake(std::uint32_t place, World& world) noexcept;
  bool wake_in(const physics::Aabb& box, World& world) noexcept;
  bool wake_touched(World& world) noexcept;  // what the bounds of the world's bodies overlap, after begin_step

  // By slot, 1: hangs together with nobody that is held (by place, 1) or within one of the regions. Needs the pairs of
  // the step that has begun. Valid until the next call of anything here.
  std::span<const std::uint8_t> find_far(std::span<const std::uint8_t> held, std::span<const physics::Aabb> regions,
                                         World& world) noexcept;

  // --- after a step
  void follow(const World& world) noexcept;  // takes over motions, and counts
  // Takes islands that have been slow for long enough out of the world, but for those with a body that is held (by
  // place, 1) or within one of the regions. `settings`: those of begin_step; `sub_step_s`: of the contacts' impulses.
  void put_to_sleep(std::span<const std::uint8_t> held, std::span<const physics::Aabb> regions,
                    const Settings& settings, double sub_step_s, World& world) noexcept;
  // Before the first step: what does not move has been slow for long enough. Needs the world's pairs.
  void count_resting_as_slow() noexcept;

  // --- books, of the sleepers
  double potential_energy(const Vec3d& gravity) const noexcept;           // J
  double stopped_energy_J() const noexcept { return stopped_energy_J_; }  // kinetic, that sleep has taken
  std::uint64_t fell_asleep() const noexcept { return fell_asleep_; }     // bodies, since the start
  std::uint64_t woke_up() const noexcept { return woke_up_; }             // same
  std::uint64_t state_hash(std::uint64_t of_the_awake) const noexcept;    // the same where nobody sleeps

 private:
  static constexpr std::uint32_t kAwake = 0xffffffffu, kNone = 0xffffffffu;
  struct SleepingContact {  // a contact of a sleeping island
    physics::WarmStart warm_start;
    std::uint32_t next{kNone};
  };

  physics::Aabb bounds_at_rest(std::uint32_t place, const Settings& settings) const noexcept;
  physics::Islands find_islands(World& world) noexcept;
  bool mark(std::uint32_t place) noexcept;
  bool wake_marked(World& world) noexcept;
  void lay_down_body(std::uint32_t slot, std::uint32_t island, const Settings& settings) noexcept;
  void park(const physics::Contact& contact, std::uint32_t island, double sub_step_s) noexcept;

  SleepRule rule_;
  std::vector<physics::Body> bodies_;      // by place
  std::vector<std::uint32_t> awake_;       // by slot
  std::vector<std::uint32_t> slow_steps_;  // by place

  // An island's name is the lowest place in it: its list of bodies begins there.
  std::vector<std::uint32_t> island_of_;     // by place; kAwake
  std::vector<std::uint32_t> next_body_;     // by place: the next of its island
  std::vector<std::uint32_t> first_parked_;  // by island
  std::vector<std::uint8_t> is_marked_;      // by island: to be woken
  std::vector<SleepingContact> parked_;
  std::size_t max_parked_;
  std::uint32_t free_parked_{kNone};
  BoxGrid grid_;

  std::vector<std::uint32_t> parents_;                 // what the islands of a step are kept in
  std::vector<std::uint8_t> stays_, apart_;            // by slot: of an island, by its lowest slot; scratch
  std::vector<std::uint32_t> marked_, woken_, merge_;  // islands to wake; places; scratch
  std::vector<physics::Body> returning_;
  double stopped_energy_J_{0};
  std::uint64_t fell_asleep_{0}, woke_up_{0};
};

}  // namespace tactus::sim
