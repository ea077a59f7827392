// Advice on size in words that a shopper may read.
#pragma once

#include <array>
#include <string_view>

#include "fitting/advice.h"

namespace cheval::fitting {

/// Memory for one sentence of advice.
using AdviceText = std::array<char, 160>;

/// Why no size is told, as shoppers read it: what they can do about it where there is something, and nothing about
/// their body. Empty for `none`, `notSized` and the ends of the chart, which need a size's name.
std::string_view reasonInWords(AdviceReason reason);

/// "Your size: M", "Between M and L", "Size: I cannot tell: still measuring"; empty for what is not sized. The words
/// lie in `memory`. Takes no heap memory.
std::string_view adviceInWords(const SizeAdvice& advice, AdviceText& memory);

}  // namespace cheval::fitting
