#pragma once

#include <string>

#include "collab/controller/requests.h"

namespace tandem {

/// Describes a request for a person who follows a session: "grab shared".
std::string DescribeRequest(const ControlRequest& request);

}  // namespace tandem
