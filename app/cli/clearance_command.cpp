#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/judgement/hand_free_space.h"
#include "app/judgement/nearest_body.h"
#include "app/judgement/start_gaps.h"
#include "app/recording/recorded_scene.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

struct ClearanceArguments {
  std::string file;
  std::string scene;       // empty: the recorded file
  bool adopt_any = false;  // take the recorded voxels, however far from the scene file's
  bool json = false;
};

std::string AsMillimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g mm", 1e3 * metres);
  return text;
}

/// Returns the name of the body that the part came nearest to; empty: there is none.
std::string NameOfOther(const WorldModel& model, const NearestPlace& nearest) {
  if (!std::isfinite(nearest.distance)) return {};
  const double reach = std::max(0.0, nearest.distance) + 1e-3 * model.scene.voxel_size;
  const auto other = NearestTo(model, nearest.body, nearest.bodies_WB, reach);
  return other ? other->name : std::string();
}

std::string DescribePath(const HandFreeSpace& room, const std::string& body,
                         const std::string& other, const ContactYield& yield) {
  const NearestPlace& nearest = room.nearest;
  if (!std::isfinite(nearest.distance)) return body + ": the scene has no other body";
  char place[120];
  std::snprintf(place, sizeof place, ", %.3f s from the start, at (%.6g, %.6g, %.6g) m", room.at_s,
                nearest.p_W.x(), nearest.p_W.y(), nearest.p_W.z());
  if (!room.crosses) {
    return body + "-" + other + ": the surfaces touch" + place + "; the depth is not judged";
  }
  if (*room.crosses) {
    return body + "-" + other + ": the surfaces cross by " + AsMillimetres(-nearest.distance) +
           " \u00b1 " + AsMillimetres(room.depth_error) + place +
           (room.contact ? "; " + yield.Describe(-nearest.distance) : "");
  }
  return body + "-" + other + ": " + AsMillimetres(nearest.distance) + " is the least distance" +
         place;
}

std::string DescribeClearance(const HandFreeSpace& room, const ContactYield& yield) {
  if (!room.contact) return "the bodies were not solid, so no clearance was tried";
  if (!room.passes_with && !room.crosses) {
    return "no clearance was tried, because the depth where surfaces touch is not judged";
  }
  if (!room.passes_with) {
    const double depth = -room.nearest.distance;
    const std::string crosses =
        "the same hand passes with no clearance: surfaces already cross by " +
        AsMillimetres(depth) + " on the recorded path";
    const double tolerance = kKeptToVoxels * yield.voxel_size;
    const bool decides = depth > yield.PressedDepth();
    return crosses + ", more than the " + AsMillimetres(tolerance) + " that count as touching" +
           (decides ? "" : "; a smaller voxel_m decides (see the line above)");
  }
  const std::string kept = std::isfinite(*room.kept)
                               ? "; its path then keeps " + AsMillimetres(*room.kept)
                               : std::string();
  return "the same hand passes with a clearance of " +
         std::string(room.at_least ? "at least " : "") + AsMillimetres(*room.passes_with) +
         (room.at_least ? ", the most that can be tried" : "") + kept;
}

nlohmann::ordered_json AsJson(const HandFreeSpace& room, const std::string& body,
                              const std::string& other, const ContactYield& yield) {
  nlohmann::ordered_json json{{"frames", room.frames},
                              {"torn", room.torn},
                              {"body", body},
                              {"other", nullptr},
                              {"along_path_mm", nullptr},
                              {"at_s", nullptr},
                              {"p_W", nullptr},
                              {"crosses", nullptr},
                              {"depth_tolerance_mm", nullptr},
                              {"passes_with_mm", nullptr},
                              {"at_least", room.at_least},
                              {"kept_mm", nullptr},
                              {"pressed_mm", nullptr},
                              {"voxel_m_decides", nullptr}};
  const NearestPlace& nearest = room.nearest;
  if (std::isfinite(nearest.distance)) {
    if (!other.empty()) json["other"] = other;
    json["along_path_mm"] = 1e3 * nearest.distance;
    json["at_s"] = room.at_s;
    json["p_W"] = {nearest.p_W.x(), nearest.p_W.y(), nearest.p_W.z()};
  }
  if (room.crosses) json["crosses"] = *room.crosses;
  if (room.crosses.value_or(false)) json["depth_tolerance_mm"] = 1e3 * room.depth_error;
  if (room.passes_with) json["passes_with_mm"] = 1e3 * *room.passes_with;
  if (room.kept && std::isfinite(*room.kept)) json["kept_mm"] = 1e3 * *room.kept;
  if (!room.contact) return json;
  json["pressed_mm"] = 1e3 * yield.PressedDepth();
  if (room.crosses.value_or(false) && -nearest.distance <= yield.PressedDepth()) {
    json["voxel_m_decides"] = yield.VoxelThatDecides(-nearest.distance);
  }
  return json;
}

