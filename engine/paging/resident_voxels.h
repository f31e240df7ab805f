#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"
#include "engine/paging/prefetch_thread.h"
#include "engine/paging/voxel_arena.h"
#include "engine/voxel/page_source.h"

namespace tandem {

class ResidentVoxels;

/// What one pair of bodies reads of a voxmap that is in memory in part. Haptic thread.
class VoxelReader {
 public:
  VoxelReader(ResidentVoxels& voxels, ShellBox& box);
  /// The shell stands elsewhere, so many voxels of travel on.
  void MoveTo(const Pose& X_VS, double travel_voxels) noexcept;
  /// What lies in a ball may be read from `frames` frames on, and for as long as the pair travels
  /// less than kKeptTravel. Lengths in voxels of V. Gives whether all of it is there.
  bool Announce(const Vec3& centre, double radius, std::uint32_t frames) noexcept;
  /// What lies in a ball may be read later, if ever. False: there was no room for all requests.
  bool Hint(const Vec3& centre, double radius, std::uint32_t frames) noexcept;

  /// The pair is not tested until it moves again: nothing that it announced counts any more. Gives
  /// whether it was tested before.
  bool Leave() noexcept;

  static constexpr double kKeptTravel = 16.0;  // voxels

 private:
  friend class ResidentVoxels;
  /// Calls visit(record) for each page that a ball meets.
  template <typename Visit>
  void VisitPages(const Vec3& centre, double radius, const Visit& visit) noexcept;

  ResidentVoxels* voxels_;
  ShellBox* box_;
  bool active_ = true;
  double travelled_ = 0;              // voxels
  std::vector<double> announced_at_;  // by record: travelled_ at the last time
};

/// The part of a voxmap that is in memory, where the whole is too large (paper §5.3, dynamic
/// pre-fetching). Pages of one hyperchunk each are brought in by a PrefetchThread.
///
/// The haptic thread says what it is going to read and is told what is there; it never waits, and
/// never reads what is not there. A page is there from the beginning of a frame on in which its
/// news is taken, and goes only with the haptic thread's consent, so both threads never touch a
/// page at once.
class ResidentVoxels {
 public:
  /// Tells why a budget does not do: it does not hold the map's outline and some pages.
  static std::optional<Error> BudgetFault(const PageSource& source, std::uint64_t budget_bytes);
  /// With the same errors.
  static Result<std::unique_ptr<ResidentVoxels>> Make(std::shared_ptr<const PageSource> source,
                                                      std::uint64_t budget_bytes);
  ~ResidentVoxels();
  ResidentVoxels(const ResidentVoxels&) = delete;
  ResidentVoxels& operator=(const ResidentVoxels&) = delete;

  /// The map, of which only what is there may be read.
  const Voxmap& voxmap() const noexcept { return arena_.voxmap(); }
  std::uint64_t bytes() const noexcept { return arena_.bytes(); }
  /// Tells whether they are locked into memory.
  bool locked() const noexcept { return arena_.locked(); }
  ResidentCounts counts() const noexcept { return thread_.counts(); }
  /// Why pages cannot be read any more; null while they can. Any thread.
  const std::string* fault() const noexcept { return thread_.fault(); }

  /// Adds a reader, whose shell's points lie in a box in its frame, m. All before Start().
  VoxelReader& AddReader(const Vec3& centre, const Vec3& half_size);
  /// Starts the thread.
  void Start() { thread_.Start(); }

  /// Begins a frame: takes note of what has come and lets go what is to go. Haptic thread.
  void BeginFrame() noexcept;
  /// Waits until all that was announced is there, or nothing more comes, or nothing for 2 s. For
  /// any thread while no frames run.
  void WaitUntilThere() noexcept;

 private:
  friend class VoxelReader;
  ResidentVoxels(std::shared_ptr<const PageSource> source, std::size_t frames);
  void TakeNews() noexcept;
  /// False: there is no room for the request.
  bool Ask(std::uint32_t record, std::uint32_t frames, bool hint) noexcept;

  VoxelArena arena_;
  std::vector<std::uint8_t> has_page_;  // by record
  std::uint32_t frame_ = 1;
  std::vector<std::uint8_t> there_;  // by record
  struct Asked {
    std::uint32_t due = 0;  // frame; 0: it is not asked for
    bool hint = false;
  };
  std::vector<Asked> asked_;     // by record
  std::uint64_t requests_ = 0;   // in all
  std::size_t outstanding_ = 0;  // asked for and not there
  std::vector<std::unique_ptr<VoxelReader>> readers_;
  std::vector<std::unique_ptr<ShellBox>> boxes_;
  PageMail mail_;
  PrefetchThread thread_;  // ends first
};

}  // namespace tandem
