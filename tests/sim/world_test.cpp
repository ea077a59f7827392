#include "hal/sim/world.h"

#include <gtest/gtest.h>

namespace cheval::hal::sim {
namespace {

TEST(World, GivesTheSameBytesWhateverWasRenderedBefore) {
    World first(WorldOptions{.seed = 3});
    World second(WorldOptions{.seed = 3});
    Image<std::uint16_t> depth, other;
    Image<Rgb8> colour, otherColour;
    for (const std::uint64_t frame : {150U, 10U, 800U})
        renderFrame(first, frame, depth, colour);
    renderFrame(first, 345, depth, colour);
    renderFrame(second, 345, other, otherColour);
    EXPECT_EQ(depth.pixels, other.pixels);
    EXPECT_EQ(colour.pixels, otherColour.pixels);
}

}  // namespace
}  // namespace cheval::hal::sim
