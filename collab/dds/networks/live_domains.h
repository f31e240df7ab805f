#pragma once

#include <functional>

#include "collab/dds/networks/domain_networks.h"

namespace tandem {

/// Calls use() for each domain that has sockets, and keeps those from being closed meanwhile.
void ForEachLiveDomain(const std::function<void(DomainNetworks&)>& use);

}  // namespace tandem
