#include "engine/voxel/voxmap_image.h"

#include <utility>

#include <sys/mman.h>

#include "engine/base/check.h"

namespace tandem {

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20U;

}  // namespace

ImageBytes::ImageBytes(std::size_t size) : size_(size) {
  // more than asked for, so that it can begin on a huge page; what is too much goes back
  const std::size_t rounded = (size + kHugePage - 1) / kHugePage * kHugePage;
  void* whole = mmap(nullptr, rounded + kHugePage, PROT_READ | PROT_WRITE,
                     MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  TANDEM_CHECK(whole != MAP_FAILED);
  auto* begin = static_cast<std::byte*>(whole);
  const std::size_t skip =
      (kHugePage - reinterpret_cast<std::uintptr_t>(begin) % kHugePage) % kHugePage;
  if (skip > 0) munmap(begin, skip);
  munmap(begin + skip + rounded, kHugePage - skip);
  data_ = begin + skip;
  // small maps are not worth a huge page each
  if (size >= kHugePage) madvise(data_, rounded, MADV_HUGEPAGE);
}

ImageBytes::~ImageBytes() {
  if (data_ != nullptr) munmap(data_, (size_ + kHugePage - 1) / kHugePage * kHugePage);
}

void ImageBytes::Shrink(std::size_t size) {
  TANDEM_CHECK(size <= size_);
  const auto rounded = [](std::size_t bytes) {
    return (bytes + kHugePage - 1) / kHugePage * kHugePage;
  };
  if (rounded(size) < rounded(size_)) {
    munmap(data_ + rounded(size), rounded(size_) - rounded(size));
  }
  size_ = size;
}

ImageBytes::ImageBytes(ImageBytes&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

ImageBytes& ImageBytes::operator=(ImageBytes&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

}  // namespace tandem
