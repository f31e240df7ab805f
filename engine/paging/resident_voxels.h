#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"
#include "engine/paging/prefetch_thread.h"
#include "engine/paging/voxel_arena.h"
#include "engine/voxel/map/page_source.h"

namespace tandem {

class ResidentVoxels;

/// Reads a voxmap that is in memory in part, for one pair of bodies. Used by the haptic thread.
class VoxelReader {
 public:
  VoxelReader(ResidentVoxels& voxels, ShellBox& box);
  /// Notes that the shell stands elsewhere, after a travel of `travel_voxels`.
  void MoveTo(const Pose& X_VS, double travel_voxels) noexcept;
  /// Announces that voxels in a ball may be read from `frames` frames on, and for as long as the
  /// pair travels less than kKeptTravel. Lengths are in voxels of V. Returns whether all of them
  /// are in memory.
  bool Announce(const Vec3& centre, double radius, std::uint32_t frames) noexcept;
  /// Hints that voxels in a ball may be read later, if ever. Returns false if there was no room for
  /// all requests.
  bool Hint(const Vec3& centre, double radius, std::uint32_t frames) noexcept;

  /// Notes that the pair is not tested until it moves again, and forgets all that it announced.
  /// Returns whether the pair was tested before.
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
  std::vector<double> announced_at_;  // per record: travelled_ at the last announcement
};

/// The part of a voxmap that is in memory, where the whole is too large (paper §5.3, dynamic
/// pre-fetching). A PrefetchThread brings in pages of one hyperchunk each.
///
/// The haptic thread announces what it is going to read, and learns what is in memory. It never
/// waits, and never reads what is not in memory. A page is in memory from the beginning of the
/// frame in which the haptic thread takes its news. It leaves only with the haptic thread's
/// consent. So the two threads never touch a page at once.
class ResidentVoxels {
 public:
  /// Returns why a budget is too small to hold the map's outline and some pages; nothing if it is
  /// not.
  static std::optional<Error> BudgetFault(const PageSource& source, std::uint64_t budget_bytes);
  /// Makes it, with the same errors.
  static Result<std::unique_ptr<ResidentVoxels>> Make(std::shared_ptr<const PageSource> source,
                                                      std::uint64_t budget_bytes);
  ~ResidentVoxels();
  ResidentVoxels(const ResidentVoxels&) = delete;
  ResidentVoxels& operator=(const ResidentVoxels&) = delete;

  /// Returns the map; only pages in memory may be read.
  const Voxmap& voxmap() const noexcept { return arena_.voxmap(); }
  std::uint64_t bytes() const noexcept { return arena_.bytes(); }
  /// Tells whether the voxels are locked into memory.
  bool locked() const noexcept { return arena_.locked(); }
  ResidentCounts counts() const noexcept { return thread_.counts(); }
  /// Returns why pages cannot be read any more; null while they can. For any thread.
  const std::string* fault() const noexcept { return thread_.fault(); }

  /// Adds a reader, whose shell's points lie in a box in its frame, m. Must come before Start().
  VoxelReader& AddReader(const Vec3& centre, const Vec3& half_size);
  /// Starts the thread.
  void Start() { thread_.Start(); }

  /// Begins a frame: takes note of pages that have come and lets go of pages that are to leave.
  /// Haptic thread.
  void BeginFrame() noexcept;
  /// Waits until all that was announced is in memory, no more can come, or none has come for 2 s.
  /// For any thread while no frames run.
  void WaitUntilResident() noexcept;

 private:
  friend class VoxelReader;
  ResidentVoxels(std::shared_ptr<const PageSource> source, std::size_t frames);
  void TakeUpdates() noexcept;
  /// Requests a page; false: there is no room for the request.
  bool Ask(std::uint32_t record, std::uint32_t frames, bool hint) noexcept;

  VoxelArena arena_;
  std::vector<std::uint8_t> has_page_;  // per record
  std::uint32_t frame_ = 1;
  std::vector<std::uint8_t> there_;  // per record
  struct RequestedPage {
    std::uint32_t due = 0;  // frame; 0: it is not requested
    bool hint = false;
  };
  std::vector<RequestedPage> requested_;  // per record
  std::uint64_t requests_ = 0;            // number of all requests
  std::size_t outstanding_ = 0;           // requests whose pages are not in memory
  std::vector<std::unique_ptr<VoxelReader>> readers_;
  std::vector<std::unique_ptr<ShellBox>> boxes_;
  PageMail mail_;
  PrefetchThread thread_;  // last, so that it ends first
};

}  // namespace tandem
