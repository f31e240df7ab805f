#pragma once

#include <string_view>

namespace tandem {

// Targets of the readers of meshes. A mesh that is read has only corners that exist, and remarks of
// one line.

void FeedOff(std::string_view bytes);
void FeedStl(std::string_view bytes);
void FeedPly(std::string_view bytes);
void FeedObj(std::string_view bytes);
void FeedAmf(std::string_view bytes);
void FeedCollada(std::string_view bytes);
void FeedGltf(std::string_view bytes);
/// Feeds the bytes as an archive, and as the model in one whose sums are right.
void Feed3mf(std::string_view bytes);
/// Feeds the bytes to what looks into a file before its reader does.
void FeedTexts(std::string_view bytes);

}  // namespace tandem
