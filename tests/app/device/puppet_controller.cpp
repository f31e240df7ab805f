// puppet_controller DRIVER: a controller that asks its device for 2.5 N, a thousand times a second,
// until it is killed.
#include <cstdio>

#include "app/cli/device_process.h"
#include "engine/realtime/periodic_thread.h"

int main(int argc, char** argv) {
  using namespace tandem;
  if (argc != 2) return 2;
  auto process = DeviceProcess::Start({.driver = argv[1]});
  if (!process) {
    std::fprintf(stderr, "%s\n", process.error().what.c_str());
    return 1;
  }
  const std::unique_ptr<Device> device = (*process)->MakeDevice();
  device->Start();
  PeriodicThread thread({.origin_ns = (*process)->origin_ns()}, [&](std::int64_t, std::int64_t) {
    device->Read();
    Wrench wanted;
    wanted.f.x() = 2.5;
    device->Render(wanted);
    return true;
  });
  thread.Join();
}
