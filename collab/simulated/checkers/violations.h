#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "collab/session/messages.h"

namespace tandem {

/// Collects the violations of a session, each sort once: "at 3.217 s: a body in hand jumps: peer
/// 101, by 3.20 mm".
class Violations {
 public:
  void SetTime(std::int64_t now_ns) noexcept { now_ns_ = now_ns; }
  std::int64_t now_ns() const noexcept { return now_ns_; }

  void Add(const std::string& sort, PeerId peer, const std::string& what = {});

  const std::vector<std::string>& all() const noexcept { return all_; }

 private:
  std::int64_t now_ns_ = 0;
  std::map<std::string, int> sorts_;
  std::vector<std::string> all_;
};

/// Formats as printf does.
[[gnu::format(printf, 1, 2)]] std::string Text(const char* format, ...);

}  // namespace tandem
