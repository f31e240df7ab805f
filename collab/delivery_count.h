#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "collab/messages.h"

namespace tandem {

/// How many of the states that others sent have come, by the numbers their transports give them
/// (1, 2, 3 … over all bodies of a peer): between the first and the newest that came, none is
/// missing when all were delivered. Written by the receive thread; read when that has ended.
class DeliveryCount {
 public:
  struct Row {
    PeerId peer = 0;
    std::uint64_t sent = 0;
    std::uint64_t received = 0;
    std::uint32_t newest = 0;
  };

  void Add(PeerId peer, std::uint32_t seq) noexcept {
    const auto row = std::find_if(rows_.begin(), rows_.end(), [peer](const Row& r) {
      return r.peer == peer || r.peer == 0;
    });
    if (row == rows_.end()) return;
    const auto step = static_cast<std::int32_t>(seq - row->newest);
    if (row->peer != 0 && step <= 0) return;  // again, or late: counted as missing already
    row->sent += row->peer == 0 ? 1U : static_cast<std::uint32_t>(step);
    row->peer = peer;
    row->newest = seq;
    ++row->received;
  }

  /// Of those that were heard; the other rows have peer 0.
  const std::array<Row, 4 * kMaxPeers>& rows() const noexcept { return rows_; }

 private:
  std::array<Row, 4 * kMaxPeers> rows_{};
};

}  // namespace tandem
