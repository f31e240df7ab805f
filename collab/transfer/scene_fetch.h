#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "collab/transfer/file_messages.h"
#include "collab/transfer/rate_controller.h"
#include "collab/transfer/scene_list.h"

namespace tandem {

/// The place for the pieces of a list's files.
class PieceStore {
 public:
  virtual ~PieceStore() = default;
  /// Reads a piece that may be there from an earlier run; returns false if it is not.
  virtual bool Read(const PiecePlace& place, std::span<char> piece) = 0;
  /// Returns false if the disk takes no more.
  virtual bool Write(const PiecePlace& place, std::span<const char> piece) = 0;
};

/// Fetches the files of a scene from the peers that have them, one peer after another, piece by
/// piece.
///
/// No statement of a peer counts until a digest confirms it: each piece has a digest in the list of
/// files, and the list has one in its offer. So the first wrong piece identifies the program that
/// sent it, and nothing more is taken from that program. Of several lists the one that most
/// programs offer is tried first. The content hash of its files tells at the end whether they are
/// the session's scene. If they are not, Refuse() goes on to the next list. The class reads no
/// clock. Used by one thread.
class SceneFetch : public TransferEndpoint {
 public:
  static constexpr std::size_t kMostSources = 16;
  static constexpr std::int64_t kAgainNs = 250'000'000;   // asks for offers again
  static constexpr std::int64_t kSettleNs = 300'000'000;  // after the first offer, waits for others
  static constexpr std::int64_t kLostNs = 1'500'000'000;  // a piece is asked for again
  static constexpr std::int64_t kSilentNs = 2'500'000'000;  // the next peer is asked
  /// The next peer is also asked where fewer than kLeastPieces new pieces came in kSlowNs: that is
  /// 16 kB/s, and a slower way carries no states.
  static constexpr std::int64_t kSlowNs = 30'000'000'000;
  static constexpr std::uint32_t kLeastPieces = 15;
  static constexpr std::int64_t kNobodyNs = 3'000'000'000;      // gives up without any peer
  static constexpr std::int64_t kPreparingNs = 30'000'000'000;  // for a peer that makes its list
  static constexpr std::int64_t kMostPreparingNs = 90'000'000'000;
  static constexpr std::int64_t kLeastAskNs = 30'000'000;

  enum class State : std::uint8_t {
    kLooking,  // looks for programs that have the scene
    kListing,  // fetches the list of its files
    kListed,   // waits for Begin() or Refuse()
    kFetching,
    kFetched,  // has all pieces; waits for Refuse() where they are not the scene
    kFailed
  };

  SceneFetch(PeerId self, std::uint64_t content_hash, std::uint64_t most_bytes);

  bool serves() const override { return false; }
  void OnPiece(const FilePiece& piece, std::int64_t now_ns) override;
  std::int64_t Tick(std::int64_t now_ns, const Out& out) override;

  /// Accepts the list, and fetches its files into `store`, except pieces that are there.
  void Begin(PieceStore& store, std::int64_t now_ns);
  /// Refuses the list or its files as not the session's scene; `why`: a line. Goes on with another
  /// list.
  void Refuse(const std::string& why, std::int64_t now_ns);

  State state() const noexcept { return state_; }
  const SceneList& list() const noexcept { return list_; }
  const Sha256& digest() const noexcept { return digest_; }
  PeerId source() const noexcept;  // peer that is asked; 0: none
  std::uint64_t bytes_held() const noexcept { return bytes_held_; }
  std::uint64_t bytes_at_start() const noexcept { return bytes_at_start_; }  // from an earlier run
  /// The reason of a failure, in a line.
  const std::string& fault() const noexcept { return fault_; }
  /// Returns the news for a person, a line each.
  std::vector<std::string> TakeNotifications();
  /// The peers whose pieces or lists were wrong.
  const std::vector<PeerId>& liars() const noexcept { return liars_; }

 private:
  struct Source {
    std::uint64_t program = 0;
    PeerId peer = 0;
    Sha256 list{};
    std::uint32_t list_bytes = 0;
    int silences = 0;
  };
  enum class Fault : std::uint8_t { kSilent, kSlow, kWrong };

  void OnOffer(const FilePiece& piece, std::int64_t now_ns);
  void OnListPiece(const FilePiece& piece, std::int64_t now_ns);
  void OnFilePiece(const FilePiece& piece, std::int64_t now_ns);
  /// Chooses the list that most programs offer, and one of these programs.
  void ChooseList(std::int64_t now_ns);
  void GoTo(State state, std::int64_t now_ns);
  /// Gives up the program that it asks, and goes on with another.
  void Drop(Fault fault, std::int64_t now_ns);
  bool ChooseSource(std::int64_t now_ns);
  /// Takes note of a new piece.
  void OnNews(std::int64_t now_ns);
  bool IsTooSlow(std::int64_t now_ns);
  void Fail(const std::string& why);
  void Ask(std::int64_t now_ns, const Out& out);
  std::uint32_t PiecesWanted() const;
  bool Holds(std::uint32_t number) const { return held_[number]; }

  const PeerId self_;
  const std::uint64_t content_hash_;
  const std::uint64_t most_bytes_;
  State state_ = State::kLooking;
  std::int64_t since_ns_ = 0;        // beginning of this state; 0: not yet
  std::int64_t began_ns_ = 0;        // beginning of the first state; 0: not yet
  std::int64_t patient_to_ns_ = 0;   // until when a peer may take to make its list
  std::int64_t offer_ns_ = 0;        // time of the first offer
  std::int64_t asked_offer_ns_ = 0;  // last ask for offers
  std::int64_t heard_ns_ = 0;        // last new piece of the source
  std::int64_t turn_ns_ = 0;         // from when pieces_in_turn_ are counted
  std::uint32_t pieces_in_turn_ = 0;
  std::int64_t asked_ns_ = 0;  // last ask for pieces
  std::vector<Source> sources_;
  std::optional<std::uint64_t> source_;  // the program that is asked
  std::set<std::uint64_t> wrong_programs_;
  std::set<Sha256> wrong_lists_;
  std::map<std::uint64_t, int> given_up_;  // programs that were silent or slow, and how often
  std::vector<PeerId> liars_;
  std::vector<std::string> notifications_;
  Sha256 digest_{};               // digest of the list
  std::uint32_t list_bytes_ = 0;  // size of the list, as offered
  std::vector<char> list_text_;
  SceneList list_;
  PieceStore* store_ = nullptr;
  std::vector<bool> held_;                             // pieces held, of the list or the files
  std::uint32_t first_missing_ = 0;                    // all pieces before it are held
  std::map<std::uint32_t, std::int64_t> outstanding_;  // piece numbers asked for, and when
  std::uint64_t bytes_held_ = 0;
  std::uint64_t bytes_at_start_ = 0;
  RateController rate_;
  PieceCoder coder_;
  std::vector<char> piece_;
  std::string fault_;
};

}  // namespace tandem
