#include "collab/transfer/scene_fetch.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"

namespace tandem {

namespace {

// silences after which a program is not asked any more
constexpr int kMostSilences = 3;
constexpr int kMostReturns = 3;  // how often a program may be silent or slow, and offer again
constexpr std::int64_t kTurnNs = 30'000'000;
// free places that make an ask worthwhile
constexpr std::size_t kLeastAsked = 16;

/// Describes a size above a limit, as "2 MB, more than the 1 MB that are allowed ...".
std::string BeyondLimit(std::uint64_t bytes, std::uint64_t most) {
  constexpr std::uint64_t kMegabyte = 1'000'000;
  const std::uint64_t megabytes = bytes / kMegabyte + (bytes % kMegabyte == 0 ? 0 : 1);
  return std::to_string(megabytes) + " MB, more than the " + std::to_string(most / kMegabyte) +
         " MB that are allowed: --scene-limit-mb allows more";
}

}  // namespace

SceneFetch::SceneFetch(PeerId self, std::uint64_t content_hash, std::uint64_t most_bytes)
    : self_(self), content_hash_(content_hash), most_bytes_(most_bytes) {}

PeerId SceneFetch::source() const noexcept {
  const auto found = std::ranges::find_if(sources_, [this](const Source& source) {
    return source_ == source.program;
  });
  return found == sources_.end() ? 0 : found->peer;
}

std::vector<std::string> SceneFetch::TakeNotifications() {
  return std::exchange(notifications_, {});
}

void SceneFetch::GoTo(State state, std::int64_t now_ns) {
  state_ = state;
  since_ns_ = now_ns;
  heard_ns_ = turn_ns_ = now_ns;
  pieces_in_turn_ = 0;
  asked_ns_ = 0;
  outstanding_.clear();
  rate_.Restart();
}

void SceneFetch::Fail(const std::string& why) {
  state_ = State::kFailed;
  // an earlier refusal says more
  if (fault_.empty()) fault_ = why;
}

void SceneFetch::OnPiece(const FilePiece& piece, std::int64_t now_ns) {
  if (piece.content_hash != content_hash_ || piece.from == self_ || piece.from == 0) return;
  if (wrong_programs_.contains(piece.program)) return;
  switch (piece.kind) {
    case FileAsk::Kind::kOffer:
      return OnOffer(piece, now_ns);
    case FileAsk::Kind::kList:
      if (state_ == State::kListing && source_ == piece.program) OnListPiece(piece, now_ns);
      return;
    case FileAsk::Kind::kFiles:
      if (state_ == State::kFetching && source_ == piece.program) OnFilePiece(piece, now_ns);
      return;
  }
}

void SceneFetch::OnOffer(const FilePiece& piece, std::int64_t now_ns) {
  if (wrong_lists_.contains(piece.list)) return;
  if (const auto known = given_up_.find(piece.program);
      known != given_up_.end() && known->second >= kMostReturns) {
    return;
  }
  patient_to_ns_ = 0;
  if (piece.total_bytes > most_bytes_) {
    if (fault_.empty()) fault_ = "its files have " + BeyondLimit(piece.total_bytes, most_bytes_);
    return;
  }
  if (const std::uint64_t most = MostListBytes(most_bytes_); piece.list_bytes > most) {
    if (fault_.empty()) fault_ = "its list of files has " + BeyondLimit(piece.list_bytes, most);
    return;
  }
  if (piece.list_bytes == 0) {
    patient_to_ns_ = std::min(now_ns + kPreparingNs, began_ns_ + kMostPreparingNs);
    return;
  }
  auto known = std::ranges::find(sources_, piece.program, &Source::program);
  if (known == sources_.end()) {
    if (sources_.size() == kMostSources) return;
    sources_.push_back({.program = piece.program, .peer = piece.from});
    known = sources_.end() - 1;
  } else if (source_ == piece.program) {
    return;
  }
  known->peer = piece.from;
  known->list = piece.list;
  known->list_bytes = piece.list_bytes;
  if (offer_ns_ == 0) offer_ns_ = now_ns;
}

void SceneFetch::ChooseList(std::int64_t now_ns) {
  // if a list's pieces are at hand, the programs that offer it come first
  std::map<Sha256, std::size_t> offered;
  for (const Source& source : sources_) ++offered[source.list];
  const Source* best = nullptr;
  const auto rank = [&](const Source& source) {
    const bool begun = store_ != nullptr && source.list == digest_;
    return std::pair(begun ? 1U : 0U, offered[source.list]);
  };
  for (const Source& source : sources_) {
    if (best == nullptr || rank(source) > rank(*best)) best = &source;
  }
  if (best == nullptr) return;
  if (store_ != nullptr && best->list == digest_) {
    GoTo(State::kFetching, now_ns);
    ChooseSource(now_ns);
    return;
  }
  digest_ = best->list;
  list_bytes_ = best->list_bytes;
  store_ = nullptr;
  list_text_.assign(list_bytes_, 0);
  held_.assign(PiecesOf(list_bytes_), false);
  first_missing_ = 0;
  GoTo(State::kListing, now_ns);
  ChooseSource(now_ns);
}

bool SceneFetch::ChooseSource(std::int64_t now_ns) {
  const Source* best = nullptr;
  for (const Source& source : sources_) {
    if (source.list != digest_ || source.silences >= kMostSilences) continue;
    if (best == nullptr || source.silences < best->silences) best = &source;
  }
  source_ = best == nullptr ? std::nullopt : std::optional(best->program);
  outstanding_.clear();
  heard_ns_ = turn_ns_ = now_ns;
  pieces_in_turn_ = 0;
  asked_ns_ = 0;
  rate_.Restart();
  return best != nullptr;
}

void SceneFetch::Drop(Fault fault, std::int64_t now_ns) {
  const auto found = std::ranges::find_if(sources_, [this](const Source& source) {
    return source_ == source.program;
  });
  if (found != sources_.end()) {
    if (fault == Fault::kWrong) {
      liars_.push_back(found->peer);
      wrong_programs_.insert(found->program);
      sources_.erase(found);
    } else {
      found->silences = fault == Fault::kSlow ? kMostSilences : found->silences + 1;
    }
  }
  if (ChooseSource(now_ns)) return;
  // no program with these files is left: one may come, or come back, but not for ever
  std::erase_if(sources_, [this](const Source& source) {
    if (source.list != digest_) return false;
    ++given_up_[source.program];
    return true;
  });
  offer_ns_ = 0;
  GoTo(State::kLooking, now_ns);
}

void SceneFetch::Begin(PieceStore& store, std::int64_t now_ns) {
  TANDEM_CHECK(state_ == State::kListed);
  store_ = &store;
  held_.assign(list_.pieces(), false);
  first_missing_ = 0;
  bytes_held_ = 0;
  std::uint32_t number = 0;
  for (std::size_t f = 0; f < list_.files.size(); ++f) {
    const ListedFile& file = list_.files[f];
    for (std::uint32_t p = 0; p < file.pieces.size(); ++p, ++number) {
      const std::uint64_t at = std::uint64_t{p} * kPieceBytes;
      const auto bytes =
          static_cast<std::size_t>(std::min<std::uint64_t>(kPieceBytes, file.bytes - at));
      piece_.resize(bytes);
      if (!store.Read({f, p, at, bytes}, piece_) || Sha256Of(piece_) != file.pieces[p]) continue;
      held_[number] = true;
      bytes_held_ += bytes;
    }
  }
  bytes_at_start_ = bytes_held_;
  GoTo(bytes_held_ == list_.total_bytes() ? State::kFetched : State::kFetching, now_ns);
}

void SceneFetch::Refuse(const std::string& why, std::int64_t now_ns) {
  fault_ = why;
  wrong_lists_.insert(digest_);
  for (const Source& source : sources_) {
    if (source.list != digest_) continue;
    // else it could offer one wrong list after another
    wrong_programs_.insert(source.program);
    liars_.push_back(source.peer);
  }
  std::erase_if(sources_, [this](const Source& source) {
    return source.list == digest_;
  });
  source_.reset();
  store_ = nullptr;
  if (sources_.empty()) {
    state_ = State::kFailed;
    return;
  }
  notifications_.push_back(why + "; another peer has other files");
  GoTo(State::kLooking, now_ns);
}

std::uint32_t SceneFetch::PiecesWanted() const {
  return static_cast<std::uint32_t>(held_.size());
}

void SceneFetch::OnNews(std::int64_t now_ns) {
  heard_ns_ = now_ns;
  ++pieces_in_turn_;
}

bool SceneFetch::IsTooSlow(std::int64_t now_ns) {
  if (now_ns - turn_ns_ < kSlowNs) return false;
  const bool too_slow = pieces_in_turn_ < kLeastPieces;
  turn_ns_ = now_ns;
  pieces_in_turn_ = 0;
  return too_slow;
}

void SceneFetch::OnListPiece(const FilePiece& piece, std::int64_t now_ns) {
  if (piece.list != digest_ || piece.number >= held_.size()) return;
  outstanding_.erase(piece.number);
  // a piece that is here already is no news: a program could send it for ever
  if (Holds(piece.number)) return;
  OnNews(now_ns);
  const std::size_t at = std::size_t{piece.number} * kPieceBytes;
  const std::size_t bytes = std::min(kPieceBytes, list_text_.size() - at);
  if (!coder_.Unpack(piece.bytes, piece.compressed, std::span(list_text_).subspan(at, bytes))) {
    notifications_.emplace_back(
        "a peer sent what is no piece of the list of files: nothing more is taken from it");
    return Drop(Fault::kWrong, now_ns);
  }
  held_[piece.number] = true;
  if (std::ranges::find(held_, false) != held_.end()) return;
  if (Sha256Of(list_text_) != digest_) {
    notifications_.emplace_back(
        "a peer sent another list of files than it offered: nothing more is taken from it");
    held_.assign(held_.size(), false);
    first_missing_ = 0;
    return Drop(Fault::kWrong, now_ns);
  }
  Result<SceneList> list = DecodeList(list_text_, most_bytes_);
  if (!list) return Refuse(list.error().what, now_ns);
  list_ = *std::move(list);
  GoTo(State::kListed, now_ns);
}

void SceneFetch::OnFilePiece(const FilePiece& piece, std::int64_t now_ns) {
  if (piece.list != digest_ || piece.number >= held_.size()) return;
  outstanding_.erase(piece.number);
  // a piece that is here already is no news: a program could send it for ever
  if (Holds(piece.number)) return;
  OnNews(now_ns);
  const PiecePlace place = PlaceOf(list_, piece.number);
  piece_.resize(place.bytes);
  const bool sound = coder_.Unpack(piece.bytes, piece.compressed, piece_) &&
                     Sha256Of(piece_) == list_.files[place.file].pieces[place.piece];
  if (!sound) {
    notifications_.emplace_back(
        "a peer sent a piece that is not the file's: nothing more is taken from it");
    return Drop(Fault::kWrong, now_ns);
  }
  if (!store_->Write(place, piece_)) {
    fault_ = "the scene's files cannot be written: the disk is full, or took no more";
    state_ = State::kFailed;
    return;
  }
  rate_.OnPiece(now_ns - piece.sent_ns, piece.bytes.size());
  held_[piece.number] = true;
  bytes_held_ += place.bytes;
  if (bytes_held_ == list_.total_bytes()) GoTo(State::kFetched, now_ns);
}

void SceneFetch::Ask(std::int64_t now_ns, const Out& out) {
  std::size_t lost = 0;
  std::erase_if(outstanding_, [&](const auto& one) {
    const bool is_lost = now_ns - one.second > kLostNs;
    if (is_lost) ++lost;
    return is_lost;
  });
  rate_.OnLost(lost);
  rate_.Tick(now_ns);
  if (now_ns - asked_ns_ < kLeastAskNs) return;
  const std::size_t free = rate_.room() - std::min(rate_.room(), outstanding_.size());
  if (free < std::min(kLeastAsked, rate_.room() / 2)) return;
  FileAsk ask;
  ask.from = self_;
  ask.to = source();
  ask.kind = state_ == State::kListing ? FileAsk::Kind::kList : FileAsk::Kind::kFiles;
  ask.content_hash = content_hash_;
  ask.list = digest_;
  ask.rate = static_cast<std::uint32_t>(rate_.rate());
  while (first_missing_ < PiecesWanted() && Holds(first_missing_)) ++first_missing_;
  std::uint32_t number = first_missing_;
  while (number < PiecesWanted() && (Holds(number) || outstanding_.contains(number))) ++number;
  ask.first = number;
  std::size_t requested = 0;
  for (std::size_t i = 0; i < kAskSpan && number < PiecesWanted() && requested < free;
       ++i, ++number) {
    if (Holds(number) || outstanding_.contains(number)) continue;
    ask.wanted[i] = true;
    outstanding_[number] = now_ns;
    ++requested;
  }
  if (requested == 0) return;
  asked_ns_ = now_ns;
  out.ask(ask);
}

std::int64_t SceneFetch::Tick(std::int64_t now_ns, const Out& out) {
  if (began_ns_ == 0) began_ns_ = since_ns_ = now_ns;
  if (state_ == State::kLooking) {
    if (offer_ns_ != 0 && now_ns - offer_ns_ >= kSettleNs && !sources_.empty()) {
      ChooseList(now_ns);
    } else if (sources_.empty() && now_ns - since_ns_ > kNobodyNs && now_ns > patient_to_ns_) {
      Fail(store_ != nullptr ? "nobody who has the scene's files is left; what came is kept: join "
                               "again when somebody has them"
                             : "nobody here hands out the scene's files: get them another way, and "
                               "name the scene with --scene");
    }
  }
  if (state_ == State::kLooking && now_ns - asked_offer_ns_ >= kAgainNs) {
    asked_offer_ns_ = now_ns;
    FileAsk ask;
    ask.from = self_;
    ask.content_hash = content_hash_;
    out.ask(ask);
  }
  if (state_ == State::kListing || state_ == State::kFetching) {
    if (now_ns - heard_ns_ > kSilentNs) {
      Drop(Fault::kSilent, now_ns);
    } else if (IsTooSlow(now_ns)) {
      Drop(Fault::kSlow, now_ns);
    }
    if (state_ == State::kListing || state_ == State::kFetching) Ask(now_ns, out);
  }
  return now_ns + kTurnNs;
}

}  // namespace tandem
