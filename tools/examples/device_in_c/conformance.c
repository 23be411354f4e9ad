/* The device against firmware/conformance.txt: prints each line, answers with its own values.
 *   device_conformance < conformance.txt | diff conformance.txt -
 * Cases of classic CAN are not this device's (it speaks CAN FD, or USB): their lines are printed as they are. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device.h"

enum { LINE = 1024 };
static const char* const kStates[] = {"RESET", "IDLE", "FORCE", "BRAKE"};

static const struct config kConfig = {.quantum = {1e-5f, 1e-5f, 1e-5f, 1e-4f, 1e-4f, 1e-4f},
                                      .max_effort = {10, 10, 10, 1, 1, 1},
                                      .max_speed = {2, 2, 2, 20, 20, 20},
                                      .max_force = 12,
                                      .max_torque = 1.2f,
                                      .period_us = 1000,
                                      .fade_frames = 3,
                                      .brake_frames = 10};

static size_t bytes_of(const char* hex, uint8_t* bytes) {
  size_t size = 0;
  unsigned byte;
  for (; sscanf(hex, "%2x", &byte) == 1 && hex[0] > ' ' && hex[1] > ' '; hex += 2) bytes[size++] = (uint8_t)byte;
  return size;
}

static void print_bytes(const char* what, const uint8_t* bytes, size_t size) {
  printf("%s ", what);
  for (size_t i = 0; i < size; ++i) printf("%02x", bytes[i]);
  printf("\n");
}

static void print_says(const struct device* device, const uint8_t* frame, const struct inputs* in) {
  printf("says %s, sequence %u, time %llu us, fault %d, limits 0x%04x, buttons %u, missed %u, echo %u\n",
         kStates[frame[3]], device->sequence, (unsigned long long)in->time_us, (int)device->fault, device->limits,
         in->buttons, frame[49], device->newest.sequence);
}

static void print_motors(const struct outputs* out) {
  if (out->shorted) {
    printf("motors short\n");
    return;
  }
  printf("motors");
  for (unsigned i = 0; i < AXES; ++i) printf(" %.9g", (double)out->effort[i]);
  printf("\n");
}

int main(void) {
  static char line[LINE];
  static struct device device;
  struct inputs in = {.supply_good = true};
  struct outputs out = {.shorted = true};
  uint8_t bytes[LINE / 2], frame[STATE_SIZE], content[SERVICE_CONTENT], reply[SERVICE_SIZE];
  bool mine = true;
  while (fgets(line, sizeof line, stdin) != NULL) {
    const char* rest = strchr(line, ' ');
    rest = rest != NULL ? rest + 1 : "";
    if (strncmp(line, "case ", 5) == 0) {
      mine = strncmp(line, "case classic CAN", 16) != 0;
      memset(&in, 0, sizeof in);
      in.supply_good = true;
      device_start(&device, &kConfig, "T0042");
    }
    if (mine && strncmp(line, "period", 6) == 0) {
      in.time_us += kConfig.period_us;
      device_period(&device, &in, frame, &out);
    }
    if (mine && strncmp(line, "in ", 3) == 0) device_hear(&device, bytes, bytes_of(rest, bytes));
    if (mine && strncmp(line, "counts ", 7) == 0)
      (void)sscanf(rest, "%d %d %d %d %d %d", &in.counts[0], &in.counts[1], &in.counts[2], &in.counts[3], &in.counts[4],
                   &in.counts[5]);
    if (mine && strncmp(line, "e-stop ", 7) == 0) in.stop_line = *rest == '1';
    if (mine && strncmp(line, "supply ", 7) == 0) in.supply_good = *rest == '1';
    if (mine && strncmp(line, "request ", 8) == 0 && service_unwrap(bytes, bytes_of(rest, bytes), content)) {
      uint8_t answer[SERVICE_CONTENT];
      device_answer(&device, content, answer);
      service_wrap(answer, reply);
    }
    if (mine && strncmp(line, "out ", 4) == 0)
      print_bytes("out", frame, sizeof frame);
    else if (mine && strncmp(line, "says ", 5) == 0)
      print_says(&device, frame, &in);
    else if (mine && strncmp(line, "motors ", 7) == 0)
      print_motors(&out);
    else if (mine && strncmp(line, "reply ", 6) == 0)
      print_bytes("reply", reply, sizeof reply);
    else
      fputs(line, stdout);
  }
  return 0;
}
