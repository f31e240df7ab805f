#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collab/transfer/file_messages.h"
#include "collab/transfer/scene_list.h"
#include "engine/base/units.h"

namespace tandem::testing {

/// A list of a scene file and meshes with these bytes, as an honest server makes it.
struct Listed {
  explicit Listed(std::vector<std::string> contents, const std::string& kind = ".stl")
      : files(std::move(contents)) {
    for (const std::string& text : files) {
      ListedFile file{list.files.empty() ? ".json" : kind, text.size(), Sha256Of(text), {}};
      for (std::size_t at = 0; at < text.size(); at += kPieceBytes) {
        file.pieces.push_back(Sha256Of(std::string_view(text).substr(at, kPieceBytes)));
      }
      list.files.push_back(std::move(file));
    }
    encoded = Encode(list);
  }
  std::string Piece(std::uint32_t number) const {
    const PiecePlace place = PlaceOf(list, number);
    return files[place.file].substr(place.at, place.bytes);
  }
  std::vector<std::string> files;
  SceneList list;
  std::vector<char> encoded;
};

/// A server that answers as it is told.
class EvilServer final : public TransferEndpoint {
 public:
  using Answer =
      std::function<void(const FileAsk& ask, const std::function<void(FilePiece)>& send)>;
  EvilServer(PeerId self, std::uint64_t content_hash, Answer answer)
      : self_(self), content_(content_hash), answer_(std::move(answer)) {}
  bool serves() const override { return true; }
  void OnAsk(const FileAsk& ask, std::int64_t) override {
    if (ask.to == 0 || ask.to == self_) asks_.push_back(ask);
  }
  std::int64_t Tick(std::int64_t now_ns, const Out& out) override {
    const auto send = [&](FilePiece piece) {
      piece.from = self_;
      piece.content_hash = content_;
      piece.sent_ns = now_ns;
      out.piece(piece);
    };
    for (const FileAsk& ask : std::exchange(asks_, {})) answer_(ask, send);
    return now_ns + kMs;
  }

  /// Offers a list and sends its pieces.
  static void Serve(const Listed& listed, const FileAsk& ask,
                    const std::function<void(FilePiece)>& send) {
    FilePiece piece;
    piece.kind = ask.kind;
    piece.list = Sha256Of(listed.encoded);
    if (ask.kind == FileAsk::Kind::kOffer) {
      piece.list_bytes = static_cast<std::uint32_t>(listed.encoded.size());
      piece.total_bytes = listed.list.total_bytes();
      return send(piece);
    }
    const bool of_list = ask.kind == FileAsk::Kind::kList;
    const std::uint32_t count = of_list ? PiecesOf(listed.encoded.size()) : listed.list.pieces();
    for (std::uint32_t i = 0; i < kAskSpan && ask.first + i < count; ++i) {
      if (!ask.wanted[i]) continue;
      piece.number = ask.first + i;
      const std::string bytes =
          of_list ? std::string(listed.encoded.begin(), listed.encoded.end())
                        .substr(std::size_t{piece.number} * kPieceBytes, kPieceBytes)
                  : listed.Piece(piece.number);
      piece.bytes.assign(bytes.begin(), bytes.end());
      send(piece);
    }
  }

 private:
  const PeerId self_;
  const std::uint64_t content_;
  Answer answer_;
  std::vector<FileAsk> asks_;
};

}  // namespace tandem::testing
