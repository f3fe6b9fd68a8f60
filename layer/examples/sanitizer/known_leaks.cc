// For builds with a sanitizer only: Debian's OpenXR loader 1.0.20 does not free all of its own memory. Ours is checked.
// Suppressed leaks are not printed: tests compare what an example writes.

extern "C" const char* __lsan_default_options();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
extern "C" const char* __lsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libopenxr_loader\n"; }
