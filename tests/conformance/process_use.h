// What this process holds of the system, to see whether something that is done again and again makes it grow.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iterator>

#include <malloc.h>

namespace cheval::test {

/// Counted at construction.
struct ProcessUse {
    std::ptrdiff_t descriptors = count("/proc/self/fd");
    std::ptrdiff_t threads = count("/proc/self/task");
    std::size_t heapBytes = heap();  ///< 0 under a sanitizer, whose own allocator finds leaks instead.

    static std::ptrdiff_t count(const char* folder) {
        return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
    }
    static std::size_t heap() {
        const struct mallinfo2 use = ::mallinfo2();
        return use.uordblks + use.hblkhd;
    }
};

/// What may remain in caches of libraries after a hundred repetitions: less than one small allocation each.
constexpr std::size_t kHeapSlack = 4096;

}  // namespace cheval::test
