/* A driver of a device that there is not: its handle goes round a circle of 20 mm, a turn in two seconds, in the plane of the screen,
 * from the top. Options: radius_mm=NUMBER. It shows all that a driver has to do; docs/devices.md says when each function is called. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <tandem/tandem_device.h>

struct TandemDevice {
  double radius; /* m */
  int64_t begin_ns;
  volatile int stopped;
  double given; /* N, the newest force at the motor that there is not */
};

static const TandemDeviceHost* host;
static char fault[128] = "";

static int32_t Init(const TandemDeviceHost* given) {
  host = given;
  return TANDEM_OK;
}

static void Deinit(void) {}

static int32_t List(TandemDeviceFound* found, int32_t room) {
  if (room < 1) return 0;
  found->present = 1; /* a real driver looks at its bus here; what it lacks goes into `missing` and `mend` */
  snprintf(found->name, sizeof found->name, "circle");
  return 1;
}

static int32_t Open(const TandemDeviceOpen* how, TandemDevice** device) {
  double radius_mm = 20;
  if (how->options[0] != '\0' && (sscanf(how->options, "radius_mm=%lf", &radius_mm) != 1 || !(radius_mm > 0 && radius_mm <= 100))) {
    snprintf(fault, sizeof fault, "'%.40s': expected radius_mm=NUMBER, up to 100", how->options);
    return TANDEM_FAILED;
  }
  *device = calloc(1, sizeof **device);
  if (*device == NULL) return TANDEM_FAILED;
  (*device)->radius = 1e-3 * radius_mm;
  return TANDEM_OK;
}

static void Close(TandemDevice* device) { free(device); }

static int32_t Capabilities(TandemDevice* device, TandemDeviceCapabilities* can) {
  (void)device;
  can->freedoms_in = 3;
  can->freedoms_out = 3;
  can->peak_force = 5;
  can->continuous_force = 2;
  return TANDEM_OK;
}

/* All that is allocated is allocated by now: from here on read() and write() come a thousand times a second. */
static int32_t Start(TandemDevice* device) {
  device->begin_ns = host->now_ns();
  return TANDEM_OK;
}

static int32_t Read(TandemDevice* device, TandemDeviceState* state) {
  const double rate = 3.14159265358979; /* rad/s */
  state->time_ns = host->now_ns();
  const double angle = rate * 1e-9 * (double)(state->time_ns - device->begin_ns);
  state->position[0] = device->radius * sin(angle);
  state->position[1] = device->radius * cos(angle);
  state->velocity[0] = rate * device->radius * cos(angle);
  state->velocity[1] = -rate * device->radius * sin(angle);
  state->orientation[3] = 1; /* it does not turn */
  state->valid = TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY;
  return TANDEM_OK;
}

static int32_t Write(TandemDevice* device, const TandemDeviceForce* force) {
  device->stopped = 0;
  device->given = force->force[1];
  return TANDEM_OK;
}

/* Any thread may call this, and a signal handler: it writes zero to the motor, and nothing else. */
static void Stop(TandemDevice* device) {
  device->given = 0;
  device->stopped = 1;
}

static int32_t LastError(TandemDevice* device, char* text, uint32_t room) {
  (void)device;
  if (fault[0] == '\0' || room == 0) return TANDEM_FAILED;
  snprintf(text, room, "%s", fault);
  return TANDEM_OK;
}

const TandemDriver tandem_driver = {
    sizeof(TandemDriver), TANDEM_DEVICE_ABI_MAJOR, TANDEM_DEVICE_ABI_MINOR, 0,
    "circle", "example: a handle that goes round", "radius_mm=NUMBER",
    Init, Deinit, List, Open, Close, Capabilities, Start, Read, Write, Stop, LastError, NULL};
