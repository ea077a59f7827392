#include "tests/support/allocation_counter.h"

#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CHEVAL_UNDER_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define CHEVAL_UNDER_SANITIZER 1
#endif
#endif

namespace {

// Plain thread-locals of an executable need no allocation themselves and no constructor.
thread_local std::uint64_t allocations = 0;
thread_local std::uint64_t newCalls = 0;
thread_local int counters = 0;
bool trap = false;

void counted() {
    ++allocations;
    if (trap && counters > 0) std::raise(SIGTRAP);
}

[[maybe_unused]] const bool kTrapRead = [] {
    const char* wish = std::getenv("CHEVAL_TRAP_ALLOCATIONS");
    trap = wish != nullptr && *wish == '1';
    return true;
}();

}  // namespace

#ifdef CHEVAL_UNDER_SANITIZER

// The sanitizers own malloc; they tell us of every call.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): their name.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));
namespace {
const int kHooked = __sanitizer_install_malloc_and_free_hooks([](const volatile void*, std::size_t) { counted(); },
                                                              [](const volatile void*) {});
}  // namespace

#else

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
// Interposes malloc in the whole program: glibc calls these by name, and keeps its own under the __libc names. free
// stays glibc's, which owns every block.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
    counted();
    return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
    counted();
    return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
    counted();
    return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
    counted();
    return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
    counted();
    return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
    constexpr int kInvalid = 22;
    constexpr int kNoMemory = 12;
    if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) return kInvalid;
    counted();
    void* taken = __libc_memalign(alignment, size);
    if (taken == nullptr) return kNoMemory;
    *block = taken;
    return 0;
}
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

// The other spellings without an alignment come down to these.
void* operator new(std::size_t size) {
    ++newCalls;
    if (void* taken = std::malloc(size > 0 ? size : 1)) return taken;
    throw std::bad_alloc();
}
void operator delete(void* block) noexcept {
    std::free(block);
}
void operator delete(void* block, std::size_t /*size*/) noexcept {
    std::free(block);
}

#endif

namespace cheval::test {

std::uint64_t allocationsOnThisThread() {
    return allocations;
}

AllocationCounter::AllocationCounter() : start_(allocations), startNew_(newCalls) {
    ++counters;
}

AllocationCounter::~AllocationCounter() {
    --counters;
}

std::uint64_t AllocationCounter::count() const {
    return allocations - start_;
}

std::uint64_t AllocationCounter::countNew() const {
    return newCalls - startNew_;
}

}  // namespace cheval::test
