#include "fitting/body/size_words.h"

#include <algorithm>
#include <cstddef>
#include <initializer_list>

namespace cheval::fitting {

namespace {

std::string_view join(std::initializer_list<std::string_view> parts, AdviceText& memory) {
    std::size_t length = 0;
    for (const std::string_view part : parts)
        length += part.copy(memory.data() + length, memory.size() - length);
    return {memory.data(), length};
}

}  // namespace

std::string_view reasonInWords(AdviceReason reason) {
    switch (reason) {
        case AdviceReason::measuring:
            return "still measuring";
        case AdviceReason::child:
            return "sizes here are for grown-ups";
        case AdviceReason::seated:
            return "I learnt it for people standing; please ask us";
        case AdviceReason::looseClothes:
            return "your coat hides you: open it or take it off";
        case AdviceReason::partlySeen:
            return "please step back so that I see all of you";
        case AdviceReason::crowded:
            return "please stand a little apart";
        case AdviceReason::tiltUnknown:
            return "I am still looking for the floor";
        case AdviceReason::uncertain:
            return "I am not sure enough; please ask us";
        case AdviceReason::girthsDisagree:
            return "it depends on the cut; please try two sizes";
        case AdviceReason::none:
        case AdviceReason::smallerThanChart:
        case AdviceReason::largerThanChart:
        case AdviceReason::notSized:
            return "";
    }
    return "";
}

std::string_view adviceInWords(const SizeAdvice& advice, AdviceText& memory) {
    const std::string_view size = advice.size.view();
    const bool smaller = advice.reason == AdviceReason::smallerThanChart;
    const bool larger = advice.reason == AdviceReason::largerThanChart;
    switch (advice.certainty) {
        case AdviceCertainty::certain:
            return join({"Your size: ", size}, memory);
        case AdviceCertainty::between:
            if (smaller) return join({size, ", or smaller than our sizes"}, memory);
            if (larger) return join({size, ", or larger than our sizes"}, memory);
            return join({"Between ", size, " and ", advice.largerSize.view()}, memory);
        case AdviceCertainty::cannotTell:
            if (smaller) return join({"Size: I cannot tell: ours begin with ", size, "; please ask us"}, memory);
            if (larger) return join({"Size: I cannot tell: ours end with ", size, "; please ask us"}, memory);
            if (advice.reason == AdviceReason::notSized) return {};
            return join({"Size: I cannot tell: ", reasonInWords(advice.reason)}, memory);
    }
    return {};
}

}  // namespace cheval::fitting
