#include "app/picture/picture_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <string_view>

#include <nlohmann/json.hpp>

#include "engine/base/text/json_reader.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 3> kMarkers{"dot", "cross", "ring"};
constexpr std::array<std::string_view, 3> kAnchors{"start", "middle", "end"};
constexpr double kLargest = 20'000;  // pixels per side

Json JsonOf(const Rgb& colour) {
  std::array<char, 10> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", colour.r, colour.g, colour.b);
  return text.data();
}

Json JsonOf(const Stroke& stroke) {
  return {{"colour", JsonOf(stroke.colour)}, {"width", stroke.width}, {"dashes", stroke.dashes}};
}

Json JsonOf(const PictureShape& shape) {
  struct Writer {
    Json operator()(const RectangleShape& s) const {
      Json out{{"box", {s.box.x, s.box.y, s.box.width, s.box.height}}};
      if (s.fill) out["fill"] = JsonOf(*s.fill);
      if (s.edge) out["edge"] = JsonOf(*s.edge);
      return {{"rectangle", out}};
    }
    Json operator()(const PolylineShape& s) const {
      Json points = Json::array();
      for (const PicturePoint& point : s.points) points.push_back({point.x, point.y});
      return {{"polyline", {{"points", points}, {"stroke", JsonOf(s.stroke)}}}};
    }
    Json operator()(const MarkerShape& s) const {
      return {{"marker",
               {{"at", {s.at.x, s.at.y}},
                {"kind", kMarkers.at(static_cast<std::size_t>(s.kind))},
                {"size", s.size},
                {"colour", JsonOf(s.colour)}}}};
    }
    Json operator()(const LabelShape& s) const {
      return {{"label",
               {{"at", {s.at.x, s.at.y}},
                {"text", s.text},
                {"size", s.size},
                {"anchor", kAnchors.at(static_cast<std::size_t>(s.anchor))},
                {"colour", JsonOf(s.colour)},
                {"bold", s.bold},
                {"upwards", s.upwards}}}};
    }
  };
  return std::visit(Writer{}, shape);
}

Rgb ColourOf(const JsonNode& node) {
  const std::string text = node.Text();
  unsigned value = 0;
  const char* const end = text.data() + text.size();
  const bool has_length = text.size() == 7 && text[0] == '#';
  if (!has_length || std::from_chars(text.data() + 1, end, value, 16).ptr != end) {
    node.Expected("a colour as \"#rrggbb\"");
    return {};
  }
  const auto byte = [value](unsigned shift) {
    return static_cast<std::uint8_t>((value >> shift) & 0xFFU);
  };
  return {byte(16), byte(8), byte(0)};
}

template <class Kind, std::size_t n>
Kind WordOf(const JsonNode& node, const std::array<std::string_view, n>& words) {
  const auto* const found = std::find(words.begin(), words.end(), node.Text());
  if (found != words.end()) return static_cast<Kind>(found - words.begin());
  node.Expected("one of the known words");
  return Kind{};
}

std::vector<double> NumbersOf(const JsonNode& node, std::size_t count) {
  std::vector<double> numbers;
  for (const JsonNode& item : node.Items()) numbers.push_back(item.Number());
  if (count != 0 && numbers.size() != count) {
    node.Expected(std::to_string(count) + " numbers");
    numbers.resize(count);
  }
  return numbers;
}

PicturePoint PointOf(const JsonNode& node) {
  const std::vector<double> xy = NumbersOf(node, 2);
  return {xy[0], xy[1]};
}

Stroke StrokeOf(const JsonNode& node) {
  return {ColourOf(node["colour"]), node["width"].NumberFrom(0), NumbersOf(node["dashes"], 0)};
}

PictureShape ShapeOf(const JsonNode& node) {
  if (node.Has("rectangle")) {
    const JsonNode in = node["rectangle"];
    const std::vector<double> box = NumbersOf(in["box"], 4);
    RectangleShape shape{{box[0], box[1], box[2], box[3]}, {}, {}, {}};
    if (in.Has("fill")) shape.fill = ColourOf(in["fill"]);
    if (in.Has("edge")) shape.edge = StrokeOf(in["edge"]);
    return shape;
  }
  if (node.Has("polyline")) {
    PolylineShape shape{{}, StrokeOf(node["polyline"]["stroke"])};
    for (const JsonNode& point : node["polyline"]["points"].Items()) {
      shape.points.push_back(PointOf(point));
    }
    return shape;
  }
  if (node.Has("marker")) {
    const JsonNode in = node["marker"];
    return MarkerShape{PointOf(in["at"]),
                       WordOf<MarkerKind>(in["kind"], kMarkers),
                       in["size"].NumberAbove(0),
                       ColourOf(in["colour"]),
                       {}};
  }
  const JsonNode in = node["label"];
  return LabelShape{PointOf(in["at"]),          in["text"].Text(),
                    in["size"].NumberAbove(0),  WordOf<TextAnchor>(in["anchor"], kAnchors),
                    ColourOf(in["colour"]),     in["bold"].TrueOrFalse(),
                    in["upwards"].TrueOrFalse()};
}

double SideOf(const JsonNode& node) {
  const double side = node.NumberAbove(0);
  if (side > kLargest) node.Expected("at most 20000 pixels");
  return side;
}

}  // namespace

std::string JsonOf(const std::vector<Picture>& pictures) {
  Json all = Json::array();
  for (const Picture& picture : pictures) {
    Json shapes = Json::array();
    for (const PictureShape& shape : picture.shapes) shapes.push_back(JsonOf(shape));
    all.push_back({{"name", picture.name},
                   {"title", picture.title},
                   {"width", picture.width},
                   {"height", picture.height},
                   {"shapes", shapes}});
  }
  return JsonText(Json{{"pictures", all}}) + '\n';
}

Result<std::vector<Picture>> ReadPictures(const std::filesystem::path& file) {
  const Result<JsonFile> json = JsonFile::Read(file);
  if (!json) return json.error();
  std::vector<Picture> pictures;
  for (const JsonNode& node : json->root()["pictures"].Items()) {
    Picture& picture = pictures.emplace_back();
    picture.name = node["name"].Text();
    // the name becomes a file's name
    if (picture.name.empty() || picture.name.front() == '.' ||
        picture.name.find_first_of("/\\") != std::string::npos) {
      node["name"].Expected("a plain file name");
    }
    picture.title = node["title"].Text();
    picture.width = SideOf(node["width"]);
    picture.height = SideOf(node["height"]);
    for (const JsonNode& shape : node["shapes"].Items()) picture.shapes.push_back(ShapeOf(shape));
  }
  if (json->fault()) return *json->fault();
  return pictures;
}

}  // namespace tandem
