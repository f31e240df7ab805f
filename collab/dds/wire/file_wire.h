#pragma once

#include <vector>

#include "collab/transfer/file_messages.h"
#include "tandem.h"  // idlc's

namespace tandem {

/// Converts between the messages of a transfer and their wire format. FromWire returns false for
/// values that no sound program sends. The bytes of a piece that is sent lie in the message and
/// live as long as it.
void ToWire(const FileAsk& ask, tandem_FileAsk& wire) noexcept;
bool FromWire(const tandem_FileAsk& wire, FileAsk& ask) noexcept;
void ToWire(const FilePiece& piece, tandem_FilePiece& wire) noexcept;
bool FromWire(const tandem_FilePiece& wire, FilePiece& piece);

}  // namespace tandem
