// Puts islands of the global world to sleep and wakes them.
//
// An island is a set of bodies connected by joints and by overlapping bounds: bodies that touch, or are near enough
// that one would wake the other in the next step. Static geometry does not connect bodies. When every body of an island
// has been slow for long enough, the island is removed from the world: its bodies' velocities are set to 0 and its
// contacts' impulses are stored. A sleeping island costs only a grid query for the awake bodies near it. It wakes as a
// whole: its bodies return at their poses, and the impulses are warm starts, so that a heap carries its own weight from
// the first sub-step. Bodies are identified by BodyIndex (body_index.h); a slot is the index in the world.
// Thread: construction [setup]; the rest: the global world's owner, allocates nothing. Frame: world. Units: SI. Bound:
// as many bodies as given; contact impulses that do not fit are dropped (those contacts start cold).
#pragma once

#include "rt/physics/islands.h"
#include "rt/physics/world.h"
#include "sim/body_index.h"
#include "sim/broad_phase/box_grid.h"

namespace tactus::sim {

// When a body may sleep. Not enabled: no body ever sleeps.
struct SleepRule {
  bool enabled{false};
  double max_speed_m_per_s{0};  // bound on the speed of its surface
  std::uint32_t steps{0};       // consecutive slow steps before it may sleep
};

class IslandManager {
 public:
  using World = physics::World;
  using Settings = physics::StepSettings;

  // Starts with all dynamic bodies of `world`, all awake.
  IslandManager(const SleepRule& rule, const World& world, std::uint32_t max_contacts);

  // All moving bodies; awake ones as at the last follow().
  BodySpan<const physics::Body> bodies() const noexcept { return bodies_; }
  // The awake bodies, by slot of the world; ascending.
  std::span<const BodyIndex> awake() const noexcept { return awake_; }
  std::uint32_t asleep() const noexcept { return grid_.size(); }
  bool is_asleep(BodyIndex body) const noexcept { return island_of_[body] != kAwake; }
  // Empty if no moving body has that id.
  std::optional<BodyIndex> index_of(BodyId id) const noexcept;

  // --- before a step: put islands back into the world. True: some were inserted, and slots have changed.
  bool wake(BodyIndex body, World& world) noexcept;
  bool wake_in(const physics::Aabb& box, World& world) noexcept;
  bool wake_touched(World& world) noexcept;  // islands that the world's bounds overlap; call after begin_step

  // Per slot: 1 if no body of the body's island is kept awake (`kept_awake`: 1) or overlaps one of the regions. Needs
  // the pairs of the step that has begun. Valid until the next call of any function here.
  std::span<const std::uint8_t> find_coarse(BodySpan<const std::uint8_t> kept_awake,
                                            std::span<const physics::Aabb> regions, World& world) noexcept;

  // --- after a step
  void follow(const World& world) noexcept;  // copies the motions and counts slow steps
  // Removes islands that have been slow for long enough from the world, except those with a body that is kept awake
  // (`kept_awake`: 1) or overlaps one of the regions. `settings`: those of begin_step; `sub_step_s`: the sub-step of
  // the contacts' impulses.
  void put_to_sleep(BodySpan<const std::uint8_t> kept_awake, std::span<const physics::Aabb> regions,
                    const Settings& settings, double sub_step_s, World& world) noexcept;
  // Before the first step: bodies at rest count as slow for long enough. Needs the world's pairs.
  void count_resting_as_slow() noexcept;

  // --- diagnostics of the sleeping bodies
  double potential_energy(const Vec3d& gravity) const noexcept;           // J
  double stopped_energy_J() const noexcept { return stopped_energy_J_; }  // kinetic energy removed by sleep
  std::uint64_t fell_asleep() const noexcept { return fell_asleep_; }     // bodies, since the start
  std::uint64_t woke_up() const noexcept { return woke_up_; }             // same
  std::uint64_t state_hash(std::uint64_t of_the_awake) const noexcept;    // of_the_awake if no body sleeps

 private:
  static constexpr BodyIndex kAwake{0xffffffffu}, kNoBodyIndex{0xffffffffu};
  static constexpr std::uint32_t kNone = 0xffffffffu;
  struct SleepingContact {  // a contact of a sleeping island
    physics::WarmStart warm_start;
    std::uint32_t next{kNone};
  };

  physics::Aabb bounds_at_rest(BodyIndex body, const Settings& settings) const noexcept;
  physics::Islands find_islands(World& world) noexcept;
  bool mark(BodyIndex body) noexcept;
  bool wake_marked(World& world) noexcept;
  void put_body_to_sleep(BodyIndex body, BodyIndex island, const Settings& settings) noexcept;
  void store_contact(const physics::Contact& contact, BodyIndex island, double sub_step_s) noexcept;

  SleepRule rule_;
  BodyVector<physics::Body> bodies_;
  std::vector<BodyIndex> awake_;          // by slot
  BodyVector<std::uint32_t> slow_steps_;  // consecutive slow steps, at most SleepRule::steps

  // An island is identified by its lowest body, the first of its linked list.
  BodyVector<BodyIndex> island_of_;           // its island; kAwake
  BodyVector<BodyIndex> next_body_;           // the next of its island; kNoBodyIndex
  BodyVector<std::uint32_t> first_sleeping_;  // of an island: its first sleeping contact; kNone
  BodyVector<std::uint8_t> is_marked_;        // of an island: 1 if in marked_
  std::vector<SleepingContact> sleeping_contacts_;
  std::size_t max_sleeping_;
  std::uint32_t free_sleeping_{kNone};
  BoxGrid grid_;

  std::vector<std::uint32_t> parents_;             // by slot: union-find parents; scratch
  std::vector<std::uint8_t> stays_, apart_;        // by an island's lowest slot; by slot; scratch
  std::vector<BodyIndex> marked_, woken_, merge_;  // islands to wake; bodies; scratch
  std::vector<physics::Body> returning_;
  double stopped_energy_J_{0};
  std::uint64_t fell_asleep_{0}, woke_up_{0};
};

}  // namespace tactus::sim
