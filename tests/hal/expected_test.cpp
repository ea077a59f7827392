#include "hal/expected.h"

#include <gtest/gtest.h>

namespace cheval {
namespace {

TEST(ErrorTest, MessageNamesPlaceCauseMendAndWhy) {
    const Error error{.code = ErrorCode::invalidInput,
                      .cause = "the rate is 500",
                      .mend = "set 5 to 60",
                      .why = "sensors give no more",
                      .file = "cheval.toml",
                      .line = 7,
                      .key = "sensor.rate"};
    EXPECT_EQ(error.message(),
              "cheval.toml:7: sensor.rate: the rate is 500. Mend: set 5 to 60. Why: sensors give no more");
}

TEST(ErrorTest, WhatIsEmptyIsLeftOut) {
    EXPECT_EQ(Error{.cause = "no frame came"}.message(), "no frame came");
}

TEST(ErrorTest, ContextIsAddedInFront) {
    EXPECT_EQ(Error{.cause = "no cage"}.within("loading tshirt.glb").cause, "loading tshirt.glb: no cage");
}

Expected<int> half(int value) {
    if (value % 2 != 0) return Error{.code = ErrorCode::invalidInput, .cause = "odd"};
    return value / 2;
}

TEST(ExpectedTest, HoldsEitherAValueOrAnError) {
    ASSERT_TRUE(half(8));
    EXPECT_EQ(*half(8), 4);
    ASSERT_FALSE(half(7));
    EXPECT_EQ(half(7).error().code, ErrorCode::invalidInput);
}

TEST(ExpectedTest, VoidIsSuccessUnlessGivenAnError) {
    EXPECT_TRUE(Expected<void>{});
    EXPECT_FALSE(Expected<void>(Error{.cause = "no"}));
}

}  // namespace
}  // namespace cheval
