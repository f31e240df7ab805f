#include "engine/scene/scene.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/base/text/json_reader.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/contact/pair/friction.h"
#include "engine/field/build/field_builder.h"

namespace tandem {
namespace {

constexpr std::size_t kMostBodies = 1024;
constexpr std::size_t kMostPairs = 256;
constexpr std::size_t kMostHands = 64;
constexpr double kMostShift = 16;      // voxels, in either direction
constexpr double kMostGravity = 1000;  // m/s^2

/// Moving bodies without a colour of their own get these in turn; fixed bodies are grey.
constexpr std::array<std::array<float, 3>, 6> kMoversColours{{{0.88F, 0.63F, 0.19F},
                                                              {0.31F, 0.53F, 0.78F},
                                                              {0.35F, 0.64F, 0.41F},
                                                              {0.75F, 0.35F, 0.33F},
                                                              {0.55F, 0.44F, 0.69F},
                                                              {0.25F, 0.65F, 0.65F}}};

std::filesystem::path ReadFilePath(const JsonNode& node, const std::filesystem::path& folder) {
  const std::filesystem::path named = node.Text("the name of a file");
  const std::filesystem::path found = named.is_absolute() ? named : folder / named;
  std::error_code unknown;
  if (!named.empty() && !std::filesystem::is_regular_file(found, unknown)) {
    node.Fault("no such file: " + found.string());
  }
  return found;
}

Pose ReadPose(const JsonNode& node) {
  node.AllowKeys({"p_W", "q_xyzw"});
  Pose X_WM;
  if (node.Has("p_W")) X_WM.p = node["p_W"].Vector();
  if (node.Has("q_xyzw")) X_WM.q = node["q_xyzw"].Rotation();
  return X_WM;
}

std::array<float, 3> ReadColour(const JsonNode& node) {
  constexpr std::string_view kExpected = "a colour like \"#4080c0\"";
  const std::string text = node.Text(kExpected);
  std::array<float, 3> colour{};
  if (text.size() != 7 || text[0] != '#' ||
      text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos) {
    node.Expected(kExpected);
    return colour;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    colour[i] = static_cast<float>(std::stoi(text.substr(1 + 2 * i, 2), nullptr, 16)) / 255.0F;
  }
  return colour;
}

bool ReadSharing(const JsonNode& node) {
  constexpr std::string_view kExpected =
      "\"own\" (one user holds it) or \"shared\" (several may hold it at once)";
  const std::string text = node.Text(kExpected);
  if (text != "own" && text != "shared") node.Expected(kExpected);
  return text == "shared";
}

ContactModel ReadContact(const JsonNode& node) {
  constexpr std::string_view kExpected = "\"refined\" (exact features) or \"plain\" (voxels alone)";
  const std::string text = node.Text(kExpected);
  if (text != "refined" && text != "plain") node.Expected(kExpected);
  return text == "plain" ? ContactModel::kPlain : ContactModel::kRefined;
}

/// Reads a spacing of points. Points farther apart than voxels would let something slip through
/// between them.
double ReadPointSpacing(const JsonNode& node) {
  const double spacing = node.NumberAbove(0);
  if (spacing > 1) node.Expected("a number above 0 and at most 1: a part of a voxel");
  return spacing;
}

/// Reads a body. `spacing`: the scene's, for bodies that have none of their own.
SceneBody ReadBody(const JsonNode& node, const std::filesystem::path& folder, double spacing) {
  node.AllowKeys({"name", "mesh", "part", "scale", "pose", "fixed", "mass_kg", "density_kg_m3",
                  "sharing", "inward_shift_voxels", "point_spacing_voxels", "colour", "free",
                  "constraint", "merge_with"});
  SceneBody body;
  body.point_spacing_voxels = spacing;
  body.name = node["name"].Text("the body's name");
  body.mesh = ReadFilePath(node["mesh"], folder);
  if (node.Has("part")) body.part = node["part"].Text("the name of a part in the mesh file");
  if (node.Has("scale")) body.scale = node["scale"].NumberAbove(0);
  if (node.Has("pose")) body.X_WM = ReadPose(node["pose"]);
  if (node.Has("fixed")) body.fixed = node["fixed"].TrueOrFalse();
  if (node.Has("inward_shift_voxels")) {
    body.inward_shift_voxels = node["inward_shift_voxels"].NumberBetween(-kMostShift, kMostShift);
  }
  if (node.Has("colour")) body.colour = ReadColour(node["colour"]);
  if (node.Has("merge_with")) {
    body.merge_with = node["merge_with"].Text("the name of a body");
    for (const std::string_view key :
         {"fixed", "mass_kg", "density_kg_m3", "sharing", "free", "constraint",
          "inward_shift_voxels", "point_spacing_voxels"}) {
      if (node.Has(key)) node[key].Fault("give it to the body that this one is merged with");
    }
    return body;
  }
  if (node.Has("point_spacing_voxels")) {
    body.point_spacing_voxels = ReadPointSpacing(node["point_spacing_voxels"]);
  }
  if (node.Has("free")) body.free = node["free"].TrueOrFalse();
  if (node.Has("constraint")) body.constraint = ReadConstraint(node["constraint"]);

  const bool weighed = node.Has("mass_kg") || node.Has("density_kg_m3");
  if (body.fixed) {
    for (const std::string_view key :
         {"mass_kg", "density_kg_m3", "sharing", "free", "constraint", "point_spacing_voxels"}) {
      if (node.Has(key)) node[key].Fault("a fixed body has none");
    }
  } else if (!weighed) {
    node.Fault("expected \"fixed\": true, or a mass_kg or a density_kg_m3");
  } else if (node.Has("mass_kg") && node.Has("density_kg_m3")) {
    node["density_kg_m3"].Fault("the mass is given already; give one of the two");
  } else if (node.Has("mass_kg")) {
    body.mass = node["mass_kg"].NumberAbove(0);
  } else {
    body.density = node["density_kg_m3"].NumberAbove(0);
  }
  if (!body.fixed && node.Has("sharing")) body.shared = ReadSharing(node["sharing"]);
  return body;
}

/// Reads the name of a body that moves by itself.
std::string ReadMover(const JsonNode& node, const Scene& scene) {
  constexpr std::string_view kExpected = "the name of a body that moves";
  std::string name = node.Text(kExpected);
  const int found = scene.BodyNamed(name);
  const SceneBody* body = found < 0 ? nullptr : &scene.bodies[static_cast<std::size_t>(found)];
  if (body == nullptr || body->fixed) {
    node.Expected(kExpected);
  } else if (!body->merge_with.empty()) {
    node.Fault("\"" + name + "\" is merged; name \"" + body->merge_with + "\"");
  }
  return name;
}

void CheckMerging(const JsonNode& node, const SceneBody& body, const Scene& scene) {
  if (body.merge_with.empty()) return;
  const int found = scene.BodyNamed(body.merge_with);
  const SceneBody* whole = found < 0 ? nullptr : &scene.bodies[static_cast<std::size_t>(found)];
  if (whole == nullptr || whole->fixed || !whole->merge_with.empty()) {
    node["merge_with"].Expected("the name of a body that moves and is not merged itself");
  }
}

ScenePair ReadPair(const JsonNode& node, const Scene& scene) {
  node.AllowKeys({"pointshell", "voxmap"});
  ScenePair pair{ReadMover(node["pointshell"], scene), ReadMover(node["voxmap"], scene)};
  if (pair.pointshell == pair.voxmap) node["voxmap"].Expected("the name of another body");
  for (const ScenePair& other : scene.pairs) {
    const bool same = other.pointshell == pair.pointshell && other.voxmap == pair.voxmap;
    const bool swapped = other.pointshell == pair.voxmap && other.voxmap == pair.pointshell;
    if (same || swapped) node.Fault("this pair is given already");
  }
  return pair;
}

SceneHand ReadHand(const JsonNode& node, const Scene& scene) {
  node.AllowKeys({"body", "file"});
  SceneHand hand;
  hand.body = ReadMover(node["body"], scene);
  hand.file = ReadFilePath(node["file"], scene.file.parent_path());
  return hand;
}

void ReadSettings(const JsonNode& root, Scene& scene) {
  scene.name = root["name"].Text("the scene's name");
  scene.voxel_size = root["voxel_m"].NumberAbove(0);
  if (root.Has("range_voxels")) {
    scene.range_voxels = root["range_voxels"].WholeNumber(4, WidestRange(8));
  }
  if (root.Has("fine_band_voxels")) {
    scene.fine_band_voxels =
        root["fine_band_voxels"].NumberBetween(FieldOptions::kLeastBand, FieldOptions::kMostBand);
  }
  if (root.Has("clearance_range_voxels")) {
    scene.clearance_range_voxels = root["clearance_range_voxels"].NumberBetween(
        DistanceField::kLeastRange, FieldOptions::kMostRange);
  }
  if (root.Has("contact")) scene.contact = ReadContact(root["contact"]);
  scene.force_layer = DefaultForceLayer(scene.contact);
  if (root.Has("force_layer")) {
    scene.force_layer = root["force_layer"].WholeNumber(0, scene.range_voxels - kWarningQueues);
    const std::string fault = LayerFault(scene.contact, scene.force_layer);
    if (!fault.empty()) root["force_layer"].Fault(fault);
  }
  if (root.Has("friction")) scene.friction = root["friction"].NumberBetween(0, kMostFriction);
  if (root.Has("gravity_m_s2")) scene.gravity_W = root["gravity_m_s2"].Vector();
  if (scene.gravity_W.cwiseAbs().maxCoeff() > kMostGravity) {
    root["gravity_m_s2"].Expected("three numbers from -1000 to 1000");
  }
}

void ReadBodies(const JsonNode& root, double spacing, Scene& scene) {
  const std::vector<JsonNode> bodies = root["bodies"].Items();
  std::size_t uncoloured = 0;
  for (const JsonNode& node : bodies) {
    SceneBody body = ReadBody(node, scene.file.parent_path(), spacing);
    if (!body.fixed && !node.Has("colour")) {
      body.colour = kMoversColours[uncoloured++ % kMoversColours.size()];
    }
    if (scene.BodyNamed(body.name) >= 0) node["name"].Fault("another body has this name already");
    scene.bodies.push_back(std::move(body));
  }
  if (scene.bodies.empty()) root["bodies"].Expected("at least one body");
  for (std::size_t i = 0; i < bodies.size(); ++i) CheckMerging(bodies[i], scene.bodies[i], scene);
}

}  // namespace

int Scene::BodyNamed(const std::string& body_name) const {
  const auto found = std::find_if(bodies.begin(), bodies.end(), [&](const SceneBody& body) {
    return body.name == body_name;
  });
  return found == bodies.end() ? -1 : static_cast<int>(found - bodies.begin());
}

std::size_t Scene::WholeOf(std::size_t body) const {
  const std::string& whole = bodies[body].merge_with;
  return whole.empty() ? body : static_cast<std::size_t>(BodyNamed(whole));
}

bool Scene::IsPointshell(std::size_t a, double a_points, std::size_t b, double b_points) const {
  const auto is = [this](std::size_t body, const std::string& named) {
    const int index = BodyNamed(named);
    return index >= 0 && WholeOf(static_cast<std::size_t>(index)) == body;
  };
  for (const ScenePair& pair : pairs) {
    if (is(a, pair.pointshell) && is(b, pair.voxmap)) return true;
    if (is(b, pair.pointshell) && is(a, pair.voxmap)) return false;
  }
  return a_points <= b_points;
}

ClearanceBounds Scene::clearance_bounds() const {
  return contact == ContactModel::kPlain
             ? ClearanceBounds::ForMarks(range_voxels, voxel_size)
             : ClearanceBounds::ForFields(clearance_range_voxels - kRefinedClearance, voxel_size);
}

Result<Scene> LoadScene(const std::filesystem::path& file) {
  const Result<JsonFile> json = JsonFile::Read(file);
  if (!json) return json.error();
  const JsonNode root = json->root();
  if (root.Has("waypoints")) root.Fault("this is a hand's script, not a scene: --hand takes it");
  root.AllowKeys({"name", "voxel_m", "range_voxels", "fine_band_voxels", "clearance_range_voxels",
                  "contact", "force_layer", "friction", "point_spacing_voxels", "gravity_m_s2",
                  "bodies", "pairs", "hands"});

  Scene scene;
  scene.file = file;
  ReadSettings(root, scene);
  double spacing = 1;
  if (root.Has("point_spacing_voxels")) spacing = ReadPointSpacing(root["point_spacing_voxels"]);
  for (const auto& [list, most] : {std::pair{"bodies", kMostBodies}, std::pair{"pairs", kMostPairs},
                                   std::pair{"hands", kMostHands}}) {
    if (!root.Has(list) || root[list].Items().size() <= most) continue;
    root[list].Fault("more than " + std::to_string(most));
    return *json->fault();
  }
  ReadBodies(root, spacing, scene);
  if (root.Has("pairs")) {
    for (const JsonNode& node : root["pairs"].Items()) scene.pairs.push_back(ReadPair(node, scene));
  }
  if (root.Has("hands")) {
    for (const JsonNode& node : root["hands"].Items()) scene.hands.push_back(ReadHand(node, scene));
  }
  if (const std::optional<Error> fault = json->fault()) return *fault;
  return scene;
}

}  // namespace tandem
