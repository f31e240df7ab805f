#pragma once

#include <QString>

namespace tandem {

/// What mouse and keys do, for Help; with those of a hand where there is one.
QString KeysPage(bool with_hand);

}  // namespace tandem
