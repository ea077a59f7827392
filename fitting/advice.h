// Advice on size, in words that a shopper may read.
#pragma once

#include <cstdint>
#include <string>

namespace cheval::fitting {

enum class AdviceCertainty : std::uint8_t { cannotTell, between, certain };

/// "M", "between M and L", or why it cannot be told.
struct SizeAdvice {
    AdviceCertainty certainty = AdviceCertainty::cannotTell;
    std::string size;        ///< The (smaller) size; empty when it cannot be told.
    std::string largerSize;  ///< Only when between two.
    std::string reason;      ///< Only when it cannot be told.
};

}  // namespace cheval::fitting
