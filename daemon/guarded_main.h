// The outermost frame of every program: an exception that nobody expected ends it with words, and not in
// std::terminate. Includes the standard library alone, so that cheval-sensor can have it.
#pragma once

#include <cstdio>
#include <exception>

namespace cheval::daemon {

/// Runs `run` and returns what it returns; `failed` where it throws.
inline int guardedMain(int (*run)(int, char**), int argc, char** argv, int failed) {
    try {
        return run(argc, argv);
    } catch (const std::exception& fault) {
        std::fputs("error: ", stderr);
        std::fputs(fault.what(), stderr);
        std::fputc('\n', stderr);
        return failed;
    }
}

}  // namespace cheval::daemon
