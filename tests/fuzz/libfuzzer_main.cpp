// The same readers for libFuzzer; TANDEM_FUZZ_TARGET says which.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tandem::FuzzTarget* const target = [] {
    const char* name = std::getenv("TANDEM_FUZZ_TARGET");
    const tandem::FuzzTarget* found = tandem::FuzzTargetNamed(name == nullptr ? "" : name);
    if (found == nullptr) {
      std::fprintf(stderr, "TANDEM_FUZZ_TARGET names no reader\n");
      std::exit(2);
    }
    return found;
  }();
  target->run({reinterpret_cast<const char*>(data), size});
  return 0;
}
