#include "rt/tape/tape_drain.h"

#include <pthread.h>
#include <signal.h>

#include <cstring>

namespace tactus::loop {

TapeDrain::TapeDrain(Ring& ring, const DrainSettings& settings, std::unique_ptr<TapeWriter> tape)
    : ring_(ring),
      settings_(settings),
      tape_(std::move(tape)),
      history_(settings.history_bytes, settings.keyframe_kind),
      payload_(ring.capacity()) {}

Status TapeDrain::start() {
  if (started_) return Status::error("the tape drain runs already");
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, 256 * 1024);
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // inherited: the main thread receives signals
  stop_ = false;
  pthread_t thread{};
  const int error = pthread_create(&thread, &attributes, &enter, this);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  pthread_attr_destroy(&attributes);
  if (error != 0) return Status::error(std::string("no thread for the tape: ") + strerrordesc_np(error));
  thread_ = thread;
  started_ = true;
  return Status::good();
}

void* TapeDrain::enter(void* self) noexcept {
  static_cast<TapeDrain*>(self)->run();
  return nullptr;
}

void TapeDrain::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    drain_locked();
    wake_.wait_for(lock, settings_.interval, [this] { return stop_; });
  }
}

void TapeDrain::drain() {
  const std::lock_guard lock(mutex_);
  drain_locked();
}

// Bounded by one full ring: a faster producer must not keep this thread, and the lock, indefinitely.
void TapeDrain::drain_locked() {
  RingRecord record;
  for (std::uint64_t taken = 0; taken <= ring_.capacity();) {
    const Pop pop = ring_.try_pop(record, payload_);
    if (pop == Pop::kEmpty) return;
    TACTUS_CHECK(pop == Pop::kRecord, record.size, payload_.size());  // the buffer holds a whole ring
    mark_gap(record.lost_before);
    const auto payload = std::span<const std::byte>(payload_).first(record.size);
    if (settings_.tap.taken != nullptr) settings_.tap.taken(settings_.tap.context, record.kind, payload);
    if (settings_.tap_only_kind == 0 || record.kind != settings_.tap_only_kind) take(record.kind, payload);
    ++records_;
    payload_bytes_ += record.size;
    taken += record.size + 16;
  }
}

void TapeDrain::mark_gap(std::uint64_t lost) {
  if (lost == 0) return;
  take(kTapeGap, std::as_bytes(std::span<const std::uint64_t, 1>(&lost, 1)));
  lost_marked_ += lost;
}

// A tape error ends the recording, not the draining: the history continues.
void TapeDrain::take(std::uint32_t kind, std::span<const std::byte> payload) {
  if (tape_ != nullptr) write(kind, payload);
  history_.push(kind, payload);
}

void TapeDrain::write(std::uint32_t kind, std::span<const std::byte> payload) {
  const bool is_tick = kind == settings_.tick_kind;
  if (!tape_status_.ok()) {
    if (is_tick) ++ticks_not_written_;
    return;
  }
  tape_status_ = tape_->write(kind, payload);
  if (is_tick) waiting_ticks_.push_back(tape_->bytes());
  forget_written_ticks();
}

void TapeDrain::forget_written_ticks() {
  while (!waiting_ticks_.empty() && waiting_ticks_.front() <= tape_->bytes_written()) waiting_ticks_.pop_front();
}

Status TapeDrain::stop() {
  if (started_) {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    pthread_join(thread_, nullptr);
    started_ = false;
  }
  const std::lock_guard lock(mutex_);
  drain_locked();
  if (tape_ != nullptr) {
    mark_gap(ring_.dropped() - lost_marked_);  // at the end, without a following record
    const Status closed = tape_->close();
    if (tape_status_.ok()) tape_status_ = closed;
    forget_written_ticks();
    ticks_not_written_ += waiting_ticks_.size();
    tape_.reset();
  }
  return tape_status_;
}

Status TapeDrain::dump(const std::string& path, std::string_view text) {
  std::unique_lock lock(mutex_);
  drain_locked();
  if (history_.empty()) return Status::error("dump '" + path + "': nothing to write, no keyframe came yet");
  const TapeHistory history = history_;  // a copy, so that the drain does not wait for a slow disk
  lock.unlock();
  auto tape = TapeWriter::create(path, text);
  if (!tape.ok()) return tape.status();
  TapeWriter& writer = *tape.value();
  history.for_each([&](std::uint32_t kind, std::span<const std::byte> payload) { (void)writer.write(kind, payload); });
  return writer.close();
}

TapeDrain::Counts TapeDrain::counts() const {
  const std::lock_guard lock(mutex_);
  return {.records = records_,
          .bytes = payload_bytes_,
          .lost = ring_.dropped(),
          .not_kept = history_.not_kept(),
          .ticks_not_written = ticks_not_written_};
}

}  // namespace tactus::loop
