// The binary message from `tactus view` to its page: what has changed since the message before.
//
//   WireHeader | indices u32[bodies], of a delta alone | positions f32[3 bodies] | rotations i16[4 bodies]
//   | roles u32[roles]: 8 bits of role above 24 bits of index | ticks f32[24 ticks] | contacts ContactForce[contacts]
//
// Little endian; every block begins at a multiple of 4 bytes, so that typed arrays look straight into the message. An
// index counts the moving bodies by id. The first message of a page is full, as is one in which more than 5/6 of the
// bodies moved: by more than 10 um or 0.1 mrad since they were last sent. Text messages are JSON (scene_text.h).
// Units: SI, times of stages in us. Frame: world; the force is the device's. Thread: values. Bound: `WireHeader`
// counts.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace tactus::view {

inline constexpr std::uint32_t kWireMagic = 0x46434154;  // "TACF"
inline constexpr std::uint32_t kWireVersion = 3;

enum WireFlag : std::uint32_t {
  kHasFrame = 1u << 0,  // the message has bodies and contacts; without it only ticks
  kRestarts = 1u << 1,  // the ticks restart at another time: earlier ones are dropped
  kIsFull = 1u << 2,    // bodies in their order, without indices
};

struct WireHeader {
  std::uint32_t magic{kWireMagic}, version{kWireVersion};
  std::uint32_t number{0};  // of the message, from 1: what the page acknowledges
  float tick_age_us{-1};    // from the beginning of the newest tick to the sending; below 0: not measured
  double time_s{0};         // of the world's clock
  std::uint32_t bodies{0}, roles{0}, ticks{0}, contacts{0};
  std::uint32_t dropped{0};     // frames of the run that this page did not get, so far
  std::uint32_t lost_ticks{0};  // ticks that it did not get, so far
  std::uint32_t component{0};   // bodies that contacts connect to the proxy
  std::uint32_t left_out{0};    // contacts that did not fit
  std::uint32_t resets{0};      // of the scene, so far
  std::uint32_t flags{0};       // WireFlag
};
static_assert(std::is_trivially_copyable_v<WireHeader> && sizeof(WireHeader) == 64);

struct Channel {
  std::string_view name, unit;
};
// Of every tick, as float32; the tick's number modulo 2^24, so that it is exact.
inline constexpr std::array<Channel, 24> kChannels{
    {{"tick", ""},           {"force_x", "N"},       {"force_y", "N"},     {"force_z", "N"},     {"proxy_x", "m"},
     {"proxy_y", "m"},       {"proxy_z", "m"},       {"target_x", "m"},    {"target_y", "m"},    {"target_z", "m"},
     {"device_energy", "J"}, {"damped_energy", "J"}, {"border_work", "J"}, {"border_tank", "J"}, {"members", ""},
     {"border", ""},         {"contacts", ""},       {"sub_steps", ""},    {"deepest", "m"},     {"wake", "us"},
     {"device", "us"},       {"compute", "us"},      {"fault", ""},        {"status", ""}}};

}  // namespace tactus::view
