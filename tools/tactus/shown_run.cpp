#include "tools/tactus/shown_run.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/caught.h"
#include "tools/json_text.h"
#include "tools/session/realtime_run.h"

namespace tactus::tools {

ShownRun::ShownRun(session::Session& session, std::unique_ptr<publication::Publication> publication)
    : session_(session), publication_(std::move(publication)), published_(publication_->tap()), running_(session) {}

std::shared_ptr<ShownRun> ShownRun::make(session::Session& session) {
  auto made = publication::Publication::create(session.scene, session.options.period_s(), session.tape_text());
  if (!made.ok()) {
    fmt::print(stderr, "tactus run: nobody can watch: {}\n", made.message());
    return nullptr;
  }
  std::shared_ptr<ShownRun> shown(new ShownRun(session, std::move(made).value()));
  session.shown = {{&ShownRun::taken, shown.get()}, &shown->publication_->watchers(), shown};
  return shown;
}

void ShownRun::add_to(service::Watchable& watchable) noexcept {
  watchable.descriptor = publication_->descriptor();
  watchable.watchers = &publication_->watchers();
}

void ShownRun::taken(void* self, std::uint32_t kind, std::span<const std::byte> payload) noexcept {
  auto& shown = *static_cast<ShownRun*>(self);
  shown.published_.taken(shown.published_.context, kind, payload);
  shown.running_.take(kind, payload);
}

void ShownRun::stepped(void* self, const sim::GlobalWorld& world) noexcept {
  auto& shown = *static_cast<ShownRun*>(self);
  if (!shown.watched()) return;
  shown.running_.take_world(world.statistics());
  publication::Publication::stepped(shown.publication_.get(), world);
}

void ShownRun::look(const session::LiveStatus& live) {
  if (!watched()) return;
  keep_fault(live);
  session::RunSummary summary = running_.so_far(live);
  if (session_.drain != nullptr && !session_.options.record.empty()) {
    summary.tape = session_.options.record.string();
    summary.tape_dropped = session_.drain->counts().lost;
  }
  say(summary, false);
}

// Writes one tape for all faults since the last tape: the fault that is latched now, with the seconds before it.
void ShownRun::keep_fault(const session::LiveStatus& live) {
  if (writing_.valid()) {
    if (writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    take_written();
  }
  const std::uint64_t faults = live.fault_count.load(std::memory_order_relaxed);
  if (faults == faults_kept_ || session_.drain == nullptr) return;
  faults_kept_ = faults;
  if (live.fault.load(std::memory_order_relaxed) == 0) return;  // re-armed before there was a watcher
  const Status thrown = caught([&] {                            // throws if no thread can be started
    writing_ = std::async(std::launch::async, [this] { return session::write_fault_tape(session_); });
  });
  if (!thrown.ok()) fault_tape_error_ = thrown.message();
}

void ShownRun::take_written() {
  Status written = Status::good();
  if (const Status thrown = caught([&] { written = writing_.get(); }); !thrown.ok()) written = thrown;
  std::error_code error;
  fault_tape_ = written.ok() ? std::filesystem::absolute(session::fault_tape_of(session_), error).string() : "";
  fault_tape_error_ = written.message();
  faults_told_ = faults_kept_;
}

void ShownRun::end(const session::RunSummary& summary) {
  if (writing_.valid()) take_written();
  say(summary, true);
}

void ShownRun::say(const session::RunSummary& summary, bool ended) {
  const session::RunVerdict verdict = session::judge(summary);
  nlohmann::ordered_json state{{"kind", "state"},
                               {"level", session::name_of(verdict.level())},
                               {"verdict", verdict.line()},
                               {"why", verdict.text()},
                               {"ended", ended},
                               {"faults", faults_told_},
                               {"fault_tape", fault_tape_},
                               {"fault_tape_error", fault_tape_error_}};
  if (pacing_ != nullptr) state["pace"] = pacing_->pace.load(std::memory_order_relaxed);
  publication_->say(json_text(state));
}

}  // namespace tactus::tools
