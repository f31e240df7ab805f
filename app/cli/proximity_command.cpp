#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/poses_file.h"
#include "app/common/scene_files.h"
#include "app/judgement/proximity_bodies.h"
#include "engine/base/text/csv_text.h"
#include "engine/base/text/json_text.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

struct ProximityArguments {
  std::string scene;
  std::string poses;
  double scale = 1;  // m per unit of the poses' translations
  double voxel = 0;  // 0: the scene's
  int range = 0;     // voxels; 0: the scene's
  bool coarse = false;
  bool csv = false;
  bool json = false;
};

// Pairs of triangles. No picture waits for these searches, so they may come to their end.
constexpr std::size_t kMostPairs = 2'000'000;

/// One question: a body at some pose, all others where the scene has them at first.
struct Question {
  std::size_t row = 0;  // row of the poses file; without a file, index of the question
  std::size_t body = 0;
  Pose X_W;
  std::optional<double> t_s;  // time of the pose, where the file has the column
};

struct Answer {
  std::size_t row = 0;
  SceneNearness near;
  std::optional<double> t_s;
};

std::vector<Question> QuestionsOfScene(const Scene& scene) {
  std::vector<Question> questions;
  for (std::size_t body = 0; body < scene.bodies.size(); ++body) {
    if (scene.bodies[body].fixed || scene.WholeOf(body) != body) continue;
    questions.push_back({questions.size(), body, {}, {}});
  }
  return questions;
}

/// Returns the body of that name or mesh file; -1: none.
int BodyOf(const Scene& scene, const std::string& name) {
  for (std::size_t body = 0; body < scene.bodies.size(); ++body) {
    if (scene.bodies[body].mesh.filename() == name) return static_cast<int>(body);
  }
  return scene.BodyNamed(name);
}

Result<std::vector<Question>> QuestionsOfFile(const Scene& scene, const std::string& file,
                                              double scale) {
  const Result<std::vector<FilePose>> poses = ReadPosesFile(file);
  if (!poses) return poses.error();
  std::vector<Question> questions;
  for (const FilePose& pose : *poses) {
    const std::string at = file + ": pose " + std::to_string(pose.row) + ": ";
    const int body = BodyOf(scene, pose.moving);
    if (body < 0) return Error{at + "the scene has no body '" + pose.moving + "'"};
    const SceneBody& of = scene.bodies[static_cast<std::size_t>(body)];
    if (of.fixed) return Error{at + "'" + pose.moving + "' is fixed; name one that moves"};
    const std::size_t whole = scene.WholeOf(static_cast<std::size_t>(body));
    if (whole != static_cast<std::size_t>(body)) {
      return Error{at + "'" + pose.moving + "' is part of '" + scene.bodies[whole].name +
                   "'; name that"};
    }
    questions.push_back(
        {pose.row, whole, Pose{pose.X_WM.q, scale * pose.X_WM.p} * of.X_WM.Inverse(), pose.t_s});
  }
  if (questions.empty()) return Error{file + ": the file has no pose"};
  return questions;
}

