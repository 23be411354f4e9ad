// A device of tactus' wire in C: the logic of firmware/PROTOCOL.md without any input or output. A template for a board
// of one's own: call device_hear() for each frame that arrives, device_answer() for each service request, and
// device_period() once in each control period.
//
// What it has: frames, states, watchdog, limits, faults 1 to 5, service messages, and the registers that a host asks
// for. What a product adds: homing by index pulses, temperature, arm weight, a memory for `save`, the fault log.
// conformance.c runs it against firmware/conformance.txt, can_fd.c on a CAN FD bus. No heap, no lock, bounded.
// Thread: one at a time for a device. Units: SI.
#ifndef TACTUS_DEVICE_H
#define TACTUS_DEVICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { AXES = 6, STATE_SIZE = 56, COMMAND_SIZE = 40, SERVICE_CONTENT = 8, SERVICE_SIZE = 16, SERIAL_WORDS = 4 };
enum state { RESET = 0, IDLE = 1, FORCE = 2, BRAKE = 3 };
enum fault { NONE = 0, COMMANDS_LOST = 1, E_STOP = 2, OVERSPEED = 3, NOT_FINITE = 4, SUPPLY = 5 };

struct config {
  float quantum[AXES];    /* m or rad per count */
  float max_effort[AXES]; /* N or N m, of each motor */
  float max_speed[AXES];  /* m/s or rad/s */
  float max_force, max_torque;
  uint32_t device_class, period_us, fade_frames, brake_frames, homing_demanded;
};

struct inputs {
  uint64_t time_us;
  int32_t counts[AXES];
  uint8_t buttons;
  bool supply_good, stop_line;
};

struct outputs {
  bool shorted;       /* the motors' windings */
  float effort[AXES]; /* N or N m */
};

struct command {
  uint32_t sequence;
  enum state wanted;
  bool rearm;
  float effort[AXES];
};

struct device {
  struct config config;
  uint32_t serial[SERIAL_WORDS];
  enum state state;
  enum fault fault;
  uint32_t sequence, missed, refused, fault_total;
  uint16_t limits;
  bool homed, idle_wanted; /* a command has wanted IDLE since the start */
  struct command newest;   /* accepted */
  bool rearm_was_up;
  /* Of this period: the best frame so far, whether it starts a sequence, and whether one had NaN. */
  struct command best;
  bool has_best, starts, not_finite;
  int32_t last_counts[AXES];
  uint64_t last_time_us;
  bool has_last;
};

void device_start(struct device* device, const struct config* config, const char* serial);
void device_hear(struct device* device, const uint8_t* bytes, size_t size);
void device_period(struct device* device, const struct inputs* in, uint8_t state_frame[STATE_SIZE],
                   struct outputs* out);
/* The eight bytes of content; on USB they are in a message of 16 bytes: service_unwrap, service_wrap. */
void device_answer(struct device* device, const uint8_t request[SERVICE_CONTENT], uint8_t reply[SERVICE_CONTENT]);
bool service_unwrap(const uint8_t* bytes, size_t size, uint8_t content[SERVICE_CONTENT]);
void service_wrap(const uint8_t content[SERVICE_CONTENT], uint8_t bytes[SERVICE_SIZE]);

#endif
