#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>

namespace tandem {

/// What a host application may ask of a controller (paper §6). Each request gets one answer. All
/// values are plain, so that a host needs neither Eigen nor DDS to read this file.

/// Where a frame stands in the world W.
struct PlainPose {
  std::array<double, 3> p_W{};            // m
  std::array<double, 4> q_W{0, 0, 0, 1};  // x y z w, of length 1
};

struct Answer {
  bool ok = false;
  std::string reason;  // one line: why not; of some requests, what came of it
};
using OnAnswer = std::function<void(const Answer&)>;

/// Leaves the scene for another one, within the same session. What the hand holds is released;
/// where the new scene cannot be loaded, the controller goes back to the old one and says why.
struct LoadSceneRequest {
  std::string file;  // absolute, or the name of a scene that Tandem brings along
};

/// Loads the present scene again with one body more. The scene's file stays as it is: SaveRequest.
struct LoadMeshRequest {
  std::string file;  // absolute
  std::string body;  // its name; empty: the file's
  bool fixed = false;
  bool shared = true;
  double mass_kg = 1;
};

/// Voxelizes a mesh, as `tandem voxelize` does, to tell whether it can be: the reason of the answer
/// has the counts of voxels and points.
struct VoxelizeRequest {
  std::string file;
  double voxel_size_m = 0;  // 0: the scene's
};

/// Takes a body in the host's hand. Answered when it is in the hand, or known not to come. The
/// grasp frame G has its origin at the grasped point and, at that moment, the axes of W; a goal is
/// a place for G. The goal of the host is G's place until it says another one.
struct GrabRequest {
  std::string body;
  std::optional<std::array<double, 3>> grasp_W{};  // m; nothing: the centre of mass
};

/// Lets go of what is in the hand; no error where nothing is.
struct ReleaseRequest {};

/// Hands what is in the hand to another peer.
struct GiveRequest {
  std::string peer;  // name, or id as 16 hexadecimal digits
};

/// Asks another peer for a body that it holds: its user is told. The answer says that it was asked.
struct AskForRequest {
  std::string body;
};

/// Changes one of the controller's own numbers; what the session has agreed on cannot be changed.
/// `hand_force_N` (0.1 to 30), `hand_speed_m_s` (0.01 to 2), `hand_smoothing_s` (0 to 0.2). Of a
/// device at the controller: `device_scale`, metres in the scene a metre of the handle's (0.01 to
/// 100); `device_recentre`, share of its way by which a hand is led back (0 to 0.3); `device_clutch`
/// (1: the handle moves alone, 0: it leads the part).
struct SetParameterRequest {
  std::string name;
  double value = 0;
};

/// How the user looks at the scene: a device at the controller moves the part to the right when it
/// goes to the right in the user's picture. V: x to the right, y away from the user, z up.
struct SetViewRequest {
  std::array<double, 4> q_WV{0, 0, 0, 1};  // x y z w
};

/// How far from others' surfaces the body in hand meets them (paper §3.2).
struct SetClearanceRequest {
  int force_layer = -1;       // -1: the scene's
  double displacement_m = 0;  // of its points, along their inward normals
};

/// Writes the scene as it stands now into a scene file. An existing file is not overwritten.
struct SaveRequest {
  std::string file;
};

/// Drives the part back along its way, at a bounded speed, through contact: where something stops
/// it, it stays, and the answer says so. `kToGrasp`: the part in hand, to where it was taken.
/// `kUndo`: the last part that was let go of, to where it had been taken; then lets go again.
/// `kReset`: every part that this controller has moved, to where the scene puts it, the last first.
/// A goal, a grab, a release or a stop ends it. Never moves a part at once.
struct RetraceRequest {
  enum class To : std::uint8_t { kGrasp, kUndo, kReset };
  To to = To::kGrasp;
};

/// Measures how near the part in hand is to the others, twenty times a second at the most. Answered
/// when that has begun: voxels have to be made, which takes seconds.
struct MeasureDistancesRequest {
  bool on = true;
};

/// How many snapshots a second this host gets: 1 to 1000; at first 60.
struct SnapshotRateRequest {
  double rate_hz = 60;
};

/// The hand lets go and takes nothing more, and a device gets no force, until ResumeRequest.
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
