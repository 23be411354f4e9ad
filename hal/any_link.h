// Type-erased link, for a kind that is chosen when the program starts: one virtual call per function of FrameLink.
//
// Owns the link. start(), for links that have one, is called just before the first tick: it drops waiting frames and
// resets the counters.
// Thread: construction and start() [setup]; receive(), send(), connected(), counters() [rt], by the haptic thread
// alone; call() and as() [setup] and normal threads. The link inside may allow more. Bound and errors: those of the
// link inside.
#pragma once

#include <memory>
#include <utility>

#include "hal/frame_link.h"

namespace tactus::hal {

// [setup] The link's own start(), where it has one.
template <FrameLink L>
Status start_link(L& link) {
  if constexpr (requires { link.start(); })
    return link.start();
  else
    return Status::good();
}

class AnyLink {
 public:
  template <FrameLink L>
  explicit AnyLink(std::unique_ptr<L> link) : held_(std::make_unique<Held<L>>(std::move(link))) {}

  Status start() { return held_->start(); }
  ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept {
    return held_->receive(buffer);
  }
  bool send(std::span<const std::byte> frame) noexcept { return held_->send(frame); }
  bool connected() const noexcept { return held_->connected(); }
  LinkCounters counters() const noexcept { return held_->counters(); }
  Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request, std::chrono::milliseconds timeout) {
    return held_->call(request, timeout);
  }

  // The link itself if it is an L, else null.
  template <FrameLink L>
  L* as() const noexcept {
    auto* held = dynamic_cast<Held<L>*>(held_.get());
    return held == nullptr ? nullptr : held->link.get();
  }

 private:
  struct Holder {
    virtual ~Holder() = default;
    virtual Status start() = 0;
    virtual ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept = 0;
    virtual bool send(std::span<const std::byte> frame) noexcept = 0;
    virtual bool connected() const noexcept = 0;
    virtual LinkCounters counters() const noexcept = 0;
    virtual Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request,
                                                  std::chrono::milliseconds timeout) = 0;
  };

  template <class L>
  struct Held final : Holder {
    explicit Held(std::unique_ptr<L> l) : link(std::move(l)) {}
    Status start() override { return start_link(*link); }
    ReceivedFrame receive(std::span<std::byte, firmware::kMaxFrameSize> buffer) noexcept override {
      return link->receive(buffer);
    }
    bool send(std::span<const std::byte> frame) noexcept override { return link->send(frame); }
    bool connected() const noexcept override { return link->connected(); }
    LinkCounters counters() const noexcept override { return link->counters(); }
    Result<firmware::ServiceMessage> call(const firmware::ServiceMessage& request,
                                          std::chrono::milliseconds timeout) override {
      return link->call(request, timeout);
    }
    std::unique_ptr<L> link;
  };

  std::unique_ptr<Holder> held_;
};

static_assert(FrameLink<AnyLink>);

}  // namespace tactus::hal
