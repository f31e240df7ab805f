#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "collab/session/messages.h"

namespace tandem {

/// Counts how many of the states sent by other peers arrived. Transports number the states of a
/// peer 1, 2, 3 … over all its bodies. If all were delivered, no number is missing between the
/// first and the newest arrival. Written by the receive thread; read when that thread has ended.
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
    if (row->peer != 0 && step <= 0) return;  // a repeated or late state, counted as missing
    row->sent += row->peer == 0 ? 1U : static_cast<std::uint32_t>(step);
    row->peer = peer;
    row->newest = seq;
    ++row->received;
  }

  /// Rows of the peers heard; unused rows have peer 0.
  const std::array<Row, 4 * kMaxPeers>& rows() const noexcept { return rows_; }

 private:
  std::array<Row, 4 * kMaxPeers> rows_{};
};

}  // namespace tandem
