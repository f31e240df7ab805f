#pragma once

#include "app/device/tandem_device.h"

namespace tandem {

/// A hand that plays what `tandem peer --record` kept.
extern const TandemDriver kRecordedDriver;

}  // namespace tandem
