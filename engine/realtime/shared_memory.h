#pragma once

#include <cstddef>

#include "engine/base/result.h"

namespace tandem {

/// Memory that a process hands to its children by a file descriptor, without a name. Its size never
/// changes, so that no process takes it away from another.
class SharedMemory {
 public:
  /// Creates zeroed memory. exec() closes the descriptor: a program that starts a child for it
  /// duplicates it there.
  static Result<SharedMemory> Create(const char* name, std::size_t size);
  /// Attaches memory that a parent handed on. An error: there is none, or it has another size.
  static Result<SharedMemory> Attach(int descriptor, std::size_t size);
  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&&) = delete;
  ~SharedMemory();

  void* data() const noexcept { return data_; }
  int descriptor() const noexcept { return descriptor_; }

 private:
  SharedMemory(int descriptor, void* data, std::size_t size) noexcept
      : descriptor_(descriptor), data_(data), size_(size) {}
  static Result<SharedMemory> Map(int descriptor, std::size_t size);

  int descriptor_ = -1;
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace tandem
