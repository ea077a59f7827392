// What the leak sanitizer is to say nothing about: memory that libraries keep until the process ends. Linked into test
// programs that draw.

// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): the sanitizer's name.
extern "C" const char* __lsan_default_suppressions();
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" const char* __lsan_default_suppressions() {
    // fontconfig's caches and Mesa's per-process state have no owner that could free them.
    return "leak:libfontconfig\nleak:libOSMesa\nleak:libEGL\nleak:swrast_dri\nleak:libLLVM\nleak:libpango\n";
}