std::array<double, 3> Numbers(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

std::string OtherOf(const SceneProximity& scene, const SceneNearness& near) {
  return near.other == SceneNearness::kNone ? "" : scene.parts()[near.other].name;
}

std::string CsvOf(const Vec3& v) {
  char text[96];
  std::snprintf(text, sizeof text, ",%.9g,%.9g,%.9g", v.x(), v.y(), v.z());
  return text;
}

void PrintCsv(const SceneProximity& scene, const std::vector<Answer>& answers) {
  const bool timed = !answers.empty() && answers.front().t_s.has_value();
  PrintLine("row,body,other,distance_m,error_bound_m,overlap,refined,px,py,pz,qx,qy,qz,gx,gy,gz%s",
            timed ? ",t_s" : "");
  for (const Answer& answer : answers) {
    const SceneNearness& near = answer.near;
    std::string rest;
    for (const Vec3& v : {near.p_WPart, near.p_WOther, near.gradient_W}) rest += CsvOf(v);
    if (answer.t_s) rest += "," + SecondsText(*answer.t_s);
    PrintLine("%zu,%s,%s,%.9g,%.9g,%d,%d%s", answer.row,
              CsvText(scene.parts()[near.part].name).c_str(), CsvText(OtherOf(scene, near)).c_str(),
              near.distance, near.error_bound(), near.overlap ? 1 : 0, near.refined ? 1 : 0,
              rest.c_str());
  }
}

/// The times of the steps.
struct Costs {
  double voxelize_s = 0;
  double median_ms = 0;  // for a pose
  double most_ms = 0;
};

void PrintJson(const ProximityArguments& arguments, const SceneProximity& scene,
               const std::vector<Answer>& answers, const Costs& costs) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Answer& answer : answers) {
    const SceneNearness& near = answer.near;
    rows.push_back({{"row", answer.row},
                    {"body", scene.parts()[near.part].name},
                    {"other", OtherOf(scene, near)},
                    {"distance_m", near.distance},
                    {"error_bound_m", near.error_bound()},
                    {"overlap", near.overlap},
                    {"refined", near.refined},
                    {"point_of_body", Numbers(near.p_WPart)},
                    {"point_of_other", Numbers(near.p_WOther)},
                    {"gradient", Numbers(near.gradient_W)}});
    if (answer.t_s) rows.back()["t_s"] = *answer.t_s;
  }
  const nlohmann::ordered_json out{
      {"scene", arguments.scene},
      {"voxel_m", scene.parts().front().shape.voxmap.voxel_size()},
      {"poses", answers.size()},
      {"voxelize_s", costs.voxelize_s},
      {"pose_ms", {{"median", costs.median_ms}, {"max", costs.most_ms}}},
      {"rows", rows}};
  PrintText(JsonText(out, 2));
}

std::string Words(const Vec3& v) {
  const auto rounded = [](double x) {
    return std::round(x * 1e6) * 1e-6 + 0.0;  // no minus sign before a 0
  };
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g %.6g %.6g)", rounded(v.x()), rounded(v.y()),
                rounded(v.z()));
  return text;
}

void PrintWords(const SceneProximity& scene, const std::vector<Answer>& answers) {
  for (const Answer& answer : answers) {
    const SceneNearness& near = answer.near;
    const std::string at = answer.t_s ? " at " + SecondsText(*answer.t_s) + " s" : "";
    PrintLine("%zu%s: %s to %s: %.4f mm%s, error at most %.4f mm, from %s to %s, gradient %s",
              answer.row, at.c_str(), scene.parts()[near.part].name.c_str(),
              OtherOf(scene, near).c_str(), 1e3 * near.distance,
              near.overlap ? " (they overlap)" : "", 1e-4 * std::ceil(1e7 * near.error_bound()),
              Words(near.p_WPart).c_str(), Words(near.p_WOther).c_str(),
              Words(near.gradient_W).c_str());
  }
}

std::vector<Answer> AnswerAll(SceneProximity& proximity, const Scene& scene,
                              const std::vector<Question>& questions, bool refine, Costs& costs) {
  std::vector<std::size_t> part_of(scene.bodies.size(), SceneNearness::kNone);
  for (std::size_t part = 0; part < proximity.parts().size(); ++part) {
    const ProximityPart& of = proximity.parts()[part];
    if (!of.fixed) part_of[of.bodies.front()] = part;
  }
  std::vector<Answer> answers;
  std::vector<double> ms;
  std::vector<Pose> X_W(scene.bodies.size());
  for (const Question& question : questions) {
    X_W[question.body] = question.X_W;
    const std::int64_t start_ns = MonotonicNowNs();
    answers.push_back({question.row,
                       proximity.NearestTo(part_of[question.body], X_W,
                                           {.refine = refine, .most_pairs = kMostPairs}),
                       question.t_s});
    ms.push_back(1e-6 * static_cast<double>(MonotonicNowNs() - start_ns));
    X_W[question.body] = Pose{};
  }
  std::sort(ms.begin(), ms.end());
  costs.median_ms = ms[ms.size() / 2];
  costs.most_ms = ms.back();
  return answers;
}

