#include "engine/geometry/formats/package/slicer_parts.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "engine/geometry/formats/number_word.h"
#include "engine/geometry/formats/text_lines.h"
#include "engine/geometry/formats/xml_scanner.h"

namespace tandem {

namespace {

constexpr std::size_t kMostSettings = std::size_t{64} << 20U;  // bytes

/// Reads <object id><volume firstid lastid><metadata key="volume_type" value>, and <object id><part
/// id subtype>; false: it is damaged.
bool ReadSettings(std::string_view text, SlicerParts& parts) {
  XmlScanner xml(text);
  std::string object;
  SlicerParts::Range range;
  bool in_volume = false;
  bool has_range = false;
  for (auto piece = xml.Next();; piece = xml.Next()) {
    if (piece == XmlScanner::Piece::kEnd) return true;
    if (piece == XmlScanner::Piece::kFault) return false;
    if (piece == XmlScanner::Piece::kClose && xml.name() == "volume" && in_volume) {
      if (range.use != PartUse::kShape && !has_range) return false;
      if (range.use != PartUse::kShape) parts.ranges_of[object].push_back(range);
      in_volume = false;
    }
    if (piece != XmlScanner::Piece::kOpen) continue;
    if (xml.name() == "object") object = xml.Attribute("id").value_or("");
    if (xml.name() == "part") {
      const PartUse use = PartUseNamed(xml.Attribute("subtype").value_or(""));
      if (use != PartUse::kShape) {
        parts.use_of_part[{object, xml.Attribute("id").value_or("")}] = use;
      }
    }
    if (xml.name() == "volume") {
      range = {};
      in_volume = !xml.empty();
      has_range = ParseNumber(xml.Attribute("firstid").value_or(""), range.first) &&
                  ParseNumber(xml.Attribute("lastid").value_or(""), range.last);
    }
    if (xml.name() == "metadata" && in_volume) {
      const std::string key = xml.Attribute("key").value_or("");
      const std::string value = xml.Attribute("value").value_or("");
      if (key == "volume_type") range.use = PartUseNamed(value);
      if (key == "modifier" && value == "1" && range.use == PartUse::kShape) {
        range.use = PartUse::kLeftOut;
      }
    }
  }
}

}  // namespace

PartUse SlicerParts::UseOf(const std::string& object, const std::string& component) const {
  const auto found = use_of_part.find({object, component});
  return found == use_of_part.end() ? PartUse::kShape : found->second;
}

PartUse PartUseNamed(const std::string& word) {
  std::string small = InSmallLetters(word);
  std::erase(small, '_');
  if (small.starts_with("negative")) return PartUse::kNegative;
  for (const char* begin : {"parametermodifier", "modifier", "support", "blocker", "enforcer"}) {
    if (small.starts_with(begin)) return PartUse::kLeftOut;
  }
  return PartUse::kShape;
}

Result<SlicerParts> ReadSlicerParts(const ZipArchive& archive) {
  SlicerParts parts;
  for (const char* name : {"Metadata/Slic3r_PE_model.config", "Metadata/Slic3r_model.config",
                           "Metadata/Prusa_Slicer_model.config",
                           "Metadata/SuperSlicer_model.config", "Metadata/model_settings.config"}) {
    if (!archive.Has(name)) continue;
    Result<std::string> text = archive.Read(name, kMostSettings);
    if (!text || !ReadSettings(InUtf8(*std::move(text)), parts)) {
      return Error{"its settings " + std::string(name) + " " +
                   (text ? "cannot be read: they are damaged" : text.error().what) +
                   "; they say which parts are no material: export it again"};
    }
  }
  return parts;
}

}  // namespace tandem
