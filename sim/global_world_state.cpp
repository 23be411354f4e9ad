// Saves the state of the global world and restores it.
#include <tuple>

#include "sim/global_world.h"

namespace tactus::sim {
namespace {

template <class Tie>
struct CopyOf;
template <class... T>
struct CopyOf<std::tuple<T&...>> {
  using Type = std::tuple<std::remove_const_t<T>...>;
};

// The bytes grow to the present state's size; the bound at full capacity is far larger.
template <class State>
std::vector<std::byte> saved_bytes(const State& state) {
  std::vector<std::byte> bytes(1u << 20);
  ByteWriter out(bytes);
  for (state.save(out); !out.ok(); state.save(out)) {
    TACTUS_CHECK(bytes.size() < state.save_size_bound(), bytes.size(), state.save_size_bound());
    bytes.resize(2 * bytes.size());
    out = ByteWriter(bytes);
  }
  bytes.resize(out.size());
  bytes.shrink_to_fit();  // a copy may be kept for long
  return bytes;
}

}  // namespace

template <class Self>
auto GlobalWorld::state_of(Self& self) noexcept {
  return std::tie(self.stepped_, self.macro_step_s_, self.settings_, self.islands_, self.pair_cache_, self.graph_,
                  self.approach_, self.border_exchange_, self.devices_, self.touches_, self.bounds_, self.free_,
                  self.kept_awake_, self.member_slots_, self.velocity_before_, self.regions_, self.asleep_J_,
                  self.asleep_of_, self.time_s_, self.statistics_);
}

struct GlobalWorld::Saved {
  std::vector<std::byte> world;
  std::vector<std::vector<std::byte>> predictions;
  CopyOf<decltype(state_of(std::declval<const GlobalWorld&>()))>::Type rest;
};

std::vector<std::byte> GlobalWorld::saved_world() const { return saved_bytes(world_); }

void GlobalWorld::restore_world(std::span<const std::byte> bytes) noexcept {
  ByteReader in(bytes);
  const bool whole = world_.restore(in);
  TACTUS_CHECK(whole, bytes.size(), in.remaining());
  world_.index_fixed_bodies();
}

std::shared_ptr<const GlobalWorld::Saved> GlobalWorld::save() const {
  std::vector<std::vector<std::byte>> predictions;
  for (const auto& prediction : predictions_) predictions.push_back(saved_bytes(*prediction));
  return std::make_shared<const Saved>(Saved{saved_world(), std::move(predictions), state_of(*this)});
}

void GlobalWorld::restore(const Saved& saved) {
  restore_world(saved.world);
  state_of(*this) = saved.rest;
  for (std::size_t d = 0; d < predictions_.size(); ++d) {
    ByteReader in(saved.predictions[d]);
    const bool whole = predictions_[d]->restore(in);
    TACTUS_CHECK(whole, saved.predictions[d].size(), in.remaining());
  }
}

}  // namespace tactus::sim
