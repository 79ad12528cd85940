#pragma once
/// PLUMBLINE_ASSERT(condition): a caller's bug, never a condition of the world (those are a `Result`).
///
/// Firmware replaces the handler by defining `PLUMBLINE_ASSERT_HANDLER(text, file, line)` before the first include;
/// it may log, reset or trap. Without one, debug builds stop in the debugger and release builds check nothing.

#if !defined(PLUMBLINE_ASSERT_HANDLER) && !defined(NDEBUG)
#define PLUMBLINE_ASSERT_HANDLER(text, file, line) __builtin_trap()
#endif

#if defined(PLUMBLINE_ASSERT_HANDLER)
#define PLUMBLINE_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : static_cast<void>(PLUMBLINE_ASSERT_HANDLER(#condition, __FILE__, __LINE__)))
#else
#define PLUMBLINE_ASSERT(condition) static_cast<void>(0)
#endif
