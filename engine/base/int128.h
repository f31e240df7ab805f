#pragma once

namespace tandem {

/// Whole numbers wide enough for exact products of snapped coordinates; both compilers have them.
__extension__ using Int128 = __int128;
__extension__ using Uint128 = unsigned __int128;

}  // namespace tandem
