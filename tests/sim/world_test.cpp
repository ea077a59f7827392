#include "hal/sim/world.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "hal/sim/view.h"
#include "tests/sim/sim_fixtures.h"
#include "tests/support/allocation_counter.h"

namespace cheval::hal::sim {
namespace {

using fitting::HandState;
using fitting::Joint;
using fitting::Side;
using test::frameAt;
using test::kInPause;
using test::kKindsOfPeople;
using test::worldTime;

struct Picture {
    Image<std::uint16_t> depth;
    Image<Rgb8> colour;
};
Picture render(World& world, std::uint64_t frame) {
    Picture picture;
    renderFrame(world, frame, picture.depth, picture.colour);
    return picture;
}

TEST(World, GivesTheSameBytesWhateverWasRenderedBefore) {
    World first(WorldOptions{.seed = 3});
    World second(WorldOptions{.seed = 3});
    for (const std::uint64_t frame : {150U, 10U, 800U, 344U})
        render(first, frame);
    const Picture picture = render(first, 345);
    const Picture other = render(second, 345);
    EXPECT_EQ(picture.depth.pixels, other.depth.pixels);
    EXPECT_EQ(picture.colour.pixels, other.colour.pixels);
}

TEST(World, IsAnotherForAnotherSeed) {
    World first(WorldOptions{.seed = 3});
    World second(WorldOptions{.seed = 4});
    EXPECT_NE(render(first, 150).depth.pixels, render(second, 150).depth.pixels);
    EXPECT_NE(truthAt(first, 5.0).statureMetres, truthAt(second, 5.0).statureMetres);
}

TEST(World, IsEmptyBetweenVisitsButForNoise) {
    WorldOptions options;
    options.sensorNoise = false;
    World world(options);
    const Picture empty = render(world, frameAt(options, 0, kInPause));
    EXPECT_EQ(empty.depth.pixels, render(world, frameAt(options, 3, kInPause)).depth.pixels);
    EXPECT_EQ(empty.colour.pixels, render(world, frameAt(options, 3, kInPause)).colour.pixels);
    EXPECT_NE(empty.depth.pixels, render(world, frameAt(options, 3, 5.0)).depth.pixels);
    EXPECT_FALSE(truthAt(world, worldTime(options, 0, kInPause)).present);
    EXPECT_FALSE(truthAt(world, worldTime(options, 0, kInPause)).skeleton.present());
}

TEST(World, BringsChildrenAndTallAdultsInTurn) {
    const World world(WorldOptions{});
    float shortest = 9.0F;
    float tallest = 0.0F;
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        const WorldTruth truth = truthAt(world, worldTime(world.options(), visit, 5.0));
        EXPECT_EQ(truth.visit, visit);
        EXPECT_EQ(truth.skeleton.userId, visit + 1);
        shortest = std::min(shortest, truth.statureMetres);
        tallest = std::max(tallest, truth.statureMetres);
    }
    EXPECT_LT(shortest, 1.40F);
    EXPECT_GT(tallest, 1.85F);
}

TEST(World, KeepsEverybodyWhollyInViewFromArrivalToLeaving) {
    for (const std::uint32_t seed : {1U, 2U, 3U}) {
        const World world(WorldOptions{.seed = seed});
        for (std::uint32_t visit = 0; visit < 2 * kKindsOfPeople; ++visit) {
            for (double t = 3.3; t < 17.0; t += 0.1) {
                EXPECT_TRUE(truthAt(world, worldTime(world.options(), visit, t)).present)
                    << "seed " << seed << " visit " << visit << " at " << t;
            }
        }
    }
}

TEST(World, TouchesNoBorderOfThePictureWhileTheShopperStands) {
    // Seen from the picture itself, clothes and hair included; the bottom row may show the floor but no shoe.
    WorldOptions options;
    options.sensorNoise = false;
    World world(options);
    const Picture empty = render(world, frameAt(options, 0, kInPause));
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        for (const double t : {5.0, 7.6, 9.0, 11.5, 13.0}) {
            const Picture picture = render(world, frameAt(options, visit, t));
            for (const int y : {0, 1, 478, 479}) {
                for (int x = 0; x < 640; ++x) {
                    ASSERT_EQ(picture.depth.view().at(x, y), empty.depth.view().at(x, y)) << visit << " at " << t;
                }
            }
        }
    }
}

/// Joints that nothing but the shopper's own surface lies before in the A-pose.
TEST(World, PutsTruthInsideTheSilhouetteJustBehindTheSurface) {
    WorldOptions options;
    options.sensorNoise = false;
    World world(options);
    const View view(Intrinsics{}, options.mount);
    const Picture empty = render(world, frameAt(options, 0, kInPause));
    for (std::uint32_t visit = 0; visit < 2 * kKindsOfPeople; ++visit) {
        for (const double t : {4.2, 5.0, 5.8}) {
            const std::uint64_t frame = frameAt(options, visit, t);
            const Picture picture = render(world, frame);
            const WorldTruth truth = truthAt(world, world.timeOf(frame));
            for (std::size_t joint = 0; joint < fitting::kJointCount; ++joint) {
                const Eigen::Vector3f seen = view.toSensor(truth.skeleton.joints[joint].position);
                const Eigen::Vector2f at = view.project(seen);
                const int x = static_cast<int>(std::lround(at.x()));
                const int y = static_cast<int>(std::lround(at.y()));
                ASSERT_TRUE(picture.depth.view().contains(x, y)) << fitting::kJointNames[joint];
                const float reading = picture.depth.view().at(x, y);
                EXPECT_LT(reading + 100.0F, static_cast<float>(empty.depth.view().at(x, y)))
                    << fitting::kJointNames[joint] << " is not on the shopper, visit " << visit << " at " << t;
                EXPECT_LT(reading, 1000.0F * seen.z() + 5.0F) << fitting::kJointNames[joint];
                EXPECT_GT(reading, 1000.0F * seen.z() - 260.0F) << fitting::kJointNames[joint];
            }
        }
    }
}

