#pragma once

#include <string>
#include <string_view>

#include "engine/geometry/formats/xml_scanner.h"

namespace tandem {

/// Returns what is wrong with the extensions that an opened <model> requires; empty: nothing. A
/// model may hold triangles and require slices, beams or encrypted parts in their place.
std::string ExtensionFaultOf3mf(const XmlScanner& model);

/// Returns the name under which a part of the format that is not read is told; empty: it is read,
/// or has no shape.
std::string_view UnreadPartOf3mf(std::string_view element);

}  // namespace tandem
