#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

#include "collab/recording/frame_code.h"
#include "collab/recording/recorder.h"
#include "collab/recording/recording.h"

namespace tandem::testing {

/// A frame by somebody who wants harm: parts as the recorder writes them, with any numbers, and a
/// checksum that is right.
class CraftedFrame {
 public:
  explicit CraftedFrame(std::int64_t now_ns = 1'000'000) {
    (*this)(FramePart::kBegin);
    (*this)(now_ns);
    (*this)(1e5);
  }
  template <typename T>
  void operator()(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <typename T>
  CraftedFrame& Part(FramePart part, const T& value) {
    (*this)(part);
    CodeFields(*this, value);
    return *this;
  }
  /// Returns the content, ended.
  std::string Ended(std::uint64_t hash = 0) const {
    CraftedFrame whole = *this;
    whole(FramePart::kEnd);
    whole(hash);
    return whole.bytes_;
  }

 private:
  std::string bytes_;
};

inline std::string Framed(const std::string& content) {
  const auto length = static_cast<std::uint32_t>(content.size());
  const std::uint32_t crc = Crc32(content.data(), content.size());
  return std::string(reinterpret_cast<const char*>(&length), sizeof length) +
         std::string(reinterpret_cast<const char*>(&crc), sizeof crc) + content;
}

inline std::string RecordingOf(const std::string& header, const std::string& frames) {
  const auto length = static_cast<std::uint32_t>(header.size());
  return std::string(kRecordingMagic) +
         std::string(reinterpret_cast<const char*>(&length), sizeof length) + header + frames;
}

}  // namespace tandem::testing
