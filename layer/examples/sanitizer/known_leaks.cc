// For builds with a sanitizer only: Debian's OpenXR loader 1.0.20 does not free all of its own memory. Ours is watched.

extern "C" const char* __lsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libopenxr_loader\n"; }
