// Layout of the shared memory in which a running controller publishes its state: header, text, three frames of bodies
// and contacts, and a ring of ticks.
//
//   Header | text | state | frame 0 | frame 1 | frame 2 | tick entries
//
// A memfd, sealed against shrinking, growing and new writers; the controller writes, watchers map it read-only. Frame n
// is in slot n mod kFrameSlots, tick n in entry n mod the capacity. Each slot and entry begins with a sequence: 2 n + 1
// while number n is being written, 2 n + 2 when it is complete. A reader that finds another one after its copy than
// before was overtaken: what it copied is no value (shared_words.h). Numbers count from 0.
// Little endian. Units: SI. Frame: world. Version: kPublicationVersion; a watcher accepts no other, and with it the
// version of the tape's records, whose structs are in the tick entries as they are.
// Thread: values. Bound: the capacities in the header; bodies and contacts beyond are left out and counted.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/loop/flight_recorder.h"

namespace tactus::publication {

inline constexpr std::array<char, 8> kMagic{'T', 'A', 'C', 'T', 'P', 'U', 'B', '\0'};
inline constexpr std::uint32_t kPublicationVersion = 2;
inline constexpr std::uint32_t kFrameSlots = 3;
inline constexpr std::uint32_t kMaxContacts = 4096;
inline constexpr std::uint32_t kTickEntries = 16384;  // 16 s of 1 kHz; a power of two

struct Header {
  std::array<char, 8> magic{kMagic};
  std::uint32_t version{kPublicationVersion};
  std::uint32_t tape_version{0};                // of the records in the tick entries
  std::uint64_t bytes{0};                       // of the whole memory
  double period_s{0};                           // of a tick
  std::uint64_t text_offset{0}, text_bytes{0};  // the text of a tape's header: scene and settings, as JSON
  std::uint64_t frames_offset{0}, frame_stride{0};
  std::uint64_t ticks_offset{0}, tick_stride{0};
  std::uint32_t tick_entries{0};
  std::uint32_t bodies{0};  // moving bodies of the scene: the length of a frame's arrays
  std::uint64_t state_offset{0};
  // Written during the run.
  alignas(64) std::uint64_t frames{0};  // complete so far
  std::uint64_t ticks{0};               // same
  std::uint64_t ended{0};               // 1: the run is over
};
static_assert(std::is_trivially_copyable_v<Header> && sizeof(Header) == 192);

// State of the run as one JSON object: verdict, path of the fault's tape.
struct StateSlot {
  std::uint64_t sequence{0};  // 2 n + 1 while text n is written, 2 n + 2 when it is complete; 0: none yet
  std::uint64_t bytes{0};
  std::array<char, 8176> text{};
};
static_assert(std::is_trivially_copyable_v<StateSlot> && sizeof(StateSlot) == 8192);

enum RoleBit : std::uint8_t {
  kIsProxy = 1u << 0,    // the device holds it
  kIsMember = 1u << 1,   // in the sub-world
  kIsBorder = 1u << 2,   // a member that touches a moving body outside of the sub-world
  kIsAsleep = 1u << 3,   // at rest, and not simulated until something comes near
  kIsUnknown = 1u << 4,  // of a tape: its pose is not known
};

// A slot: FrameHead, then arrays of `bodies` entries each by the moving bodies' order of ids, each array rounded up to
// 8 bytes, then kMaxContacts contacts.
struct FrameHead {
  std::uint64_t sequence{0};
  std::uint64_t tick{0};       // steps of the world so far: global steps; with the direct coupling ticks
  double time_s{0};            // of the world's clock
  std::uint32_t bodies{0};     // of the arrays below; 0 before the first frame
  std::uint32_t contacts{0};   // in the list
  std::uint32_t left_out{0};   // contacts that did not fit: those of the least force
  std::uint32_t component{0};  // bodies that contacts connect to the proxy
  std::uint32_t resets{0};     // of the scene, so far
  std::uint32_t padding{0};
};
static_assert(std::is_trivially_copyable_v<FrameHead> && sizeof(FrameHead) == 48);

struct Position {
  float x{0}, y{0}, z{0};  // m, of the centre of mass
};
// Quaternion world_from_body times 32,767: to 0.06 mrad.
struct Rotation {
  std::int16_t w{32767}, x{0}, y{0}, z{0};
};
// A contact point of the proxy's component.
struct ContactForce {
  Position point;          // m
  float x{0}, y{0}, z{0};  // N, on body b: mean over the world's last step, friction included
  BodyId a{kNoBody}, b{kNoBody};
};
static_assert(sizeof(Position) == 12 && sizeof(Rotation) == 8 && sizeof(ContactForce) == 32);

struct TickEntry {
  std::uint64_t sequence{0};
  loop::TickRecord tick;
  loop::TickTimesRecord times;  // 0 where nothing is measured
};
static_assert(std::is_trivially_copyable_v<TickEntry> && sizeof(TickEntry) % 8 == 0);

constexpr std::uint64_t rounded(std::uint64_t bytes, std::uint64_t to = 8) noexcept {
  return (bytes + to - 1) / to * to;
}
// Offsets in a slot, in bytes.
constexpr std::uint64_t positions_at() noexcept { return sizeof(FrameHead); }
constexpr std::uint64_t rotations_at(std::uint64_t bodies) noexcept {
  return positions_at() + rounded(bodies * sizeof(Position));
}
constexpr std::uint64_t roles_at(std::uint64_t bodies) noexcept {
  return rotations_at(bodies) + bodies * sizeof(Rotation);
}
constexpr std::uint64_t contacts_at(std::uint64_t bodies) noexcept { return roles_at(bodies) + rounded(bodies); }
constexpr std::uint64_t slot_bytes(std::uint64_t bodies) noexcept {
  return contacts_at(bodies) + kMaxContacts * sizeof(ContactForce);
}

}  // namespace tactus::publication
