#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>

namespace tandem {

/// Requests of a host application to a controller (paper §6). Each request gets one answer. All
/// values are plain, so that a host needs neither Eigen nor DDS to read this file.

/// The pose of a frame in the world W.
struct PlainPose {
  std::array<double, 3> p_W{};            // m
  std::array<double, 4> q_W{0, 0, 0, 1};  // x y z w, of length 1
};

struct Answer {
  bool ok = false;
  std::string reason;  // one line: why not, or the result of some requests
};
using OnAnswer = std::function<void(const Answer&)>;

/// Leaves the scene for another one, within the same session. The hand lets go. Where the new scene
/// cannot be loaded, the controller goes back to the old one and says why.
struct LoadSceneRequest {
  std::string file;  // absolute, or the name of a scene installed with Tandem
};

/// Loads the present scene again with one more body. The scene's file stays as it is: SaveRequest.
struct LoadMeshRequest {
  std::string file;  // absolute
  std::string body;  // its name; empty: the file's
  bool fixed = false;
  bool shared = true;
  double mass_kg = 1;
};

/// Voxelizes a mesh, as `tandem voxelize` does, to tell whether it can be voxelized: the reason of
/// the answer has the counts of voxels and points.
struct VoxelizeRequest {
  std::string file;
  double voxel_size_m = 0;  // 0: the scene's
};

/// Takes a body in the host's hand. Answered when it is in the hand, or is known not to come. The
/// grasp frame G has its origin at the grasped point and, at that moment, the axes of W. A goal is
/// a pose of G. The host's goal is G's pose until the host sends another one.
struct GrabRequest {
  std::string body;
  std::optional<std::array<double, 3>> grasp_W{};  // m; empty: the centre of mass
};

/// Lets go of the part in hand; no error where the hand is empty.
struct ReleaseRequest {};

/// Hands the part in hand to another peer.
struct GiveRequest {
  std::string peer;  // name, or id as 16 hexadecimal digits
};

/// Asks another peer for a body that it holds, and its user is told. The answer says that it was
/// asked.
struct AskForRequest {
  std::string body;
};

/// Changes one of the controller's own numbers; the session's agreed values cannot be changed.
/// `hand_force_N` (0.1 to 30), `hand_speed_m_s` (0.01 to 2), `hand_smoothing_s` (0 to 0.2). For a
/// device at the controller: `device_scale`, metres in the scene per metre of the handle (0.01 to
/// 100); `device_recentre`, share of its way by which a hand is led back (0 to 0.3);
/// `device_clutch` (1: the handle moves alone, 0: it leads the part).
struct SetParameterRequest {
  std::string name;
  double value = 0;
};

/// Sets the user's view of the scene. A device at the controller then moves the part to the right
/// in the user's picture when it goes to the right. V: x to the right, y away from the user, z up.
struct SetViewRequest {
  std::array<double, 4> q_WV{0, 0, 0, 1};  // x y z w
};

/// Sets the distance from others' surfaces at which contact of the body in hand begins (paper
/// §3.2).
struct SetClearanceRequest {
  int force_layer = -1;       // -1: the scene's
  double displacement_m = 0;  // displacement of its points along their inward normals
};

/// Writes the present scene into a scene file. An existing file is not overwritten.
struct SaveRequest {
  std::string file;
};

/// Drives the part back along its way, at a bounded speed, through contact. Where something stops
/// it, it stays, and the answer says so. `kToGrasp`: the part in hand, to where it was taken.
/// `kUndo`: the last part released, to where it had been taken; then lets go again. `kReset`: every
/// part that this controller has moved, to its place in the scene, the last one first. A goal, a
/// grab, a release or a stop ends it. No part ever jumps.
struct RetraceRequest {
  enum class To : std::uint8_t { kGrasp, kUndo, kReset };
  To to = To::kGrasp;
};

/// Measures the distance of the part in hand from the others, at most twenty times a second.
/// Answered when that has begun: voxels have to be made, which takes seconds.
struct MeasureDistancesRequest {
  bool on = true;
};

/// Sets the number of snapshots a second for this host: 1 to 1000; at first 60.
struct SnapshotRateRequest {
  double rate_hz = 60;
};

/// Stops the hand: it lets go and takes nothing more, and a device gets no force, until
/// ResumeRequest.
struct EmergencyStopRequest {};
struct ResumeRequest {};

/// Ends the controller.
struct QuitRequest {};

using ControlRequest =
    std::variant<LoadSceneRequest, LoadMeshRequest, VoxelizeRequest, GrabRequest, ReleaseRequest,
                 GiveRequest, AskForRequest, SetParameterRequest, SetClearanceRequest, SaveRequest,
                 RetraceRequest, SnapshotRateRequest, EmergencyStopRequest, ResumeRequest,
                 QuitRequest, SetViewRequest, MeasureDistancesRequest>;

}  // namespace tandem
