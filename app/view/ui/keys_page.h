#pragma once

#include <QString>

namespace tandem {

/// Returns the text of Help on mouse and keys; with a hand, its keys too.
QString KeysPage(bool with_hand);

}  // namespace tandem
