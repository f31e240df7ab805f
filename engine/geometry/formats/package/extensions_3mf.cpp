#include "engine/geometry/formats/package/extensions_3mf.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

namespace tandem {

std::string ExtensionFaultOf3mf(const XmlScanner& model) {
  // extensions that are supported, and extensions that affect looks or names only
  constexpr std::array<std::string_view, 4> kTaken{"core/2015/02", "production/2015/06",
                                                   "material/2015/02", "trianglesets/2021/07"};
  constexpr std::string_view kBegin = "http://schemas.microsoft.com/3dmanufacturing/";
  std::istringstream prefixes(model.AttributeAsWritten("requiredextensions").value_or(""));
  for (std::string prefix; prefixes >> prefix;) {
    const std::string space = model.AttributeAsWritten("xmlns:" + prefix).value_or(prefix);
    const bool taken =
        space.starts_with(kBegin) &&
        std::ranges::count(kTaken, std::string_view(space).substr(kBegin.size())) > 0;
    if (!taken) return "needs the extension " + space + ", which is not read: export it without";
  }
  return {};
}

std::string_view UnreadPartOf3mf(std::string_view element) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kParts{
      {{"beamlattice", "beam lattice"},
       {"slicestack", "stack of slices"},
       {"booleanshape", "boolean shape"},
       {"levelset", "level set"},
       {"displacementmesh", "displaced mesh"},
       {"image3d", "volume image"},
       {"implicit", "implicit function"},
       {"volumetricstack", "volumetric stack"}}};
  for (const auto& [known, words] : kParts) {
    if (element == known) return words;
  }
  return {};
}

}  // namespace tandem
