#include "device.h"

#include <math.h>
#include <string.h>

enum { MAGIC = 0x74, VERSION = 1, TYPE_STATE = 1, TYPE_COMMAND = 2, TYPE_REQUEST = 3, TYPE_REPLY = 4, REVISION = 3 };
/* Bit n of the limit bits is limit 64 + n. */
enum {
  FORCE_CUT = 1 << 6,
  TORQUE_CUT = 1 << 7,
  FADING = 1 << 8,
  STOP_NOW = 1 << 9,
  SUPPLY_LOW = 1 << 10,
  NOT_HOMED = 1 << 12,
  IDLE_FIRST = 1 << 14
};

/* --- bytes, little-endian on any machine */

static void put(uint8_t* at, uint64_t value, unsigned bytes) {
  for (unsigned i = 0; i < bytes; ++i) at[i] = (uint8_t)(value >> (8 * i));
}

static uint32_t get32(const uint8_t* at) {
  return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static float as_float(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static uint32_t as_bits(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

static uint32_t crc32c(const uint8_t* bytes, size_t size) {
  uint32_t crc = 0xffffffffu;
  for (size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (unsigned bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0x82f63b78u & (0u - (crc & 1u)));
  }
  return ~crc;
}

/* --- commands */

static bool decode_command(const uint8_t* bytes, size_t size, struct command* command) {
  if (size != COMMAND_SIZE || bytes[0] != MAGIC || get32(bytes + 36) != crc32c(bytes, 36)) return false;
  if (bytes[1] != VERSION || bytes[2] != TYPE_COMMAND || bytes[3] < IDLE || bytes[3] > BRAKE) return false;
  if ((bytes[8] & ~1u) != 0 || bytes[9] != 0 || bytes[10] != 0 || bytes[11] != 0) return false;
  command->wanted = (enum state)bytes[3];
  command->sequence = get32(bytes + 4);
  command->rearm = bytes[8] != 0;
  for (unsigned i = 0; i < AXES; ++i) command->effort[i] = as_float(get32(bytes + 12 + 4 * i));
  return true;
}

static bool is_newer(uint32_t a, uint32_t b) { return a != b && a - b < 0x80000000u; }

static bool is_silent(const struct device* device) { return device->missed >= device->config.brake_frames; }

void device_hear(struct device* device, const uint8_t* bytes, size_t size) {
  struct command command;
  const bool starts = is_silent(device);
  if (!decode_command(bytes, size, &command) || (!starts && !is_newer(command.sequence, device->newest.sequence))) {
    ++device->refused;
    return;
  }
  for (unsigned i = 0; i < AXES; ++i) {
    if (isfinite(command.effort[i])) continue;
    device->not_finite = true;
    ++device->refused;
    return;
  }
  /* Of several the newest counts; of those that may start a sequence the last that came. */
  if (device->has_best && !starts && !is_newer(command.sequence, device->best.sequence)) {
    ++device->refused;
    return;
  }
  device->best = command;
  device->has_best = true;
  device->starts = starts;
}

/* --- states */

static bool is_too_fast(const struct device* device, const struct inputs* in) {
  if (!device->has_last || in->time_us <= device->last_time_us) return false;
  const float time_s = (float)(in->time_us - device->last_time_us) * 1e-6f;
  for (unsigned i = 0; i < AXES; ++i) {
    const float moved = (float)(in->counts[i] - device->last_counts[i]) * device->config.quantum[i];
    if (fabsf(moved) > device->config.max_speed[i] * time_s) return true;
  }
  return false;
}

static void brake(struct device* device, enum fault fault) {
  if (device->state != BRAKE) {
    device->fault = fault;
    if (fault != NONE) ++device->fault_total;
  }
  device->state = BRAKE;
}

/* The most urgent event of the period alone; `wanted` is null where no command acts. */
static void choose_state(struct device* device, const struct inputs* in, bool too_fast, const struct command* wanted,
                         bool rearm_rises) {
  const bool waits = device->state == RESET;
  if (in->stop_line) {
    brake(device, E_STOP);
  } else if (!in->supply_good) {
    if (!waits) brake(device, SUPPLY);
  } else if (too_fast) {
    if (!waits) brake(device, OVERSPEED);
  } else if (device->not_finite) {
    brake(device, NOT_FINITE);
  } else if (device->state == FORCE && is_silent(device)) {
    brake(device, COMMANDS_LOST);
  } else if (wanted != NULL && wanted->wanted == BRAKE) {
    brake(device, NONE);
  } else if (waits) {
    device->state = IDLE;
  } else if (device->state == BRAKE) {
    if (!rearm_rises) return;
    device->state = IDLE;
    device->fault = NONE;
  } else if (wanted != NULL && wanted->wanted == FORCE) {
    if ((device->limits & (NOT_HOMED | IDLE_FIRST)) == 0) device->state = FORCE;
  } else if (wanted != NULL) {
    device->state = IDLE;
  }
}

/* --- efforts */

/* One factor for three axes, so that the direction of the command is kept. */
static void limit(struct device* device, float* effort, const float* most, float norm_limit, unsigned first,
                  int norm_bit) {
  float share = 1, norm = 0;
  for (unsigned i = 0; i < 3; ++i) {
    const float size = fabsf(effort[i]);
    norm += size * size;
    if (size <= most[i]) continue;
    device->limits |= (uint16_t)(1u << (first + i));
    share = fminf(share, most[i] / size);
  }
  norm = sqrtf(norm);
  if (norm * share > norm_limit) {
    device->limits |= (uint16_t)norm_bit;
    share = norm_limit / norm;
  }
  for (unsigned i = 0; i < 3; ++i) effort[i] *= share;
}

static void drive(struct device* device, struct outputs* out) {
  const struct config* c = &device->config;
  memset(out, 0, sizeof *out);
  out->shorted = device->state == RESET || device->state == BRAKE;
  if (device->state != FORCE) return;
  memcpy(out->effort, device->newest.effort, sizeof out->effort);
  if (device->missed >= c->fade_frames) {
    const float share = (float)(c->brake_frames - device->missed) / (float)(c->brake_frames - c->fade_frames + 1);
    for (unsigned i = 0; i < AXES; ++i) out->effort[i] *= share;
    device->limits |= FADING;
  }
  limit(device, out->effort, c->max_effort, c->max_force, 0, FORCE_CUT);
  limit(device, out->effort + 3, c->max_effort + 3, c->max_torque, 3, TORQUE_CUT);
}

/* --- one control period */

static void tell(const struct device* device, const struct inputs* in, uint8_t* bytes) {
  memset(bytes, 0, STATE_SIZE);
  bytes[0] = MAGIC;
  bytes[1] = VERSION;
  bytes[2] = TYPE_STATE;
  bytes[3] = (uint8_t)device->state;
  put(bytes + 4, device->sequence, 4);
  put(bytes + 8, in->time_us, 8);
  for (unsigned i = 0; i < AXES; ++i) put(bytes + 16 + 4 * i, (uint32_t)in->counts[i], 4);
  put(bytes + 40, device->newest.sequence, 4);
  put(bytes + 44, (uint64_t)device->fault, 2);
  put(bytes + 46, device->limits, 2);
  bytes[48] = in->buttons;
  bytes[49] = (uint8_t)(device->missed < 255 ? device->missed : 255);
  put(bytes + 52, crc32c(bytes, 52), 4);
}

void device_period(struct device* device, const struct inputs* in, uint8_t state_frame[STATE_SIZE],
                   struct outputs* out) {
  const struct command* acts = NULL;
  bool rearm_rises = false;
  if (device->has_best) {
    rearm_rises = !device->starts && device->best.rearm && !device->rearm_was_up;
    device->rearm_was_up = device->starts || device->best.rearm;
    device->idle_wanted = device->idle_wanted || device->best.wanted == IDLE;
    device->newest = device->best;
    device->missed = 0;
    if (!device->starts) acts = &device->newest;
  } else if (device->missed < UINT32_MAX) {
    ++device->missed;
  }
  device->limits = (uint16_t)((in->stop_line ? STOP_NOW : 0) | (in->supply_good ? 0 : SUPPLY_LOW) |
                              (device->config.homing_demanded != 0 && !device->homed ? NOT_HOMED : 0) |
                              (device->idle_wanted ? 0 : IDLE_FIRST));
  choose_state(device, in, is_too_fast(device, in), acts, rearm_rises);
  drive(device, out);
  ++device->sequence;
  tell(device, in, state_frame);

  device->has_best = device->starts = device->not_finite = false;
  memcpy(device->last_counts, in->counts, sizeof device->last_counts);
  device->last_time_us = in->time_us;
  device->has_last = true;
}

void device_start(struct device* device, const struct config* config, const char* serial) {
  memset(device, 0, sizeof *device);
  device->config = *config;
  device->missed = config->brake_frames;
  for (unsigned i = 0; i < 4 * SERIAL_WORDS && serial[i] != 0; ++i)
    device->serial[i / 4] |= (uint32_t)(uint8_t)serial[i] << (8 * (i % 4));
}

/* --- registers */

enum { READ = 1, WRITE = 2, EXECUTE = 3 };
enum { GOOD = 0, NO_REGISTER = 1, READ_ONLY = 2, OUT_OF_RANGE = 3, WRONG_STATE = 4, NO_OPERATION = 5 };

/* A float of the configuration that may be written, and its range; null: another register. */
static float* real_register(struct device* device, uint16_t number, float* low, float* high) {
  struct config* c = &device->config;
  *low = 0;
  *high = 1e6f;
  if (number >= 0x0110 && number < 0x0110 + AXES) return &c->max_effort[number - 0x0110];
  if (number == 0x0130) return &c->max_force;
  if (number == 0x0131) return &c->max_torque;
  *low = 1e-6f;
  if (number >= 0x0120 && number < 0x0120 + AXES) return &c->max_speed[number - 0x0120];
  *low = 1e-9f;
  *high = 1;
  return number >= 0x0100 && number < 0x0100 + AXES ? &c->quantum[number - 0x0100] : NULL;
}

static uint32_t* whole_register(struct device* device, uint16_t number, uint32_t* low, uint32_t* high) {
  struct config* c = &device->config;
  /* fade_frames stays below brake_frames. */
  *low = number == 0x0134 ? c->fade_frames + 1 : number == 0x0133 ? 1 : 0;
  *high = number == 0x0133 ? c->brake_frames - 1 : number == 0x0134 ? 255 : 1;
  return number == 0x0133   ? &c->fade_frames
         : number == 0x0134 ? &c->brake_frames
         : number == 0x0252 ? &c->homing_demanded
                            : NULL;
}

/* Registers of what this device does not have: they are there, and read as zero (a node id: 1). */
static bool is_unused_register(uint16_t number) {
  static const struct {
    uint16_t first, count;
  } kUnused[] = {{0x0200, 6}, {0x0210, 6}, {0x0220, 6},  {0x0230, 6}, {0x0240, 6}, {0x0250, 2},  {0x0253, 1},
                 {0x0300, 6}, {0x0310, 6}, {0x0320, 6},  {0x0330, 6}, {0x0400, 6}, {0x0410, 24}, {0x0430, 24},
                 {0x0450, 1}, {0x0500, 1}, {0x0605, 1},  {0x0608, 4}, {0x0610, 6}, {0x0620, 6},  {0x0630, 6},
                 {0x0640, 6}, {0x0650, 3}, {0x0700, 64}, {0x0800, 4}};
  for (size_t i = 0; i < sizeof kUnused / sizeof kUnused[0]; ++i)
    if (number >= kUnused[i].first && number < kUnused[i].first + kUnused[i].count) return true;
  return false;
}

/* Registers that can be read only. False: there is no such register. */
static bool told_register(const struct device* device, uint16_t number, uint32_t* value) {
  if (number >= 0x0008 && number < 0x0008 + SERIAL_WORDS) {
    *value = device->serial[number - 0x0008];
    return true;
  }
  switch (number) {
    case 0x0000:
      *value = VERSION;
      return true;
    case 0x0001:
      *value = REVISION;
      return true;
    case 0x0002:
      *value = 1u << 16;
      return true;
    case 0x0003:
      *value = device->config.device_class;
      return true;
    case 0x0004:
      *value = AXES;
      return true;
    case 0x0132:
      *value = device->config.period_us;
      return true;
    case 0x0600:
      *value = (uint32_t)device->state;
      return true;
    case 0x0601:
      *value = (uint32_t)device->fault;
      return true;
    case 0x0602:
      *value = device->limits;
      return true;
    case 0x0603:
      *value = device->missed;
      return true;
    case 0x0604:
      *value = device->refused;
      return true;
    case 0x0606:
      *value = device->homed ? 2 : 0;
      return true;
    case 0x0607:
      *value = device->homed ? 63 : 0;
      return true;
    case 0x060c:
      *value = device->fault_total;
      return true;
    default:
      *value = number == 0x0500 ? 1 : 0;
      return is_unused_register(number);
  }
}

static int execute(struct device* device, uint16_t number, uint32_t value) {
  if (number != 0x0802) return NO_OPERATION;
  if (device->state != IDLE && device->state != BRAKE) return WRONG_STATE;
  if (value != 0 && value != 2) return OUT_OF_RANGE; /* by index pulses: this device has none */
  device->homed = value == 2;                        /* a board takes its counts here */
  return GOOD;
}

static int write(struct device* device, uint16_t number, uint32_t value) {
  float low, high;
  uint32_t least, most, told;
  float* real = real_register(device, number, &low, &high);
  uint32_t* whole = whole_register(device, number, &least, &most);
  if (real == NULL && whole == NULL) return told_register(device, number, &told) ? READ_ONLY : NO_REGISTER;
  if (device->state == FORCE) return WRONG_STATE;
  if (real != NULL) {
    const float number_given = as_float(value);
    if (!(number_given >= low && number_given <= high)) return OUT_OF_RANGE; /* NaN too */
    *real = number_given;
    /* Another quantum makes no speed: the next reading is the first. */
    if (number < 0x0110) device->has_last = false;
    return GOOD;
  }
  if (value < least || value > most) return OUT_OF_RANGE;
  *whole = value;
  if (number == 0x0252) device->homed = false;
  return GOOD;
}

static int read(struct device* device, uint16_t number, uint32_t* value) {
  float low, high;
  uint32_t least, most;
  const float* real = real_register(device, number, &low, &high);
  const uint32_t* whole = whole_register(device, number, &least, &most);
  if (real != NULL) {
    *value = as_bits(*real);
    return GOOD;
  }
  if (whole != NULL) {
    *value = *whole;
    return GOOD;
  }
  return told_register(device, number, value) ? GOOD : NO_REGISTER;
}

void device_answer(struct device* device, const uint8_t request[SERVICE_CONTENT], uint8_t reply[SERVICE_CONTENT]) {
  const unsigned operation = request[0] & 0xfu;
  const uint16_t number = (uint16_t)(request[2] | request[3] << 8);
  uint32_t value = get32(request + 4);
  int status = NO_OPERATION;
  if (operation == READ) status = read(device, number, &value);
  if (operation == WRITE) status = write(device, number, value);
  if (operation == EXECUTE) {
    status = execute(device, number, value);
    if (status == GOOD) value = 0;
  }
  memcpy(reply, request, SERVICE_CONTENT);
  reply[0] = (uint8_t)(operation | (unsigned)status << 4);
  put(reply + 4, value, 4);
}

bool service_unwrap(const uint8_t* bytes, size_t size, uint8_t content[SERVICE_CONTENT]) {
  if (size != SERVICE_SIZE || bytes[0] != MAGIC || bytes[1] != VERSION || bytes[2] != TYPE_REQUEST || bytes[3] != 0 ||
      get32(bytes + 12) != crc32c(bytes, 12))
    return false;
  memcpy(content, bytes + 4, SERVICE_CONTENT);
  return true;
}

void service_wrap(const uint8_t content[SERVICE_CONTENT], uint8_t bytes[SERVICE_SIZE]) {
  bytes[0] = MAGIC;
  bytes[1] = VERSION;
  bytes[2] = TYPE_REPLY;
  bytes[3] = 0;
  memcpy(bytes + 4, content, SERVICE_CONTENT);
  put(bytes + 12, crc32c(bytes, 12), 4);
}
