#include "engine/realtime/shared_memory.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {

Result<SharedMemory> SharedMemory::Map(int descriptor, std::size_t size) {
  void* data =
      mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, descriptor, 0);
  if (data == MAP_FAILED) {
    const int why = errno;
    close(descriptor);
    return Error{std::string("shared memory cannot be mapped: ") + std::strerror(why)};
  }
  return SharedMemory(descriptor, data, size);
}

Result<SharedMemory> SharedMemory::Create(const char* name, std::size_t size) {
  const int descriptor = memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (descriptor < 0) return Error{std::string("no shared memory: ") + std::strerror(errno)};
  if (ftruncate(descriptor, static_cast<off_t>(size)) != 0 ||
      fcntl(descriptor, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    const int why = errno;
    close(descriptor);
    return Error{std::string("no shared memory: ") + std::strerror(why)};
  }
  return Map(descriptor, size);
}

Result<SharedMemory> SharedMemory::Attach(int descriptor, std::size_t size) {
  struct stat facts {};
  if (fstat(descriptor, &facts) != 0 || static_cast<std::size_t>(facts.st_size) != size) {
    return Error{"file descriptor " + std::to_string(descriptor) +
                 " is not the memory of a device of this version"};
  }
  fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  return Map(descriptor, size);
}

SharedMemory::SharedMemory(SharedMemory&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      data_(std::exchange(other.data_, nullptr)),
      size_(other.size_) {}

SharedMemory::~SharedMemory() {
  if (data_ != nullptr) munmap(data_, size_);
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace tandem