TEST(World, MeasuresTheStatureFromFloorToCrown) {
    // The head's centre lies half a head, 6 to 8 per cent of the stature, below the crown.
    const World world(WorldOptions{});
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        const WorldTruth truth = truthAt(world, worldTime(world.options(), visit, 5.0));
        const float head = truth.skeleton[Joint::head].position.y();
        EXPECT_GT(head, 0.90F * truth.statureMetres);
        EXPECT_LT(head, 0.95F * truth.statureMetres);
    }
}

TEST(World, OpensAndClosesTheRaisedHand) {
    const World world(WorldOptions{});
    for (std::uint32_t visit = 0; visit < kKindsOfPeople; ++visit) {
        std::vector<HandState> states;
        for (double t = 10.6; t < 12.6; t += 1.0 / 30.0) {
            const HandState state =
                truthAt(world, worldTime(world.options(), visit, t)).hands[fitting::index(Side::right)];
            if (states.empty() || states.back() != state) states.push_back(state);
        }
        EXPECT_EQ(states, (std::vector<HandState>{HandState::open, HandState::unknown, HandState::closed,
                                                  HandState::unknown, HandState::open}));
        const WorldTruth relaxed = truthAt(world, worldTime(world.options(), visit, 9.0));
        EXPECT_EQ(relaxed.hands[0], HandState::unknown);
        EXPECT_EQ(relaxed.hands[1], HandState::unknown);
    }
}

TEST(World, ScalesTheScriptWithTheVisit) {
    WorldOptions options;
    options.visitSeconds = 40.0;
    const World slow(options);
    const World quick(WorldOptions{});
    const Eigen::Vector3f there = truthAt(slow, 23.0).skeleton[Joint::rightHand].position;
    const Eigen::Vector3f here = truthAt(quick, 11.5).skeleton[Joint::rightHand].position;
    EXPECT_LT((there - here).norm(), 1e-5F);
}

TEST(World, SeesTheShopperInColourWhereItSeesThemInDepth) {
    WorldOptions options;
    options.sensorNoise = false;
    World world(options);
    const Picture empty = render(world, frameAt(options, 0, kInPause));
    const Picture picture = render(world, frameAt(options, 0, 5.0));
    std::size_t shopper = 0;
    std::size_t coloured = 0;
    for (std::size_t i = 0; i < picture.depth.pixels.size(); ++i) {
        if (picture.depth.pixels[i] + 200 > empty.depth.pixels[i]) continue;
        ++shopper;
        if (picture.colour.pixels[i] != empty.colour.pixels[i]) ++coloured;
    }
    EXPECT_GT(shopper, 12'000U);
    EXPECT_GT(static_cast<double>(coloured), 0.97 * static_cast<double>(shopper));
}

/// FNV-1a over the bytes of both pictures.
std::uint64_t hashOf(const Picture& picture) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    const auto add = [&](std::uint32_t byte) { hash = (hash ^ byte) * 0x100000001b3U; };
    for (const std::uint16_t reading : picture.depth.pixels) {
        add(reading & 0xffU);
        add(reading >> 8U);
    }
    for (const Rgb8& pixel : picture.colour.pixels) {
        add(pixel.r);
        add(pixel.g);
        add(pixel.b);
    }
    return hash;
}

TEST(World, DrawsTheVisitAsItAlwaysHas) {
    // Recordings, golden pictures and figures of accuracy were made of this script: its bytes are not to change.
    World world(WorldOptions{.seed = 3});
    std::vector<std::uint64_t> hashes;
    for (const std::uint64_t frame : {40U, 150U, 345U, 402U, 550U, 700U, 1130U})
        hashes.push_back(hashOf(render(world, frame)));
    EXPECT_EQ(hashes, (std::vector<std::uint64_t>{0xb0749827ee8cc58fU, 0xc663e4665ded0866U, 0x59be2074512dca14U,
                                                  0x623308d286000840U, 0x8be8ddd56376f17fU, 0xd912b7e268ab8625U,
                                                  0xee77c959b932d380U}));
}

TEST(World, LeavesColourOutWhenItHasNone) {
    World world(WorldOptions{.colour = false});
    World coloured(WorldOptions{});
    const Picture picture = render(world, 150);
    EXPECT_TRUE(picture.colour.empty());
    EXPECT_EQ(picture.depth.pixels, render(coloured, 150).depth.pixels);
}

TEST(World, TakesNoMemoryOnceWarm) {
    World world(WorldOptions{});
    Picture picture = render(world, 0);
    const cheval::test::AllocationCounter counter;
    // Across a pause and into the next shopper's visit.
    for (std::uint64_t frame = 1; frame < 1000; frame += 37)
        renderFrame(world, frame, picture.depth, picture.colour);
    EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace cheval::hal::sim
