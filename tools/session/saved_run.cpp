// The state of a run in virtual time: saves and restores all of its parts.
#include "tools/session/virtual_run.h"

namespace tactus::session {

struct VirtualRun::Saved {
  std::vector<std::byte> loop;
  Driver::State driver;
  loop::Governor governor;
  std::optional<hal::SimulatedDevice> device;             // none with a device of the caller's own
  std::shared_ptr<const sim::GlobalWorld::Saved> global;  // null with the direct coupling, as is `exchange`
  std::unique_ptr<haptics::Exchange> exchange;
  std::uint64_t next_report{0};
  loop::RunStats stats;
  Session::Progress progress;
  std::uint64_t tick{0};
  VirtualWorld::Clock clock;
};

std::shared_ptr<const VirtualRun::Saved> VirtualRun::save() const {
  std::vector<std::byte> bytes(session_.loop->save_size_bound());
  ByteWriter out(bytes);
  session_.loop->save(out);
  TACTUS_CHECK(out.ok(), out.size(), bytes.size());
  bytes.resize(out.size());
  auto saved = std::make_shared<Saved>(Saved{std::move(bytes),
                                             session_.driver->state(),
                                             *session_.governor,
                                             {},
                                             {},
                                             {},
                                             0,
                                             session_.stats,
                                             session_.progress(),
                                             tick_,
                                             {}});
  if (const hal::SimulatedDevice* device = session_.simulated()) saved->device = *device;
  if (session_.global == nullptr) return saved;
  saved->global = session_.global->save();
  saved->exchange = std::make_unique<haptics::Exchange>();
  saved->exchange->snapshots.copy_from(session_.exchange->snapshots);
  saved->exchange->reports.copy_from(session_.exchange->reports);
  saved->next_report = world_->next_report();
  saved->clock = world_->clock();
  return saved;
}

void VirtualRun::restore(const Saved& saved) {
  ByteReader in(saved.loop);
  const bool whole = session_.loop->restore(in);
  TACTUS_CHECK(whole, saved.loop.size(), in.remaining());
  session_.driver->set_state(saved.driver);
  *session_.governor = saved.governor;
  if (saved.device) *session_.device->as<hal::SimulatedDevice>() = *saved.device;
  session_.stats = saved.stats;
  session_.set_progress(saved.progress);
  tick_ = saved.tick;
  if (session_.global == nullptr) return;
  session_.global->restore(*saved.global);
  session_.exchange->snapshots.copy_from(saved.exchange->snapshots);
  session_.exchange->reports.copy_from(saved.exchange->reports);
  world_->continue_at(saved.clock, saved.next_report);
}

}  // namespace tactus::session
