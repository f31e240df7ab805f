#include "engine/base/files/image_bytes.h"

#include <algorithm>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/base/check.h"

namespace tandem {

namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kHugePage = std::size_t{2} << 20U;

/// Returns the bytes of whole pages; small images are not worth a huge page each.
std::size_t WholePages(std::size_t size) {
  const std::size_t page = size >= kHugePage ? kHugePage : kPage;
  return (size + page - 1) / page * page;
}

void* MapZeroed(std::size_t bytes) {
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  TANDEM_CHECK(memory != MAP_FAILED);
  return memory;
}

}  // namespace

ImageBytes::ImageBytes(std::size_t size) : size_(size), mapped_(WholePages(size)) {
  if (size < kHugePage) {
    mapped_ = std::max(mapped_, kPage);
    data_ = static_cast<std::byte*>(MapZeroed(mapped_));
    return;
  }
  // more than required, so that it can begin on a huge page; the excess goes back
  auto* begin = static_cast<std::byte*>(MapZeroed(mapped_ + kHugePage));
  const std::size_t skip =
      (kHugePage - reinterpret_cast<std::uintptr_t>(begin) % kHugePage) % kHugePage;
  if (skip > 0) munmap(begin, skip);
  munmap(begin + skip + mapped_, kHugePage - skip);
  data_ = begin + skip;
  madvise(data_, mapped_, MADV_HUGEPAGE);
}

ImageBytes::~ImageBytes() {
  if (data_ != nullptr) munmap(data_, mapped_);
}

Result<ImageBytes> ImageBytes::Map(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  if (descriptor < 0) return Error{file.string() + ": cannot be opened"};
  struct stat status {};
  const bool regular = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  if (!regular || status.st_size == 0) {
    close(descriptor);
    return Error{file.string() + (regular ? ": empty" : ": not a file")};
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  void* data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  close(descriptor);
  if (data == MAP_FAILED) return Error{file.string() + ": cannot be mapped"};
  ImageBytes image;
  image.data_ = static_cast<std::byte*>(data);
  image.size_ = size;
  image.mapped_ = size;
  return image;
}

void ImageBytes::Shrink(std::size_t size) {
  TANDEM_CHECK(size <= size_);
  const std::size_t kept = std::max(WholePages(size), kPage);
  if (kept < mapped_) {
    munmap(data_ + kept, mapped_ - kept);
    mapped_ = kept;
  }
  size_ = size;
}

ImageBytes::ImageBytes(ImageBytes&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)),
      mapped_(std::exchange(other.mapped_, 0)) {}

ImageBytes& ImageBytes::operator=(ImageBytes&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

}  // namespace tandem