int RunClearance(const ClearanceArguments& arguments) {
  const Result<RecordingReader> reader = RecordingReader::Open(arguments.file);
  if (!reader) return Fail(kExitFile, reader.error().what);
  const Result<std::shared_ptr<const WorldModel>> model = LoadRecorded(
      reader->header(),
      {.recording = arguments.file, .scene = arguments.scene, .adopt_any = arguments.adopt_any});
  if (!model) return Fail(kExitFile, model.error().what);
  if (reader->header().peer.experiments.contact) TellStart(FindStartGaps(**model));
  kHapticThread.Enter();
  const Result<HandFreeSpace> room =
      MeasureHandFreeSpace(arguments.file, *model, [](double clearance, bool passes) {
        Say("with " + AsMillimetres(clearance) + " it " + (passes ? "passes" : "does not pass"));
      });
  if (!room) return Fail(kExitFailed, room.error().what);
  if (room->torn)
    Say("the recording is incomplete: it ends within a frame, and the frames before count");
  const std::string body = (*model)->bodies[room->nearest.body].name;
  const std::string other = NameOfOther(**model, room->nearest);
  const WorldModel& of = **model;
  ContactYield yield =
      YieldOf(of.scene, of.scene.bodies[of.object[room->nearest.body]].inward_shift_voxels);
  yield.force = std::max(kHandForce, room->peak_force);
  if (arguments.json) {
    PrintText(JsonText(AsJson(*room, body, other, yield), 2));
  } else {
    PrintLine("%s", DescribePath(*room, body, other, yield).c_str());
    PrintLine("%s", DescribeClearance(*room, yield).c_str());
  }
  return kExitOk;
}

}  // namespace

void AddClearanceCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ClearanceArguments>();
  CLI::App* command = app.add_subcommand(
      "clearance", "Measure from a recording how much room the hand had, by exact surfaces");
  command->add_option("FILE", arguments->file, "recording of 'tandem peer --record'")->required();
  command->add_option("--scene", arguments->scene,
                      "folder or file of the scene, if it was moved since the recording");
  command->add_flag("--adopt-any", arguments->adopt_any,
                    "use the recorded voxel size even if it differs from the scene file's by more "
                    "than a factor of 4");
  command->add_flag("--json", arguments->json, "print the result as one JSON object");
  command->footer(
      "The command prints two figures. The first is the least distance between the part in hand "
      "and all\nother bodies in all recorded frames; where surfaces cross, it is below 0 by their "
      "depth. The second\nis the greatest clearance with which the same hand still passes. About "
      "ten replays find it, in\nwhich force begins that much farther from surfaces. The greatest "
      "clearance that can be tried is a\nvoxel: then the answer is 'at least'.\nA hand passes with "
      "a clearance if the part ends where it ended and has kept the clearance. A part\nthat is out "
      "may end anywhere out; any other part ends within a voxel or 2 mm, the greater of the\ntwo. "
      "A part keeps the clearance if its exact surface never comes nearer to another than "
      "the\nclearance less 0.05 voxel. Without this rule a part would pass with any clearance, "
      "because contact\ngives way in a narrow passage.");
  command->callback([arguments, &exit_code] {
    exit_code = RunClearance(*arguments);
  });
}

}  // namespace tandem
