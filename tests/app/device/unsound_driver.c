/* A driver that is unsound in one way, by what it is built with: UNSOUND_NAME, UNSOUND_MAJOR, UNSOUND_NO_READ, UNSOUND_CRASH. */
#include <stdlib.h>

#include "app/device/tandem_device.h"

#ifndef UNSOUND_NAME
#define UNSOUND_NAME "unsound"
#endif
#ifndef UNSOUND_MAJOR
#define UNSOUND_MAJOR TANDEM_DEVICE_ABI_MAJOR
#endif

static int32_t Init(const TandemDeviceHost* host) {
  (void)host;
#ifdef UNSOUND_CRASH
  abort();
#endif
  return TANDEM_OK;
}
static void Deinit(void) {}
static int32_t List(TandemDeviceFound* found, int32_t room) {
  (void)found;
  (void)room;
  return 0;
}
static int32_t Open(const TandemDeviceOpen* how, TandemDevice** device) {
  (void)how;
  (void)device;
  return TANDEM_FAILED;
}
static void Close(TandemDevice* device) { (void)device; }
static int32_t Capabilities(TandemDevice* device, TandemDeviceCapabilities* can) {
  (void)device;
  (void)can;
  return TANDEM_FAILED;
}
static int32_t Start(TandemDevice* device) {
  (void)device;
  return TANDEM_FAILED;
}
#ifndef UNSOUND_NO_READ
static int32_t Read(TandemDevice* device, TandemDeviceState* state) {
  (void)device;
  (void)state;
  return TANDEM_FAILED;
}
#else
#define Read 0
#endif
static int32_t Write(TandemDevice* device, const TandemDeviceForce* force) {
  (void)device;
  (void)force;
  return TANDEM_FAILED;
}
static void Stop(TandemDevice* device) { (void)device; }
static int32_t LastError(TandemDevice* device, char* text, uint32_t room) {
  (void)device;
  (void)text;
  (void)room;
  return TANDEM_FAILED;
}

const TandemDriver tandem_driver = {
    sizeof(TandemDriver), UNSOUND_MAJOR, 0, 0, UNSOUND_NAME, "unsound driver of a test", "",
    Init, Deinit, List, Open, Close, Capabilities, Start, Read, Write, Stop, LastError, 0};
