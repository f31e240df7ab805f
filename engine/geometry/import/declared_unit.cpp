#include "engine/geometry/import/declared_unit.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/package/zip_archive.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

// A 3MF file is a ZIP archive. One of the files in it, the model, is XML whose first element has
// the unit.

constexpr std::size_t kHead = 1 << 16;  // bytes of the model that contain its first element
constexpr double kDefaultUnit = 1e-3;   // m; the format's default, where the model declares none

std::string HeadOfModel(const std::filesystem::path& file) {
  const std::optional<ZipArchive> archive = ZipArchive::Open(file);
  if (!archive) return {};
  Result<std::string> head = archive->Read(archive->Model(), kHead);
  return head ? InUtf8(*std::move(head)) : std::string();
}

/// Goes through the beginning of an XML file.
class XmlHead {
 public:
  explicit XmlHead(std::string_view text) : rest_(text) { Take("\xEF\xBB\xBF"); }

  bool Take(std::string_view words) {
    if (!rest_.starts_with(words)) return false;
    rest_.remove_prefix(words.size());
    return true;
  }
  /// Takes the text before these words, and the words; nothing: they do not come.
  std::optional<std::string_view> TakeUpTo(std::string_view words) {
    const std::size_t at = rest_.find(words);
    if (at == std::string_view::npos) return std::nullopt;
    const std::string_view before = rest_.substr(0, at);
    rest_.remove_prefix(at + words.size());
    return before;
  }
  /// Takes white space; returns whether there was any.
  bool TakeSpace() {
    const std::size_t end = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
    rest_.remove_prefix(end);
    return end > 0;
  }
  /// Takes a name of an element or an attribute; empty: there is none here.
  std::string_view TakeName() {
    const std::size_t end = std::min(rest_.find_first_of(" \t\r\n=/<>\"'"), rest_.size());
    const std::string_view name = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return name;
  }
  /// Takes all before the first element: spaces, the declaration, comments.
  void TakeProlog() {
    while (TakeSpace() || (Take("<?") && TakeUpTo("?>")) || (Take("<!--") && TakeUpTo("-->"))) {
    }
  }
  /// Takes a value in quotes, behind its equals sign.
  std::optional<std::string_view> TakeValue() {
    TakeSpace();
    if (!Take("=")) return std::nullopt;
    TakeSpace();
    for (const char* quote : {"\"", "'"}) {
      if (Take(quote)) return TakeUpTo(quote);
    }
    return std::nullopt;
  }

 private:
  std::string_view rest_;
};

std::optional<double> MetresOf(std::string_view unit) {
  constexpr std::array<std::pair<std::string_view, double>, 6> kUnits{{{"micron", 1e-6},
                                                                       {"millimeter", 1e-3},
                                                                       {"centimeter", 1e-2},
                                                                       {"inch", 0.0254},
                                                                       {"foot", 0.3048},
                                                                       {"meter", 1.0}}};
  for (const auto& [name, metres] : kUnits) {
    if (unit == name) return metres;
  }
  return std::nullopt;
}

/// Returns the unit by the first element's attribute; nothing where the text is not the beginning
/// of a model.
std::optional<double> UnitIn(std::string_view text) {
  XmlHead head(text);
  head.TakeProlog();
  if (!head.Take("<")) return std::nullopt;
  const std::string_view element = head.TakeName();
  if (element != "model" && !element.ends_with(":model")) return std::nullopt;
  std::optional<double> unit;
  while (true) {
    const bool apart = head.TakeSpace();
    if (head.Take(">")) return unit.value_or(kDefaultUnit);
    const std::string_view name = head.TakeName();
    const std::optional<std::string_view> value = head.TakeValue();
    if (!apart || name.empty() || !value) return std::nullopt;
    if (name != "unit") continue;
    if (unit) return std::nullopt;
    unit = MetresOf(*value);
    if (!unit) return std::nullopt;
  }
}

}  // namespace

bool KindDeclaresUnit(const std::filesystem::path& file) {
  const std::string ending = EndingOf(file);
  return ending == "3mf" || ending == "amf" || ending == "dae" || ending == "fbx";
}

std::optional<double> DeclaredUnit(const std::filesystem::path& file) {
  return EndingOf(file) == "3mf" ? UnitIn(HeadOfModel(file)) : std::nullopt;
}

}  // namespace tandem