int RunProximity(const ProximityArguments& arguments) {
  if (arguments.csv && arguments.json) return Fail(kExitUsage, "give --csv or --json, not both");
  const Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  const Result<std::vector<Question>> questions =
      arguments.poses.empty() ? QuestionsOfScene(*scene)
                              : QuestionsOfFile(*scene, arguments.poses, arguments.scale);
  if (!questions) return Fail(kExitFile, questions.error().what);
  if (questions->empty())
    return Fail(kExitFile, arguments.scene + ": the scene has no moving body");
  if (scene->bodies.size() < 2) {
    return Fail(kExitFile, arguments.scene +
                               ": the scene has only one body, so there is no distance to measure");
  }
  const Result<std::vector<ProximityBody>> bodies = LoadProximityBodies(*scene);
  if (!bodies) return Fail(kExitFile, bodies.error().what);

  Costs costs;
  const std::int64_t start_ns = MonotonicNowNs();
  Result<std::vector<ProximityPart>> parts = MakeProximityParts(
      *bodies, arguments.voxel > 0 ? arguments.voxel : scene->voxel_size,
      arguments.range > 0 ? arguments.range : scene->range_voxels,
      [](std::size_t /*done*/, std::size_t /*total*/, const std::string& /*part*/) {
        return true;
      });
  if (!parts) return Fail(kExitFile, arguments.scene + ": " + parts.error().what);
  costs.voxelize_s = ToSeconds(MonotonicNowNs() - start_ns);
  SceneProximity proximity(std::make_shared<const std::vector<ProximityPart>>(std::move(*parts)));
  const std::vector<Answer> answers =
      AnswerAll(proximity, *scene, *questions, !arguments.coarse, costs);
  if (arguments.json) {
    PrintJson(arguments, proximity, answers, costs);
  } else if (arguments.csv) {
    PrintCsv(proximity, answers);
  } else {
    PrintWords(proximity, answers);
  }
  const auto overlapping = std::count_if(answers.begin(), answers.end(), [](const Answer& a) {
    return a.near.overlap;
  });
  char costs_text[96];
  std::snprintf(costs_text, sizeof costs_text,
                "; voxelized in %.2f s, then %.2f ms a pose (median; max %.2f)", costs.voxelize_s,
                costs.median_ms, costs.most_ms);
  Say(std::to_string(overlapping) + " of " + WithPlural(answers.size(), "pose") + " overlap" +
      costs_text);
  return kExitOk;
}

}  // namespace

void AddProximityCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ProximityArguments>();
  CLI::App* command = app.add_subcommand(
      "proximity",
      "Compute the distance of a body to all others: distance, two points, error, gradient");
  command->add_option("scene", arguments->scene, "name of a scene, or a scene file")->required();
  command->add_option("--poses", arguments->poses,
                      "CSV file of poses; default: each moving body at its place in the scene");
  command->add_option("--scale", arguments->scale, "metres per unit of the poses' translations")
      ->check(NumberFrom(kLeastScale, kLargestScale))
      ->capture_default_str();
  command->add_option("--voxel", arguments->voxel, "voxel size, m; default: the scene's")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel));
  command
      ->add_option("--range", arguments->range,
                   "range of the distance fields, voxels; default: the scene's")
      ->check(WholeNumberFrom(1, WidestRange(8)));
  command->add_flag("--coarse", arguments->coarse,
                    "use voxels alone: the error is at most sqrt(3) voxels");
  command->add_flag("--csv", arguments->csv, "print one line for each pose, for programs");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->footer(
      "A poses file is CSV. Its header names at least moving,tx,ty,tz,ax,ay,az,angle_deg. These "
      "are the moving\nbody's name in the scene, or its mesh file's; the place of that file's "
      "frame in the scene; and the\naxis and angle of its rotation. All other bodies stay where "
      "the scene puts them. The output is in\nthe scene's frame: p is the point on the body, q the "
      "point on the other body, and g the unit\ndirection in which the distance grows fastest. The "
      "exact distance differs from the printed one by\nat most the error bound; it is 0 where "
      "bodies overlap.");
  command->callback([arguments, &exit_code] {
    exit_code = RunProximity(*arguments);
  });
}

}  // namespace tandem
