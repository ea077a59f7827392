// What a fuzz harness offers: the entry point that libFuzzer calls too, and its seeds. See tests/support/fuzz.cmake.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// Feeds one input to the code under test, which must neither crash nor take memory or time out of proportion. Returns
/// 0.
// NOLINTNEXTLINE(readability-identifier-naming): the name is libFuzzer's.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace cheval::test {

using FuzzInput = std::vector<std::uint8_t>;

/// Valid inputs, made by the harness itself, small (under some kilobytes), one for each thing the code can meet.
std::vector<FuzzInput> fuzzSeeds();

}  // namespace cheval::test
