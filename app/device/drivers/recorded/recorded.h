#pragma once

#include "app/device/tandem_device.h"

namespace tandem {

/// A hand that plays a recording of `tandem peer --record`.
extern const TandemDriver kRecordedDriver;

}  // namespace tandem
