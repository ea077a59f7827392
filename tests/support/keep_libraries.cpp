// Linked into every test program of a build with the address sanitizer: libraries that are unloaded before the leak
// check (EGL unloads its driver with the last display) would leave addresses that no suppression of
// tests/support/lsan.supp can name. So nothing is unloaded.

// NOLINTNEXTLINE(readability-identifier-naming): the C library's name.
extern "C" int dlclose(void* /*handle*/) {
    return 0;
}
