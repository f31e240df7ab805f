#include "engine/geometry/import/declared_unit.h"

#include <string>

#include "engine/geometry/formats/native_readers.h"

namespace tandem {

bool KindDeclaresUnit(const std::filesystem::path& file) {
  const std::string ending = EndingOf(file);
  return ending == "3mf" || ending == "amf" || ending == "dae" || ending == "fbx";
}

}  // namespace tandem
