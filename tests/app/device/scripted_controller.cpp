// scripted_controller DRIVER is a controller that asks its device for 2.5 N, a thousand times a
// second, until it is killed. scripted_controller --memory N does the same with a device process
// that another program has started; N is the descriptor of that process's memory.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "app/process/device_process.h"
#include "engine/haptics/process_device.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem {
namespace {

int Control(Device& device, std::int64_t origin_ns) {
  device.Start();
  PeriodicThread thread({.origin_ns = origin_ns}, [&](std::int64_t, std::int64_t) {
    device.Read();
    Wrench wanted;
    wanted.f.x() = 2.5;
    device.Render(wanted);
    return true;
  });
  thread.Join();
  return 0;
}

int Run(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "--memory") == 0) {
    Result<SharedMemory> shared = SharedMemory::Attach(std::atoi(argv[2]), sizeof(DeviceMemory));
    if (!shared) {
      std::fprintf(stderr, "%s\n", shared.error().what.c_str());
      return 1;
    }
    auto& memory = *static_cast<DeviceMemory*>(shared->data());
    ProcessDevice device(memory);
    return Control(device, memory.origin_ns);
  }
  if (argc != 2) return 2;
  auto process = DeviceProcess::Start({.driver = argv[1]});
  if (!process) {
    std::fprintf(stderr, "%s\n", process.error().what.c_str());
    return 1;
  }
  const std::unique_ptr<Device> device = (*process)->MakeDevice();
  return Control(*device, (*process)->origin_ns());
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  return tandem::Run(argc, argv);
}
