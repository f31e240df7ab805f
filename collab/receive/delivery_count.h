#pragma once

#include <cstdint>

#include "collab/session/messages.h"
#include "collab/session/peer_map.h"

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
    Row* const row = rows_.FindOrInsert(peer);
    if (row == nullptr) return;
    const bool is_first = row->received == 0;
    const auto step = static_cast<std::int32_t>(seq - row->newest);
    if (!is_first && step <= 0) return;  // a repeated or late state, counted as missing
    row->sent += is_first ? 1U : static_cast<std::uint32_t>(step);
    row->newest = seq;
    ++row->received;
  }

  /// Rows of the peers heard.
  const PeerMap<Row, 4 * kMaxPeers>& rows() const noexcept { return rows_; }

 private:
  PeerMap<Row, 4 * kMaxPeers> rows_;
};

}  // namespace tandem
