/* The device on a CAN FD bus, by Linux' SocketCAN: node 1, a state frame each millisecond.
 *   device_can_fd INTERFACE        such as vcan0 with an MTU of 72
 * Its arm is a mass on each axis, held by nobody: put your encoders and motors in move(). */
#include <errno.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <math.h>
#include <net/if.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "device.h"

/* Functions in bits 7 to 10 of the identifier, the node in the others. */
enum { NODE = 1, COMMAND = 1 << 7 | NODE, STATE = 3 << 7 | NODE, REQUEST = 7 << 7 | NODE, REPLY = 8 << 7 | NODE };
enum { PADDED_COMMAND = 48, PADDED_STATE = 64, PERIOD_NS = 1000000, FRAMES_A_PERIOD = 64, PRIORITY = 90 };

/* What hal/devices/desk3d.toml needs of its device: `tactus device ask needs --device-file FILE` prints it. */
static const struct config kConfig = {.quantum = {1.25663704e-4f, 1.25663704e-4f, 1.25663704e-4f, 1e-4f, 1e-4f, 1e-4f},
                                      .max_effort = {1.5f, 1.5f, 1.5f, 0, 0, 0},
                                      .max_speed = {30, 30, 30, 1, 1, 1},
                                      .max_force = 2.5f,
                                      .device_class = 1,
                                      .period_us = 1000,
                                      .fade_frames = 3,
                                      .brake_frames = 10};

static volatile sig_atomic_t stop;
static void ask_to_stop(int signal) {
  (void)signal;
  stop = 1;
}

static int open_bus(const char* interface) {
  const int bus = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK, CAN_RAW), on = 1;
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(interface)};
  if (bus < 0 || address.can_ifindex == 0 || setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0 ||
      bind(bus, (const struct sockaddr*)&address, sizeof address) != 0)
    return -1;
  return bus;
}

static void send_frame(int bus, uint32_t id, const uint8_t* bytes, size_t size, size_t padded, bool fd) {
  struct canfd_frame frame = {.can_id = id, .len = (uint8_t)padded, .flags = fd ? CANFD_BRS : 0};
  memcpy(frame.data, bytes, size);
  (void)!write(bus, &frame, fd ? CANFD_MTU : CAN_MTU); /* a bus that takes nothing is not waited for */
}

/* What has come: commands, and requests, which are answered at once. */
static void take_frames(struct device* device, int bus) {
  struct canfd_frame frame;
  ssize_t size;
  for (int i = 0; i < FRAMES_A_PERIOD && (size = read(bus, &frame, sizeof frame)) > 0; ++i) {
    if (frame.can_id == COMMAND && size == CANFD_MTU && frame.len == PADDED_COMMAND)
      device_hear(device, frame.data, COMMAND_SIZE);
    if (frame.can_id == REQUEST && size == CAN_MTU && frame.len == SERVICE_CONTENT) {
      uint8_t reply[SERVICE_CONTENT];
      device_answer(device, frame.data, reply);
      send_frame(bus, REPLY, reply, sizeof reply, sizeof reply, false);
    }
  }
}

/* One period of the mechanics: here a damped inertia per axis; yours has encoders and motors. */
static void move(const struct outputs* out, struct inputs* in) {
  static const double kInertia = 0.005, kDamping = 0.02, kBrake = 0.2, kPeriod_s = 1e-3, kStop_rad = 0.3;
  static double angle[AXES], speed[AXES];
  for (unsigned i = 0; i < 3; ++i) {
    const double torque = (double)out->effort[i] - (out->shorted ? kBrake : kDamping) * speed[i];
    speed[i] += kPeriod_s * torque / kInertia;
    angle[i] += kPeriod_s * speed[i];
    if (fabs(angle[i]) > kStop_rad) {
      angle[i] = copysign(kStop_rad, angle[i]);
      speed[i] = 0;
    }
    in->counts[i] = (int32_t)lround(angle[i] / (double)kConfig.quantum[i]);
  }
}

int main(int argc, char** argv) {
  static struct device device;
  const int bus = argc == 2 ? open_bus(argv[1]) : -1;
  if (bus < 0) {
    fprintf(stderr, "device_can_fd: no CAN FD interface '%s': %s\n", argc == 2 ? argv[1] : "", strerror(errno));
    return 2;
  }
  const struct sched_param priority = {.sched_priority = PRIORITY};
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0 || sched_setscheduler(0, SCHED_FIFO, &priority) != 0)
    fprintf(stderr, "device_can_fd: not real-time: %s\n", strerror(errno));
  signal(SIGINT, ask_to_stop);
  signal(SIGTERM, ask_to_stop);
  device_start(&device, &kConfig, "EXAMPLE-1");
  struct inputs in = {.supply_good = true};
  struct outputs out = {.shorted = true};
  struct timespec next;
  clock_gettime(CLOCK_MONOTONIC, &next);
  puts("ready");
  fflush(stdout);
  while (!stop) {
    next.tv_nsec += PERIOD_NS;
    next.tv_sec += next.tv_nsec / 1000000000;
    next.tv_nsec %= 1000000000;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
    uint8_t frame[STATE_SIZE];
    take_frames(&device, bus);
    move(&out, &in);
    in.time_us += PERIOD_NS / 1000;
    device_period(&device, &in, frame, &out);
    send_frame(bus, STATE, frame, sizeof frame, PADDED_STATE, true);
  }
  move(&(struct outputs){.shorted = true}, &in); /* no effort, and the motors brake */
  return 0;
}
