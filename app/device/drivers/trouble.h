#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "engine/realtime/seqlock.h"

namespace tandem::driver {

/// The trouble of a device in one line; empty: none. Written by the driver's own thread, read by
/// the main thread.
class Trouble {
 public:
  void Say(std::string_view line) noexcept {
    Text text{};
    std::memcpy(text.data(), line.data(), std::min(line.size(), text.size() - 1));
    text_.Write(text);
  }
  std::string line() const {
    Text text{};
    return text_.Read(text) ? std::string(text.data()) : std::string();
  }

 private:
  using Text = std::array<char, 256>;
  Seqlock<Text> text_;
};

}  // namespace tandem::driver
