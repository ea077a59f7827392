#include "tests/support/allocation_counter.h"

#include <cstdlib>
#include <memory>
#include <new>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace cheval::test {
namespace {

// Through a volatile pointer, or the compiler may leave the pair out.
void* volatile kept = nullptr;

TEST(AllocationCounter, countsEveryWayToTakeMemory) {
    const AllocationCounter counter;
    kept = std::malloc(7);
    EXPECT_EQ(counter.count(), 1U);
    kept = std::realloc(kept, 70'000);
    EXPECT_EQ(counter.count(), 2U);
    std::free(kept);
    kept = std::calloc(3, 5);
    EXPECT_EQ(counter.count(), 3U);
    std::free(kept);
    void* aligned = nullptr;
    ASSERT_EQ(posix_memalign(&aligned, 64, 100), 0);
    EXPECT_EQ(counter.count(), 4U);
    std::free(aligned);
    kept = std::aligned_alloc(64, 128);
    EXPECT_EQ(counter.count(), 5U);
    std::free(kept);
    kept = ::operator new(9);
    EXPECT_EQ(counter.count(), 6U);
    ::operator delete(kept);
    kept = ::operator new(9, std::align_val_t(64));
    EXPECT_EQ(counter.count(), 7U);
    ::operator delete(kept, std::align_val_t(64));
    const std::vector<int> numbers(10);
    EXPECT_EQ(counter.count(), 8U);
}

TEST(AllocationCounter, countsNothingWhereNothingIsTaken) {
    std::vector<int> numbers;
    numbers.reserve(100);
    const AllocationCounter counter;
    for (int i = 0; i < 100; ++i)
        numbers.push_back(i);
    EXPECT_EQ(counter.count(), 0U);
}

TEST(AllocationCounter, countsThisThreadAlone) {
    std::uint64_t other = 0;
    std::uint64_t mine = 1;
    std::thread thread([&other] {
        const AllocationCounter counter;
        for (int i = 0; i < 5; ++i) {
            kept = std::malloc(11);
            std::free(kept);
        }
        other = counter.count();
    });
    {
        const AllocationCounter counter;
        thread.join();
        mine = counter.count();
    }
    EXPECT_EQ(other, 5U);
    EXPECT_EQ(mine, 0U);
}

}  // namespace
}  // namespace cheval::test
