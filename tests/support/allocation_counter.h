// Counts heap allocations of the current thread at malloc, so that "takes no heap memory" is a test and not a hope.
#pragma once

#include <cstdint>

namespace cheval::test {

/// Calls of malloc, calloc, realloc, posix_memalign, aligned_alloc and operator new (in any spelling) by this thread
/// since it started. Frees are not counted.
std::uint64_t allocationsOnThisThread();

/// Counts this thread's allocations from its construction on. Thread-bound.
/// With CHEVAL_TRAP_ALLOCATIONS=1 in the environment, the first allocation while a counter lives stops the program with
/// SIGTRAP, so that a debugger shows who took it.
class AllocationCounter {
  public:
    AllocationCounter();
    ~AllocationCounter();
    AllocationCounter(const AllocationCounter&) = delete;
    AllocationCounter& operator=(const AllocationCounter&) = delete;

    [[nodiscard]] std::uint64_t count() const;
    /// Of those, the calls of operator new. Near to what our own code took, and no more than near: C++ libraries (LLVM
    /// in the GL driver) call it too, while Eigen, aligned new and C libraries call malloc. Always 0 under a sanitizer,
    /// which owns operator new.
    [[nodiscard]] std::uint64_t countNew() const;

  private:
    std::uint64_t start_;
    std::uint64_t startNew_;
};

}  // namespace cheval::test
