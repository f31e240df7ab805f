#pragma once

#include <filesystem>
#include <memory>

#include "collab/peer/peer_node.h"
#include "collab/recording/recording.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/result.h"

namespace tandem {

/// Writes a replayed recording as a poses file, which `tandem proximity --poses` reads: CSV with
/// the columns t_s,moving,tx,ty,tz,ax,ay,az,angle_deg, a row for each moving body every ten frames.
/// t_s counts from the first frame. The pose is that of the body's mesh file in the scene, in
/// metres.
class PosesExport {
 public:
  static constexpr std::int64_t kEveryFrames = 10;

  static Result<std::unique_ptr<PosesExport>> Create(const std::filesystem::path& file,
                                                     const WorldModel& model);

  /// Adds a frame that `node` has just replayed.
  void Add(const RecordedFrame& frame, const PeerNode& node);
  /// Ends the file. Returns the number of rows.
  Result<std::uint64_t> Close();

 private:
  PosesExport(WholeFile file, const WorldModel& model);

  WholeFile file_;
  const WorldModel* model_;
  std::int64_t frames_ = 0;
  std::int64_t first_ns_ = 0;
  std::uint64_t rows_ = 0;
};

}  // namespace tandem
