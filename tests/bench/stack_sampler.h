// Where a computation spends its time, by looking at its stack now and then: what is measured needs no hook for it.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace cheval::bench {

/// Samples the stack of the one thread that computes, by processor time, from its construction to shares(). One at a
/// time. The program must export its symbols (CMake's ENABLE_EXPORTS). Functions of anonymous namespaces have none:
/// their callers stand for them.
class StackSampler {
  public:
    StackSampler();
    ~StackSampler();
    StackSampler(const StackSampler&) = delete;
    StackSampler& operator=(const StackSampler&) = delete;

    /// Whether what is computed from now on is of interest; at first it is.
    static void look(bool interesting);
    /// Stops, and says which share (0…1) of the samples lay in each class of namespace `space`, or in each of its free
    /// functions: the innermost of them on the stack. "": in none.
    std::map<std::string, double> shares(std::string_view space);
};

}  // namespace cheval::bench
