#include "daemon/triple_buffer.h"

#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::daemon {
namespace {

TEST(TripleBuffer, givesTheNewestAndSaysWhatWasMissed) {
    TripleBuffer<int> buffer;
    EXPECT_FALSE(buffer.take());
    buffer.back() = 1;
    EXPECT_FALSE(buffer.publish());
    buffer.back() = 2;
    EXPECT_TRUE(buffer.publish());
    EXPECT_TRUE(buffer.take());
    EXPECT_EQ(buffer.front(), 2);
    EXPECT_FALSE(buffer.take());
    EXPECT_EQ(buffer.front(), 2);
    buffer.back() = 3;
    EXPECT_FALSE(buffer.publish());
    EXPECT_TRUE(buffer.take());
    EXPECT_EQ(buffer.front(), 3);
}

TEST(TripleBuffer, neverLendsOneSlotTwice) {
    TripleBuffer<int> buffer;
    for (int i = 0; i < 50; ++i) {
        buffer.back() = i;
        EXPECT_NE(&buffer.back(), &buffer.front());
        buffer.publish();
        if (i % 3 == 0) buffer.take();
        EXPECT_NE(&buffer.back(), &buffer.front());
    }
}

// Under the thread sanitizer this is the proof that a slot is never written while it is read.
TEST(TripleBuffer, handsOverWholeValuesInOrderBetweenThreads) {
    struct Value {
        std::uint64_t number = 0;
        std::vector<std::uint64_t> copies = std::vector<std::uint64_t>(64);
    };
    constexpr std::uint64_t kLast = 20'000;
    TripleBuffer<Value> buffer;
    std::thread writer([&buffer] {
        for (std::uint64_t i = 1; i <= kLast; ++i) {
            Value& value = buffer.back();
            value.number = i;
            for (std::uint64_t& copy : value.copies)
                copy = i;
            buffer.publish();
        }
    });
    std::uint64_t last = 0;
    bool whole = true;
    bool ordered = true;
    while (last < kLast) {
        if (!buffer.take()) {
            std::this_thread::yield();
            continue;
        }
        const Value& value = buffer.front();
        ordered = ordered && value.number > last;
        last = value.number;
        for (const std::uint64_t copy : value.copies)
            whole = whole && copy == value.number;
    }
    writer.join();
    EXPECT_TRUE(whole);
    EXPECT_TRUE(ordered);
}

}  // namespace
}  // namespace cheval::daemon
