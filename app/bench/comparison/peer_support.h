#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/common/poses_file.h"
#include "engine/base/result.h"
#include "engine/contact/field/field_pair.h"
#include "engine/contact/pair/contact_kind.h"
#include "engine/voxel/map/voxmap.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

/// Runs `app` on what the command line says, and returns how the program is to end.
int RunPeer(CLI::App& app, int argc, char** argv, const std::function<std::optional<Error>()>& run);

/// A fixed and a moving mesh file and their poses, as options say.
struct PeerPair {
  std::filesystem::path fixed;
  std::filesystem::path moving;
  std::filesystem::path poses;
  double scale = 0.001;  // m per file unit
  double voxel = 0.001;  // m, of the map
  double spacing = 0;    // m, of the points; 0: as the map
  bool plain = false;    // contact model
};
void AddPeerPair(CLI::App& app, PeerPair& pair);

/// The pair, loaded.
struct PeerModels {
  TriangleMesh fixed;
  TriangleMesh moving;
  Voxmap voxmap;
  Pointshell points;  // in B, whose origin is the mesh's centre of mass
  // surfaces for the refined contact model
  BodySurface fixed_surface;
  BodySurface moving_surface;
  Pose X_MB;                    // M: the file's frame
  std::vector<FilePose> poses;  // poses of M
};
Result<PeerModels> LoadPeerModels(const PeerPair& pair, ContactModel model);

/// Returns the processor time of all this process's threads, ns.
double ProcessCpuNs();

struct Timed {
  double cpu_s = 0;  // medians of a run
  double wall_s = 0;
  int runs = 0;
};
/// Repeats `work` until it has used that much processor time, at least once.
Timed Repeated(const std::function<void()>& work, double cpu_s = 2);

double MedianOf(std::vector<double> values);

}  // namespace tandem
