#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "collab/transfer/file_messages.h"
#include "collab/transfer/rate_finder.h"
#include "collab/transfer/scene_list.h"

namespace tandem {

/// Where the pieces of a list's files go.
class PieceStore {
 public:
  virtual ~PieceStore() = default;
  /// Reads a piece that may be there from an earlier run; false: it is not.
  virtual bool Read(const PiecePlace& place, std::span<char> piece) = 0;
  /// False: the disk takes no more.
  virtual bool Write(const PiecePlace& place, std::span<const char> piece) = 0;
};

/// Fetches the files of a scene from the peers that have them, one after the other, piece by piece.
///
/// What a peer says counts for nothing until a digest confirms it: each piece has one in the list
/// of files, and the list has one by which it was offered. So the first wrong piece tells which
/// program it came from, and nothing more is taken from that one. Of several lists the one that
/// most programs offer is tried first; whether it is the session's scene its content hash tells in
/// the end, and where it is not, Refuse() goes on to the next. Times are handed in. Used by one
/// thread.
class SceneFetch : public FileParty {
 public:
  static constexpr std::size_t kMostSources = 16;
  static constexpr std::int64_t kAgainNs = 250'000'000;         // asks for offers again
  static constexpr std::int64_t kSettleNs = 300'000'000;        // after the first offer, for others
  static constexpr std::int64_t kLostNs = 1'500'000'000;        // a piece is asked for again
  static constexpr std::int64_t kSilentNs = 2'500'000'000;      // the next peer is asked
  static constexpr std::int64_t kNobodyNs = 3'000'000'000;      // gives up without any peer
  static constexpr std::int64_t kPreparingNs = 30'000'000'000;  // for one that makes its list
  static constexpr std::int64_t kMostPreparingNs = 90'000'000'000;
  static constexpr std::int64_t kLeastAskNs = 30'000'000;

  enum class State : std::uint8_t {
    kLooking,  // for programs that have the scene
    kListing,  // the list of its files is on its way
    kListed,   // waits for Begin() or Refuse()
    kFetching,
    kFetched,  // all pieces are there; waits for Refuse() where they are not the scene
    kFailed
  };

  SceneFetch(PeerId self, std::uint64_t content_hash, std::uint64_t most_bytes);

  bool serves() const override { return false; }
  void OnPiece(const FilePiece& piece, std::int64_t now_ns) override;
  std::int64_t Turn(std::int64_t now_ns, const Out& out) override;

  /// The list is as it should be: fetches its files into `store`, as far as they are not there.
  void Begin(PieceStore& store, std::int64_t now_ns);
  /// What the list names is not the session's scene: `why`, in a line. Goes on with another list.
  void Refuse(const std::string& why, std::int64_t now_ns);

  State state() const noexcept { return state_; }
  const SceneList& list() const noexcept { return list_; }
  const FileDigest& digest() const noexcept { return digest_; }
  PeerId source() const noexcept;  // whom it asks; 0: nobody
  std::uint64_t bytes_held() const noexcept { return bytes_held_; }
  std::uint64_t bytes_at_start() const noexcept { return bytes_at_start_; }  // of an earlier run
  /// Why it failed, in a line.
  const std::string& fault() const noexcept { return fault_; }
  /// What happened meanwhile that a person should know, a line each.
  std::vector<std::string> TakeNews();
  /// The peers whose pieces or lists were wrong.
  const std::vector<PeerId>& liars() const noexcept { return liars_; }

 private:
  struct Source {
    std::uint64_t program = 0;
    PeerId peer = 0;
    FileDigest list{};
    std::uint32_t list_bytes = 0;
    int silences = 0;
  };
  enum class Fault : std::uint8_t { kSilent, kWrong };

  void OnOffer(const FilePiece& piece, std::int64_t now_ns);
  void OnListPiece(const FilePiece& piece, std::int64_t now_ns);
  void OnFilePiece(const FilePiece& piece, std::int64_t now_ns);
  /// Takes the list that most offer, and of its programs one.
  void ChooseList(std::int64_t now_ns);
  void GoTo(State state, std::int64_t now_ns);
  /// Does without the program that it asks, and goes on with another.
  void Drop(Fault fault, std::int64_t now_ns);
  bool ChooseSource(std::int64_t now_ns);
  void Fail(const std::string& why);
  void Ask(std::int64_t now_ns, const Out& out);
  std::uint32_t PiecesWanted() const;
  bool Holds(std::uint32_t number) const { return held_[number]; }

  const PeerId self_;
  const std::uint64_t content_hash_;
  const std::uint64_t most_bytes_;
  State state_ = State::kLooking;
  std::int64_t since_ns_ = 0;        // in this state; 0: not yet
  std::int64_t began_ns_ = 0;        // in the first state; 0: not yet
  std::int64_t patient_to_ns_ = 0;   // somebody has the files and makes its list of them
  std::int64_t offer_ns_ = 0;        // of the first offer
  std::int64_t asked_offer_ns_ = 0;  // when offers were asked for last
  std::int64_t heard_ns_ = 0;        // of the source
  std::int64_t asked_ns_ = 0;        // when pieces were asked for last
  std::vector<Source> sources_;
  std::optional<std::uint64_t> source_;  // its program
  std::set<std::uint64_t> wrong_programs_;
  std::set<FileDigest> wrong_lists_;
  std::vector<PeerId> liars_;
  std::vector<std::string> news_;
  FileDigest digest_{};           // of the list
  std::uint32_t list_bytes_ = 0;  // of the list, as offered
  std::vector<char> list_text_;
  SceneList list_;
  PieceStore* store_ = nullptr;
  std::vector<bool> held_;                             // pieces, of the list or of the files
  std::uint32_t first_missing_ = 0;                    // all before are held
  std::map<std::uint32_t, std::int64_t> outstanding_;  // when they were asked for
  std::uint64_t bytes_held_ = 0;
  std::uint64_t bytes_at_start_ = 0;
  RateFinder rate_;
  PieceCoder coder_;
  std::vector<char> piece_;
  std::string fault_;
};

}  // namespace tandem
