#include "tests/bench/stack_sampler.h"

#include <array>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <vector>

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <sys/time.h>

namespace cheval::bench {
namespace {

constexpr std::size_t kMaximumSamples = 20'000;
constexpr int kDeepest = 40;
/// The kernel looks at its clock less often than that, at each tick.
constexpr suseconds_t kEveryMicroseconds = 1000;

struct Sample {
    std::array<void*, kDeepest> frames;
    int depth = 0;
};
// A signal handler has nowhere else to put what it finds.
std::vector<Sample> samples;         // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
volatile std::sig_atomic_t taken;    // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
volatile std::sig_atomic_t looking;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

void takeSample(int /*signal*/) {
    if (looking == 0) return;
    const auto next = static_cast<std::size_t>(taken);
    if (next >= samples.size()) return;
    Sample& sample = samples[next];
    sample.depth = backtrace(sample.frames.data(), kDeepest);
    taken = static_cast<std::sig_atomic_t>(next + 1);
}

void setTimer(suseconds_t every) {
    const itimerval timer{.it_interval = {.tv_sec = 0, .tv_usec = every}, .it_value = {.tv_sec = 0, .tv_usec = every}};
    setitimer(ITIMER_PROF, &timer, nullptr);
}

std::string nameOf(void* address) {
    Dl_info info{};
    // One before the return address lies within the call.
    if (dladdr(static_cast<char*>(address) - 1, &info) == 0 || info.dli_sname == nullptr) return {};
    int failed = 0;
    const std::unique_ptr<char, void (*)(void*)> demangled(
        abi::__cxa_demangle(info.dli_sname, nullptr, nullptr, &failed), std::free);
    return failed == 0 ? std::string(demangled.get()) : std::string();
}

/// "Class" of "space::Class::method(…)", "function" of "space::function(…)"; empty for anything else.
std::string partOf(const std::string& name, std::string_view space) {
    if (!name.starts_with(space)) return {};
    const std::string rest = name.substr(space.size());
    return rest.substr(0, rest.find_first_of("(<:"));
}

}  // namespace

StackSampler::StackSampler() {
    samples.resize(kMaximumSamples);
    taken = 0;
    looking = 1;
    // The first call loads the unwinder, which no signal handler may.
    std::array<void*, 1> here{};
    (void)backtrace(here.data(), 1);
    struct sigaction action {};
    action.sa_handler = &takeSample;
    action.sa_flags = SA_RESTART;
    sigaction(SIGPROF, &action, nullptr);
    setTimer(kEveryMicroseconds);
}

StackSampler::~StackSampler() {
    setTimer(0);
}

void StackSampler::look(bool interesting) {
    looking = interesting ? 1 : 0;
}

std::map<std::string, double> StackSampler::shares(std::string_view space) {
    setTimer(0);
    std::map<void*, std::string> parts;
    std::map<std::string, double> shares;
    const auto count = static_cast<std::size_t>(taken);
    for (std::size_t i = 0; i < count; ++i) {
        const Sample& sample = samples[i];
        std::string part;
        for (int k = 0; k < sample.depth && part.empty(); ++k) {
            void* address = sample.frames[static_cast<std::size_t>(k)];
            const auto [known, isNew] = parts.try_emplace(address);
            if (isNew) known->second = partOf(nameOf(address), space);
            part = known->second;
        }
        shares[part] += 1.0 / static_cast<double>(count);
    }
    return shares;
}

}  // namespace cheval::bench
