#include "collab/transfer/scene_server.h"

#include <algorithm>
#include <utility>

#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kIdleNs = kSecondNs / 2;
// sent at once after a pause: two pieces' time
constexpr std::int64_t kAtOnceNs = 10'000'000;
// cost of a message beside its bytes: packet headers
constexpr std::size_t kHeads = 600;
constexpr std::uint32_t kLeastRate = 16'384;

std::int64_t NsOf(std::size_t bytes, std::uint64_t rate) {
  return static_cast<std::int64_t>(static_cast<double>(bytes) * 1e9 / static_cast<double>(rate));
}

}  // namespace

SceneServer::SceneServer(PeerId self, std::uint64_t content_hash, Open open, std::uint64_t rate)
    : self_(self), content_hash_(content_hash), open_(std::move(open)), rate_(rate) {
  requesters_.reserve(kMostRequesters);
}

std::size_t SceneServer::waiting() const noexcept {
  std::size_t sum = 0;
  for (const Requester& requester : requesters_) sum += requester.waiting.size();
  return sum;
}

void SceneServer::Note(const std::string& line) {
  const std::scoped_lock lock(news_mutex_);
  notifications_ = line;
  has_news_.store(true);
}

std::string SceneServer::TakeNotifications() {
  if (!has_news_.exchange(false)) return {};
  const std::scoped_lock lock(news_mutex_);
  return std::exchange(notifications_, {});
}

void SceneServer::OnAsk(const FileAsk& ask, std::int64_t now_ns) {
  if (ask.content_hash != content_hash_ || (ask.to != 0 && ask.to != self_)) return;
  if (ask.kind == FileAsk::Kind::kOffer) {
    wants_offer_ = ask.from;
    return;
  }
  if (!files_ || ask.list != list_digest_) return;
  auto requester = std::ranges::find(requesters_, ask.program, &Requester::program);
  if (requester == requesters_.end()) {
    if (requesters_.size() == kMostRequesters) return;
    requester = requesters_.emplace(requesters_.end());
    requester->program = ask.program;
  }
  if (requester->kind != ask.kind || requester->peer != ask.from) {
    requester->waiting.clear();
    requester->known.clear();
  }
  if (ask.kind == FileAsk::Kind::kFiles && !std::exchange(reported_, true)) {
    Note("a joiner fetches the scene's files from here (--no-share-scene keeps them here)");
  }
  requester->kind = ask.kind;
  requester->peer = ask.from;
  requester->received_ns = now_ns;
  requester->rate = std::max(ask.rate, kLeastRate);
  const std::uint32_t pieces =
      ask.kind == FileAsk::Kind::kList ? PiecesOf(list_.size()) : files_->list().pieces();
  for (std::size_t i = 0; i < kAskSpan; ++i) {
    const std::uint64_t number = std::uint64_t{ask.first} + i;
    if (!ask.wanted[i] || number >= pieces || requester->waiting.size() == kMostWaiting) continue;
    const auto piece = static_cast<std::uint32_t>(number);
    if (requester->known.insert(piece).second) requester->waiting.push_back(piece);
  }
}

bool SceneServer::Ready() {
  if (opened_) return files_.has_value();
  opened_ = true;
  Result<SceneFiles> files = open_(stop_);
  if (!files) {
    if (!stop_) {
      Note("somebody asks for the scene's files, and they are not sent: " + files.error().what);
    }
    return false;
  }
  files_.emplace(*std::move(files));
  list_ = Encode(files_->list());
  list_digest_ = Sha256Of(list_);
  return true;
}

void SceneServer::Offer(std::int64_t now_ns, const Out& out) {
  if (!wants_offer_ || now_ns < offer_from_ns_) return;
  const PeerId to = *std::exchange(wants_offer_, std::nullopt);
  offer_from_ns_ = now_ns + kSecondNs / kOffersPerSecond;
  FilePiece offer;
  offer.from = self_;
  offer.to = to;
  offer.kind = FileAsk::Kind::kOffer;
  offer.content_hash = content_hash_;
  // an offer without a list: it is being made, which takes a while for a large scene
  if (!opened_) out.piece(offer);
  if (!Ready()) return;
  offer.list = list_digest_;
  offer.list_bytes = static_cast<std::uint32_t>(list_.size());
  offer.total_bytes = files_->list().total_bytes();
  out.piece(offer);
}

SceneServer::Requester* SceneServer::NextRequester(std::int64_t now_ns) {
  std::erase_if(requesters_, [now_ns](const Requester& requester) {
    return now_ns - requester.received_ns > kForgetNs;
  });
  for (std::size_t i = 0; i < requesters_.size(); ++i) {
    Requester& requester = requesters_[(turn_ + i) % requesters_.size()];
    if (requester.waiting.empty() || requester.room_from_ns > now_ns) continue;
    turn_ = (turn_ + i + 1) % requesters_.size();
    return &requester;
  }
  return nullptr;
}

std::size_t SceneServer::Serve(Requester& requester, std::int64_t now_ns, const Out& out) {
  const std::uint32_t number = requester.waiting.front();
  requester.waiting.pop_front();
  requester.known.erase(number);
  if (requester.kind == FileAsk::Kind::kList) {
    const std::size_t at = std::size_t{number} * kPieceBytes;
    const auto begin = list_.begin() + static_cast<std::ptrdiff_t>(at);
    piece_.assign(begin,
                  begin + static_cast<std::ptrdiff_t>(std::min(kPieceBytes, list_.size() - at)));
  } else if (!files_->Read(number, piece_)) {
    return 0;
  }
  out_.from = self_;
  out_.to = requester.peer;
  out_.kind = requester.kind;
  out_.content_hash = content_hash_;
  out_.list = list_digest_;
  out_.number = number;
  out_.sent_ns = now_ns;
  out_.compressed = coder_.Pack(piece_, out_.bytes);
  out.piece(out_);
  return out_.bytes.size() + kHeads;
}

std::int64_t SceneServer::Tick(std::int64_t now_ns, const Out& out) {
  Offer(now_ns, out);
  std::int64_t next_ns = now_ns + kIdleNs;
  if (wants_offer_) next_ns = std::min(next_ns, offer_from_ns_);
  if (!files_) return next_ns;
  room_from_ns_ = std::max(room_from_ns_, now_ns - kAtOnceNs);
  if (room_from_ns_ <= now_ns) {
    if (Requester* const requester = NextRequester(now_ns)) {
      const std::size_t bytes = Serve(*requester, now_ns, out);
      // each program that receives pieces gets a copy
      const std::size_t copies = std::clamp<std::size_t>(out.listeners(), 1, 64);
      room_from_ns_ += NsOf(bytes * copies, rate_);
      requester->room_from_ns =
          std::max(requester->room_from_ns, now_ns - kAtOnceNs) + NsOf(bytes, requester->rate);
    }
  }
  for (const Requester& requester : requesters_) {
    if (requester.waiting.empty()) continue;
    next_ns = std::min(next_ns, std::max(requester.room_from_ns, room_from_ns_));
  }
  return std::max(next_ns, now_ns);
}

}  // namespace tandem
